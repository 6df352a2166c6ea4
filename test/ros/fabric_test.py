#!/usr/bin/python3
"""A fabric's values by dynamic_reconfigure, and wind by topic."""

import math
import unittest

import rospy
import rostest
from dynamic_reconfigure.client import Client
from geometry_msgs.msg import Vector3Stamped
from rosgraph_msgs.msg import Log

from cloth_client import (
    PATIENCE, Cloth, Frames, Recorder, make_transform, positions, publisher_at_once, wait_for)

SILK = {"stretch_stiffness_warp": 500.0, "stretch_stiffness_weft": 400.0, "shear_stiffness": 10.0,
        "bending_stiffness_warp": 3e-6, "bending_stiffness_weft": 2e-6, "density": 0.06,
        "internal_damping_stretch": 1e-5, "internal_damping_bending": 3e-3, "damping": 3.0,
        "strain_limit_enabled": False, "wind_x": 0.0, "wind_y": 0.0, "wind_z": 0.0, "gusts": 0.0}


class Fabric(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.cloth = Cloth()
        cls.log = Recorder("/rosout", Log)
        cls.client = Client("/clothsim", timeout=PATIENCE)
        cls.wind = publisher_at_once("/clothsim/wind", Vector3Stamped)
        wait_for(cls.wind.get_num_connections, "the node to hear of the wind")

    def setUp(self):
        self.cloth.pause()
        self.client.update_configuration(SILK)
        self.cloth.reset()

    def blown(self):
        """Mean y [m] after a third of a second: soon afterwards flutter amplifies differences of rounding."""
        return positions(self.cloth.step(30))[:, 1].mean()

    def test_starts_from_the_file(self):
        config = self.client.get_configuration(timeout=PATIENCE)
        self.assertEqual({name: config[name] for name in SILK}, SILK)

    def test_softer_hangs_lower(self):
        stiff = positions(self.cloth.step(180))[:, 2].min()
        self.client.update_configuration({"stretch_stiffness_weft": 1.0, "shear_stiffness": 0.1})
        self.cloth.reset()
        self.assertLess(positions(self.cloth.step(180))[:, 2].min(), stiff - 0.01)

    def test_refused_values_change_nothing(self):
        for bad in ({"ks": 100.0}, {"stretch_stiffness_warp": -1.0},
                    {"internal_damping_bending": math.nan}, {"drag_across": -1.0}, {"wind_z": 1e9}):
            name = list(bad)[0]
            self.log.clear()
            answer = self.client.update_configuration(bad)
            self.assertEqual({key: answer[key] for key in SILK}, SILK, bad)
            self.log.wait("a message of " + name,
                          lambda log: log.msg.startswith("/clothsim/%s: got " % name))

    def test_wind_by_topic_in_any_frame(self):
        """The same wind three times: in the world, in a turned frame, and as a live value."""
        message = Vector3Stamped()
        message.vector.y = 4
        self.wind.publish(message)
        rospy.sleep(0.3)
        in_world = self.blown()
        self.assertGreater(in_world, 0.01)

        frames = Frames()
        frames.send(make_transform("turned", (5, 5, 5), math.pi / 2, stamp=rospy.Time.now()))
        self.cloth.reset()
        message.header.frame_id, message.vector.x, message.vector.y = "turned", 4, 0  # its x is y
        self.wind.publish(message)
        rospy.sleep(0.3)
        self.assertAlmostEqual(self.blown(), in_world, delta=1e-5)

        self.cloth.reset()
        self.client.update_configuration({"wind_y": 4.0})
        self.assertAlmostEqual(self.blown(), in_world, delta=1e-5)

    def test_wind_that_is_no_use_is_told_and_ignored(self):
        message = Vector3Stamped()
        self.log.clear()
        message.vector.x = math.nan
        self.wind.publish(message)
        self.log.wait("a warning of numbers", lambda log: "Ignored a wind" in log.msg)
        message.header.frame_id, message.vector.x = "nowhere", 1
        self.wind.publish(message)


if __name__ == "__main__":
    rospy.init_node("fabric_test")
    rostest.rosrun("clothsim", "fabric", Fabric)
