#!/usr/bin/python3
"""A collider is turned off and on: the cloth and the markers follow."""

import unittest

import rospy
import rostest
from visualization_msgs.msg import Marker, MarkerArray

from clothsim.srv import EnableCollider, RestoreState, SaveState
from cloth_client import Cloth, Recorder, call, content, marker_named, positions, says, wait_for

FRAMES = 60
LIFTED = 5 * 12 + 5  # a point above the ball


class Enable(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.cloth = Cloth()
        cls.markers = Recorder("/clothsim/markers", MarkerArray)
        for recorder in (cls.cloth.states, cls.markers):
            wait_for(recorder.all, "the first messages")

    def setUp(self):
        self.cloth.reset()

    def enable(self, enabled, name="ball"):
        return call("/clothsim/enable_collider", EnableCollider, name, enabled)

    def height(self):
        return positions(self.cloth.step(FRAMES))[LIFTED, 2]

    def test_off_the_cloth_falls_through(self):
        lying = self.height()
        self.cloth.reset()
        self.assertTrue(self.enable(False).success)
        self.assertLess(self.height(), lying - 0.1)

    def test_reset_and_restore_go_back(self):
        expected = content(self.cloth.step(FRAMES))
        self.assertTrue(self.enable(False).success)
        self.cloth.reset()
        self.assertEqual(content(self.cloth.step(FRAMES)), expected)
        self.cloth.reset()
        self.assertTrue(call("/clothsim/save_state", SaveState, "on").success)
        self.assertTrue(self.enable(False).success)
        self.assertTrue(call("/clothsim/restore_state", RestoreState, "on").success)
        self.assertEqual(content(self.cloth.step(FRAMES)), expected)

    def test_markers_follow_while_paused(self):
        for enabled, action in ((False, Marker.DELETE), (True, Marker.ADD)):
            self.markers.clear()
            self.assertTrue(self.enable(enabled).success)
            self.markers.wait("the ball's marker", lambda a: (
                marker_named(a, "colliders").action == action))

    def test_an_unknown_name_is_refused(self):
        answer = self.enable(False, "bal")
        self.assertFalse(answer.success)
        self.assertRegex(answer.message, says('name: got "bal" ... ball'))


if __name__ == "__main__":
    rospy.init_node("enable_collider_test")
    rostest.rosrun("clothsim", "enable_collider", Enable)
