#!/usr/bin/python3
"""The example of launch/grasp.launch: lifted, folded, laid down, let go, and nothing crosses."""

import re
import unittest

import numpy as np
import rospy
import rostest
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import WrenchStamped
from rosgraph_msgs.msg import Log
from tf2_msgs.msg import TFMessage

from cloth_client import Cloth, Recorder, point, positions, velocities

COLUMNS = ROWS = 30
HANDS = ("left_hand", "right_hand")
CORNERS = [0, COLUMNS - 1]
WEIGHT = 5 * 9.8  # [N] of the whole cloth
GROUND, BEND = 0.0015, 0.05  # points below GROUND lie on the ground; points above BEND hang [m]
SWING = 0.04  # share of the weight by which it may still bob where the computer is busy


class Grasp(unittest.TestCase):
    def test_folds(self):
        cloth = Cloth()
        diagnostics = Recorder("/diagnostics", DiagnosticArray)
        log = Recorder("/rosout", Log)
        transforms = Recorder("/tf", TFMessage)
        wrenches = {hand: Recorder("/clothsim/wrench/" + hand, WrenchStamped) for hand in HANDS}
        log.wait("the end of the example", lambda m: m.msg == "the cloth is folded")

        # The hands lifted it. At rest each carried half of the cloth between the ground and the hands: all
        # above the bend at the ground, and a part of the bend.
        highest = max(cloth.states.all(), key=lambda s: positions(s)[CORNERS, 2].min())
        self.assertGreater(positions(highest)[CORNERS, 2].min(), 0.5)
        carried = [float(re.search(r"carries (\S+) N", m.msg)[1]) for m in log.all()
                   if "carries" in m.msg]
        self.assertEqual(len(carried), 2)
        self.assertAlmostEqual(*carried, delta=0.02 * sum(carried))
        at_rest = self.state_before(cloth, log, "carries")
        height = positions(at_rest)[:, 2]
        self.assertGreater(height.max(), 0.5)
        self.assertLess(np.abs(velocities(at_rest)).max(), 0.2)
        self.assertGreater(sum(carried), WEIGHT * (np.mean(height > BEND) - SWING))
        self.assertLess(sum(carried), WEIGHT * (np.mean(height > GROUND) + SWING))

        self.expect_held(cloth.states.all(), transforms.all())
        # The hands laid the cloth down without pressing.
        let_go = self.state_before(cloth, log, "the cloth is folded").header.stamp
        for recorder in wrenches.values():
            last = max((m for m in recorder.all() if m.header.stamp <= let_go),
                       key=lambda m: m.header.stamp)
            self.assertLess(np.linalg.norm(point(last.wrench.force)), 0.1 * WEIGHT)

        # Two layers: the corners beside those of the far edge, and released.
        end = cloth.states.all()[-1].step
        where = positions(cloth.states.wait("a second more", lambda s: s.step > end + 90))
        far = where[[(ROWS - 1) * COLUMNS, ROWS * COLUMNS - 1]]
        self.assertLess(np.linalg.norm(where[CORNERS] - far, axis=1).max(), 0.1)
        self.assertLess(where[:, 2].max(), 0.1)
        self.assertGreater(where[:, 2].min(), 0)
        self.assertGreater(where[:, 1].min(), 0.3)  # nothing is left of the near half

        # Nothing crossed in any of the checks, one a second.
        crossings = [v.value for array in diagnostics.all() for s in array.status
                     for v in s.values if v.key == "intersecting pairs"]
        self.assertGreater(len(crossings), 5)
        self.assertEqual(set(crossings), {"0"})

    @staticmethod
    def state_before(cloth, log, text):
        """The last state before the first message with that text."""
        stamp = next(m.header.stamp for m in log.all() if text in m.msg)
        return max((s for s in cloth.states.all() if s.header.stamp <= stamp),
                   key=lambda s: s.header.stamp)

    def expect_held(self, states, transforms):
        """While they move, at 0.5 m/s of simulated time, the corners are within 1 mm of a recent place of
        the hands: the last transform that the node had received."""
        ways = {hand: [(t.header.stamp.to_sec(), point(t.transform.translation)) for m in transforms
                       for t in m.transforms if t.child_frame_id == hand] for hand in HANDS}
        moving = [b[0] for a, b in zip(ways[HANDS[0]], ways[HANDS[0]][1:]) if np.any(a[1] != b[1])]
        speeds, compared = [], 0
        for state in states:
            now = state.header.stamp.to_sec()
            if not moving[0] < now < moving[-1]:
                continue
            speeds.append(np.linalg.norm(velocities(state)[CORNERS[0]]))
            for hand, corner in zip(HANDS, CORNERS):
                near = [place for time, place in ways[hand] if -0.3 < time - now < 0.05]
                distance = np.linalg.norm(positions(state)[corner] - near, axis=1).min()
                self.assertLess(distance, 1e-3, "%s at frame %d" % (hand, state.step))
                compared += 1
        self.assertGreater(compared, 200)
        self.assertAlmostEqual(np.median([v for v in speeds if v > 0.1]), 0.5, delta=0.1)


if __name__ == "__main__":
    rospy.init_node("grasp_test")
    rostest.rosrun("clothsim", "grasp", Grasp)
