#!/usr/bin/python3
"""The example of launch/arm.launch: lifted by friction alone, weighed, folded in a straight line, laid down in two
layers; nothing crosses."""

import re
import time
import unittest

import numpy as np
import rospy
import rostest
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from rosgraph_msgs.msg import Log

from clothsim.msg import Colliders
from cloth_client import SLOWER, Cloth, Recorder, positions, velocities

SIDE, POINTS = 0.4, 25
WEIGHT = 0.35 * SIDE**2 * 9.8  # [N]
CELL = SIDE / (POINTS - 1)  # [m]
LONGEST = 120 * SLOWER  # at most, for the example at 0.3 of its speed [s]


class Arm(unittest.TestCase):
    def test_folds(self):
        cloth = Cloth()
        log, diagnostics = Recorder("/rosout", Log), Recorder("/diagnostics", DiagnosticArray)
        colliders = Recorder("/clothsim/colliders", Colliders)
        end = time.monotonic() + LONGEST
        while not any(m.msg == "the towel is folded" for m in log.all()):
            self.assertLess(time.monotonic(), end, "the example goes on")
            time.sleep(0.1)

        # The towel hung free from two fingers, and no point was attached.
        self.assertGreater(max(positions(s)[:, 2].min() for s in cloth.states.all()), 0.02)
        self.assertEqual([m for m in colliders.all() if m.held], [])
        carried = next(float(found[1]) for found in (re.match(r"the arm carries (\S+) N", m.msg) for m in log.all())
                       if found)
        self.assertAlmostEqual(carried / WEIGHT, 1, delta=0.02)

        state = cloth.states.all()[-1]
        self.assertLess(np.abs(velocities(state)).max(), 0.05, "it lies")
        grid = positions(state).reshape(POINTS, POINTS, 3).astype(float)  # rows from the front edge to the far one
        y, z = grid[..., 1], grid[..., 2]

        # The fold: a straight line, square to the sides, near the middle.
        fold = y.min(axis=0)
        self.assertLess(np.ptp(fold), CELL)
        self.assertLess(np.abs(y.argmin(axis=0) - POINTS // 2).max(), 4)
        # Two layers: rows behind the fold lie on the table, rows before it upon them, as far as the far edge,
        # except for the ridge that the fingers made.
        lower, upper = z[POINTS // 2 + 4:], z[4:POINTS // 2 - 3]
        self.assertLess(lower.max(), 0.002)
        self.assertGreater(upper.min(), lower.max())
        self.assertLess(upper.max(), 0.01)
        self.assertLess(np.abs(y.max(axis=0) - y[-1]).max(), 2 * CELL)
        self.assertLess(z.max(), 3 * CELL)

        # Holding is no fault: the status is green while there are points between the fingers.
        simulation = [s for array in diagnostics.all() for s in array.status if "points between colliders"
                      in (v.key for v in s.values)]
        holding = [s for s in simulation
                   if int(next(v.value for v in s.values if v.key == "points between colliders")) > 0]
        self.assertGreater(len(holding), 0)
        self.assertIn(DiagnosticStatus.OK, {s.level for s in holding}, {s.message for s in holding})

        # Nothing crossed in any of the checks, one a second.
        crossings = [v.value for array in diagnostics.all() for s in array.status
                     for v in s.values if v.key == "intersecting pairs"]
        self.assertGreater(len(crossings), 5)
        self.assertEqual(set(crossings), {"0"})


if __name__ == "__main__":
    rospy.init_node("arm_test")
    rostest.rosrun("clothsim", "arm", Arm)
