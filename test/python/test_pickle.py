"""Scenes, states, simulators and their results pickle, and continue bit-identically in another process."""

import copy
import multiprocessing
import os
import pickle

import joblib
import numpy as np
import pytest
from scenes import SCENES, busy, free, hanging, same_state

import clothsim


def again(thing):
    return pickle.loads(pickle.dumps(thing))


def stirred(method="auto", **simulation):
    """A simulator with live values, grips, moving frames and a collider that is turned off."""
    simulator = clothsim.Simulator(busy(method, **simulation))
    simulator.weighs_colliders = True
    simulator.place_frame("ball", [0.5, 0.5, 0.75])
    simulator.step(20, {"hand": [0, 0, 1.1], "ball": [0.45, 0.5, 0.8, 0, 0, 0.6, 0.8]})
    simulator.attach("finger", [1, 1, 1], points=[99, 98], tear_force=1e5)
    simulator.set(ks=350, damping=2, gravity=[0, 0.5, -9])
    simulator.set(collider_friction={"ball": 0.9})
    simulator.step(10, {"finger": [0.9, 1, 1.05]})
    simulator.enable_collider("ground", False)
    return simulator


def goes_on(simulator):
    simulator.step(6, {"finger": [0.8, 0.9, 1.1], "hand": [0, 0.1, 1.1]})
    simulator.detach("finger")
    return simulator.step(6)


@pytest.mark.parametrize("method", ["auto", "verlet", "bdf2", "implicit_euler", "xpbd"])
def test_a_simulator_goes_on_to_the_same_bits(method):
    one = stirred(method)
    other = again(one)
    assert same_state(one, other) and one.time == other.time
    assert np.array_equal(one.memory, other.memory)
    assert one.report == other.report
    assert repr(one.grips) == repr(other.grips) and repr(one.colliders) == repr(other.colliders)
    assert repr(one.contacts) == repr(other.contacts) and other.weighs_colliders
    reports = goes_on(one), goes_on(other)
    assert same_state(one, other) and np.array_equal(one.memory, other.memory)
    assert all(getattr(reports[0], name) == getattr(reports[1], name)
               for name in ("method", "substeps", "sweeps", "contacts", "reason"))


def test_parameters_of_a_method_and_a_fabric_come_along():
    simulator = clothsim.Simulator({"cloth": {"fabric": "denim", "columns": 8, "rows": 8},
                                    "simulation": {"method": "xpbd", "wind": [1, 0, 0], "gusts": 0.5}})
    simulator.set(method="xpbd", method_parameters={"iterations": 7}, substeps=3, threads=2)
    simulator.step(3)
    other = again(simulator)
    simulator.step(5)
    other.step(5)
    assert same_state(simulator, other)
    simulator.reset()  # to the current values
    other.reset()
    simulator.step(5)
    other.step(5)
    assert same_state(simulator, other)


def test_motions_go_on_where_they_were():
    scene = dict(busy(), motions=[
        {"time": 0, "frame": "hand", "position": [0, 0, 1]}, {"time": 0.3, "frame": "hand", "position": [0, 0.2, 1.2]},
        {"time": 0.1, "set": {"damping": 1}}, {"time": 0.5, "frame": "hand", "position": [0, 0, 1.1]}])
    one = clothsim.Simulator(scene)
    one.step(18)
    other = again(one)
    one.step(40)
    other.step(40)
    assert same_state(one, other)


def test_a_scene_keeps_texts_numbers_and_its_files(tmp_path, monkeypatch):
    (tmp_path / "triangle.stl").write_bytes((SCENES.parent / "robots/finger.stl").read_bytes())
    (tmp_path / "scene.yaml").write_text(
        "cloth: {columns: 4, rows: 4}\n"
        "colliders:\n"
        "  - {name: '5', shape: mesh, file: triangle.stl, frame: 'true'}\n"
        "simulation: {seed: 9007199254740993, method: verlet}\n")
    monkeypatch.chdir(tmp_path)
    scene = clothsim.Scene("scene.yaml", {"cloth.ks": 0.1 + 0.2})
    kept = pickle.dumps(scene)
    simulator = clothsim.Simulator(scene)
    kept_simulator, kept_state = pickle.dumps(simulator), pickle.dumps(simulator.save())
    monkeypatch.chdir("/")
    other = pickle.loads(kept)
    assert other.to_dict() == scene.to_dict() and other.to_dict()["cloth"]["ks"] == 0.1 + 0.2
    assert clothsim.Simulator(other).colliders["5"]["frame"] == "true"
    copied = pickle.loads(kept_simulator)
    assert copied.report == simulator.report
    copied.restore(pickle.loads(kept_state))
    assert repr(clothsim.Scene(free(8))) == repr(again(clothsim.Scene(free(8))))


