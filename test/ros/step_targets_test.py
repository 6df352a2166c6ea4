#!/usr/bin/python3
"""~step with targets: equal moves, given twists, broadcast transforms, saved states, refusals."""

import math
import subprocess
import time
import unittest

import numpy as np
import rospy
import rostest
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import Twist, Vector3
from rosgraph_msgs.msg import Log
from tf2_msgs.msg import TFMessage
from visualization_msgs.msg import MarkerArray

from clothsim.srv import GetState, RestoreState, SaveState, Step
from cloth_client import Cloth, Frames, Recorder, call, content, is_connected, make_transform, positions, says, wait_for

BALL = np.array([0.5, 0.5, 0.75])  # its place in the scene [m]
HAND = np.array([0.0, 0.0, 1.0])  # the corner
FRAME = 1 / 90  # [s]
COLLIDERS = ["ball", "tip", "finger"]


def twist(linear=(0, 0, 0), angular=(0, 0, 0)):
    return Twist(Vector3(*linear), Vector3(*angular))


class StepTargets(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.cloth = Cloth()
        wait_for(cls.cloth.states.all, "the first state")
        cls.tf = Recorder("/tf", TFMessage)
        cls.markers = Recorder("/clothsim/markers", MarkerArray)
        # The frame of the ball is sent once, so that the node is connected with the listeners.
        cls.cloth.step(1, [make_transform("ball", BALL)])
        wait_for(lambda: is_connected("/tf", "step_targets"), "the node's transforms")

    def setUp(self):
        now = rospy.Time.now()
        self.cloth.reset()
        self.cloth.states.wait("the start", lambda s: s.header.stamp >= now)
        self.cloth.states.clear()

    def told(self, frame, state, count):
        """Broadcasts of a frame in the `count` frames up to a state: places, quaternions, stamps."""
        def transforms():
            found = [t for m in self.tf.all() for t in m.transforms if t.child_frame_id == frame]
            return found and found[-1].header.stamp == state.header.stamp and found[-count:]
        found = wait_for(transforms, "%d transforms of %s" % (count, frame))
        self.assertEqual(len(found), count)
        self.assertEqual({t.header.frame_id for t in found}, {"map"})
        places = np.array([[getattr(t.transform.translation, a) for a in "xyz"] for t in found])
        turns = np.array([[getattr(t.transform.rotation, a) for a in "xyzw"] for t in found])
        return places, turns, [t.header.stamp for t in found]

    def collider(self, name, state):
        """Place of a collider in the markers after a state."""
        stamp = state.header.stamp
        array = self.markers.wait("markers", lambda a: a.markers[0].header.stamp >= stamp)
        place = [m for m in array.markers if m.ns == "colliders"][COLLIDERS.index(name)].pose.position
        return np.array([place.x, place.y, place.z])

    def test_five_centimetres_in_nine_frames_are_nine_equal_moves(self):
        self.cloth.step(9, [make_transform("hand", HAND)])
        last = self.cloth.step(9, [make_transform("ball", BALL + (0, 0, 0.05), 0.9),
                                   make_transform("hand", HAND + (0, 0, 0.05))])
        shares = np.arange(1, 10)[:, None] / 9
        for frame, start in (("ball", BALL), ("hand", HAND)):
            places, turns, stamps = self.told(frame, last, 9)
            np.testing.assert_allclose(places, start + shares * [0, 0, 0.05], atol=1e-15)
            if frame == "ball":
                np.testing.assert_allclose(2 * np.arcsin(turns[:, 2]), 0.1 * np.arange(1, 10), atol=1e-14)
        self.cloth.states.wait("the last state", lambda s: s.step == last.step)
        states = self.cloth.states.all()[-9:]
        self.assertEqual(stamps, [s.header.stamp for s in states])
        corner = np.array([positions(s)[0] for s in states])
        np.testing.assert_allclose(corner, HAND + shares * [0, 0, 0.05], atol=1e-7)

    def test_none_is_late(self):
        """Each call's target takes effect in that call, at the highest rate of calls."""
        step = rospy.ServiceProxy("/clothsim/step", Step, persistent=True)
        self.cloth.step(1, [make_transform("hand", HAND)])
        begin, calls = time.monotonic(), 1000
        for i in range(calls):
            x = 0.05 * math.sin(i / 30)
            answer = step(1, [make_transform("hand", HAND + (x, 0, 0))], [])
            self.assertAlmostEqual(answer.state.positions[0], x, delta=1e-8, msg="call %d" % i)
        print("%.0f calls of ~step a second" % (calls / (time.monotonic() - begin)))
        step.close()

    def test_twists_keep_the_velocity_from_call_to_call(self):
        self.cloth.step(1, [make_transform("hand", HAND)])
        self.cloth.step(30, [make_transform("hand", HAND + (0.1, 0, 0))], [twist((0.6, 0, 0), (0, 0, 1))])
        last = self.cloth.step(30, [make_transform("hand", HAND + (0.2, 0, 0.1))], [twist()])
        places, turns, _ = self.told("hand", last, 60)
        velocities = np.diff(np.vstack([HAND, places]), axis=0) / FRAME
        self.assertAlmostEqual(velocities[29:31, 0].mean(), 0.6, delta=0.02)
        # The cubics' accelerations are a few m/s^2 here; a jump of velocity would be 50.
        self.assertLess(np.abs(np.diff(velocities, axis=0)).max() / FRAME, 12)
        self.assertLess(np.abs(velocities[[0, -1]]).max(), 0.05)
        spin = np.diff(2 * np.arcsin(turns[:, 2])) / FRAME
        # The mean over a frame before and after, in which it is slower by about 2 / 30.
        self.assertAlmostEqual(spin[28:30].mean(), 1, delta=0.07)
        self.assertAlmostEqual(spin[-1], 0, delta=0.06)

    def test_frames_of_other_frames(self):
        """In a frame that is turned, and with a child that a collider follows."""
        target = make_transform("arm", (0.2, 0.3, 0.4), parent="table")
        last = self.cloth.step(5, [target], [twist((1, 0, 0))])
        places, turns, _ = self.told("arm", last, 5)
        np.testing.assert_allclose(places[-1], [1 - 0.3, 0.2, 0.4], atol=1e-12)
        np.testing.assert_allclose(turns[-1], [0, 0, math.sqrt(0.5), math.sqrt(0.5)], atol=1e-12)
        np.testing.assert_allclose(self.collider("tip", last), [1 - 0.3, 0.2 + 0.1, 0.4], atol=1e-9)

    def test_what_others_move_in_a_targets_frame(self):
        """As joints of an arm whose base is a target: their age is that of their stamps, and none is lost."""
        frames, log = Frames(), Recorder("/rosout", Log)
        wait_for(lambda: frames.count() > 1, "the node to listen, beside this test")
        last = self.cloth.step(1, [make_transform("base", (0.2, -1, 0.5))])
        for x in (0.05, 0.1, 0.15):
            frames.send(make_transform("finger", (x, 0, 0), parent="base", stamp=rospy.Time.now()))
            time.sleep(0.05)  # this test receives it, too, in a thread of its own
            last = self.cloth.step(1)
            np.testing.assert_allclose(self.collider("finger", last), [0.2 + x, -1, 0.5], atol=1e-9)
        diagnostics = Recorder("/diagnostics", DiagnosticArray)
        begin = rospy.Time.now()
        diagnostics.wait("a while to pass", lambda d: (d.header.stamp - begin).to_sec() > 1.5)
        lost = {m.msg for m in log.all() if "Lost tf frame" in m.msg}
        self.assertLessEqual(lost, {"Lost tf frame finger: what they carry stays where it was"})
        # Other nodes may take it over.
        now = rospy.Time.now()
        frames.send(make_transform("base", (0.4, -1, 0.5), stamp=now),
                    make_transform("finger", (0, 0, 0), parent="base", stamp=now))
        time.sleep(0.05)
        last = self.cloth.step(1)
        np.testing.assert_allclose(self.collider("finger", last), [0.4, -1, 0.5], atol=1e-9)

    def test_runs_repeat_after_a_reset(self):
        runs = []
        for _ in range(2):
            self.cloth.reset()
            self.cloth.step(20)
            runs.append(content(self.cloth.step(30, [make_transform("ball", BALL + (0.02, 0, 0.2), 0.4),
                                                     make_transform("hand", HAND + (0, 0, 0.1))])))
        self.assertEqual(*runs)

    def test_tf_hears_where_frames_go_back_to(self):
        self.cloth.step(5, [make_transform("ball", BALL + (0, 0, 0.2))])
        self.assertTrue(call("/clothsim/save_state", SaveState, "up").success)
        self.cloth.reset()
        state = self.cloth.step(1)
        np.testing.assert_allclose(self.told("ball", state, 2)[0], [BALL, BALL], atol=1e-12)
        self.assertTrue(call("/clothsim/restore_state", RestoreState, "up").success)
        state = self.cloth.step(1)
        np.testing.assert_allclose(self.told("ball", state, 1)[0][0], BALL + (0, 0, 0.2), atol=1e-12)

    def test_who_listens_later_hears_of_frames_at_once(self):
        self.cloth.step(1, [make_transform("ball", BALL + (0, 0, 0.1))])
        heard = subprocess.run(["rostopic", "echo", "-n", "1", "/tf"], capture_output=True, text=True,
                               timeout=60, check=True).stdout
        self.assertIn('child_frame_id: "ball"', heard)

    def test_save_run_restore_run(self):
        def go_on():
            self.cloth.step(10, [make_transform("ball", BALL + (0, 0, 0.2))], [twist((0.3, 0, 0))])
            return content(self.cloth.step(10, [make_transform("hand", HAND + (0, 0, 0.2))]))
        self.cloth.step(20, [make_transform("ball", BALL + (0, 0, 0.1)), make_transform("hand", HAND)],
                        [twist((0, 0, 0.5)), twist()])
        self.assertTrue(call("/clothsim/save_state", SaveState, "here").success)
        expected = go_on()
        for _ in range(2):
            self.assertTrue(call("/clothsim/restore_state", RestoreState, "here").success)
            self.assertEqual(go_on(), expected)

    def test_says_which_frame_nothing_follows(self):
        """Once, with a name that is similar. No warning for a hand to be attached later."""
        log = Recorder("/rosout", Log)
        wait_for(log.connected, "the node's log")
        for _ in range(2):
            self.cloth.step(1, [make_transform(frame, (9, 9, 9)) for frame in ("bal", "Tip", "gripper")])
        log.wait("the message", lambda m: "frame gripper" in m.msg)
        told = [m for m in log.all() if "~step moves frame" in m.msg]
        for said, (level, message) in zip(told, ((Log.WARN, "frame Tip ... tip?"), (Log.WARN, "frame bal ... ball?"),
                                                 (Log.INFO, "frame gripper ... yet"))):
            self.assertEqual(said.level, level)
            self.assertRegex(said.msg, says(message))
        self.assertEqual(len(told), 3)
        log.close()

    def test_refused(self):
        before = call("/clothsim/get_state", GetState).state
        good = make_transform("hand", HAND)
        nan, far = make_transform("hand", (0, float("nan"), 0)), make_transform("hand", (0, 0, 2e6))
        flat = make_transform("hand", HAND)
        flat.transform.rotation.z = flat.transform.rotation.w = 0
        spin = twist(angular=(0, 0, float("inf")))
        for targets, twists, message in (
                ([nan], [], "targets/0/transform: got ... not finite"),
                ([far], [], "targets/0/transform: got ... too far"),
                ([good, flat], [], "targets/1/transform: got"),
                ([make_transform("", HAND)], [], "targets/0/child_frame_id: got nothing"),
                ([make_transform("/hand", HAND)], [], "targets/0/child_frame_id/frame: got \"/hand\""),
                ([make_transform("map", HAND)], [], 'targets/0/child_frame_id: got "map" ... frame'),
                ([good, good], [], 'targets/1/child_frame_id: got "hand" ... again'),
                ([make_transform("hand", HAND, parent="moon")], [],
                 'targets/0/header/frame_id: got "moon" ... transform to map'),
                ([good], [twist(), twist()], "twists: got 2 ... none ... each of 1"),
                ([], [twist()], "twists: got 1 "),
                ([good], [spin], "targets/0/twist/angular/")):
            answer = self.cloth.try_step(3, targets, twists)
            self.assertFalse(answer.success, message)
            self.assertRegex(answer.message, says(message))
        self.assertEqual(call("/clothsim/get_state", GetState).state, before)


if __name__ == "__main__":
    rospy.init_node("step_targets_test")
    rostest.rosrun("clothsim", "step_targets", StepTargets)
