#!/usr/bin/python3
"""Forces on points by topic, and the internal forces of the cloth as messages."""

import math
import re
import time
import unittest

import numpy as np
import rospy
import rostest
from geometry_msgs.msg import Vector3
from rosgraph_msgs.msg import Log

from clothsim.msg import Change, ClothTopology, PointForces, Stress
from cloth_client import Cloth, Frames, Recorder, make_transform, positions, publisher_at_once, says, wait_for

POINT_MASS = 2 / 30  # [kg]


class Forces(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.cloth = Cloth()
        cls.frames = Frames()
        cls.changes = Recorder("/clothsim/changes", Change)
        cls.log = Recorder("/rosout", Log)
        cls.forces = publisher_at_once("/clothsim/forces", PointForces)
        wait_for(lambda: cls.forces.get_num_connections() and cls.changes.connected(), "the node")

    def setUp(self):
        self.cloth.reset()
        self.changes.clear()
        self.log.clear()

    def send(self, points, forces, frame="", duration=0.0):
        message = PointForces(points=points, forces=[Vector3(*force) for force in forces], duration=duration)
        message.header.frame_id = frame
        self.forces.publish(message)

    def push(self, *arguments, **options):
        self.changes.clear()
        self.send(*arguments, **options)
        return self.changes.wait("the forces", lambda m: m.what == "forces")

    def momentum(self, frames):
        velocities = np.asarray(self.cloth.step(frames).velocities).reshape(-1, 3)
        return POINT_MASS * velocities.sum(axis=0)

    def test_they_give_momentum_until_the_next_message(self):
        change = self.push([0, 29], [(1, 0, 0), (0, 0, 3)])
        self.assertEqual(tuple(change.points), (0, 29))
        np.testing.assert_allclose(self.momentum(20), [0.2, 0, 0.6], atol=1e-5)
        self.push([7], [(0, -2, 0)])
        np.testing.assert_allclose(self.momentum(10), [0.2, -0.2, 0.6], atol=1e-5)
        self.push([], [])
        np.testing.assert_allclose(self.momentum(10), [0.2, -0.2, 0.6], atol=1e-5)

    def test_they_act_for_a_duration_and_end_with_reset(self):
        self.push([3], [(0, 0, 1)], duration=0.052)  # five frames
        np.testing.assert_allclose(self.momentum(20), [0, 0, 0.05], atol=1e-5)
        self.push([3], [(0, 0, 1)])
        self.cloth.reset()
        np.testing.assert_allclose(self.momentum(5), [0, 0, 0], atol=1e-6)

    def test_they_are_turned_with_their_frame(self):
        self.frames.send(make_transform("fan", (5, 5, 5), math.pi / 2, stamp=rospy.Time.now()))
        self.push([3], [(1, 0, 0.5)], frame="fan")
        np.testing.assert_allclose(self.momentum(10), [0, 0.1, 0.05], atol=1e-5)

    def test_what_is_wrong_is_told_and_changes_nothing(self):
        self.push([0], [(1, 0, 0)])
        self.changes.clear()
        self.send([30], [(1, 0, 0)])
        refusal = says("~forces.points.0: got 30 ... 0 to 29")
        self.log.wait("a warning", lambda log: re.search(refusal, log.msg))
        for points, forces, options in (
                ([1, 1], [(1, 0, 0)] * 2, {}), ([1, 2], [(1, 0, 0)], {}), ([1], [(math.nan, 0, 0)], {}),
                ([1], [(2e6, 0, 0)], {}), ([1], [(1, 0, 0)], {"frame": "nowhere"}),
                ([1], [(1, 0, 0)], {"duration": -1.0}), ([1], [(1, 0, 0)], {"duration": math.nan})):
            self.send(points, forces, **options)
            time.sleep(0.05)  # further warnings are throttled
        np.testing.assert_allclose(self.momentum(10), [0.1, 0, 0], atol=1e-5)
        self.assertEqual([m.what for m in self.changes.all() if m.what == "forces"], [])

    def test_stress_is_hooke_s(self):
        topology = Recorder("/clothsim/topology", ClothTopology).wait("the topology")
        stress = Recorder("/clothsim/stress", Stress)
        wait_for(stress.connected, "the topic")
        self.push([0, 1, 2, 27, 28, 29], [(0, -2, 0)] * 3 + [(0, 2, 0)] * 3)
        state = self.cloth.step(40)
        message = stress.wait("the stress", lambda m: m.header.stamp == state.header.stamp)
        self.assertEqual((message.step, message.topology_seq), (state.step, topology.seq))
        x, rest = positions(state), np.asarray(topology.rest_positions).reshape(-1, 3)
        for family, stiffness in (("structural", 300), ("shear", 300), ("bending", 60)):
            a, b = np.asarray(getattr(topology, family)).reshape(-1, 2).T
            longer = np.linalg.norm(x[b] - x[a], axis=1) - np.linalg.norm(rest[b] - rest[a], axis=1)
            self.assertGreater(np.abs(longer).max(), 1e-4)
            np.testing.assert_allclose(getattr(message, family), stiffness * longer, atol=3e-4 * stiffness)
        triangles = np.reshape(message.triangles, (-1, 3))
        self.assertEqual(len(triangles), len(topology.triangles) // 3)
        self.assertGreater(triangles[:, 1].mean(), 1)  # pulled along its columns
        stress.close()


if __name__ == "__main__":
    rospy.init_node("forces_test")
    rostest.rosrun("clothsim", "forces", Forces)
