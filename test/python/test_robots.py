"""The joints of a scene's robots: forward kinematics against matrices in this file."""

import numpy as np
import pytest
from scenes import SCENES, free, same_state

import clothsim
from clothsim import InvalidValue, Simulator

URDF = """
<robot name="toy">
  <link name="base"/>
  <link name="mast"><collision><origin xyz="0 0 0.5"/><geometry><box size="0.1 0.1 1"/></geometry></collision></link>
  <link name="boom"><collision><geometry><sphere radius="0.1"/></geometry></collision></link>
  <link name="left"><collision><geometry><sphere radius="0.02"/></geometry></collision></link>
  <link name="right"><collision><geometry><sphere radius="0.02"/></geometry></collision></link>
  <link name="tool"/>
  <joint name="turn" type="continuous"><parent link="base"/><child link="mast"/><axis xyz="0 0 2"/>
    <origin xyz="0 0 0.2"/></joint>
  <joint name="lift" type="revolute"><parent link="mast"/><child link="boom"/><axis xyz="0 -1 0"/>
    <origin xyz="0.3 0 1" rpy="0 0 1.5707963267948966"/><limit lower="-1" upper="0.5" effort="1" velocity="1"/></joint>
  <joint name="grip" type="prismatic"><parent link="boom"/><child link="left"/><axis xyz="1 0 0"/>
    <origin xyz="0.4 0 0"/><limit lower="0" upper="0.05" effort="1" velocity="1"/></joint>
  <joint name="grip_too" type="prismatic"><parent link="boom"/><child link="right"/><axis xyz="1 0 0"/>
    <origin xyz="0.4 0 0"/><mimic joint="grip" multiplier="-1" offset="0.01"/></joint>
  <joint name="flange" type="fixed"><parent link="boom"/><child link="tool"/><axis xyz="0 0 0"/>
    <origin xyz="0.5 0 0"/></joint>
</robot>
"""


def about(axis, angle):
    axis = np.asarray(axis, dtype=float) / np.linalg.norm(axis)
    cross = np.cross(np.eye(3), axis)
    matrix = np.eye(4)
    matrix[:3, :3] += np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross
    return matrix


def shift(x, y, z):
    matrix = np.eye(4)
    matrix[:3, 3] = x, y, z
    return matrix


