#!/usr/bin/python3
"""Two cloths in one node: their names in ~topology, and a hand that takes one of them by its own [column, row]."""

import unittest

import numpy as np
import rospy
import rostest

from clothsim.msg import ClothTopology
from cloth_client import Cloth, Recorder, positions


class NapkinsTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.cloth = Cloth()
        cls.topology = Recorder("/clothsim/topology", ClothTopology).wait("the topology")

    def test_topology_lists_the_cloths(self):
        self.assertEqual(list(self.topology.cloths), ["lower", "upper"])
        self.assertEqual(list(self.topology.first_points), [0, 441])
        self.assertEqual(list(self.topology.cloth_columns), [21, 21])
        self.assertEqual((self.topology.columns, self.topology.rows), (882, 1))

    def test_the_hand_takes_the_upper_one(self):
        high = self.cloth.states.wait("the corner 0.2 m above the table",
                                      lambda m: positions(m)[441, 2] > 0.2)
        self.assertEqual(list(high.held), [441, 442, 462])
        lower = positions(high)[:441]
        self.assertLess(lower[:, 2].max(), 0.01)
        aside = self.cloth.states.wait("the corner aside", lambda m: positions(m)[441, 0] > 0.3)
        self.assertLess(np.linalg.norm(positions(aside)[:441] - lower, axis=1).max(), 0.01)


if __name__ == "__main__":
    rospy.init_node("napkins_test")
    rostest.rosrun("clothsim", "napkins", NapkinsTest)
