#!/usr/bin/python3
"""Points attached to tf frames: their motion, the forces on the frames, tearing, refusals."""

import math
import time
import unittest

import numpy as np
import rospy
import rostest
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import WrenchStamped
from rosgraph_msgs.msg import Log
from tf2_msgs.msg import TFMessage
from tf2_ros import StaticTransformBroadcaster

from clothsim.srv import Attach, Detach, GetState, RestoreState, SaveState
from cloth_client import (SLOWER, Cloth, Frames, Recorder, call, content, is_connected, make_transform, point,
                          positions, publisher_at_once, says, wait_for)

COLUMNS = 10
CORNERS = {"left": 0, "right": COLUMNS - 1}
WEIGHT = 5 * 9.8  # [N] of the whole cloth
NAN = float("nan")


class Hands:
    """Frames at given places, turned about z. Latched, so that a late listener receives them."""

    def __init__(self):
        self.broadcaster = StaticTransformBroadcaster()
        self.places = {}
        self.marks = 0

    def put(self, frame, place, angle=0.0):
        self.places[frame] = (place, angle)

    def send(self):
        """Returns the name of a new frame: where the node knows that one, it has all of this message."""
        self.marks += 1
        mark = "mark_" + str(self.marks)
        self.broadcaster.sendTransform(
            [make_transform(frame, place, angle) for frame, (place, angle) in self.places.items()] +
            [make_transform(mark, (0, 0, 90), 0)])
        return mark


