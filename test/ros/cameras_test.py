#!/usr/bin/python3
"""Several cameras of one node: each with its topics, its place and its diagnostics, one look."""

import numpy as np
import rospy
import rostest
import tf2_ros
from dynamic_reconfigure.client import Client
from geometry_msgs.msg import Quaternion

from camera_client import Camera, CameraDiagnostics, CameraTestCase
from cloth_client import PATIENCE, make_transform, positions, wait_for

NAMES = ("camera", "camera_top", "camera_wrist")
SIZES = {"camera": (240, 320), "camera_top": (200, 200), "camera_wrist": (120, 160)}


class CamerasTest(CameraTestCase):
    def setUp(self):
        super().setUp()
        self.cameras = {name: Camera(camera=name) for name in NAMES}
        for camera in self.cameras.values():
            camera.wait_for_connections()

    def tearDown(self):
        for camera in self.cameras.values():
            camera.close()
        super().tearDown()

    def frames(self):
        stamp = self.cloth.step(3).header.stamp
        return {name: camera.frame(stamp) for name, camera in self.cameras.items()}

    def test_each_sees_the_same_state_from_its_place(self):
        frames = self.frames()
        for name, frame in frames.items():
            self.assertEqual(frame.mask.shape, SIZES[name])
            self.assertEqual(frame.infos["mask"].width, SIZES[name][1])
        for name in NAMES[:2]:
            frame_id = frames[name].images["mask"].header.frame_id
            self.assertEqual(frame_id, "clothsim_%s_optical" % name)
        # From above, at 3 m: a square of 1 m, whose side is f / (3 - 0.5) pixels at its height.
        top = frames["camera_top"]
        area = np.count_nonzero(top.mask == 1)
        height = 3 - np.median(top.depth[top.mask == 1])
        focal = top.infos["mask"].K[0]
        self.assertAlmostEqual(area, (focal / (3 - height)) ** 2, delta=0.03 * area)

    def test_a_frame_carries_one_of_them(self):
        broadcaster = tf2_ros.StaticTransformBroadcaster()
        # It looks down on the cloth at 45 degrees: its optical axis is (1, 0, -1), its x is -y.
        eye, axis = np.array([-1.5, 0.5, 2]), np.sqrt(0.5) * np.array([1, 0, -1])
        transform = make_transform("wrist_optical", eye)
        half = np.pi / 8
        more, less = (np.cos(half) + np.sin(half)) / 2, (np.cos(half) - np.sin(half)) / 2
        transform.transform.rotation = Quaternion(-more, more, -less, less)
        broadcaster.sendTransform(transform)

        def depths_of_carried():
            state = self.cloth.step(3)
            frame = self.cameras["camera_wrist"].frame(state.header.stamp)
            if frame.images["depth"].header.frame_id != "wrist_optical":
                return None
            return (positions(state) - eye) @ axis, frame.depth[frame.mask == 1]
        points, pixels = wait_for(depths_of_carried, "pictures from the wrist")
        self.assertAlmostEqual(pixels.min(), points.min(), delta=0.03)
        self.assertAlmostEqual(self.frames()["camera_top"].depth.min(), 2, delta=0.6)

    def test_looks_are_of_all_and_viewpoints_of_each(self):
        before = self.frames()
        self.shading.update_configuration({"shader": "diffuse", "color_r": 0.0, "color_g": 1.0})
        viewpoint = Client("/clothsim/camera_top/viewpoint", timeout=PATIENCE)
        viewpoint.update_configuration({"eye_z": 6.0})

        def frames_with_green():
            frames = self.frames()
            seen = [frames[name].color[frames[name].mask == 1] for name in NAMES[:2]]
            return frames if all(np.all(c[:, 0] == 0) and c[:, 1].max() > 30 for c in seen) else None
        after = wait_for(frames_with_green, "a green cloth in both")
        area = {name: [np.count_nonzero(f[name].mask == 1) for f in (before, after)]
                for name in NAMES[:2]}
        self.assertLess(area["camera_top"][1], 0.3 * area["camera_top"][0])
        self.assertGreater(area["camera"][1], 0.8 * area["camera"][0])
        viewpoint.update_configuration({"eye_z": 3.0})
        viewpoint.close()

    def test_diagnostics_of_each(self):
        self.frames()
        for name in NAMES:
            status = CameraDiagnostics(camera=name).next(
                lambda s: int(s.values["pictures drawn"]) > 0, "of " + name)
            for kind in ("color", "depth", "mask"):
                self.assertIn(kind, status.values["images subscribed"])


if __name__ == "__main__":
    rospy.init_node("cameras_test")
    rostest.rosrun("clothsim", "cameras", CamerasTest)
