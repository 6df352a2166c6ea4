"""Calls of a script on a scene and a simulator, one by one."""

import copy
import math
import pathlib
import re
import warnings

import numpy as np
import pytest
from scenes import SCENES, busy, free, hanging, same_state

import clothsim
from clothsim import Scene, Simulator

G = 9.8  # [m/s^2]


# ---- Scenes

def test_scenes_are_read_from_files_texts_and_dicts_alike():
    path = SCENES / "sphere.yaml"
    scenes = [Scene(path), Scene(str(path)), Scene.parse(path.read_text()),
              Scene(Scene(path).to_dict())]
    runs = [Simulator(scene) for scene in scenes] + [Simulator(path)]
    for run in runs:
        run.step(2)
        assert same_state(run, runs[0])
    assert (scenes[0].columns, scenes[0].rows, scenes[0].frames_per_second) == (50, 50, 90)


def test_overrides_take_the_place_of_values():
    scene = Scene(SCENES / "sphere.yaml", {
        "cloth.columns": 9, "cloth.rows": np.int64(7), "cloth.ks": 1e-3, "cloth.strain_limit": "off",
        "colliders.0.center": np.array([0.1, 0.2, 0.3]), "simulation": {"substeps": 4}})
    assert (scene.columns, scene.rows) == (9, 7)
    given = scene.to_dict()
    assert given["cloth"]["ks"] == 1e-3 and given["cloth"]["strain_limit"] == "off"
    assert given["colliders"][0]["center"] == [0.1, 0.2, 0.3]
    assert Simulator(scene).step().substeps == 4


def test_numbers_keep_their_bits():
    width = 0.1 + 0.2
    simulator = Simulator(free(2, width=width, height=math.pi))
    assert simulator.positions[1, 0] == width
    assert simulator.positions[2, 1] == math.pi


@pytest.mark.parametrize("source, key, text", [
    ({"cloth": {"kss": 1}}, "cloth.kss", "unknown"),
    ({"cloth": {"ks": -1}}, "cloth.ks", "got -1.*least 0"),
    ({"cloth": {"ks": "5"}}, "cloth.ks", 'got "5".*finite'),
    ({"cloth": {"ks": math.nan}}, "cloth.ks", "nan"),
    ({"cloth": {"ks": None}}, "cloth.ks", "got nothing"),
    ({"cloth": {"origin": [0, 0, {}]}}, "cloth.origin.2", "a map"),
    ({"cloth": {"ks": {1, 2}}}, "cloth.ks", "of type set"),
    ({"cloth": {3: 1}}, "cloth", "as a key"),
    ({}, "cloth", "got nothing"),
    ({"cloth": {}, "colliders": [{"shape": "cone"}]}, "colliders.0.shape", '"cone"'),
])
def test_mistakes_in_a_scene_are_refused_by_key(source, key, text):
    for make in (Scene, Simulator):
        with pytest.raises(clothsim.InvalidValue) as caught:
            make(source)
        assert caught.value.key == key
        assert re.search(text, str(caught.value))
        assert isinstance(caught.value, ValueError)


def test_whole_messages_read_like_these():
    for source, message in [
            ({"cloth": {"ks": -1}}, "cloth.ks: got -1, expected a number of at least 0 [N/m]"),
            ({"cloth": {"ks": "5"}}, 'cloth.ks: got "5" (text), expected a finite number')]:
        with pytest.raises(clothsim.InvalidValue) as caught:
            Scene(source)
        assert str(caught.value) == message


def test_mistakes_in_files_texts_and_overrides_are_refused(tmp_path):
    for make, key in [
            (lambda: Scene(tmp_path / "none.yaml"), str(tmp_path / "none.yaml")),
            (lambda: Scene.parse("cloth: ["), "scene"),
            (lambda: Scene(free(), {"cloth.ks": "5"}), "cloth.ks"),
            (lambda: Scene(free(), {"cloth..ks": 5}), "assignment"),
            (lambda: Scene(free(), {"cloth.ks": object()}), "cloth.ks"),
            (lambda: Scene(free(), {5: 5}), "overrides")]:
        with pytest.raises(clothsim.InvalidValue) as caught:
            make()
        assert caught.value.key == key


