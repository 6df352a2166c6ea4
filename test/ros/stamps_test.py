#!/usr/bin/python3
"""For all stamps of tf and all jumps of the clock the node goes on, with transforms of the current time."""

import re
import unittest

import genpy
import numpy as np
import rospy
import rostest
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from rosgraph_msgs.msg import Clock, Log
from visualization_msgs.msg import MarkerArray

from cloth_client import Cloth, Frames, Recorder, is_connected, make_transform, point, publisher_at_once, says, wait_for

LATEST = 2**32 - 1  # that a stamp can hold [s]
AHEAD = 2  # largest lead over the clock of a stamp that the node accepts [s]


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
        wait_for(lambda: is_connected("/rosout", "/stamps"), "the log")
        cls.places = 0
        cls.now = 0

    def set_clock(self, seconds, nanoseconds=0):
        now = genpy.Time(seconds, nanoseconds)
        Stamps.now = seconds
        self.clock.publish(now)
        wait_for(lambda: self.cloth.step(1).header.stamp == now, "the node to have the time")

    @staticmethod
    def new_place():
        Stamps.places += 1
        return np.array([0.01 * Stamps.places, 0, -2])

    def colliders(self):
        """Places of the sphere and the witness."""
        self.markers.clear()
        self.cloth.step(1)
        array = self.markers.wait("markers")
        return [point(m.pose.position) for m in array.markers if m.ns == "colliders"]

    def expect_followed(self, stamp):
        place = self.new_place()
        self.frames.send(make_transform("sphere", place, stamp=genpy.Time(stamp)))
        wait_for(lambda: np.allclose(self.colliders()[0], place), "the sphere at %s" % place)

    def expect_refused(self, stamp):
        """One message moves the witness, with a good stamp of its own each time, and not the sphere."""
        before = self.colliders()[0]
        refused, witness = self.new_place(), self.new_place()
        good = genpy.Time.from_sec(self.now + 0.001 * self.places)
        self.frames.send(make_transform("sphere", refused, stamp=genpy.Time(stamp)),
                         make_transform("witness", witness, stamp=good))
        wait_for(lambda: np.allclose(self.colliders()[1], witness), "the witness at %s" % witness)
        np.testing.assert_allclose(self.colliders()[0], before, err_msg="a stamp of %d" % stamp)

    def expect_lost(self):
        self.diagnostics.clear()
        self.diagnostics.wait("a warning of the lost frame", lambda array: any(
            s.level == DiagnosticStatus.WARN and "lost tf frame sphere" in s.message
            for s in array.status))

    def test_1_before_time_begins(self):
        self.expect_refused(LATEST)
        refusal = says("frame sphere ... /stamps ... 4294967295.000 ... 4294967280.000")
        self.log.wait("a warning", lambda m: re.search(refusal, m.msg))
        self.expect_followed(500)
        self.set_clock(1)
        self.expect_lost()  # that was no current stamp
        self.expect_followed(1)

    def test_2_ahead_of_now(self):
        self.set_clock(1000)
        self.expect_followed(1000)
        for stamp in (1000 + AHEAD + 1, 2000000000, 4000000000, LATEST):
            self.expect_refused(stamp)
        self.expect_followed(1000 + AHEAD - 1)
        self.set_clock(1010)
        self.expect_lost()

    def test_3_the_clock_jumps(self):
        for now in (2000, 20, 3000000000, 30, LATEST - 20, 40):
            self.set_clock(now)
            self.expect_lost()
            self.expect_followed(now)

    def test_4_time_ends(self):
        """No later time exists: frames, diagnostics and calls go on, and earlier times work again afterwards."""
        for nanoseconds in (0, 999999999):
            self.set_clock(LATEST, nanoseconds)
            self.cloth.pause(False)
            for _ in range(2):
                self.diagnostics.clear()
                self.diagnostics.wait("diagnostics")
            self.cloth.pause()
            self.cloth.step(10)
        self.set_clock(50)
        self.expect_followed(50)


if __name__ == "__main__":
    rospy.init_node("stamps_test")
    rostest.rosrun("clothsim", "stamps", Stamps)
