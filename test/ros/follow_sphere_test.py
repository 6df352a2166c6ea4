#!/usr/bin/python3
"""A sphere moved over tf lifts the cloth and carries it along, and no cloth gets inside."""

import threading
import unittest

import numpy as np
import rospy
import rostest
import tf2_ros
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from rosgraph_msgs.msg import Log
from visualization_msgs.msg import MarkerArray

from cloth_client import Cloth, Recorder, make_transform, marker_named, point, positions, wait_for

START = np.array([0.5, 0.5, 0.2])  # of the sphere, as in the scene [m]
RADIUS = 0.2  # [m]
SPEED = 1.0  # of the sphere, in simulated time [m/s]
FRAME_WAY = SPEED / 90  # at 90 frames per second [m]


class MovingSphere:
    """Broadcasts the frame `sphere` on its path from point to point.

    It advances by one frame's distance at SPEED once the node's sphere has reached the last place, so that
    no frame moves it faster on a slow machine either.
    """

    def __init__(self):
        self._lock = threading.Lock()
        self._position = START.copy()
        self._target = START.copy()
        self.silent = False
        self._broadcaster = tf2_ros.TransformBroadcaster()
        self._subscriber = rospy.Subscriber("/clothsim/markers", MarkerArray, self._move)

    def _move(self, array):
        with self._lock:
            centre = point(marker_named(array, "colliders").pose.position)
            if np.allclose(centre, self._position, rtol=0, atol=1e-9):
                way = self._target - self._position
                length = np.linalg.norm(way)
                self._position += way if length <= FRAME_WAY else way * (FRAME_WAY / length)
            if not self.silent:
                self._send()

    def send_useless(self):
        with self._lock:
            known, self._position = self._position, np.array([np.inf, 0, 0])
            self._send()
            self._position = known

    def _send(self):
        self._broadcaster.sendTransform(
            make_transform("sphere", self._position, stamp=rospy.Time.now()))

    def go_to(self, target):
        with self._lock:
            self._target = np.array(target, dtype=float)
        wait_for(lambda: np.array_equal(self._position, self._target), "the sphere's way")


class FollowSphere(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.cloth = Cloth()
        cls.markers = Recorder("/clothsim/markers", MarkerArray)
        cls.diagnostics = Recorder("/diagnostics", DiagnosticArray)
        cls.log = Recorder("/rosout", Log)
        cls.cloth.states.wait("the first state")
        cls.markers.wait("the first markers")

    def sphere_centres(self):
        """Places of the node's sphere, by stamp."""
        centres = {}
        for array in self.markers.all():
            marker = marker_named(array, "colliders")
            centres[marker.header.stamp] = point(marker.pose.position)
        return centres

    def wait_for_sphere(self, target):
        return self.markers.wait(
            "the node's sphere at %s" % target,
            lambda a: np.allclose(point(marker_named(a, "colliders").pose.position), target,
                                  atol=1e-9))

    def test_follow(self):
        # Before the frame is broadcast, the sphere is where the scene puts it.
        self.wait_for_sphere(START)
        sphere = MovingSphere()
        self.cloth.pause(False)

        # Up through the falling cloth, which comes to lie on the sphere's top, above its start.
        top = START + [0, 0, 0.9]
        sphere.go_to(top)
        self.wait_for_sphere(top)
        lifted = positions(self.cloth.states.wait(
            "the cloth on the lifted sphere",
            lambda s: abs(positions(s)[:, 2].max() - (top[2] + RADIUS)) < 0.02))

        # Aside: its middle goes along with the sphere.
        side = top + [0.5, 0, 0]
        sphere.go_to(side)
        self.wait_for_sphere(side)
        middle = lifted.shape[0] // 2
        self.cloth.states.wait("the cloth's middle to be carried aside",
                               lambda s: positions(s)[middle, 0] > lifted[middle, 0] + 0.25)

        self.nothing_inside()
        self.moved_at_speed()
        self.ignores_nonsense(sphere, side)
        self.lost_and_found(sphere, side)

    def nothing_inside(self):
        centres = self.sphere_centres()
        compared = 0
        for state in self.cloth.states.all():
            if state.header.stamp not in centres:
                continue
            distance = np.linalg.norm(positions(state) - centres[state.header.stamp], axis=1)
            self.assertGreaterEqual(distance.min(), RADIUS, "inside at frame %d" % state.step)
            compared += 1
        self.assertGreater(compared, 60)

    def moved_at_speed(self):
        """The comparison above was with a moving sphere."""
        centres = sorted(self.sphere_centres().items())
        ways = [np.linalg.norm(b[1] - a[1]) for a, b in zip(centres, centres[1:])]
        self.assertAlmostEqual(sum(ways), 1.4, delta=1e-6)
        self.assertLess(max(ways), FRAME_WAY + 1e-6)

    def ignores_nonsense(self, sphere, where):
        sphere.silent = True
        sphere.send_useless()
        self.log.wait("a warning of the useless transform",
                      lambda log: log.msg.startswith("Ignored a transform of tf frame sphere"))
        self.markers.clear()
        self.wait_for_sphere(where)

    def lost_and_found(self, sphere, where):
        def status(level, text):
            return lambda array: any(s.level == level and text in s.message for s in array.status)

        sphere.silent = True
        self.diagnostics.wait("a warning of the lost frame",
                              status(DiagnosticStatus.WARN, "lost tf frame sphere"))
        self.markers.clear()
        self.wait_for_sphere(where)

        sphere.silent = False
        self.diagnostics.clear()
        self.diagnostics.wait(
            "diagnostics without the warning",
            lambda array: any("simulation" in s.name and "lost" not in s.message
                              for s in array.status))


if __name__ == "__main__":
    rospy.init_node("follow_sphere_test")
    rostest.rosrun("clothsim", "follow_sphere", FollowSphere)