def test_a_dict_that_holds_itself_is_refused():
    endless = free()
    endless["cloth"]["pinned"] = endless
    with pytest.raises(clothsim.InvalidValue):
        Scene(endless)


# ---- Steps

def test_a_free_cloth_falls_as_it_must():
    simulator = Simulator(free(damping=0))
    start = simulator.positions.copy()
    simulator.step(45)
    t = simulator.time
    assert t == pytest.approx(0.5)
    assert simulator.frame_duration == 1 / 90
    fallen = simulator.positions - start
    assert np.allclose(fallen, [0, 0, -G / 2 * t * t], atol=1e-12)
    assert np.allclose(simulator.velocities, [0, 0, -G * t], atol=1e-12)


def test_one_call_of_many_frames_is_as_many_calls_of_one():
    one, many = Simulator(busy()), Simulator(busy())
    report = many.step(40)
    for _ in range(40):
        last = one.step()
    assert same_state(one, many)
    assert (report.substeps, report.method, report.reason) == (
        last.substeps, last.method, last.reason)
    assert report.contacts > 0 and report.worst_stretch > 0


def test_a_report_has_what_simulate_writes():
    simulator = Simulator(busy())
    simulator.step(30)
    report = simulator.report
    assert report["frames"] == 30 and report["simulated_seconds"] == simulator.time
    assert report["energy"]["kinetic"] == pytest.approx(
        (simulator.topology["mass"] * (simulator.velocities**2).sum(axis=1)).sum() / 2)
    assert report["intersecting_pairs"] == len(simulator.intersections()) == 0
    assert report["diverged"] is False and report["cpu_seconds"] > 0


def test_crossing_triangles_are_found():
    simulator = Simulator(free(6))
    positions = simulator.positions.copy()
    over = positions[:, 0] > 0.5  # folded over, and through the other half a quarter from its end
    positions[over, 0] = 1 - positions[over, 0]
    positions[over, 1] += 0.03
    positions[over, 2] += 0.2 * (positions[over, 0] - 0.25)
    simulator.set_state(positions=positions)
    pairs = simulator.intersections()
    assert pairs.shape == (simulator.report["intersecting_pairs"], 2) and len(pairs) > 0
    assert (pairs[:, 0] < pairs[:, 1]).all()
    assert pairs.max() < len(simulator.topology["triangles"])


def crossed(simulator):
    positions = simulator.positions.copy()
    over = positions[:, 0] > 0.5
    positions[over, 0] = 1 - positions[over, 0]
    positions[over, 2] += 0.04 + 0.1 * np.sin(2 * np.pi * positions[over, 1]) * (0.5 - positions[over, 0])
    return positions


def test_a_state_that_crosses_itself_is_told_of_and_taken_apart():
    scene = free(20, self_collision="surface", thickness=0.005)
    simulator = Simulator(scene)
    with pytest.warns(UserWarning, match=r"crosses itself in \d+ pairs"):
        simulator.set_state(positions=crossed(simulator))
    pairs = len(simulator.intersections())
    report = simulator.step(1)
    assert pairs > 0 and report.crossings > 0 and f"{report.crossings} pairs" in report.reason
    before, left = simulator.untangle()
    assert before == report.crossings and left == 0 == len(simulator.intersections())
    assert simulator.step(1).crossings == 0 and simulator.untangle() == (0, 0)

    scene["cloth"]["untangle"] = True
    simulator = Simulator(scene)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        simulator.set_state(positions=crossed(simulator))
    assert len(simulator.intersections()) == 0


def test_contacts_tell_where_the_cloth_lies():
    simulator = Simulator({**free(10, origin=[0, 0, 0.001]), "colliders": [
        {"shape": "plane", "name": "ground"}, {"shape": "sphere", "center": [0, 0, 9]}]})
    assert simulator.contacts["ground"] == {
        "count": 0, "middle": None, "force": None, "torque": None}
    simulator.step(90)
    assert simulator.contacts["sphere"]["count"] == 0
    assert simulator.contacts["ground"]["count"] == 100
    assert np.allclose(simulator.contacts["ground"]["middle"], [0.5, 0.5, 0], atol=1e-3)


