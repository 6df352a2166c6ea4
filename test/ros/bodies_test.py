#!/usr/bin/python3
"""Rigid bodies: the cloth carries them, their topics and tf frames tell so, and ~set_body puts them elsewhere."""

import math
import os
import shutil
import signal
import subprocess
import tempfile
import unittest

import roslib.packages
import rospy
import rostest
from geometry_msgs.msg import Point, Pose, Quaternion, Twist, Vector3
from tf2_msgs.msg import TFMessage

from clothsim.msg import Bodies, Colliders
from clothsim.srv import Attach, AttachBody, DetachBody, LoadScene, RestoreState, SaveState, SetBody
from cloth_client import Cloth, Frames, Recorder, call, content, is_connected, make_transform, says, wait_for

G = 9.8
SCENES = os.path.join(roslib.packages.get_pkg_dir("clothsim"), "config", "scenes")


def there(x, y, z):
    return Pose(Point(x, y, z), Quaternion(0, 0, 0, 1))


class BodiesTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.cloth = Cloth()
        cls.bodies = Recorder("/clothsim/bodies", Bodies)
        cls.tf = Recorder("/tf", TFMessage)
        for recorder in (cls.cloth.states, cls.bodies, cls.tf):
            wait_for(recorder.all, "the first messages")
        cls.frames = Frames()
        wait_for(lambda: cls.frames.count() == 2, "the node and this one to listen to tf")

    def setUp(self):
        self.cloth.reset()

    def step(self, frames):
        """The bodies by name, after so many frames."""
        state = self.cloth.step(frames)
        return {b.name: b for b in self.bodies.wait(
            "the bodies of the frame", lambda m: m.header.stamp == state.header.stamp).bodies}

    def put(self, pose, twist=None, name="ball"):
        return call("/clothsim/set_body", SetBody, name, pose, twist or Twist())

    def test_the_cloth_carries_them(self):
        bodies = self.step(900)
        self.assertEqual([b.name for b in self.bodies.all()[-1].bodies], ["box", "ball"])
        for name, mass in (("box", 0.8), ("ball", 0.3)):
            body = bodies[name]
            self.assertEqual(body.mass, mass)
            self.assertGreater(body.pose.position.z, 0.2)
            self.assertLess(abs(body.twist.linear.z), 0.3)
        upward = sum(bodies[name].wrench.force.z for name in bodies)
        self.assertGreater(upward, 0.7 * 1.1 * G)

    def test_each_is_a_tf_frame(self):
        body = self.step(30)["box"]
        wanted = body.pose.position
        self.tf.wait("the transform of the box", lambda m: any(
            t.header.frame_id == "map" and t.child_frame_id == "box" and
            abs(t.transform.translation.z - wanted.z) < 1e-12 for t in m.transforms))

    def test_set_body_puts_one_elsewhere(self):
        answer = self.put(there(3, 0, 5), Twist(Vector3(1, 0, 2), Vector3(0, 0, 1)))
        self.assertTrue(answer.success, answer.message)
        ball = self.step(45)["ball"]
        time = 45 / 90
        self.assertAlmostEqual(ball.pose.position.x, 3 + time * math.exp(-0.5 * time / 2), delta=0.02)
        self.assertAlmostEqual(ball.pose.position.z, 5 + 2 * time - G * time ** 2 / 2, delta=0.2)
        self.assertGreater(ball.twist.angular.z, 0.5)

    def test_mistakes_are_refused(self):
        for pose, twist, name, message in (
                (there(0, 0, 1), Twist(), "bell", 'name: got "bell" ... box, ball'),
                (there(0, 0, math.nan), Twist(), "ball", "position.2: got nan"),
                (Pose(), Twist(), "ball", "orientation"),
                (there(0, 0, 1), Twist(Vector3(0, 0, 1e9), Vector3()), "ball", "velocity.2: got 1e+09 ... [m/s]")):
            answer = self.put(pose, twist, name)
            self.assertFalse(answer.success)
            self.assertRegex(answer.message, says(message))
        self.assertAlmostEqual(self.step(1)["ball"].pose.position.z, 1.7, delta=1e-2)

    def test_a_frame_holds_one_and_lets_it_go(self):
        self.frames.send(make_transform("hand", (0, 0, 0), stamp=rospy.Time.now()))
        self.assertTrue(call("/clothsim/attach_body", AttachBody, "ball", "hand").success)
        ball = self.step(5)["ball"]
        self.assertEqual(ball.frame, "hand")
        start = ball.pose.position
        for k in range(1, 10):
            self.frames.send(make_transform("hand", (0, -0.01 * k, 0), stamp=rospy.Time.now()))
            ball = self.step(1)["ball"]
        self.assertAlmostEqual(ball.pose.position.y, start.y - 0.09, delta=1e-9)
        self.assertAlmostEqual(ball.twist.linear.y, -0.9, delta=1e-6)
        answer = call("/clothsim/attach_body", AttachBody, "ball", "hand")
        self.assertRegex(answer.message, says("body: got ball ... hand ... a body that no tf frame holds"))
        self.assertTrue(call("/clothsim/detach_body", DetachBody, "ball").success)
        ball = self.step(9)["ball"]
        self.assertEqual(ball.frame, "")
        self.assertLess(ball.pose.position.y, start.y - 0.16)
        self.assertLess(ball.pose.position.z, start.z - 0.03)
        self.assertRegex(call("/clothsim/detach_body", DetachBody, "ball").message, says("body: got ball"))

    def test_points_on_one_pull_on_it(self):
        self.assertTrue(self.put(there(0.5, 0.5, 1.2)).success)
        answer = call("/clothsim/attach", Attach, "ball", [15 * 31 + 15], 0, 0, 0, "", "")
        self.assertTrue(answer.success, answer.message)
        bodies = self.step(180)
        self.assertGreater(bodies["ball"].pose.position.z, 0.2)
        answer = call("/clothsim/attach", Attach, "ball", [3], 0, 0, 5, "", "")
        self.assertRegex(answer.message, says("strength: got 5"))

    def test_saved_states_have_them(self):
        self.step(40)
        self.assertTrue(call("/clothsim/save_state", SaveState, "falling").success)
        expected = content(self.cloth.step(60))
        self.assertTrue(self.put(there(0.5, 0.5, 3)).success)
        self.cloth.step(5)
        self.assertTrue(call("/clothsim/restore_state", RestoreState, "falling").success)
        self.assertEqual(content(self.cloth.step(60)), expected)

    def test_a_bag_repeats_them(self):
        folder = tempfile.mkdtemp()
        path = os.path.join(folder, "run.bag")
        topics = ["/clothsim/state", "/clothsim/changes"]
        recorder = subprocess.Popen(["rosbag", "record", "-O", path] + topics, stdout=subprocess.DEVNULL)
        for topic in topics:
            wait_for(lambda t=topic: is_connected(t, "/record"), "the recorder of " + topic)
        self.cloth.reset()
        self.step(20)
        self.assertTrue(self.put(there(0.6, 0.5, 1.15), Twist(Vector3(0, 0, -1), Vector3())).success)
        self.step(10)
        self.frames.send(make_transform("bagged", (0, 0, 1), stamp=rospy.Time.now()))
        answer = call("/clothsim/attach_body", AttachBody, "box", "bagged")
        self.assertTrue(answer.success, answer.message)
        self.step(10)
        self.assertTrue(call("/clothsim/detach_body", DetachBody, "box").success)
        self.step(20)
        recorder.send_signal(signal.SIGINT)
        recorder.wait()
        replay = roslib.packages.find_node("clothsim", "replay_bag")[0]
        run = subprocess.run([replay, path], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False)
        shutil.rmtree(folder)
        self.assertEqual(run.returncode, 0, run.stdout)

    def test_a_scene_without_bodies_has_no_topic(self):
        self.assertTrue(call("/clothsim/load_scene", LoadScene, os.path.join(SCENES, "plane.yaml")).success)
        try:
            published = [name for name, _ in rospy.get_published_topics()]
            self.assertNotIn("/clothsim/bodies", published)
            self.assertIn("/clothsim/colliders", published)
        finally:
            answer = call("/clothsim/load_scene", LoadScene, os.path.join(SCENES, "hammock.yaml"))
            self.assertTrue(answer.success, answer.message)
        self.assertTrue(Recorder("/clothsim/colliders", Colliders).wait(
            "the colliders", lambda m: len(m.colliders) == 2))


if __name__ == "__main__":
    rospy.init_node("bodies_test")
    rostest.rosrun("clothsim", "bodies", BodiesTest)
