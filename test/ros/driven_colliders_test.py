#!/usr/bin/python3
"""A sphere and a box that another node drives over tf, under a cloth: no triangle gets inside."""

import unittest

import numpy as np
import rospy
import rostest

from clothsim.msg import ClothTopology
from cloth_client import Cloth, Frames, Recorder, make_transform, positions, velocities

BALL = np.array([0.5, 0.5, 0.65])  # where they start [m]
CRATE = np.array([0.5, 0.5, 0.65])
AWAY = np.array([0.5, 9.0, 0.65])  # where the other one waits
RADIUS = 0.2  # [m]
HALF = np.array([0.2, 0.25, 0.15])  # [m]
FRAMES_PER_SECOND = 90
SETTLE = 90  # frames until the cloth lies


def turned(angle):
    """The axes of a frame turned about z, as columns."""
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])


def distance_from(centre, triangles):
    """Distance [T] of `centre` to the nearest point of each triangle; T x 3 x 3 corners."""
    nearest = np.linalg.norm(triangles - centre, axis=2).min(axis=1)
    for i in range(3):
        a, d = triangles[:, i], triangles[:, (i + 1) % 3] - triangles[:, i]
        t = np.clip(((centre - a) * d).sum(axis=1) / (d * d).sum(axis=1), 0, 1)
        nearest = np.minimum(nearest, np.linalg.norm(a + t[:, None] * d - centre, axis=1))
    # Where the foot of the perpendicular is in the triangle.
    a, b, c = triangles[:, 0], triangles[:, 1], triangles[:, 2]
    n = np.cross(b - a, c - a)
    n /= np.linalg.norm(n, axis=1)[:, None]
    height = ((centre - a) * n).sum(axis=1)
    foot = centre - height[:, None] * n
    within = np.all([(np.cross(q - p, foot - p) * n).sum(axis=1) >= 0
                     for p, q in ((a, b), (b, c), (c, a))], axis=0)
    return np.where(within, np.abs(height), nearest)


def ways_out_of_box(triangles):
    """Translation of each triangle, in the box's frame, that separates it from the box; negative if apart."""
    edges = [triangles[:, (i + 1) % 3] - triangles[:, i] for i in range(3)]
    axes = [np.broadcast_to(axis, edges[0].shape) for axis in np.eye(3)]
    axes.append(np.cross(edges[0], edges[1]))
    axes += [np.cross(axis, edge) for axis in np.eye(3) for edge in edges]
    shortest = np.full(len(triangles), np.inf)
    for axis in axes:
        length = np.linalg.norm(axis, axis=1)
        u = axis / np.maximum(length, 1e-12)[:, None]
        reach = np.abs(u) @ HALF
        along = (triangles * u[:, None, :]).sum(axis=2)
        way = np.minimum(reach - along.min(axis=1), reach + along.max(axis=1))
        shortest = np.where(length > 1e-9, np.minimum(shortest, way), shortest)
    return shortest


class DrivenColliders(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.cloth = Cloth()
        cls.frames = Frames()
        topology = Recorder("/clothsim/topology", ClothTopology).wait("the topology")
        cls.triangles = np.asarray(topology.triangles, dtype=int).reshape(-1, 3)

    def send(self, frame, position, angle=0.0):
        self.frames.send(make_transform(frame, position, angle, stamp=rospy.Time.now()))

    def lay(self, ball, crate):
        """Resets the cloth and lays it on one of them."""
        self.send("ball", ball)
        self.send("crate", crate)
        self.ball, self.crate, self.angle = ball, crate, 0.0
        self.cloth.step(1)
        self.cloth.reset()
        return self.step(SETTLE)

    def step(self, frames=1):
        """Steps and checks that no triangle is inside the colliders at their frames."""
        state = self.cloth.step(frames)
        corners = positions(state).astype(float)[self.triangles]
        self.assertTrue(np.isfinite(corners).all())
        near = distance_from(self.ball, corners).min()
        self.assertGreaterEqual(near, RADIUS - 1e-6, "in the ball at frame %d" % state.step)
        way = ways_out_of_box((corners - self.crate) @ turned(self.angle)).max()
        self.assertLessEqual(way, 1e-6, "in the box at frame %d" % state.step)
        return state

    def drive(self, name, target, speed):
        start = getattr(self, name).copy()
        frames = int(np.ceil(np.linalg.norm(target - start) / speed * FRAMES_PER_SECOND))
        for frame in range(1, frames + 1):
            place = start + (target - start) * (frame / frames)
            setattr(self, name, place)
            self.send(name, place, self.angle if name == "crate" else 0.0)
            state = self.step()
        return state

    def test_sphere_and_box_at_all_speeds(self):
        for name, others in (("ball", (BALL, AWAY)), ("crate", (AWAY, CRATE))):
            for speed, way in ((0.1, 0.05), (1.0, 0.4), (10.0, 0.5)):
                start = self.lay(*others)
                self.assertGreater(positions(start)[:, 2].max(), 0.79, "it lies on the " + name)
                home = getattr(self, name).copy()
                self.drive(name, home + [0, 0, way], speed)
                self.drive(name, home + [way, 0, way], speed)
                self.drive(name, home, speed)
                self.step(30)

    def test_frames_lost_for_a_second(self):
        self.lay(BALL, AWAY)
        before = positions(self.step(60))
        end = rospy.Time.now() + rospy.Duration(1.2)
        while rospy.Time.now() < end:
            self.step(5)
        middle = len(before) // 2
        self.assertLess(np.linalg.norm(positions(self.step())[middle] - before[middle]), 0.02,
                        "the last pose holds")
        # Back, a hand's breadth farther.
        self.ball = BALL + [0.1, 0, 0.05]
        self.send("ball", self.ball)
        self.step()
        self.step(30)

    def test_a_jump(self):
        """Into the cloth, or through: the cloth is pushed out within 0.2 s, and not flung."""
        for way in ([0, 0, 0.2], [0, 0, 0.5], [0, 0, 1], [0.3, 0, 0], [0.2, 0.1, 0.1],
                    [-0.2, 0, -0.2]):
            self.lay(BALL, AWAY)
            self.ball = BALL + way
            self.send("ball", self.ball)
            speeds = [np.linalg.norm(velocities(self.cloth.step(1)), axis=1).max()
                      for _ in range(18)]
            # One point between springs at their limit snaps out at 6.4 m/s.
            self.assertLess(max(speeds), 8, way)
            for _ in range(10):
                self.step()

    def test_a_frame_that_turns_only(self):
        start = positions(self.lay(AWAY, CRATE))
        top = np.flatnonzero((np.abs(start[:, :2] - CRATE[:2]) < 0.12).all(axis=1))
        self.assertGreater(len(top), 10)
        for frame in range(1, 91):
            self.angle = np.pi / 3 * frame / 90
            self.send("crate", CRATE, self.angle)
            state = self.step()
        # Cloth that lies on the box goes round with it.
        carried = (start[top] - CRATE) @ turned(self.angle).T
        now = positions(state)[top] - CRATE
        self.assertLess(np.linalg.norm(now - carried, axis=1).max(), 0.03)


if __name__ == "__main__":
    rospy.init_node("driven_colliders_test")
    rostest.rosrun("clothsim", "driven_colliders", DrivenColliders)
