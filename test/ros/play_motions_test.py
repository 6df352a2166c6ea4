#!/usr/bin/python3
"""Two hands take the corners that bag.yaml names by their texture coordinates, and lift the ball."""

import unittest

import numpy as np
import rospy
import rostest

from clothsim.msg import Bodies
from cloth_client import Cloth, Recorder



class PlayMotionsTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.cloth = Cloth()
        cls.bodies = Recorder("/clothsim/bodies", Bodies)

    def test_hands_lift_the_ball(self):
        high = self.cloth.states.wait("corners at the height of the hands", lambda m: m.positions[2] > 0.595)
        self.assertEqual(list(high.held), [0, 32, 1056, 1088])
        state = self.cloth.states.wait("a second more", lambda m: m.time > high.time + 1)
        corners = np.reshape(state.positions, (-1, 3))[list(high.held)]
        expected = [[-0.15, -0.4, 0.6], [0.15, -0.4, 0.6], [-0.15, 0.4, 0.6], [0.15, 0.4, 0.6]]
        np.testing.assert_allclose(corners, expected, atol=2e-3)
        ball = self.bodies.wait("the ball", lambda m: m.header.stamp >= state.header.stamp).bodies[0]
        self.assertGreater(ball.pose.position.z, 0.15)
        self.assertLess(abs(ball.pose.position.x), 0.2)


if __name__ == "__main__":
    rospy.init_node("played_motions_test")
    rostest.rosrun("clothsim", "played_motions", PlayMotionsTest)
