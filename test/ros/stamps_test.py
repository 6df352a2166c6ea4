#!/usr/bin/python3
"""Whatever the stamps of tf and wherever the clock jumps: the node goes on, by frames of now."""

import unittest

import genpy
import numpy as np
import rospy
import rostest
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from rosgraph_msgs.msg import Clock, Log
from visualization_msgs.msg import MarkerArray

from cloth_client import (Cloth, Frames, Recorder, make_transform, marker_named, point,
                          publisher_at_once, wait_for)

LATEST = 2**32 - 1  # that a stamp can hold [s]
AHEAD = 2  # as far as the node takes stamps for those of now [s]


class Stamps(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.cloth = Cloth()
        cls.frames = Frames()
        cls.markers = Recorder("/clothsim/markers", MarkerArray)
        cls.diagnostics = Recorder("/diagnostics", DiagnosticArray)
        cls.log = Recorder("/rosout", Log)
        cls.clock = publisher_at_once("/clock", Clock)
        wait_for(lambda: cls.clock.get_num_connections() >= 2, "the clock's subscribers")
        wait_for(cls.markers.connected, "the markers")
        cls.places = 0

    def set_clock(self, seconds):
        now = genpy.Time(seconds)
        self.clock.publish(now)
        wait_for(lambda: self.cloth.step(1).header.stamp == now, "the node to have the time")

    def send(self, stamp):
        """Another place each time; returns it."""
        Stamps.places += 1
        place = np.array([0.01 * self.places, 0, -2])
        self.frames.send(make_transform("sphere", place, stamp=genpy.Time(stamp)))
        return place

    def sphere(self):
        self.markers.clear()
        self.cloth.step(1)
        array = self.markers.wait("markers")
        return point(marker_named(array, "colliders").pose.position)

    def expect_at(self, place):
        wait_for(lambda: np.allclose(self.sphere(), place), "the sphere at %s" % place)

    def expect_followed(self, stamp):
        self.expect_at(self.send(stamp))

    def expect_refused(self, stamp):
        before = self.sphere()
        refused = self.send(stamp)
        for _ in range(5):
            self.assertFalse(np.allclose(self.sphere(), refused), "a stamp of %d" % stamp)
        self.expect_at(before)

    def expect_lost(self):
        self.diagnostics.clear()
        self.diagnostics.wait("a warning of the lost frame", lambda array: any(
            s.level == DiagnosticStatus.WARN and "lost tf frame sphere" in s.message
            for s in array.status))

    def test_1_before_time_begins(self):
        self.expect_refused(LATEST)
        self.expect_followed(500)
        self.set_clock(1)
        self.expect_lost()  # that was no stamp of now
        self.expect_followed(1)

    def test_2_ahead_of_now(self):
        self.set_clock(1000)
        self.expect_followed(1000)
        self.log.clear()
        for stamp in (1000 + AHEAD + 1, 2000000000, 4000000000, LATEST):
            self.expect_refused(stamp)
        self.log.wait("a warning", lambda m: m.msg.startswith(
            "Ignored a transform of tf frame sphere from /stamps"))
        self.expect_followed(1000 + AHEAD - 1)
        self.set_clock(1010)
        self.expect_lost()

    def test_3_the_clock_jumps(self):
        for now in (2000, 20, 3000000000, 30, LATEST - 20, 40):
            self.set_clock(now)
            self.expect_lost()
            self.expect_followed(now)


if __name__ == "__main__":
    rospy.init_node("stamps_test")
    rostest.rosrun("clothsim", "stamps", Stamps)
