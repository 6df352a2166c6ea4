#!/usr/bin/python3
"""Where EGL is broken, the node reports its attempts, and works except for images."""

import unittest

import rospy
import rostest
from diagnostic_msgs.msg import DiagnosticStatus
from rosgraph_msgs.msg import Log
from sensor_msgs.msg import CameraInfo, Image

from camera_client import CameraDiagnostics
from cloth_client import Cloth, Recorder


class CameraWithoutEgl(unittest.TestCase):
    def test_runs_on_and_warns(self):
        cloth = Cloth()
        diagnostics = CameraDiagnostics()
        log = Recorder("/rosout", Log)
        self.assertEqual(diagnostics.next().level, DiagnosticStatus.OK)  # nobody wants an image
        cloth.step(2)

        images = Recorder("/clothsim/camera/color/image_raw", Image)
        status = diagnostics.next(lambda s: s.level == DiagnosticStatus.WARN)
        for text in (status.message, log.wait("a warning", lambda m: m.level == Log.WARN).msg):
            self.assertIn("no OpenGL context without a display; tried:", text)
            self.assertIn("EGL offers neither devices nor", text)
        self.assertEqual(status.values["pictures drawn"], "0")

        self.assertEqual(cloth.step(3).step, 5)  # returns, though there is no picture to wait for
        self.assertEqual(cloth.step(1).step, 6)
        cloth.pause(False)
        cloth.states.wait("a running simulation", lambda s: s.step > 30)
        self.assertEqual(images.all(), [])

    def test_camera_info_needs_no_opengl(self):
        infos = Recorder("/clothsim/camera/depth/camera_info", CameraInfo)
        self.assertEqual(infos.wait("a camera_info").width, 640)
        infos.close()


if __name__ == "__main__":
    rospy.init_node("camera_without_egl_test")
    rostest.rosrun("clothsim", "camera_without_egl", CameraWithoutEgl)