def test_contacts_weigh_what_lies_on_colliders():
    simulator = Simulator({**free(10, origin=[0, 0, 0.001]), "colliders": [
        {"shape": "plane", "name": "ground"}, {"shape": "sphere", "center": [0, 0, 9]}]})
    simulator.weighs_colliders = True
    assert np.array_equal(simulator.contacts["ground"]["force"], [0, 0, 0])  # no frame yet
    simulator.step(90)
    weight = 5 * G
    ground = simulator.contacts["ground"]
    assert np.allclose(ground["force"], [0, 0, -weight], atol=1e-6 * weight)
    assert np.allclose(ground["torque"], [-weight / 2, weight / 2, 0], atol=1e-6 * weight)
    assert np.array_equal(simulator.contacts["sphere"]["force"], [0, 0, 0])
    simulator.load(free())
    assert simulator.weighs_colliders and simulator.contacts == {}
    simulator.weighs_colliders = False
    assert not simulator.weighs_colliders


def test_contact_is_among_the_live_values():
    slope = {"shape": "plane", "name": "slope"}
    simulator = Simulator({**free(10, origin=[0, 0, 0.001]), "colliders": [slope],
                           "simulation": {"gravity": [4.9, 0, -8.5]}})
    simulator.step(30)
    assert simulator.velocities[:, 0].mean() > 0.5  # slips
    simulator.set(collider_friction={"slope": 2}, thickness=0.02, self_collision="points", friction=0.5)
    simulator.step(60)
    assert np.abs(simulator.velocities).max() < 1e-3
    assert simulator.report["self_collision"] == "points"
    for values, key in (({"collider_friction": {"ball": 1}}, "collider_friction.ball"),
                        ({"thickness": 0}, "thickness"), ({"friction": float("nan")}, "friction"),
                        ({"self_collision": "maybe"}, "self_collision")):
        with pytest.raises(clothsim.InvalidValue) as error:
            simulator.set(**values)
        assert error.value.key == key


# ---- State

def test_positions_are_a_view_that_shows_each_frame():
    simulator = Simulator(free())
    positions, velocities = simulator.positions, simulator.velocities
    assert positions.shape == velocities.shape == (64, 3) and positions.dtype == np.float64
    before = positions.copy()
    simulator.step()
    assert not np.array_equal(positions, before)
    assert np.shares_memory(positions, simulator.positions)
    for array in (positions, velocities):
        with pytest.raises(ValueError):
            array[0] = 0
        with pytest.raises(ValueError):
            array.flags.writeable = True


@pytest.mark.parametrize("method", ["auto", "verlet", "rk4", "implicit_euler", "bdf2", "xpbd"])
def test_views_stay_with_every_method(method):
    simulator = Simulator(busy(method))
    positions = simulator.positions
    saved = simulator.save()
    for change in (simulator.step, simulator.reset, lambda: simulator.restore(saved),
                   lambda: simulator.set(springs={"bending": False}), lambda: simulator.step(3),
                   lambda: simulator.set_state(positions=simulator.positions.copy())):
        change()
        assert np.shares_memory(positions, simulator.positions)


def test_views_outlive_the_simulator_and_its_scene():
    simulator = Simulator(free())
    simulator.step()
    view = simulator.positions
    kept = view.copy()
    simulator.load(free(5))
    simulator.step(3)
    assert simulator.positions.shape == (25, 3)
    assert np.array_equal(view, kept)
    view = simulator.positions[3:, 1]
    kept = view.copy()
    del simulator
    ballast = [np.ones((25, 3)) for _ in range(100)]
    assert np.array_equal(view, kept) and ballast


def test_a_refused_scene_leaves_the_old_one():
    simulator = Simulator(free())
    simulator.step()
    kept = simulator.positions.copy()
    with pytest.raises(clothsim.InvalidValue):
        simulator.load({"cloth": {"ks": -1}})
    assert np.array_equal(simulator.positions, kept)


