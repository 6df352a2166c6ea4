#!/usr/bin/python3
"""Two cloths in one node: their names, markers, looks and live values; a hand takes one by its own [column, row]."""

import unittest

import numpy as np
import rospy
import rostest
from dynamic_reconfigure.client import Client
from std_srvs.srv import Trigger
from visualization_msgs.msg import MarkerArray

from clothsim.msg import Change, ClothTopology
from cloth_client import Cloth, PATIENCE, Recorder, call, positions, wait_for


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

    def test_each_has_a_marker_of_its_own(self):
        array = Recorder("/clothsim/markers", MarkerArray).wait("markers")
        surfaces = [m for m in array.markers if m.ns == "surface"]
        self.assertEqual([m.id for m in surfaces], [0, 1])
        self.assertEqual([len(m.points) for m in surfaces], [2 * 3 * 800] * 2)
        self.assertNotEqual(surfaces[0].color, surfaces[1].color)

    def test_values_of_each_are_live(self):
        node, lower, upper = (Client("/clothsim" + space, timeout=PATIENCE)
                              for space in ("", "/cloth/lower", "/cloth/upper"))

        def shown(key):
            return [client.get_configuration()[key] for client in (node, lower, upper)]

        def expect(key, values):
            wait_for(lambda: shown(key) == values, "%s of node, lower and upper: %s" % (key, values))

        changes = Recorder("/clothsim/changes", Change)
        wait_for(changes.connected, "~changes")

        def cloths_of(change):
            names = [value.name for value in change.values.doubles if value.name.endswith("/density")]
            return [name.split("/")[1] for name in names]

        def expect_change(*names):
            changes.wait("set_parameters of " + " and ".join(names),
                         lambda m: m.what == "set_parameters" and cloths_of(m) == list(names))

        density, thickness, damping = shown("density"), shown("thickness"), shown("damping")
        upper.update_configuration({"density": 0.5, "friction": 0.7, "bending": False})
        expect("density", density[:2] + [0.5])
        expect_change("upper")
        expect("bending", [True, True, False])
        upper.update_configuration({"damping": 2.0, "drag_across": 1.5, "strain_limit_enabled": True,
                                    "strain_limit": 0.05})
        expect("damping", damping[:2] + [2.0])
        expect("drag_across", [1.17, 1.17, 1.5])
        expect("strain_limit_enabled", [False, False, True])
        self.assertEqual(upper.get_configuration()["strain_limit"], 0.05)
        self.assertEqual(upper.update_configuration({"strain_limit": -1})["strain_limit"], 0.05)
        lower.update_configuration({"density": 0.6, "thickness": 4e-4})
        expect("density", [0.6, 0.6, 0.5])
        node.update_configuration({"gravity_z": -9.7})
        expect("density", [0.6, 0.6, 0.5])
        node.update_configuration({"density": 0.4})
        expect("density", [0.4] * 3)
        expect("thickness", [4e-4, 4e-4, thickness[2]])
        self.assertEqual(upper.update_configuration({"thickness": -1})["thickness"], thickness[2])
        told = call("/clothsim/reset_values", Trigger).message
        self.assertIn("cloth/upper/friction 0.7", told)
        expect("density", density)
        expect("thickness", thickness)
        expect("bending", [True] * 3)
        expect("damping", damping)
        expect("strain_limit_enabled", [False] * 3)
        expect_change("lower", "upper")
        self.assertNotIn("cloth/", call("/clothsim/reset_values", Trigger).message)

    def test_each_has_a_look_of_its_own(self):
        lower, upper = (Client("/clothsim/shading/" + name, timeout=PATIENCE) for name in ("lower", "upper"))
        both = Client("/clothsim/shading/cloth", timeout=PATIENCE)

        def expect(*colors):
            wait_for(lambda: [client.get_configuration()["color_b"] for client in (lower, upper)] == list(colors),
                     "blue of %g and %g" % colors)

        before = lower.get_configuration()["color_b"]
        upper.update_configuration({"color_b": 0.9})
        expect(before, 0.9)
        both.update_configuration({"kd": 0.7})
        wait_for(lambda: lower.get_configuration()["kd"] == upper.get_configuration()["kd"] == 0.7, "kd of both")
        expect(before, 0.9)
        both.update_configuration({"color_b": 0.5})
        expect(0.5, 0.5)
        call("/clothsim/reset_values", Trigger)
        expect(before, before)

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