def test_a_state_comes_back_in_another_simulator():
    simulator = stirred()
    state = again(simulator.save())
    goes_on(simulator)
    other = clothsim.Simulator(busy())
    other.set(ks=350, damping=2, gravity=[0, 0.5, -9], collider_friction={"ball": 0.9})
    other.restore(state)
    goes_on(other)
    assert same_state(simulator, other)
    assert state.nbytes == stirred().save().nbytes
    with pytest.raises(clothsim.InvalidValue, match="another scene"):
        clothsim.Simulator(free()).restore(state)


def test_copies_are_apart():
    simulator = clothsim.Simulator(hanging())
    simulator.step(5)
    for make in (copy.copy, copy.deepcopy):
        other = make(simulator)
        simulator.step(5)
        assert not same_state(simulator, other)
        other.step(5)
        assert same_state(simulator, other)


def run(simulator, frames):
    report = simulator.step(frames)
    return os.getpid(), np.array(simulator.positions), report, simulator.save()


def diverge(_):
    raise clothsim.InvalidValue("cloth.ks: no")


@pytest.mark.parametrize("way", ["spawn", "joblib"])
def test_other_processes_take_them_and_give_them_back(way):
    simulators = [clothsim.Simulator(hanging(ks=ks)) for ks in (100, 200)]
    for simulator in simulators:
        simulator.step(10)
    if way == "joblib":
        results = joblib.Parallel(2)(joblib.delayed(run)(one, 20) for one in simulators)
    else:
        with multiprocessing.get_context("spawn").Pool(2) as pool:
            results = pool.starmap(run, [(one, 20) for one in simulators])
            with pytest.raises(clothsim.InvalidValue, match="cloth.ks: no"):
                pool.map(diverge, [1])
    for simulator, (process, positions, report, state) in zip(simulators, results):
        assert process != os.getpid()
        expected = simulator.step(20)
        assert np.array_equal(simulator.positions, positions)
        assert repr(report) == repr(expected) and report.worst_stretch == expected.worst_stretch
        simulator.reset()
        simulator.restore(state)
        assert np.array_equal(simulator.positions, positions)


def test_a_batch_and_a_view_pickle():
    batch = clothsim.Batch([clothsim.Simulator(hanging()) for _ in range(3)], 2)
    batch.step(frames=4)
    other = again(batch)
    assert other.threads == 2 and np.array_equal(other.positions, batch.positions)
    assert np.array_equal(other.step(frames=3), batch.step(frames=3))
    view = clothsim.View({"eye": [1, -1, 1], "width": 64, "height": 48})
    assert again(view).to_dict() == view.to_dict()
    simulator = batch.simulators[0]
    assert np.array_equal(simulator.render(view)[0], again(simulator).render(again(view))[0])


def test_errors_keep_their_key():
    with pytest.raises(clothsim.InvalidValue) as caught:
        clothsim.Scene({"cloth": {"ks": -5}})
    error = again(caught.value)
    assert type(error) is clothsim.InvalidValue
    assert error.key == "cloth.ks" and str(error) == str(caught.value)


@pytest.mark.parametrize("make", [lambda: clothsim.Scene(free()), lambda: clothsim.Simulator(free()),
                                  lambda: clothsim.Simulator(free()).save(),
                                  lambda: clothsim.Simulator(free()).step()])
def test_what_another_version_has_pickled_is_refused(make):
    thing = make()
    _, (type_, *_), kept = thing.__reduce_ex__(2)[:3]
    empty = type_.__new__(type_)
    with pytest.raises(clothsim.InvalidValue, match="version 0.0.1"):
        empty.__setstate__(("0.0.1", *kept[1:]))
    with pytest.raises(clothsim.InvalidValue, match="version none"):
        empty.__setstate__(kept[:-1])
    if isinstance(kept[-1], bytes):
        with pytest.raises(clothsim.InvalidValue, match="end too early"):
            empty.__setstate__((*kept[:-1], kept[-1][:-20]))
