#!/usr/bin/python3
"""Contents of the messages: consistent with each other, finite, and valid for RViz."""

import threading
import unittest

import numpy as np
import rospy
import rostest
import sensor_msgs.point_cloud2
from diagnostic_msgs.msg import DiagnosticArray
from dynamic_reconfigure.client import Client
from sensor_msgs.msg import PointCloud2
from tf2_ros import StaticTransformBroadcaster
from visualization_msgs.msg import Marker, MarkerArray

from clothsim.msg import ClothTopology
from cloth_client import (PATIENCE, Cloth, Recorder, make_transform, marker_named, point, points,
                          positions, velocities)

COLUMNS, ROWS = 7, 5
N = COLUMNS * ROWS
SKIN = 0.0005  # distance of a drawn side from the cloth [m]


def pairs(indices):
    return np.asarray(indices, dtype=int).reshape(-1, 2)


class Messages(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.cloth = Cloth()
        cls.markers = Recorder("/clothsim/markers", MarkerArray)
        cls.springs = Recorder("/clothsim/markers/springs", MarkerArray)
        cls.colliders = Recorder("/clothsim/markers/colliders", MarkerArray)
        cls.topology = Recorder("/clothsim/topology", ClothTopology).wait("the topology")
        # Paused from the start, the simulation publishes nothing; new subscribers receive the state.
        cls.cloth.states.wait("the first state")
        recorders = (cls.markers, cls.springs, cls.colliders)
        for recorder in recorders:
            recorder.wait("the first markers")
        cls.state = cls.cloth.step(20)
        cls.array, cls.spring_array, cls.collider_array = [
            recorder.wait("the markers of frame 20",
                          lambda a: a.markers[0].header.stamp == cls.state.header.stamp)
            for recorder in recorders]

    def test_state(self):
        self.assertEqual(self.state.header.frame_id, "table")
        self.assertEqual(self.state.step, 20)
        self.assertEqual(self.state.topology_seq, self.topology.seq)
        self.assertEqual(positions(self.state).shape, (N, 3))
        self.assertEqual(velocities(self.state).shape, (N, 3))
        self.assertTrue(np.isfinite(positions(self.state)).all())
        self.assertTrue(np.isfinite(velocities(self.state)).all())

    def test_diagnostics(self):
        def says_none_cross(array):
            return any(v.key == "intersecting pairs" and v.value == "0"
                       for status in array.status for v in status.values)
        Recorder("/diagnostics", DiagnosticArray).wait("a count of crossings", says_none_cross)

    def test_points(self):
        clouds = Recorder("/clothsim/points", PointCloud2)
        cloud = clouds.wait("points")
        clouds.close()
        state = self.cloth.states.all()[-1]
        self.assertEqual(cloud.header.stamp, state.header.stamp)
        self.assertEqual(cloud.header.frame_id, "table")
        self.assertEqual((cloud.width, cloud.height), (COLUMNS, ROWS))
        self.assertEqual(len(cloud.data), cloud.row_step * cloud.height)
        read = np.array(list(sensor_msgs.point_cloud2.read_points(cloud, ("x", "y", "z"))))
        self.assertTrue(np.array_equal(read.astype(np.float32), positions(state)))

    def test_who_comes_during_a_frame_gets_it_once(self):
        """Frames that take long, so that the subscriber comes during one of them."""
        client = Client("/clothsim", timeout=PATIENCE)
        client.update_configuration({"substeps": 10000})
        self.cloth.states.clear()
        stepping = threading.Thread(target=lambda: self.cloth.step(20))
        stepping.start()
        self.cloth.states.wait("a frame")
        clouds = Recorder("/clothsim/points", PointCloud2)
        stepping.join()
        client.update_configuration({"substeps": 0})
        last = self.cloth.step(1).header.stamp
        clouds.wait("the points of one frame more", lambda c: c.header.stamp == last)
        stamps = [c.header.stamp for c in clouds.all()]
        self.assertEqual(stamps, sorted(set(stamps)))
        clouds.close()

    def test_topology(self):
        topology = self.topology
        self.assertEqual((topology.columns, topology.rows), (COLUMNS, ROWS))
        self.assertEqual(list(topology.pinned), [0, COLUMNS - 1])

        rest = np.asarray(topology.rest_positions).reshape(-1, 3)
        uv = np.asarray(topology.uv).reshape(-1, 2)
        self.assertEqual((len(rest), len(uv)), (N, N))
        self.assertEqual((uv.min(), uv.max()), (0, 1))

        # Each family joins the neighbours that its name says, once.
        grid = np.stack([np.arange(N) % COLUMNS, np.arange(N) // COLUMNS], axis=1)
        steps = {"structural": ({(1, 0), (0, 1)}, ROWS * (COLUMNS - 1) + COLUMNS * (ROWS - 1)),
                 "shear": ({(1, 1), (1, -1)}, 2 * (ROWS - 1) * (COLUMNS - 1)),
                 "bending": ({(2, 0), (0, 2)}, ROWS * (COLUMNS - 2) + COLUMNS * (ROWS - 2))}
        for family, (allowed, count) in steps.items():
            springs = pairs(getattr(topology, family))
            self.assertEqual(len({tuple(sorted(s)) for s in springs}), count, family)
            self.assertEqual(len(springs), count, family)
            way = grid[springs[:, 1]] - grid[springs[:, 0]]
            way[way[:, 0] < 0] *= -1
            way[(way[:, 0] == 0) & (way[:, 1] < 0)] *= -1
            self.assertLessEqual({tuple(w) for w in way}, allowed, family)

    def test_triangles_face_up_and_cover_the_cloth(self):
        rest = np.asarray(self.topology.rest_positions).reshape(-1, 3)
        corners = rest[np.asarray(self.topology.triangles, dtype=int).reshape(-1, 3)]
        self.assertEqual(len(corners), 2 * (ROWS - 1) * (COLUMNS - 1))
        double_area = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        self.assertGreater(double_area[:, 2].min(), 0)  # counter-clockwise from above: normals up
        self.assertAlmostEqual(double_area[:, 2].sum() / 2, 0.6 * 0.4, delta=1e-6)

    def test_markers_are_well_formed(self):
        seen = set()
        for m in self.array.markers + self.spring_array.markers:
            self.assertEqual(m.header.frame_id, "table")
            self.assertEqual(m.header.stamp, self.state.header.stamp)
            self.assertNotIn((m.ns, m.id), seen)
            seen.add((m.ns, m.id))
            self.assertEqual(m.action, Marker.ADD)
            q = m.pose.orientation
            self.assertAlmostEqual(q.x**2 + q.y**2 + q.z**2 + q.w**2, 1, delta=1e-9)
            self.assertTrue(np.isfinite(point(m.pose.position)).all())
            self.assertGreater(m.scale.x, 0)
            self.assertEqual(len(m.colors), 0)  # they would switch RViz's lighting off
            self.assertEqual(m.color.a, 1)
            if m.points:
                self.assertTrue(np.isfinite(points(m)).all())
        self.assertEqual(seen, {("surface", 0), ("structural", 0), ("shear", 0), ("bending", 0),
                                ("pins", 0)} |
                         {("colliders", id) for id in (0, 1, 2, 3, 3 + 7, 3 + 2 * 7, 4, 5, 6)})

    def test_each_topic_has_its_part(self):
        self.assertEqual({m.ns for m in self.array.markers}, {"surface", "colliders", "pins"})
        self.assertEqual({m.ns for m in self.spring_array.markers},
                         {"structural", "shear", "bending"})
        self.assertEqual(self.collider_array.markers,
                         [m for m in self.array.markers if m.ns == "colliders"])

    def test_a_new_subscriber_drops_what_it_had(self):
        """RViz keeps the markers of a node that has ended; the next node may have fewer."""
        for recorder in (self.markers, self.springs, self.colliders):
            first, *others = recorder.all()
            self.assertEqual([m.action for m in first.markers[:2]], [Marker.DELETEALL, Marker.ADD])
            self.assertTrue(others)
            for array in others:
                self.assertNotIn(Marker.DELETEALL, [m.action for m in array.markers])

    def test_markers_show_the_state(self):
        where = positions(self.state)

        def shown(ns, array=self.array):
            return points(marker_named(array, ns)).astype(np.float32)

        # All fronts, then all backs turned round, each side a little off the cloth.
        self.assertEqual(marker_named(self.array, "surface").type, Marker.TRIANGLE_LIST)
        corners = where[np.asarray(self.topology.triangles, dtype=int)].reshape(-1, 3, 3)
        front, back = np.split(points(marker_named(self.array, "surface")).reshape(-1, 3, 3), 2)
        back = back[:, [0, 2, 1]]
        self.assertTrue(np.allclose((front + back) / 2, corners, atol=1e-6))
        out = front - corners
        self.assertTrue(np.allclose(np.linalg.norm(out, axis=2), SKIN, atol=1e-6))
        normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        self.assertGreater(np.einsum("tci,ti->tc", out, normal).min(), 0)

        for family in ("structural", "shear", "bending"):
            self.assertEqual(marker_named(self.spring_array, family).type, Marker.LINE_LIST)
            ends = np.asarray(getattr(self.topology, family), dtype=int)
            self.assertTrue(np.array_equal(shown(family, self.spring_array), where[ends]), family)
        self.assertTrue(np.array_equal(
            shown("pins"), where[np.asarray(self.topology.pinned, dtype=int)]))

    def test_springs_have_the_colours_of_the_images(self):
        """docs/gallery.md, wireframe: light grey, orange, blue."""
        for family, expected in (("structural", (0.9, 0.9, 0.9)), ("shear", (1, 0.6, 0.1)),
                                 ("bending", (0.2, 0.6, 1))):
            color = marker_named(self.spring_array, family).color
            self.assertTrue(np.allclose((color.r, color.g, color.b), expected), family)

    def test_collider_markers(self):
        ball, ground, sheet, rod, end, other_end, crate, drum, finger = [
            m for m in self.array.markers if m.ns == "colliders"]
        self.assertEqual(ball.type, Marker.SPHERE)
        self.assertTrue(np.allclose(point(ball.scale), 0.2))
        self.assertTrue(np.allclose(point(ball.pose.position), [0.3, 0.2, 0.5]))

        # The upper face of the plate is the plane; a two-sided plane lies about its middle.
        normal = np.array([0, 0.6, 0.8])
        self.assertEqual(ground.type, Marker.CUBE)
        face = point(ground.pose.position) + normal * ground.scale.z / 2
        self.assertTrue(np.allclose(face, [0, 0, 0.1], atol=1e-9))
        self.assertTrue(np.allclose(point(sheet.pose.position), [0, 0, -1]))

        # A capsule is a cylinder along its z axis and two balls.
        self.assertEqual(rod.type, Marker.CYLINDER)
        self.assertTrue(np.allclose(point(rod.scale), [0.1, 0.1, 0.4]))
        self.assertTrue(np.allclose(point(rod.pose.position), [2, 0, 0]))
        q = rod.pose.orientation
        self.assertTrue(np.allclose([q.x, q.y, q.z, q.w], [0, 0.5**0.5, 0, 0.5**0.5]))
        for ball, x in ((end, 2.2), (other_end, 1.8)):
            self.assertEqual(ball.type, Marker.SPHERE)
            self.assertTrue(np.allclose(point(ball.scale), 0.1))
            self.assertTrue(np.allclose(point(ball.pose.position), [x, 0, 0]))

        self.assertEqual(crate.type, Marker.CUBE)
        self.assertTrue(np.allclose(point(crate.scale), [0.1, 0.2, 0.3]))
        self.assertTrue(np.allclose(point(crate.pose.position), [0, 2, 0]))
        q = crate.pose.orientation
        self.assertTrue(np.allclose([q.x, q.y, q.z, q.w], [0, 0, np.sin(0.25), np.cos(0.25)]))

        self.assertEqual(drum.type, Marker.CYLINDER)
        self.assertTrue(np.allclose(point(drum.scale), [0.1, 0.1, 0.4]))
        self.assertTrue(np.allclose(point(drum.pose.position), [0, 3, 0]))
        q = drum.pose.orientation
        self.assertTrue(np.allclose([q.x, q.y, q.z, q.w], [0, 0.5**0.5, 0, 0.5**0.5]))

        # RViz loads a mesh itself.
        self.assertEqual((finger.type, finger.mesh_resource),
                         (Marker.MESH_RESOURCE, "package://clothsim/config/robots/finger.stl"))
        self.assertTrue(np.allclose(point(finger.scale), [2, 1, -1]))
        self.assertTrue(np.allclose(point(finger.pose.position), [0, 4, 0]))

    def test_family_switched_off_is_deleted(self):
        client = Client("/clothsim", timeout=PATIENCE)
        client.update_configuration({"bending": False})
        gone = self.springs.wait("markers without bending springs", lambda a: marker_named(
            a, "bending").action == Marker.DELETE)
        self.assertEqual(marker_named(gone, "shear").action, Marker.ADD)
        client.update_configuration({"bending": True})
        self.springs.wait("bending springs again",
                          lambda a: marker_named(a, "bending").action == Marker.ADD)

    def test_pin_follows_its_frame(self):
        """With its offset to the frame at the first transform, which may be any."""
        broadcaster = StaticTransformBroadcaster()
        hand = make_transform("hand", (5, 0, 0), parent="table")
        start = positions(self.cloth.step(1))[COLUMNS - 1].copy()
        broadcaster.sendTransform(hand)

        def where_after_a_frame():
            return positions(self.cloth.step(1))[COLUMNS - 1]

        # Stepping on changes nothing until the frame moves.
        for _ in range(20):
            self.assertTrue(np.array_equal(where_after_a_frame(), start))
            rospy.sleep(0.02)

        hand.transform.translation.z = 0.1
        broadcaster.sendTransform(hand)
        target = start + np.array([0, 0, 0.1], dtype=np.float32)
        for _ in range(500):
            if np.allclose(where_after_a_frame(), target, atol=1e-6):
                break
            rospy.sleep(0.01)
        self.assertTrue(np.allclose(where_after_a_frame(), target, atol=1e-6))


if __name__ == "__main__":
    rospy.init_node("messages_test")
    rostest.rosrun("clothsim", "messages", Messages)
