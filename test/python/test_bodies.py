"""Rigid bodies: colliders with a mass, which the cloth moves."""

import copy
import gc
import math
import pickle

import numpy as np
import pytest
from scenes import same_state

import clothsim
from clothsim import InvalidValue, Simulator

G = 9.8  # [m/s^2]
BALL = {"name": "ball", "shape": "sphere", "radius": 0.1, "center": [0.5, 0.5, 1.12], "mass": 0.5, "damping": 2}
BRICK = {"name": "brick", "shape": "box", "size": [0.1, 0.2, 0.05], "center": [0.6, 0.5, 1.6], "rpy": [0.3, 0.2, 0.1],
         "mass": 0.3, "friction": 0.4}
GROUND = {"name": "ground", "shape": "plane", "friction": 0.5}


def trampoline(*colliders, points=21, damping=1, **simulation):
    """A cloth at z = 1 m that four pins hold."""
    last = points - 1
    return {"cloth": {"columns": points, "rows": points, "density": 0.3, "ks": 300, "damping": damping,
                      "pinned": [[0, 0], [last, 0], [0, last], [last, last]]},
            "colliders": list(colliders), "simulation": simulation}


def tumbling(method="auto"):
    """Bodies that fall on the cloth and on each other, between colliders that are not bodies."""
    return trampoline(GROUND, {**BALL, "friction": 0.5, "velocity": [0.3, 0, 0], "angular_velocity": [1, 5, 0]},
                      {"name": "post", "shape": "capsule", "center": [2, 2, 0.5]}, BRICK, points=11, method=method)


def motions(simulator):
    return [np.concatenate([body.pose, body.velocity, body.angular_velocity])
            for body in simulator.bodies.values()]


def same(a, b):
    return same_state(a, b) and np.array_equal(motions(a), motions(b)) and np.array_equal(a.memory, b.memory)


def again(thing):
    return pickle.loads(pickle.dumps(thing))


@pytest.mark.parametrize("friction", [0, 0.5])
def test_a_cloth_carries_a_ball(friction):
    simulator = Simulator(trampoline({**BALL, "friction": friction}))
    simulator.weighs_colliders = True
    ball = simulator.bodies["ball"]
    simulator.step(12 * 90)
    forces = []
    for _ in range(90):
        simulator.step()
        forces.append(simulator.contacts["ball"]["force"])
        assert np.linalg.norm(ball.velocity) < 5e-3
    assert np.mean(forces, axis=0) == pytest.approx([0, 0, 0.5 * G], rel=1e-3, abs=1e-3)
    assert ball.pose[:2] == pytest.approx([0.5, 0.5], abs=1e-3)
    assert 0.7 < ball.pose[2] - 0.1 < 0.9  # the cloth sags
    assert simulator.positions[:, 2].min() == pytest.approx(ball.pose[2] - 0.1, abs=0.01)


def test_bodies_are_in_the_scenes_order_with_their_values():
    bodies = Simulator(tumbling()).bodies
    assert list(bodies) == [body.name for body in bodies.values()] == ["ball", "brick"]
    assert [body.mass for body in bodies.values()] == [0.5, 0.3]
    ball, brick = bodies.values()
    assert ball.pose == pytest.approx([0.5, 0.5, 1.12, 0, 0, 0, 1])
    assert brick.pose[:3] == pytest.approx([0.6, 0.5, 1.6]) and np.linalg.norm(brick.pose[3:]) == pytest.approx(1)
    assert list(ball.velocity) == [0.3, 0, 0] and list(ball.angular_velocity) == [1, 5, 0]
    assert list(brick.velocity) == list(brick.angular_velocity) == [0, 0, 0]
    assert Simulator(trampoline(GROUND)).bodies == {}