def matrix_of(pose):
    x, y, z, w = pose[3:]
    matrix = shift(*pose[:3])
    matrix[:3, :3] = [[1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
                      [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
                      [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]]
    return matrix


def expected(turn=0, lift=0, grip=0):
    """The links' matrices, for a robot whose root is at (1, 2, 0), turned by 0.3 about z."""
    mast = shift(1, 2, 0) @ about([0, 0, 1], 0.3) @ shift(0, 0, 0.2) @ about([0, 0, 1], turn)
    boom = mast @ shift(0.3, 0, 1) @ about([0, 0, 1], np.pi / 2) @ about([0, -1, 0], lift)
    return {"mast": mast, "boom": boom, "left": boom @ shift(0.4 + grip, 0, 0),
            "right": boom @ shift(0.4 - grip + 0.01, 0, 0)}


@pytest.fixture
def scene(tmp_path):
    (tmp_path / "toy.urdf").write_text(URDF)
    return dict(free(6, origin=[0, 0, 3]), robots=[
        {"file": str(tmp_path / "toy.urdf"), "prefix": "a_", "pose": {"xyz": [1, 2, 0], "rpy": [0, 0, 0.3]}}])


def check_links(simulator, joints):
    """The colliders' frames; the box of the mast is half a metre up in its link's frame."""
    for link, matrix in expected(**joints).items():
        offset = shift(0, 0, 0.5) if link == "mast" else np.eye(4)
        pose = simulator.colliders["toy/a_" + link]["pose"]
        assert np.allclose(matrix_of(pose), matrix @ offset, atol=1e-12), link


def test_links_are_where_joints_have_them(scene):
    simulator = Simulator(scene)
    robot = simulator.robots["toy"]
    joints = robot.joints
    assert set(joints) == {"turn", "lift", "grip"}
    assert joints["lift"] == {"position": 0, "lower": -1, "upper": 0.5}
    assert joints["turn"]["lower"] is None and joints["turn"]["upper"] is None
    for values in ({"turn": 1.2, "lift": -0.7, "grip": 0.03}, {"turn": -9}, {"lift": 0.5, "grip": 0}):
        robot.set_joints(values)
        told = {name: joint["position"] for name, joint in robot.joints.items()}
        assert {name: told[name] for name in values} == values
        check_links(simulator, told)  # also for the joints that were set before
    simulator.reset()
    assert all(joint["position"] == 0 for joint in robot.joints.values())
    robot.set_joints({})
    check_links(simulator, {})


def test_step_moves_a_robot_there(scene):
    simulator = Simulator(scene)
    robot = simulator.robots["toy"]
    targets = robot.targets({"lift": 0.2, "grip": 0.02})
    assert set(targets) == {"a_mast", "a_boom", "a_left", "a_right"}
    simulator.step(9, targets)
    check_links(simulator, {"lift": 0.2, "grip": 0.02})
    batch = clothsim.Batch([simulator])
    batch.step([robot.targets({"turn": 0.1})], 3)
    check_links(simulator, {"turn": 0.1, "lift": 0.2, "grip": 0.02})

    simulator.attach("a_tool", [0, 0, 0], points=[0])  # a link without collisions, once it is known
    assert "a_tool" in robot.targets({})


def test_joints_are_saved_and_pickled(scene):
    import pickle
    simulator = Simulator(scene)
    simulator.robots["toy"].set_joints({"lift": 0.3})
    state = simulator.save()
    other = pickle.loads(pickle.dumps(simulator))
    simulator.robots["toy"].set_joints({"lift": -0.3})
    simulator.restore(state)
    for each in (simulator, other):
        assert each.robots["toy"].joints["lift"]["position"] == 0.3
        each.step(3, each.robots["toy"].targets({"turn": 0.1}))
        check_links(each, {"turn": 0.1, "lift": 0.3})
    assert same_state(simulator, other)


def test_the_arm_reaches_down_to_the_towel():
    simulator = Simulator(SCENES / "arm.yaml")
    arm = simulator.robots["arm"]
    assert set(arm.joints) == {"pan", "shoulder", "elbow", "wrist", "roll", "finger_a", "finger_b"}
    arm.set_joints({"shoulder": 0.9, "elbow": 1.2, "wrist": np.pi - 2.1, "finger_a": 0.04, "finger_b": 0.04})
    # In the plane of the arm: two links of 0.45 m on a shoulder 0.35 m up, the hand straight down.
    out = 0.45 * (np.sin(0.9) + np.sin(2.1))
    up = 0.35 + 0.45 * (np.cos(0.9) + np.cos(2.1)) - 0.06
    frame = simulator.colliders["arm/hand"]["pose"]
    assert np.allclose(frame[:3], [0.2, -0.5 + out, up], atol=1e-9)


@pytest.mark.parametrize("joints, key, message", [
    ({"lift": 0.6}, "joints.lift", "got 0.6.*most 0.5 \\[rad\\]"),
    ({"grip": -0.01}, "joints.grip", "at least 0 \\[m\\]"),
    ({"turn": float("nan")}, "joints.turn", "finite"),
    ({"elbow": 1}, "joints.elbow", "one of grip, lift, turn"),
    ({"grip_too": 0.01}, "joints.grip_too", "cannot be set"),
    ({"flange": 0.01}, "joints.flange", "cannot be set"),
])
def test_what_cannot_be_is_refused(scene, joints, key, message):
    simulator = Simulator(scene)
    robot = simulator.robots["toy"]
    robot.set_joints({"lift": 0.1})
    for call in (robot.set_joints, robot.targets):
        with pytest.raises(InvalidValue, match=message) as caught:
            call({"turn": 0.5, **joints})
        assert caught.value.key == key
    check_links(simulator, {"lift": 0.1})


def test_robots_of_one_name_and_of_another_scene(scene):
    scene["robots"].append(dict(scene["robots"][0], prefix="b_"))
    simulator = Simulator(scene)
    assert set(simulator.robots) == {"toy", "toy/b_"}
    simulator.robots["toy"].set_joints({})
    simulator.robots["toy/b_"].set_joints({"turn": 1})
    check_links(simulator, {})
    robot = simulator.robots["toy"]
    simulator.load(free())
    assert simulator.robots == {}
    with pytest.raises(InvalidValue, match="a robot of the scene"):
        robot.set_joints({})


@pytest.mark.parametrize("wrong, message", [
    (("<axis xyz=\"0 -1 0\"/>", "<axis xyz=\"0 0 0\"/>"), "the joint \"lift\": xyz of <axis> is 0"),
    (("upper=\"0.5\"", "upper=\"half\""), "upper of <limit> is \"half\""),
    (("mimic joint=\"grip\"", "mimic joint=\"flange\""), "mimics \"flange\""),
])
def test_a_joint_that_is_wrong_is_told_when_it_is_asked_for(tmp_path, wrong, message):
    (tmp_path / "toy.urdf").write_text(URDF.replace(*wrong))
    simulator = Simulator(dict(free(4), robots=[{"file": str(tmp_path / "toy.urdf")}]))
    simulator.step()  # its links stay where they are
    with pytest.raises(InvalidValue) as caught:
        simulator.robots
    assert message in str(caught.value) and caught.value.key.startswith("robots.0")
