"""Stubs, documentation and examples of the package are correct."""

import ast
import pathlib
import re
import subprocess
import sys
import xml.etree.ElementTree

import pytest
from scenes import CLONE

import clothsim

STUBS = ast.parse((pathlib.Path(clothsim.__file__).parent / "__init__.pyi").read_text())
CLASSES = [node for node in STUBS.body if isinstance(node, ast.ClassDef)]


def public(names):
    return {name for name in names if not name.startswith("_")}


def own_names(type_):
    return public(set(dir(type_)) - set(dir(Exception)))


def test_the_stubs_have_every_name():
    assert {node.name for node in CLASSES} == public(clothsim.__all__)


@pytest.mark.parametrize("stub", CLASSES, ids=lambda node: node.name)
def test_a_stub_has_the_names_and_arguments_of_its_class(stub):
    type_ = getattr(clothsim, stub.name)
    functions = [node for node in stub.body if isinstance(node, ast.FunctionDef)]
    assert public(node.name for node in functions) == own_names(type_)
    for function in functions:
        member = getattr(type_, function.name)
        decorators = {getattr(node, "id", "setter") for node in function.decorator_list}
        assert isinstance(member, property) == bool(decorators & {"property", "setter"})
        if "setter" in decorators:
            assert member.fset is not None
        if isinstance(member, property) or function.name == "__len__":
            continue
        arguments = [argument.arg for argument in function.args.args if argument.arg != "self"]
        signature = member.__doc__.splitlines()[0]
        if function.args.kwarg:
            assert "**kwargs" in signature
            continue
        names = re.findall(r"[(,] ?(\w+): ", signature)
        assert [name for name in names if name != "self"] == arguments
        assert signature.count(" = ") == len(function.args.defaults)


@pytest.mark.parametrize("stub", CLASSES, ids=lambda node: node.name)
def test_everything_is_documented(stub):
    type_ = getattr(clothsim, stub.name)
    assert type_.__doc__
    for name in own_names(type_):
        doc = getattr(type_, name).__doc__
        text = doc if isinstance(getattr(type_, name), property) else doc.split("\n", 1)[1]
        assert len(text.strip()) > 10, name


def test_the_version_is_that_of_the_package():
    manifest = xml.etree.ElementTree.parse(CLONE / "package.xml").getroot()
    version = manifest.findtext("version")
    assert clothsim.__version__ == version
    assert f'version = "{version}"' in (CLONE / "pyproject.toml").read_text()


def code_blocks(path):
    return re.findall(r"```python\n(.*?)```", path.read_text(), re.DOTALL)


def test_the_document_runs(tmp_path, monkeypatch):
    monkeypatch.chdir(CLONE)
    names = {}
    blocks = code_blocks(CLONE / "docs/python.md")
    assert len(blocks) > 3
    for block in blocks:
        exec(compile(block, "docs/python.md", "exec"), names)


def run_example(name):
    return subprocess.run([sys.executable, CLONE / "scripts/examples" / name], check=True,
                          stdout=subprocess.PIPE, text=True).stdout


def test_the_environment_folds_the_towel(monkeypatch):
    monkeypatch.syspath_prepend(CLONE / "scripts/examples")
    import fold_env
    env = fold_env.FoldEnv()
    first, info = env.reset(seed=3)
    again, _ = env.reset(seed=3)
    other, _ = env.reset(seed=4)
    assert (first == again).all() and (first != other).any()
    assert first.shape == env.observation_space.shape == (25 * 25 * 3 + 6 + 2,)
    assert abs(info["fold"]) < 1e-9

    env.reset(options={"off": 0})
    rewards = 0
    for action in fold_env.plan():
        assert action.shape == env.action_space.shape
        observation, reward, terminated, truncated, info = env.step(action)
        assert observation.shape == first.shape and not truncated
        rewards += reward
    assert terminated and info["fold"] > fold_env.FOLDED
    assert rewards == pytest.approx(info["fold"])
    assert len(env.simulator.intersections()) == 0
    assert env.render().shape == (480, 640, 3)
    assert "done" in run_example("fold_env.py")


def test_the_material_of_a_motion_is_found():
    found = dict(re.findall(r"(ks|damping): ([\d.]+)", run_example("identify_material.py")))
    assert float(found["ks"]) == pytest.approx(60, rel=0.01)
    assert float(found["damping"]) == pytest.approx(1.5, rel=0.01)


def test_the_tour_shows_all_that_there_is():
    assert run_example("tour.py").endswith("the tour is done\n")
    text = (CLONE / "scripts/examples/tour.py").read_text()
    for name in ("Scene", "Batch", "positions", "topology", "attach", "detach", "enable_collider", "set(",
                 "save()", "restore", "memory", "report", "contacts", "intersections", "render"):
        assert name in text, name