def test_a_placed_body_has_the_pose_and_the_velocities():
    simulator = Simulator(tumbling())
    body = simulator.bodies["brick"]
    turned = [0.1, 0.2, 3, 0, 0, 0.6, 0.8]
    body.place(turned, [1, 2, 3], angular_velocity=np.array([4, 5, 6]))
    assert body.pose == pytest.approx(turned)
    assert list(body.velocity) == [1, 2, 3] and list(body.angular_velocity) == [4, 5, 6]
    assert simulator.colliders["brick"]["pose"] == pytest.approx(turned)
    body.place([0, 0, 2])
    assert list(body.pose) == [0, 0, 2, 0, 0, 0, 1]
    assert not body.velocity.any() and not body.angular_velocity.any()


def test_a_body_falls_freely_and_keeps_turning():
    simulator = Simulator(trampoline({**BALL, "damping": 0}, damping=0, method="verlet"))
    body = simulator.bodies["ball"]
    body.place([5, 0, 3], [1, 0, 2], [0, 3, 0])
    for frame in range(1, 91):
        simulator.step()
        t = frame / 90
        assert body.pose == pytest.approx(
            [5 + t, 0, 3 + 2 * t - G * t * t / 2, 0, math.sin(1.5 * t), 0, math.cos(1.5 * t)], abs=1e-6)
        assert body.velocity == pytest.approx([1, 0, 2 - G * t], abs=1e-6)
        assert body.angular_velocity == pytest.approx([0, 3, 0], abs=1e-6)


def test_the_velocity_is_that_of_the_centre_of_mass():
    simulator = Simulator(trampoline({**BALL, "damping": 0, "center_of_mass": [0.05, 0, 0]}, gravity=[0, 0, 0]))
    body = simulator.bodies["ball"]
    body.place([5, 0, 3], angular_velocity=[0, 0, 2 * math.pi])
    simulator.step(45)  # half a turn about the centre of mass, which rests at x = 5.05 m
    assert body.pose[:3] == pytest.approx([5.1, 0, 3], abs=1e-6)
    assert body.velocity == pytest.approx([0, 0, 0], abs=1e-9)


@pytest.mark.parametrize("method", ["verlet", "bdf2", "implicit_euler", "xpbd"])
def test_bodies_in_motion_go_on_to_the_same_bits(method):
    simulator, whole = Simulator(tumbling(method)), Simulator(tumbling(method))
    whole.step(70)
    simulator.step(30)
    state = simulator.save()
    others = [again(simulator), copy.deepcopy(simulator), Simulator(tumbling(method))]
    others[2].restore(again(state))
    others.append(with_state_of(simulator, Simulator(tumbling(method))))
    assert simulator.step(40).contacts > 0
    assert all(np.linalg.norm(body.velocity) > 1e-3 for body in simulator.bodies.values())
    assert same(simulator, whole)
    simulator.step(20)
    simulator.restore(state)
    for each in (simulator, *others):
        each.step(40)
        assert same(each, whole)


def with_state_of(simulator, other):
    """`other` with the same state, by arrays and numbers alone."""
    for name, body in simulator.bodies.items():
        other.bodies[name].place(body.pose)
    other.set_state(simulator.positions, simulator.velocities, simulator.time, simulator.memory)
    return other


def test_a_saved_state_keeps_velocities_where_its_memory_does_not_fit():
    simulator = Simulator(tumbling())
    simulator.step(10)
    states = simulator.save(), again(simulator.save())
    expected = motions(simulator)
    for state in states:
        other = Simulator(tumbling())
        other.set(method="xpbd")
        other.restore(state)
        assert np.allclose(motions(other), expected, rtol=0, atol=1e-12)


def test_a_reset_brings_bodies_back():
    simulator = Simulator(tumbling())
    start = motions(simulator)
    simulator.step(30)
    assert not np.allclose(motions(simulator), start)
    simulator.reset()
    assert np.array_equal(motions(simulator), start)


def test_a_body_keeps_its_simulator_alive():
    bodies = Simulator(tumbling()).bodies
    gc.collect()
    assert bodies["ball"].mass == 0.5


