#!/usr/bin/python3
"""Ends of the node and of its master: SIGINT ends it cleanly, a lost master does not."""

import os
import signal
import socket
import subprocess
import threading
import time
import unittest

import roslib.packages
import rosunit

from cloth_client import PATIENCE, Cloth, wait_for


def free_port():
    with socket.socket() as s:
        s.bind(("", 0))
        return s.getsockname()[1]


# A master of the test's own, to kill. It must be known before rospy starts.
PORT = free_port()
os.environ["ROS_MASTER_URI"] = "http://localhost:%d" % PORT

import rosgraph  # noqa: E402
import rospy  # noqa: E402


def start_master():
    master = subprocess.Popen(["rosmaster", "--core", "-p", str(PORT)],
                              stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    wait_for(rosgraph.is_master_online, "the master")
    return master


class LifeCycle(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.program = roslib.packages.find_node("clothsim", "clothsim_node")[0]
        cls.master = start_master()
        rospy.init_node("life_cycle_test")

    @classmethod
    def tearDownClass(cls):
        cls.master.kill()
        cls.master.wait()

    def start_node(self, name, **parameters):
        rospy.set_param("/%s/scene" % name, {"cloth": {"columns": 20, "rows": 20}})
        for key, value in parameters.items():
            rospy.set_param("/%s/%s" % (name, key), value)
        node = subprocess.Popen([self.program, "__name:=" + name], stdout=subprocess.DEVNULL,
                                stderr=subprocess.PIPE, text=True)
        cloth = Cloth("/" + name)
        cloth.states.wait("the first state")
        return node, cloth

    def assert_ends_cleanly(self, node):
        node.send_signal(signal.SIGINT)
        _, errors = node.communicate(timeout=PATIENCE)
        self.assertEqual(node.returncode, 0, errors)
        return errors

    def test_interrupt_while_running(self):
        node, _ = self.start_node("running")
        self.assertEqual(self.assert_ends_cleanly(node), "")

    def test_interrupt_while_paused(self):
        node, _ = self.start_node("paused", paused=True)
        self.assertEqual(self.assert_ends_cleanly(node), "")

    def test_interrupt_in_a_long_step(self):
        node, cloth = self.start_node("stepping", paused=True)
        answers = []

        def step():
            try:
                answers.append(cloth.try_step(1000000000))
            except rospy.ServiceException as error:
                answers.append(error)
        caller = threading.Thread(target=step)
        caller.start()
        cloth.states.wait("frame 100", lambda s: s.step >= 100)
        self.assert_ends_cleanly(node)
        caller.join(PATIENCE)
        self.assertEqual(len(answers), 1)

    def test_master_goes_away_and_comes_back(self):
        node, cloth = self.start_node("orphan")

        def keeps_publishing():
            cloth.states.clear()
            cloth.states.wait("states after the master went")
            time.sleep(1.5)  # past the next diagnostics
            cloth.states.clear()
            return cloth.states.wait("states still")

        self.master.kill()
        self.master.wait()
        step = keeps_publishing().step
        type(self).master = start_master()
        self.assertGreater(keeps_publishing().step, step)
        self.assert_ends_cleanly(node)

    def test_interrupt_without_a_master(self):
        node, _ = self.start_node("last")
        self.master.kill()
        self.master.wait()
        try:
            self.assert_ends_cleanly(node)
        finally:
            type(self).master = start_master()


if __name__ == "__main__":
    rosunit.unitrun("clothsim", "life_cycle", LifeCycle)
