#!/usr/bin/python3
"""A lockstep run is recorded with rosbag, and its bag replayed: the same bits, or it says so."""

import os
import shutil
import signal
import subprocess
import tempfile
import time
import unittest
from xmlrpc.client import ServerProxy

import rosbag
import rosgraph
import roslib.packages
import rospy
import rostest
from dynamic_reconfigure.client import Client
from tf2_msgs.msg import TFMessage

from cloth_client import PATIENCE, Cloth, content, make_transform, publisher_at_once, wait_for

FRAMES = 60  # by then the cloth is on the sphere
TOPICS = ["/clothsim/state", "/tf", "/tf_static"]


class Bag(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.cloth = Cloth()
        wait_for(cls.cloth.states.all, "the first state")
        cls.tf = publisher_at_once("/tf", TFMessage)
        cls.folder = tempfile.mkdtemp()
        cls.replay_bag = roslib.packages.find_node("clothsim", "replay_bag")[0]

    @classmethod
    def tearDownClass(cls):
        shutil.rmtree(cls.folder)

    def put_sphere(self, x, height):
        self.tf.publish([make_transform("sphere", (x, 0.5, height), stamp=rospy.Time.now())])

    def record(self, name, run):
        """The bag of what is published while run() runs."""
        path = os.path.join(self.folder, name + ".bag")
        recorder = subprocess.Popen(["rosbag", "record", "-O", path] + TOPICS,
                                    stdout=subprocess.DEVNULL)
        wait_for(lambda: self.records("/clothsim/state"), "the recorder of the states")
        wait_for(lambda: self.tf.get_num_connections() == 2, "that of transforms")
        run()
        wait_for(lambda: os.path.exists(path + ".active"), "the bag")
        time.sleep(1)  # what is on its way
        recorder.send_signal(signal.SIGINT)
        recorder.wait(PATIENCE)
        wait_for(lambda: os.path.exists(path), "the bag")
        return path

    @staticmethod
    def records(topic):
        """Whether rosbag is connected to a topic of the node."""
        node = ServerProxy(rosgraph.Master("/bag_test").lookupNode("/clothsim"))
        return any("/record" in c[1] and c[4] == topic for c in node.getBusInfo("/bag_test")[2])

    def run_lockstep(self):
        """The sphere rises and goes aside under the cloth, a step at a time."""
        self.put_sphere(0.5, 0.25)
        self.cloth.reset()
        for i in range(FRAMES // 2):
            self.put_sphere(0.5 + 0.002 * i, 0.25 + 0.004 * i)
            self.cloth.step(2)

    def replay(self, path):
        return subprocess.run([self.replay_bag, path], capture_output=True, text=True,
                              timeout=2 * PATIENCE)

    @staticmethod
    def contents(path):
        with rosbag.Bag(path) as bag:
            states = [content(m) for _, m, _ in bag.read_messages(TOPICS[:1])]
        start = max(i for i, state in enumerate(states) if state[0] == 0)
        return states[start:]  # from the last reset on

    def test_bag(self):
        wait_for(lambda: self.tf.get_num_connections() == 1, "the node to listen")
        path = self.record("run", self.run_lockstep)
        recorded = self.contents(path)
        self.assertEqual([state[0] for state in recorded], list(range(FRAMES + 1)))

        # Replayed from the frames as they now are, and recorded again: the same bytes.
        answers = []
        again = self.record("again", lambda: answers.append(self.replay(path)))
        self.assertEqual((answers[0].returncode, answers[0].stderr), (0, ""))
        self.assertEqual(answers[0].stdout, "%d frames, the same bits\n" % FRAMES)
        self.assertEqual(self.contents(again), recorded)

        # Another value: it is found.
        client = Client("/clothsim", timeout=PATIENCE)
        client.update_configuration({"damping": 5.5})
        answer = self.replay(path)
        self.assertEqual(answer.returncode, 1)
        self.assertRegex(answer.stderr, "^frame 1: ")
        client.update_configuration({"damping": 5.4})
        self.assertEqual(self.replay(path).returncode, 0)

        # A bag without the start of a run.
        answer = self.replay(self.record("late", lambda: self.cloth.step(3)))
        self.assertEqual(answer.returncode, 1)
        self.assertIn("no frame of /clothsim/state after a ~reset", answer.stderr)


if __name__ == "__main__":
    rospy.init_node("bag_test")
    rostest.rosrun("clothsim", "bag", Bag)