def test_a_body_is_found_by_name_in_another_scene():
    simulator = Simulator(tumbling())
    ball = simulator.bodies["ball"]
    simulator.load(trampoline({**BALL, "mass": 2}))
    assert ball.mass == 2 and list(simulator.bodies) == ["ball"]
    simulator.load(trampoline({"name": "ball", "shape": "sphere"}))
    for call in (lambda: ball.mass, lambda: ball.pose, lambda: ball.place([0, 0, 1])):
        with pytest.raises(InvalidValue, match='bodies: got "ball", expected a body of the scene'):
            call()


def test_places_that_cannot_be_are_refused_and_nothing_moves():
    simulator, twin = Simulator(tumbling()), Simulator(tumbling())
    with pytest.raises(KeyError):
        simulator.bodies["ground"]
    ball = simulator.bodies["ball"]
    for call, message in [
            (lambda: ball.place([0, 0, math.nan]), "pose.position.2: got nan, expected a finite number [m]"),
            (lambda: ball.place([0, 0, 0, 1, 1, 1, 1]),
             "pose.orientation: got a quaternion of norm 2, expected norm 1"),
            (lambda: ball.place([0, 0]),
             "pose: got an array of shape [2], expected [x, y, z] or [x, y, z, qx, qy, qz, qw]"),
            (lambda: ball.place([0, 0, 1], [0, math.nan, 0]), "velocity.1: got nan, expected a finite number [m/s]"),
            (lambda: ball.place([0, 0, 1], [0, 0, 2000]),
             "velocity.2: got 2000, expected a number of at most 1000 [m/s]"),
            (lambda: ball.place([0, 0, 1], None), "velocity: got nothing, expected [x, y, z]"),
            (lambda: ball.place([0, 0, 1], angular_velocity=[0, 0, -math.inf]),
             "angular_velocity.2: got -inf, expected a finite number [rad/s]"),
            (lambda: ball.place([0, 0, 1], angular_velocity=[[0, 0, 1]]),
             "angular_velocity: got an array of shape [1, 3], expected [x, y, z]"),
            (lambda: simulator.step(targets={"ball": [0, 0, 1]}),
             "targets.ball: got a frame that nothing follows, expected one that was placed or attached to")]:
        with pytest.raises(InvalidValue) as caught:
            call()
        assert str(caught.value) == message and caught.value.key == message.split(":")[0]
    for attribute in ("name", "mass", "pose", "velocity", "angular_velocity"):
        with pytest.raises(AttributeError):
            setattr(ball, attribute, getattr(ball, attribute))
    simulator.step(5)
    twin.step(5)
    assert same(simulator, twin)


@pytest.mark.parametrize("collider, message", [
    ({**GROUND, "mass": 1}, "colliders.0.mass: got that of a plane, expected a solid"),
    ({**BALL, "mass": math.nan}, "colliders.0.mass: got .nan, expected a finite number"),
    ({**BALL, "mass": 0}, "colliders.0.mass: got 0, expected a number of at least 1e-06 [kg]"),
    ({**BALL, "frame": "hand"}, "colliders.0.frame: got hand, expected none, as the collider has a mass"),
    ({**GROUND, "velocity": [0, 0, 1]}, "colliders.0.velocity: got an unknown key"),
])
def test_bodies_that_cannot_be_are_refused(collider, message):
    with pytest.raises(clothsim.InvalidValue) as caught:
        Simulator(trampoline(collider))
    assert str(caught.value).startswith(message)


def test_a_held_body_follows_its_frame_and_flies_on():
    simulator = Simulator(trampoline(BALL))
    ball = simulator.bodies["ball"]
    ball.attach("hand", pose=[0.5, 0.5, 2])
    assert ball.frame == "hand"
    simulator.step(45, targets={"hand": [0.5, 0.2, 2]})
    np.testing.assert_allclose(ball.pose[:3], [0.5, 0.2, 1.12], atol=1e-12)
    np.testing.assert_allclose(ball.velocity, [0, -0.6, 0], atol=1e-9)
    saved = simulator.save()
    ball.detach()
    assert ball.frame is None
    simulator.step()
    np.testing.assert_allclose(ball.velocity, [0, -0.6 * math.exp(-2 / 90), -G / 90], atol=2e-3)
    flown = ball.pose
    simulator.restore(saved)
    assert ball.frame == "hand"
    ball.detach()
    simulator.step()
    assert np.array_equal(ball.pose, flown)
    simulator.reset()
    assert ball.frame is None


