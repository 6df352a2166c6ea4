"""Frames that a script moves, and their followers: colliders, pins, attached points."""

import math
import re

import numpy as np
import pytest
from scenes import busy, free, same_state

import clothsim
from clothsim import Simulator

G = 9.8  # [m/s^2]


def test_a_collider_goes_to_its_target_in_equal_moves():
    simulator = Simulator(busy())
    simulator.place_frame("ball", [0.5, 0.5, 0.2])
    heights = []
    for _ in range(3):  # one motion of nine frames, seen three times
        before = simulator.colliders["ball"]["pose"][2]
        simulator.step(3, {"ball": [0.5, 0.5, before + 0.05]})
        heights.append(simulator.colliders["ball"]["pose"][2])
    assert np.allclose(heights, [0.25, 0.3, 0.35])
    assert simulator.colliders["ball"]["frame"] == "ball"

    half_turn = [0.5, 0.5, 0.35, 0, 0, 1, 0]
    simulator.step(1, {"ball": ([0.5, 0.5, 0.3], half_turn)})
    assert np.allclose(simulator.colliders["ball"]["pose"], half_turn)


def test_a_pin_follows_its_frame():
    simulator = Simulator(busy())
    simulator.place_frame("hand", [0, 0, 1])
    simulator.step(9, {"hand": [0.05, 0, 1.1]})
    assert np.allclose(simulator.positions[0], [0.05, 0, 1.1])


def test_what_hangs_on_a_frame_pulls_it_down():
    simulator = Simulator(free(10, damping=20))
    points = simulator.attach("hand", [0, 0, 1], radius=0.15)
    assert points == [0, 1, 10]
    assert simulator.grips["hand"]["points"] == points
    simulator.step(900)
    grip = simulator.grips["hand"]
    free_mass = simulator.topology["mass"].sum()
    assert grip["force"][2] == pytest.approx(-free_mass * G, rel=1e-3)
    assert np.allclose(grip["pose"], [0, 0, 1, 0, 0, 0, 1])
    simulator.step(90, {"hand": [0, 0, 1.5]})
    assert simulator.positions[0] == pytest.approx([0, 0, 1.5])
    simulator.attach("hand", points=[2])
    simulator.detach(points=[0])
    assert simulator.grips["hand"]["points"] == [1, 2, 10]
    simulator.detach("hand")
    assert simulator.grips == {}


def test_points_by_place():
    simulator = Simulator(free(10))
    places = [{"near": [1, 0, 1]}, (0, 9), 50, {"within": 0.12, "of": np.array([0, 0, 1])}, {"uv": [1, 1]}]
    assert simulator.attach("hand", [0, 0, 1], points=places) == [9, 90, 50, 0, 1, 10, 99]
    simulator.detach(points=[{"uv": [1, 1]}, [0, 9]])
    assert simulator.grips["hand"]["points"] == [0, 1, 9, 10, 50]
    simulator.step(5)  # places are those at the start
    simulator.detach("hand")
    assert simulator.attach("hand", points=[{"near": [0, 0, 1]}]) == [0]
    simulator.detach("hand")
    assert simulator.attach("hand", points=np.array([[0, 9], [1, 9]])) == [90, 91]
    assert simulator.attach("hand", points=np.array([{"near": [1, 0, 1]}, 5], dtype=object)) == [9, 5]
    assert simulator.attach("hand", points=[np.array([3, 3])]) == [33]


def test_points_by_the_names_of_a_pattern():
    square = [[0, 0], [0.1, 0], [0.1, 0.1], [0, 0.1]]
    simulator = Simulator({"cloth": {"fabric": "silk", "pattern": {
        "cell": 0.05, "panels": [{"name": "front", "outline": square, "pose": {"xyz": [0, 0, 1]}}]}}})
    side = simulator.attach("hand", [0, 0, 1], points=[{"side": "front.2"}])
    assert len(side) == 3
    assert np.allclose(simulator.positions[side, 1], 0.1)
    (corner,) = simulator.attach("other", [0, 0, 1], points=[{"corner": "front.1"}])
    assert np.allclose(simulator.positions[corner], [0.1, 0, 1])


