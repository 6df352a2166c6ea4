#!/usr/bin/python3
"""Forces of the cloth on colliders, their poses and the held points, as messages."""

import math
import unittest

import numpy as np
import rospy
import rostest
from dynamic_reconfigure.client import Client
from geometry_msgs.msg import WrenchStamped
from rosgraph_msgs.msg import Log

from clothsim.msg import Colliders, Contacts
from clothsim.srv import Attach, EnableCollider
from cloth_client import PATIENCE, Cloth, Frames, Recorder, call, make_transform, point, wait_for

WEIGHT = np.array([0, 0, -5 * 9.8])  # [N]
TURN = math.pi / 2  # of the tray about z
ARM = np.array([-0.05, 0.1, 0])  # [m] from the tray's frame to its middle, in the world


class ContactTopics(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.cloth = Cloth()
        cls.frames = Frames()
        cls.colliders = Recorder("/clothsim/colliders", Colliders)
        cls.log = Recorder("/rosout", Log)
        cls.colliders.wait("the colliders of a paused node")

    def setUp(self):
        self.frames.send(make_transform("tray", (0.55, 0.4, -0.0095), TURN))
        self.cloth.reset()

    def after(self, frames):
        """~contacts and the tray's wrench for the last of so many frames."""
        contacts = Recorder("/clothsim/contacts", Contacts)
        wrenches = Recorder("/clothsim/contact_wrench/robot_tray", WrenchStamped)
        wait_for(lambda: contacts.connected() and wrenches.connected(), "the topics")
        step = self.cloth.step(frames).step
        message = contacts.wait("the contacts", lambda m: m.step == step)
        wrench = wrenches.wait("the wrench", lambda m: m.header.stamp == message.header.stamp)
        contacts.close()
        wrenches.close()
        return message, wrench

    def test_at_rest_they_bear_the_weight(self):
        self.cloth.step(150)  # nobody listens
        message, wrench = self.after(30)
        self.assertEqual([(c.name, c.frame) for c in message.colliders],
                         [("ground", ""), ("robot/tray", "tray")])
        forces = [point(c.wrench.force) for c in message.colliders]
        # Except for the load of the pin: a quarter of a cell's weight and a little tension.
        np.testing.assert_allclose(sum(forces), WEIGHT, atol=0.01 * -WEIGHT[2])
        for contact, force in zip(message.colliders, forces):
            self.assertLess(force[2], -5, contact.name)
            self.assertGreater(contact.count, 10, contact.name)
        tray = message.colliders[1]
        np.testing.assert_allclose(point(tray.origin), [0.5, 0.5, -0.0095])
        np.testing.assert_allclose(point(tray.middle)[:2], [0.5, 0.5], atol=0.01)

        # The same about the frame's origin, in its axes, which are turned: its x is the world's y.
        self.assertEqual(wrench.header.frame_id, "tray")
        x, y, z = forces[1]
        np.testing.assert_allclose(point(wrench.wrench.force), [y, -x, z], atol=1e-9)
        x, y, z = np.array(point(tray.wrench.torque)) + np.cross(ARM, forces[1])
        np.testing.assert_allclose(point(wrench.wrench.torque), [y, -x, z], atol=1e-9)

    def test_a_fixed_collider_tells_about_the_world(self):
        self.assertTrue(call("/clothsim/enable_collider", EnableCollider, "robot/tray", False).success)
        recorder = Recorder("/clothsim/contact_wrench/ground", WrenchStamped)
        wait_for(recorder.connected, "the topic")
        self.cloth.step(180)
        wrench = recorder.wait("the wrench")
        self.assertEqual(wrench.header.frame_id, "map")
        # The arms are half the sides: -W y about x, W x about y.
        torque = point(recorder.all()[-1].wrench.torque)
        np.testing.assert_allclose(torque, [-24.5, 24.5, 0], atol=0.1)
        recorder.close()

    def test_colliders_and_what_is_held(self):
        call("/clothsim/enable_collider", EnableCollider, "ground", False)
        self.frames.send(make_transform("hand", (1, 1, 0)))
        self.assertTrue(call("/clothsim/attach", Attach, "hand", [143, 142], 0, 7.5, 0.0, "", "").success)
        step = self.cloth.step(1).step
        message = self.colliders.wait("the colliders", lambda m: m.step == step and len(m.held) > 1)
        ground, tray = message.colliders
        self.assertEqual((ground.name, ground.frame, ground.enabled, ground.friction),
                         ("ground", "", False, 0.5))
        self.assertEqual((tray.name, tray.frame, tray.enabled), ("robot/tray", "tray", True))
        np.testing.assert_allclose(point(tray.pose.position), [0.5, 0.5, -0.0095])
        self.assertAlmostEqual(tray.pose.orientation.z, math.sin(TURN / 2))
        self.assertEqual([(h.frame, h.points, h.pinned, h.tear_force) for h in message.held],
                         [("", (0,), True, 0), ("hand", (143, 142), False, 7.5)])

    def test_friction_of_a_collider_is_a_live_value(self):
        client = Client("/clothsim/collider/robot_tray", timeout=PATIENCE)
        self.assertEqual(client.update_configuration({"friction": 0.9})["friction"], 0.9)
        self.log.clear()
        self.assertEqual(client.update_configuration({"friction": -1.0})["friction"], 0.9)
        self.log.wait("a refusal", lambda log: log.msg.startswith(
            "/clothsim/collider/robot_tray/friction: got -1"))
        self.colliders.clear()
        step = self.cloth.step(1).step
        message = self.colliders.wait("the colliders", lambda m: m.step == step)
        self.assertEqual([c.friction for c in message.colliders], [0.5, 0.9])
        client.update_configuration({"friction": 0.5})


if __name__ == "__main__":
    rospy.init_node("contacts_test")
    rostest.rosrun("clothsim", "contacts", ContactTopics)