def test_a_body_without_a_frame_s_pose_is_held_where_it_is():
    simulator = Simulator(trampoline(BALL))
    simulator.bodies["ball"].attach("hand")
    simulator.step(20)
    np.testing.assert_allclose(simulator.bodies["ball"].pose[:3], BALL["center"], atol=1e-12)
    np.testing.assert_allclose(simulator.grips["hand"]["pose"][:3], BALL["center"], atol=1e-12)


def test_points_on_a_body_pull_on_it():
    simulator = Simulator({
        "cloth": {"columns": 5, "rows": 9, "width": 0.2, "height": 0.4, "orientation": "vertical", "damping": 4,
                  "origin": [0, 0, 1], "density": 0.3, "ks": 1000, "pinned": [[c, 8] for c in range(5)],
                  "attached": [{"body": "brick", "points": [[c, 0] for c in range(5)]}]},
        "colliders": [{"name": "brick", "shape": "box", "size": [0.3, 0.1, 0.1], "center": [0.1, 0, 0.94],
                       "mass": 0.3, "damping": 1}]})
    simulator.step(540)
    assert simulator.grips["brick"]["points"] == list(range(5))
    assert simulator.grips["brick"]["force"][2] == pytest.approx(0.3 * G, rel=0.02)
    again_ = pickle.loads(pickle.dumps(simulator))
    simulator.step(20)
    again_.step(20)
    assert same_state(simulator, again_)
    simulator.detach("brick")
    simulator.step(30)
    assert simulator.bodies["brick"].velocity[2] < -2


@pytest.mark.parametrize("act, message", [
    (lambda s: s.step(targets={"ball": [0, 0, 0]}), "ball"),
    (lambda s: s.place_frame("ball", [0, 0, 1]), "ball: got a rigid body"),
    (lambda s: s.attach("ball", points=[3], pose=[0, 0, 0]), "ball: got a rigid body"),
    (lambda s: s.attach("ball", points=[3], strength=2), "strength: got 2"),
    (lambda s: s.bodies["ball"].detach(), "body: got ball"),
    (lambda s: s.bodies["ball"].attach("brick"), "frame: got brick, a rigid body"),
    (lambda s: s.bodies["ball"].attach(""), "frame: got"),
    (lambda s: s.bodies["ball"].attach("hand", pose=[0, 0, math.nan]), "got nan")])
def test_holds_that_cannot_be_are_refused_and_nothing_changes(act, message):
    simulator = Simulator(trampoline(BALL, BRICK))
    with pytest.raises(InvalidValue, match=message):
        act(simulator)
    assert simulator.grips == {}
    assert simulator.bodies["ball"].frame is None


def test_a_joint_leaves_one_motion():
    drawer = dict(BRICK, rpy=[0, 0, 0], joint={"type": "slider", "axis": [2, 0, 0], "upper": 0.2}, velocity=[1, 1, 1])
    simulator = Simulator(trampoline(drawer))
    body = simulator.bodies["brick"]
    simulator.step(9)
    np.testing.assert_allclose(body.pose[:3], [0.7, 0.5, 1.6], atol=1e-9)
    simulator.step(90)
    np.testing.assert_allclose(body.pose[:3], [0.8, 0.5, 1.6], atol=1e-12)
    body.place([0.6, 0.5, 1.6])
    with pytest.raises(InvalidValue, match="pose: got one that its joint does not allow"):
        body.place([0.6, 0.5, 1.7])