def test_states_are_set_and_checked():
    simulator = Simulator(hanging())
    given = np.asfortranarray(simulator.positions + [0, 0, 0.0])
    given[30] += [0.01, 0, 0]
    simulator.positions = given
    assert np.array_equal(simulator.positions, given)
    simulator.velocities = given.tolist()
    held = simulator.topology["pinned"]
    assert np.array_equal(np.delete(simulator.velocities, held, 0), np.delete(given, held, 0))
    simulator.set_state(time=7.5)
    assert simulator.time == 7.5

    kept = simulator.positions.copy(), simulator.velocities.copy(), simulator.time
    wrong = given.copy()
    wrong[3, 1] = math.nan
    moved = given + [0, 0, 1]  # the pins, too
    for bad, key in [
            ({"positions": given[:-1]}, "positions"), ({"positions": given.T}, "positions"),
            ({"positions": 5}, "positions"), ({"positions": "abc"}, "positions"),
            ({"positions": wrong}, "positions.3"), ({"velocities": wrong}, "velocities.3"),
            ({"positions": moved}, "positions.0"), ({"velocities": given + 1e4}, "velocities.0"),
            ({"time": -1.0}, "time"), ({"time": math.inf}, "time"), ({"memory": [1, 2]}, "memory"),
            ({"memory": [[1]]}, "memory")]:
        with pytest.raises(clothsim.InvalidValue) as caught:
            simulator.set_state(**bad)
        assert caught.value.key == key
        assert np.array_equal(simulator.positions, kept[0])
        assert np.array_equal(simulator.velocities, kept[1]) and simulator.time == kept[2]


def test_a_state_with_its_memory_goes_on_to_the_same_bits():
    simulator, other = Simulator(busy()), Simulator(busy())
    simulator.step(40)
    state = {"positions": simulator.positions.copy(), "velocities": simulator.velocities.copy(),
             "time": simulator.time, "memory": simulator.memory}
    simulator.step(20)
    other.set_state(**state)
    other.step(20)
    assert same_state(simulator, other)
    simulator.set_state(**{**state, "memory": None})
    simulator.step(20)
    assert not same_state(simulator, other)


def test_what_is_hardly_meant_is_warned_of():
    with pytest.warns(UserWarning, match=r"cloth.width: got 40 \[m\].* 1.6 m.* 0.4.* cm"):
        simulator = Simulator({"cloth": {"width": 40, "columns": 26}})
    with pytest.warns(UserWarning, match="points of the cloth start in collider ball"):
        simulator.load({"cloth": {}, "colliders": [{"shape": "sphere", "name": "ball", "center": [0.5, 0.5, 1]}]})
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        simulator.load(SCENES / "sphere.yaml")


def test_values_of_the_scene_come_back():
    simulator, twin = Simulator(SCENES / "sphere.yaml"), Simulator(SCENES / "sphere.yaml")
    simulator.set(ks=500, damping=27, strain_limit="off", gravity=[0, 0, -5], substeps=4, method="verlet",
                  collider_friction={"sphere": 0.8}, thickness=0.005, springs={"shear": False})
    simulator.step(10)
    simulator.reset()  # keeps them
    simulator.step(10)
    twin.step(10)
    assert not same_state(simulator, twin)
    simulator.reset_values()
    simulator.reset()
    simulator.step(10)
    assert same_state(simulator, twin)
    simulator.load(SCENES / "plane.yaml")  # which has the scene's values from now on
    simulator.set(ks=500)
    simulator.reset_values()
    twin.load(SCENES / "plane.yaml")
    for run in (simulator, twin):
        run.step(2)
    assert same_state(simulator, twin)


def test_saved_states_bring_back_frames_on_their_way():
    simulator = Simulator(busy())
    simulator.step(20, {"ball": [0.5, 0.5, 0.8]})
    simulator.attach("finger", [1, 1, 1], radius=0.2)
    simulator.step(5, {"finger": [1, 1, 1.1], "hand": [0, 0.1, 1]})
    saved = simulator.save()
    assert saved.nbytes > simulator.positions.nbytes
    simulator.step(10, {"finger": [1, 1, 1.2]})
    expected = simulator.positions.copy()
    simulator.detach()
    simulator.reset()
    simulator.step(3)
    simulator.restore(saved)
    simulator.step(10, {"finger": [1, 1, 1.2]})
    assert np.array_equal(simulator.positions, expected)
    twin = Simulator(busy())
    twin.restore(saved)
    twin.step(10, {"finger": [1, 1, 1.2]})
    assert np.array_equal(twin.positions, expected)
    with pytest.raises(clothsim.InvalidValue):
        Simulator(free()).restore(saved)