class Grasp(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.cloth = Cloth()
        wait_for(cls.cloth.states.all, "the first state")
        cls.hands = Hands()
        cls.wrenches = {f: Recorder("/clothsim/wrench/" + f, WrenchStamped) for f in CORNERS}
        cls.diagnostics = Recorder("/diagnostics", DiagnosticArray)

    def setUp(self):
        self.cloth.reset()
        self.hands.put("left", (0, 0, 1))
        self.hands.put("right", (1, 0, 1))
        self.hands.put("far", (0, 0, 50))
        self.send_hands()

    def send_hands(self):
        mark = self.hands.send()
        wait_for(lambda: "no point" in self.attach(mark, radius=1e-6).message, "the hands' frames")

    def attach(self, frame, points=(), radius=0.0, tear_force=0.0, strength=0.0, places="", cloth=""):
        return call("/clothsim/attach", Attach, frame, points, radius, tear_force, strength, places, cloth)

    def detach(self, frame="", points=(), places="", cloth=""):
        return call("/clothsim/detach", Detach, frame, points, places, cloth)

    def take_corners(self, strength=0.0):
        for frame, corner in CORNERS.items():
            answer = self.attach(frame, radius=0.05, strength=strength)
            self.assertTrue(answer.success, answer.message)
            self.assertEqual(list(answer.points), [corner])

    def carry(self):
        """One frame of simulation after the hands' frames are set."""
        self.send_hands()
        return positions(self.cloth.step(1))

    def test_0_a_frame_that_was_broadcast_once(self):
        """Before the first call, and not latched; the scene names no frame."""
        Frames().send(make_transform("once", (0, 0, 1), stamp=rospy.Time.now()))
        answer = self.attach("once", radius=0.05)
        self.assertEqual((answer.message, list(answer.points)), ("", [0]))

    def test_follows_position_and_rotation(self):
        answer = self.attach("left", points=[0, 1, COLUMNS])
        self.assertTrue(answer.success, answer.message)
        self.assertEqual(list(answer.points), [0, 1, COLUMNS])
        self.hands.put("left", (0.02, 0.01, 1.03), math.radians(20))
        for _ in range(20):
            where = self.carry()
        turn = math.radians(20)
        side = 1 / 9
        expected = np.array([0.02, 0.01, 1.03]) + np.array(
            [[0, 0, 0], [side * math.cos(turn), side * math.sin(turn), 0],
             [-side * math.sin(turn), side * math.cos(turn), 0]])
        self.assertLess(np.abs(where[[0, 1, COLUMNS]] - expected).max(), 1e-6)

    def test_corners_follow_at_speed(self):
        """Half a metre a second. A corner's distance from its frame is at most the frame's motion in one step."""
        self.take_corners()
        for i in range(60):
            x = 0.5 / 90 * i
            self.hands.put("left", (x, 0, 1))
            self.hands.put("right", (1 + x, 0, 1))
            where = self.carry()
            self.assertLess(abs(where[CORNERS["left"], 0] - x), 1e-3)
            self.assertLess(abs(where[CORNERS["right"], 0] - 1 - x), 1e-3)

    def test_a_jump(self):
        """The points travel there at ~jump_speed. The node warns and goes on serving calls."""
        self.take_corners(strength=1e12)
        self.cloth.step(30)
        log = Recorder("/rosout", Log)
        wait_for(lambda: is_connected("/rosout", "/attach"), "the log")
        self.hands.put("left", (0, 0, 1001))
        start = time.monotonic()
        for frame in range(1, 31):
            where = self.carry()
            self.assertAlmostEqual(where[0, 2], 1 + 15 / 90 * frame, delta=1e-4)
            self.assertTrue(np.isfinite(where).all())
        self.assertLess(time.monotonic() - start, 10 * SLOWER)
        log.wait("a warning", lambda m: m.level == Log.WARN and m.msg.startswith(
            "tf frame left is 1e+03 m ahead of the points it holds: they follow at 15 m/s"))
        log.close()
        # Back at a place nearby, they arrive.
        self.hands.put("left", where[0] + [0, 0.3, 0])
        self.carry()
        self.assertLess(np.abs(self.carry()[0] - where[0] - [0, 0.3, 0]).max(), 1e-6)

    def test_what_came_before_a_step_counts(self):
        """Without a pause between transform and step, a hundred times."""
        self.assertTrue(self.attach("right", points=[9]).success)
        tf = publisher_at_once("/tf", TFMessage)
        wait_for(lambda: tf.get_num_connections() > 0, "the node to listen")
        for i in range(100):
            tf.publish([make_transform("quick", (0.002 * i, 0, 1), stamp=rospy.Time.now())])
            if i == 0:
                answer = self.attach("quick", points=[0])
                self.assertTrue(answer.success, answer.message)
            where = positions(self.cloth.step(1))[0]
            self.assertAlmostEqual(where[0], 0.002 * i, delta=1e-6)

    def hang(self):
        """Forces on the frames [N] with the cloth at rest."""
        self.take_corners()
        last = self.cloth.step(900)
        forces = {}
        for frame, recorder in self.wrenches.items():
            message = recorder.wait("the wrench on " + frame,
                                    lambda w: w.header.stamp == last.header.stamp)
            self.assertEqual(message.header.frame_id, frame)
            self.assertLess(np.linalg.norm(point(message.wrench.torque)), 1e-6)
            forces[frame] = point(message.wrench.force)
        return forces

    def test_wrench_is_the_weight_carried(self):
        forces = self.hang()
        error = forces["left"] + forces["right"] - [0, 0, -WEIGHT]
        self.assertLess(np.linalg.norm(error), 0.01 * WEIGHT)
        self.assertGreater(forces["left"][0], 5)  # the cloth pulls the hands together

    def test_wrench_is_in_the_frame(self):
        """The world's x is -y of a frame turned by 90 degrees about z."""
        self.hands.put("left", (0, 0, 1), math.pi / 2)
        self.send_hands()
        left = self.hang()["left"]
        self.assertLess(left[1], -5)
        self.assertAlmostEqual(left[0], 0, delta=0.01)
        self.assertAlmostEqual(left[2], -WEIGHT / 2, delta=0.01 * WEIGHT)

    def test_several_frames_and_points_at_once(self):
        self.assertTrue(self.attach("left", points=[0, 10, 20]).success)
        self.assertTrue(self.attach("right", points=[9, 19]).success)
        self.assertTrue(self.attach("left", points=[30]).success)
        self.assertEqual(list(self.cloth.step(1).held), [0, 9, 10, 19, 20, 30])
        answer = self.detach("left", [10, 0])
        self.assertEqual((answer.success, list(answer.points)), (True, [0, 10]))
        answer = self.detach("left")
        self.assertEqual(list(answer.points), [20, 30])
        self.assertTrue(self.attach("left", points=[0]).success)
        self.assertEqual(list(self.detach().points), [0, 9, 19])
        self.assertEqual(list(self.cloth.step(1).held), [])
        self.assertLess(positions(self.cloth.step(60))[0, 2], 0.9)  # falls

    def test_diagnostics_tell_of_the_frame(self):
        self.take_corners()
        self.diagnostics.clear()
        self.diagnostics.wait("the age of the frame", lambda array: any(
            v.key == "tf age of left [s]" for s in array.status for v in s.values))

    def test_tears_off_above_the_force(self):
        self.assertTrue(self.attach("left", points=[0], tear_force=5.0).success)
        self.assertTrue(self.attach("right", points=[9], tear_force=500.0).success)
        where = positions(self.cloth.step(180))
        self.assertLess(where[0, 2], 0.8)
        self.assertLess(np.abs(where[9] - [1, 0, 1]).max(), 1e-6)
        self.assertFalse(self.detach("left").success)
        self.assertEqual(list(self.detach("right").points), [9])

    def test_reset_lets_go(self):
        self.take_corners()
        self.cloth.reset()
        self.assertFalse(self.detach().success)

    def wrench_after(self, frame, let_go):
        """The last force [N] on a frame with one held point, after let_go() has detached it. Its topic
        then ends, so that a late subscriber receives none."""
        answer = self.attach(frame, points=[0])
        self.assertTrue(answer.success, answer.message)
        stamp = self.cloth.step(30).header.stamp
        topic = "/clothsim/wrench/" + frame
        wrenches = Recorder(topic, WrenchStamped)
        carried = wrenches.wait("the present wrench for a new subscriber")
        self.assertEqual(carried.header.stamp, stamp)
        self.assertLess(carried.wrench.force.z, -1)
        let_go()
        last = wrenches.wait("another wrench", lambda w: w.header.stamp > stamp)
        wait_for(lambda: topic not in (name for name, _ in rospy.get_published_topics()),
                 "the end of the topic")
        self.assertEqual(wrenches.all(), [carried, last])
        self.assertEqual(last.header.frame_id, frame)
        wrenches.close()
        return point(last.wrench.force)

    def test_no_wrench_without_points(self):
        self.hands.put("passing", (0, 0, 1))
        self.send_hands()
        for let_go in (self.detach, self.cloth.reset):
            self.assertEqual(list(self.wrench_after("passing", let_go)), [0, 0, 0])

    def test_save_and_restore(self):
        self.take_corners()
        self.cloth.step(30)
        self.assertTrue(call("/clothsim/save_state", SaveState, "held").success)
        expected = content(self.cloth.step(30))
        self.assertTrue(self.detach().success)
        self.cloth.step(10)
        self.assertTrue(call("/clothsim/restore_state", RestoreState, "held").success)
        self.assertEqual(content(self.cloth.step(30)), expected)
        self.assertEqual(list(self.detach().points), sorted(CORNERS.values()))

    def test_frames_of_one_topic(self):
        """One wrench for each topic: a frame whose topic is in use is refused until the other frame lets go."""
        wrenches = Recorder("/clothsim/wrench/arm_hand", WrenchStamped)
        for frame in ("arm/hand", "arm_hand"):
            self.hands.put(frame, (0, 0, 1))
        self.hands.send()
        self.assertTrue(self.attach("arm/hand", points=[0]).success)
        self.cloth.step(1)
        answer = self.attach("arm_hand", points=[9])
        self.assertFalse(answer.success)
        self.assertRegex(answer.message, says('frame: got "arm_hand" ... ~wrench/arm_hand ... "arm/hand"'))
        self.assertTrue(self.attach("arm/hand", points=[9]).success)
        self.assertTrue(self.detach("arm/hand").success)
        self.assertTrue(self.attach("arm_hand", points=[9]).success)
        self.cloth.step(1)
        wrenches.wait("the wrench", lambda m: m.header.frame_id == "arm_hand")

    def test_a_radius_about_held_points(self):
        """Points that are held already are left out."""
        self.assertTrue(self.attach("left", points=[0]).success)
        answer = self.attach("left", radius=0.12)
        self.assertEqual((answer.message, list(answer.points)), ("", [1, COLUMNS]))
        answer = self.attach("left", radius=0.12)
        self.assertFalse(answer.success)
        self.assertRegex(answer.message, says("radius: got 0.12 ... held ... free point"))

    def test_whole_messages_read_like_these(self):
        self.assertEqual(self.attach("right", points=[100]).message,
                         "points/0: got 100, expected a number from 0 to 99")
        self.assertEqual(self.attach("right", radius=-1).message,
                         "radius: got -1 and no points, expected a number above 0 [m], or points")
        self.assertEqual(self.detach("right").message,
                         'frame: got "right", expected a frame that points are attached to')

    def test_points_by_place(self):
        answer = self.attach("right", places="[{near: [1, 0, 1]}, [0, 9], 50, {within: 0.12, of: [0, 0, 1]}]")
        self.assertTrue(answer.success, answer.message)
        self.assertEqual(list(answer.points), [0, 1, 9, 10, 50, 90])
        self.cloth.step(1)
        self.assertEqual(sorted(self.cloth.states.wait("held points", lambda m: len(m.held) == 6).held),
                         [0, 1, 9, 10, 50, 90])
        answer = self.detach("right", places="[{uv: [1, 0]}, {within: 0.12, of: [0, 0, 1]}]")
        self.assertTrue(answer.success, answer.message)
        self.assertEqual(list(answer.points), [0, 1, 9, 10])

    def test_refused(self):
        self.assertTrue(self.attach("left", points=[0]).success)
        self.cloth.step(3)
        before = call("/clothsim/get_state", GetState).state

        for request, message in (
                (("nowhere", [9]), 'frame: got "nowhere" ... transform'),
                (("", [9]), 'frame: got ""'),
                (("/right", [9]), 'frame: got "/right"'),
                (("right", [100]), "points/0: got 100 ... 0 to 99"),
                (("right", [9, -1]), "points/1: got -1 ... 0 to 99"),
                (("right", [], -1), "radius: got -1 ... no points ... above 0 [m]"),
                (("right", [], NAN), "radius: got nan ... no points ... above 0 [m]"),
                (("right", [], 1e7), "radius: got 1e+07 ... most 1e+06 [m]"),
                (("right", []), "radius: got 0 ... no points ... above 0 [m]"),
                (("right", [9], 0.1), "radius: got 0.1 and points ... one of the two"),
                (("right", [9], -1), "radius: got -1 and points ... one of the two"),
                (("far", [], 0.1), "radius: got 0.1 ... no point"),
                (("right", [9, 0]), "points/1: got 0 ... held"),
                (("right", [9, 9]), "points/1: got 9 ... again"),
                (("right", [9], 0.0, -1.0), "tear_force: got -1"),
                (("right", [9], 0.0, NAN), "tear_force: got nan"),
                (("right", [9], 0, 0, 0, "[1]"), "places: got places and points ... one of the two"),
                (("right", [], 0.1, 0, 0, "[1]"), "radius: got 0.1 and points ... one of the two"),
                (("right", [9], 0, 0, 0, "", "shirt"), 'cloth: got "shirt" ... none without places'),
                (("right", [], 0, 0, 0, "[1]", "shirt"), 'cloth: got "shirt" ... one cloth'),
                (("right", [], 0, 0, 0, "[1"), "places: got ... YAML"),
                (("right", [], 0, 0, 0, "{near: [0, 0, 1]}"), "places: got a map"),
                (("right", [], 0, 0, 0, "[{near: [0, 0]}]"), "places/0/near: got"),
                (("right", [], 0, 0, 0, "[{side: front.1}]"), "places/0/side: got ... no pattern"),
                (("right", [], 0, 0, 0, "[100]"), "places/0: got 100"),
                (("right", [], 0, 0, 0, "[]"), "places: got none"),
                (("right", [], 0, 0, 0, "[9, {near: [1, 0, 1]}]"), "places/1: got 9 ... again"),
                (("right", [], 0, 0, 0, "[&a {within: 9, of: [0, 0, 0]}" + ", *a" * 10000 + "]"), "places/1: got 0 again"),
                (("right", [], 0, 0, 0, "[" + " " * 10000000 + "]"), "places: got 10000002 characters")):
            answer = self.attach(*request)
            self.assertFalse(answer.success, request)
            self.assertRegex(answer.message, says(message))
            self.assertEqual(list(answer.points), [])
            self.assertEqual(call("/clothsim/get_state", GetState).state, before, request)

        for request, message in (
                (("right",), 'frame: got "right" ... attached'),
                (("left", [1]), "points/0: got 1 ... attached to left"),
                (("", [0, 55]), "points/1: got 55 ... attached"),
                (("left", [], "[{near: [1, 0, 1]}]"), "points/0: got 9 ... attached to left"),
                (("left", [0], "[0]"), "places: got places and points ... one of the two")):
            answer = self.detach(*request)
            self.assertFalse(answer.success, request)
            self.assertRegex(answer.message, says(message))
            self.assertEqual(call("/clothsim/get_state", GetState).state, before, request)
        self.assertEqual(list(self.detach().points), [0])
        self.assertFalse(self.detach().success)


if __name__ == "__main__":
    rospy.init_node("attach_test")
    rostest.rosrun("clothsim", "attach", Grasp)
