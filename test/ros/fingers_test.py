#!/usr/bin/python3
"""Two fingers that another node drives over tf close on a cloth farther than there is room."""

import unittest

import numpy as np
import rospy
import rostest

from cloth_client import Cloth, Frames, make_transform, positions, velocities

HALF = 0.02  # of a finger's width [m]
OPEN, CLOSED = 0.36, -0.004  # between them [m]
LOW, HIGH = 0.3, 0.6  # [m]


class Fingers(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.cloth = Cloth()
        cls.frames = Frames()

    def go(self, gaps, heights, frames):
        """Moves from the first to the last gap and height; returns the state then, and the largest speed."""
        fastest = 0
        for gap, z in zip(np.linspace(*gaps, frames), np.linspace(*heights, frames)):
            self.frames.send(*[
                make_transform(frame, (0.5, side * (HALF + gap / 2), z), stamp=rospy.Time.now())
                for frame, side in (("left_finger", -1), ("right_finger", 1))])
            state = self.cloth.step(1)
            fastest = max(fastest, np.linalg.norm(velocities(state), axis=1).max())
        return state, fastest

    def test_lift(self):
        hanging, _ = self.go((OPEN, OPEN), (LOW, LOW), 180)
        held = np.linalg.norm(positions(hanging) - (0.5, 0, LOW), axis=1).argmin()
        before = positions(hanging)[held]

        self.go((OPEN, CLOSED), (LOW, LOW), 60)
        lifted, fastest = self.go((CLOSED, CLOSED), (LOW, HIGH), 90)
        way = positions(lifted)[held] - before
        np.testing.assert_allclose(way, (0, 0, HIGH - LOW), atol=0.01)
        self.assertLess(fastest, 5, "nothing is flung about")

        self.go((CLOSED, 2), (HIGH, HIGH), 90)
        free, _ = self.go((2, 2), (HIGH, HIGH), 180)
        np.testing.assert_allclose(positions(free)[held], before, atol=0.02)


if __name__ == "__main__":
    rospy.init_node("fingers_test")
    rostest.rosrun("clothsim", "fingers", Fingers)
