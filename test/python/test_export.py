"""A run as OBJ, PLY and USD, read again by readers in this file."""

import ast
import pathlib
import re
import subprocess
import sys

import numpy as np
import pytest
from scenes import CLONE, hanging

import clothsim
from clothsim.export import Recording

SIMULATE = pathlib.Path(clothsim.__file__).resolve().parents[3] / "clothsim/simulate"


@pytest.fixture
def recording():
    simulator = clothsim.Simulator(hanging(5))
    recording = Recording.of(simulator)
    for _ in range(3):
        simulator.step(9)
        recording.add(simulator)
    assert np.ptp(recording.positions[-1] - recording.positions[0]) > 0.01
    return recording


def test_obj_has_each_frame(recording, tmp_path):
    paths = recording.save(tmp_path / "new/cloth.obj")
    assert [path.name for path in paths] == [f"cloth_00000{i}.obj" for i in range(4)]
    for path, positions in zip(paths, recording.positions):
        lines = [line.split() for line in path.read_text().splitlines()]
        assert np.array_equal([[float(x) for x in line[1:]] for line in lines if line[0] == "v"], positions)
        assert np.array_equal([[float(x) for x in line[1:]] for line in lines if line[0] == "vt"], recording.uv)
        corners = np.array([[word.split("/") for word in line[1:]] for line in lines if line[0] == "f"], int)
        assert np.array_equal(corners[:, :, 0], recording.triangles + 1)
        assert np.array_equal(corners[:, :, 0], corners[:, :, 1])


def test_usd_has_all_frames(recording, tmp_path):
    path, = recording.save(tmp_path / "cloth.usda")
    text = path.read_text()
    assert text.startswith("#usda 1.0\n") and text.count("{") == text.count("}")
    assert 'upAxis = "Z"' in text and "metersPerUnit = 1\n" in text
    assert re.search(r"startTimeCode = 0\n.*endTimeCode = 3\n.*timeCodesPerSecond = 10\n", text, re.DOTALL)

    def value(name):
        return ast.literal_eval(re.search(r"\[\] " + name + r" = (\[.*?\])", text).group(1))
    assert np.array_equal(value("faceVertexCounts"), [3] * len(recording.triangles))
    assert np.array_equal(value("faceVertexIndices"), recording.triangles.ravel())
    assert np.allclose(value("primvars:st"), recording.uv)

    def samples(name):
        block = re.search(name + r"\.timeSamples = \{\n(.*?)\n    \}", text, re.DOTALL).group(1)
        return ast.literal_eval("{" + block + "}")
    points = samples("points")
    assert list(points) == [0, 1, 2, 3]
    assert np.array_equal(np.float32([points[i] for i in range(4)]), np.float32(recording.positions))
    for i, extent in samples("extent").items():
        assert np.allclose(extent, [np.min(points[i], axis=0), np.max(points[i], axis=0)])


def run_export(*arguments):
    return subprocess.run([sys.executable, CLONE / "scripts/export", *arguments], stdout=subprocess.PIPE,
                          stderr=subprocess.PIPE, text=True)


def test_the_program_takes_what_simulate_has_kept(tmp_path):
    scene = CLONE / "config/scenes/pinned2.yaml"
    subprocess.run([SIMULATE, scene, "--seconds", "0.2", "--every", "0.1", "--set", "cloth.columns=9",
                    "--set", "cloth.rows=7", "--set", "cloth.pinned=[[0, 0], [8, 0]]", "--output", tmp_path],
                   check=True, stdout=subprocess.DEVNULL)
    result = run_export(tmp_path / "frames.npz", tmp_path / "cloth.ply")
    assert result.returncode == 0 and result.stdout == f"{tmp_path}/cloth_000000.ply to cloth_000002.ply\n"
    theirs = sorted((tmp_path / "frames").glob("*.ply"))
    ours = sorted(tmp_path.glob("cloth_*.ply"))
    assert len(ours) == len(theirs) == 3
    for one, other in zip(ours, theirs):
        assert one.read_bytes() == other.read_bytes()
    assert run_export(tmp_path / "frames.npz", tmp_path / "cloth.usda").stdout == f"{tmp_path}/cloth.usda\n"
    loaded = Recording.load(tmp_path / "frames.npz")
    topology = clothsim.Simulator(clothsim.Scene(scene, {
        "cloth.columns": 9, "cloth.rows": 7, "cloth.pinned": [[0, 0], [8, 0]]})).topology
    assert np.array_equal(loaded.uv, topology["uv"])
    assert np.array_equal(loaded.triangles, topology["triangles"])


def test_what_cannot_be_exported_is_told(recording, tmp_path):
    with pytest.raises(clothsim.InvalidValue, match=r"\.obj, \.ply, \.usda"):
        recording.save(tmp_path / "cloth.abc")
    (tmp_path / "other.npz").write_text("no frames")
    for path, message in [(tmp_path / "none.npz", "No such file"), (tmp_path / "other.npz", "frames.npz")]:
        result = run_export(path, tmp_path / "cloth.obj")
        assert result.returncode == 1 and message in result.stderr
    rope = Recording.of(clothsim.Simulator({"cloth": {"columns": 5, "rows": 1}}))
    with pytest.raises(clothsim.InvalidValue, match="without a surface"):
        rope.save(tmp_path / "rope.obj")
