#!/usr/bin/python3
"""100 cycles of subscribing and unsubscribing: memory, threads and files of the node stay."""

import os
import unittest
from xmlrpc.client import ServerProxy

import rosgraph
import rosnode
import rospy
import rostest

from camera_client import Camera
from cloth_client import SLOWER, Cloth

# Allocators keep some memory; an OpenGL context alone is more [MB].
SLACK = 8


class Process:
    """The node as the kernel sees it."""

    def __init__(self, name):
        uri = rosnode.get_api_uri(rosgraph.Master("camera_cycles_test"), name)
        self._folder = "/proc/%d/" % ServerProxy(uri).getPid("camera_cycles_test")[2]

    def memory(self):
        """Memory of its own, in use [MB]."""
        with open(self._folder + "status") as status:
            return next(int(line.split()[1]) for line in status if line.startswith("RssAnon")) / 1024

    def threads(self):
        return len(os.listdir(self._folder + "task"))

    def files(self):
        return len(os.listdir(self._folder + "fd"))


class CameraCycles(unittest.TestCase):
    def cycle(self, cloth):
        camera = Camera()
        camera.wait_for_connections()
        cloth.states.clear()
        stamp = cloth.states.wait("a state").header.stamp
        camera.wait_for_frame_after(stamp)
        camera.close()

    def test_cycles(self):
        cloth = Cloth()
        node = Process("/clothsim")
        for _ in range(15):
            self.cycle(cloth)
        before = (node.memory(), node.threads(), node.files())
        for _ in range(100):
            self.cycle(cloth)
        after = (node.memory(), node.threads(), node.files())
        print("MB, threads, files before %s, after %s" % (before, after))
        # A sanitizer keeps freed memory and records of its own; there its leak check at exit decides.
        if SLOWER == 1:
            self.assertLess(after[0], before[0] + SLACK)
        self.assertLessEqual(after[1], before[1])
        # Connections may take a moment to close; one left open in each cycle would be 100 more.
        self.assertLess(after[2], before[2] + 20)


if __name__ == "__main__":
    rospy.init_node("camera_cycles_test")
    rostest.rosrun("clothsim", "camera_cycles", CameraCycles)