def test_topology_tells_what_the_cloth_is():
    topology = Simulator(hanging(5)).topology
    assert (topology["columns"], topology["rows"], topology["pinned"]) == (5, 5, [0, 4])
    rest = topology["rest_positions"]
    a, b = topology["springs"].T
    assert np.allclose(np.linalg.norm(rest[a] - rest[b], axis=1), topology["rest_lengths"])
    counts = np.bincount(topology["families"]).tolist()
    assert counts == [2 * 5 * 4, 2 * 4 * 4, 2 * 5 * 3]
    corners = rest[topology["triangles"]]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    assert normals.shape == (32, 3) and (normals[:, 2] > 0).all()
    assert np.linalg.norm(normals, axis=1).sum() / 2 == pytest.approx(1)
    assert topology["mass"].sum() == pytest.approx(5)
    assert topology["uv"].min() == 0 and topology["uv"].max() == 1


# ---- Live values

def test_live_values_change_the_run():
    simulator = Simulator(hanging())
    simulator.set(ks=50, damping=20, springs={"shear": False}, gravity=(0, 0, -1), substeps=12,
                  strain_limit=0.2, method="xpbd", method_parameters={"iterations": 3})
    report = simulator.step()
    assert (report.method, report.substeps) == ("xpbd", 12)
    assert set(simulator.topology["families"]) == {0, 2}
    assert simulator.topology["stiffness"].max() == 50
    twin = Simulator({"cloth": {**hanging()["cloth"], "ks": 50, "damping": 20, "strain_limit": 0.2,
                                "springs": {"shear": False}},
                      "simulation": {"gravity": [0, 0, -1], "substeps": 12, "method": "xpbd",
                                     "method_parameters": {"iterations": 3}}})
    twin.step()
    assert same_state(simulator, twin)


def test_live_values_that_cannot_be_change_nothing():
    simulator, twin = Simulator(hanging()), Simulator(hanging())
    for values, key in [({"ks": -1}, "ks"), ({"ks": "soft"}, "ks"), ({"columns": 3}, "columns"),
                        ({"springs": {"bend": True}}, "springs.bend"), ({"seed": 4}, "seed"),
                        ({"ks": 7, "gravity": [0, 0]}, "gravity"), ({"method": "magic"}, "method"),
                        ({"method": "auto", "method_parameters": {"iterations": 1}},
                         "method_parameters")]:
        with pytest.raises(clothsim.InvalidValue) as caught:
            simulator.set(**values)
        assert caught.value.key == key
    simulator.step()
    twin.step()
    assert same_state(simulator, twin)


# ---- The package

def test_arguments_of_wrong_types_raise():
    simulator = Simulator(free())
    for call in (lambda: simulator.step("1"), lambda: simulator.step(1.5), lambda: Simulator(),
                 lambda: simulator.step(10**30), lambda: simulator.restore(None),
                 lambda: simulator.set_state(time="now"), lambda: simulator.attach(5),
                 lambda: Scene(free(), 5)):
        with pytest.raises(TypeError):
            call()


def test_names_are_those_of_the_package():
    assert set(clothsim.__all__) <= set(dir(clothsim))
    assert clothsim.Simulator.__module__ == "clothsim"
    assert repr(Scene(free())).startswith("<clothsim.Scene of 8 x 8")
    with pytest.raises(AttributeError):
        clothsim.Simulater
    assert pathlib.Path(clothsim.__file__).parent.joinpath("py.typed").exists()


def test_a_scene_does_not_follow_its_dict():
    source = busy()
    scene = Scene(source)
    kept = copy.deepcopy(source)
    source["cloth"]["ks"] = 1
    assert scene.to_dict()["cloth"]["ks"] == kept["cloth"]["ks"]
