#!/usr/bin/python3
"""The curtain of curtain.launch: drawn together it falls in pleats, also after a reset."""

import unittest

import numpy as np
import rospy
import rostest

from cloth_client import Cloth, positions

COLUMNS = ROWS = 40
DRAWN = 4.0  # [s] when the rings have come together and the cloth has followed


def pleats(row):
    """Number of turns of a row of points from front to back, by more than a centimetre."""
    sides = [1 if y > 0 else -1 for y in row[:, 1] - row[:, 1].mean() if abs(y) > 0.01]
    return np.count_nonzero(np.diff(sides))


class Curtain(unittest.TestCase):
    def expect_pleats(self, state):
        rows = positions(state).reshape(ROWS, COLUMNS, 3)
        self.assertAlmostEqual(np.ptp(rows[-1, :, 0]), 0.6, delta=0.02)
        for row in (rows[-1], rows[ROWS // 2], rows[0]):
            self.assertGreaterEqual(pleats(row), 3)
            self.assertLess(np.ptp(row[:, 0]), 0.85)
            self.assertGreater(np.ptp(row[:, 1]), 0.03)
        self.assertGreater(rows[:, :, 2].min(), 0.4)  # it hangs

    def test_pleats(self):
        cloth = Cloth()
        self.expect_pleats(cloth.states.wait("the drawn curtain", lambda s: s.time > DRAWN))
        cloth.reset()
        cloth.states.wait("the start", lambda s: s.time < 1)
        cloth.states.clear()
        self.expect_pleats(cloth.states.wait("the drawn curtain", lambda s: s.time > DRAWN))


if __name__ == "__main__":
    rospy.init_node("curtain_test")
    rostest.rosrun("clothsim", "curtain", Curtain)