@pytest.mark.parametrize("points, cloth, message", [
    ([{"near": [0, 0]}], None, "points.0.near: got"),
    ([{"nearby": [0, 0, 1]}], None, "points.0.nearby: got"),
    ([{"near": [0, 0, 1], "uv": [0, 0]}], None, "points.0: got a part of a place, or two"),
    ([[10, 0]], None, "points.0"),
    ([1, {"within": 0.1, "of": [9, 9, 9]}], None, "points.1.within: got 0.1"),
    ([{"side": "front.2"}], None, "points.0.side: got \"front.2\", expected none"),
    ([{"near": {1, 2}}], None, "points.0.near: got"),
    ({"near": [0, 0, 1]}, None, "points: got a value of type dict, expected a list of numbers, [column, row] or places"),
    ("12", None, "points: got"),
    ([{"within": 100, "of": [0, 0, 0]}] * 2, None, "points.1: got 0 again, expected each point once"),
    ([0, {"near": [0, 0, 1]}], None, "points.1: got 0"),
    ([1], "shirt", "cloth: got \"shirt\""),
    ([1], "", "cloth: got"),
    (None, "shirt", "cloth: got \"shirt\", expected none without points")])
def test_wrong_places_are_refused(points, cloth, message):
    simulator = Simulator(free(10))
    radius = 0.1 if points is None else None
    with pytest.raises(clothsim.InvalidValue, match=re.escape(message)):
        simulator.attach("hand", [0, 0, 1], points=points, radius=radius, cloth=cloth)
    assert simulator.grips == {}
    simulator.attach("hand", [0, 0, 1], points=range(20))
    with pytest.raises(clothsim.InvalidValue):
        simulator.detach(points=points, cloth=cloth)
    assert simulator.grips["hand"]["points"] == list(range(20))


def test_a_weak_frame_lets_go():
    simulator = Simulator(free(10))
    simulator.attach("hand", [0, 0, 1], points=[0], tear_force=1)
    simulator.step(60)
    assert simulator.grips == {}


def test_a_collider_that_is_off_touches_nothing():
    def lowest(enabled):
        simulator = Simulator({**free(damping=0),
                               "colliders": [{"shape": "plane", "name": "ground"}]})
        simulator.enable_collider("ground", enabled)
        assert simulator.colliders["ground"]["enabled"] is enabled
        simulator.step(90)
        return simulator.positions[:, 2].min()
    assert lowest(True) > 0
    assert lowest(False) < -1


def test_frames_that_cannot_be_are_refused_and_nothing_moves():
    simulator, twin = Simulator(busy()), Simulator(busy())
    simulator.attach("finger", [1, 1, 1], points=[99])
    twin.attach("finger", [1, 1, 1], points=[99])
    for call, key in [
            (lambda: simulator.step(targets={"bal": [0, 0, 0]}), "targets.bal"),
            (lambda: simulator.step(targets={"ball": [0, 0]}), "targets.ball"),
            (lambda: simulator.step(targets={"ball": [[[0, 0, 0]]]}), "targets.ball"),
            (lambda: simulator.step(targets={"ball": None}), "targets.ball"),
            (lambda: simulator.step(targets={"ball": "up"}), "targets.ball"),
            (lambda: simulator.step(targets={"ball": [0, 0, math.nan]}), "targets.ball.position.2"),
            (lambda: simulator.step(targets={"ball": [0, 0, 0, 1, 1, 1, 1]}),
             "targets.ball.orientation"),
            (lambda: simulator.step(targets={"ball": ([0, 0, math.inf], [0, 0, 0])}),
             "targets.ball.start.position.2"),
            (lambda: simulator.step(targets=[1]), "targets"),
            (lambda: simulator.step(0), "frames"),
            (lambda: simulator.place_frame("/ball", [0, 0, 0]), ""),
            (lambda: simulator.attach("new", points=[5]), "pose"),
            (lambda: simulator.attach("new", [0, 0, 1]), "points"),
            (lambda: simulator.attach("new", [0, 0, 1], [1], 0.1), "points"),
            (lambda: simulator.attach("new", [0, 0, 1], [100]), "points.0"),
            (lambda: simulator.attach("new", [0, 0, 1], [1.5]), "points.0"),
            (lambda: simulator.attach("new", [0, 0, 1], [0]), "points.0"),
            (lambda: simulator.attach("new", [0, 0, 1], [1], tear_force=-1), "tear_force"),
            (lambda: simulator.attach("new", [0, 0, 9], radius=0.1), "radius"),
            (lambda: simulator.detach("new"), "frame"),
            (lambda: simulator.detach(points=[3]), "points.0"),
            (lambda: simulator.enable_collider("wall"), "name")]:
        with pytest.raises(clothsim.InvalidValue) as caught:
            call()
        if key:
            assert caught.value.key == key
    simulator.step(5)
    twin.step(5)
    assert same_state(simulator, twin)
