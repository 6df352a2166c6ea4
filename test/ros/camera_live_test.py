#!/usr/bin/python3
"""Live changes while the node draws images: looks, light and camera."""

import os
import tempfile
import threading

import numpy as np
import PIL.Image
import rospy
import rostest
from dynamic_reconfigure.client import Client

from camera_client import CameraTestCase
from cloth_client import PATIENCE, wait_for


class CameraLiveTest(CameraTestCase):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.folder = rospy.get_param("/clothsim/image_folders")[0]
        os.makedirs(cls.folder, exist_ok=True)

    def test_shader_changes_live(self):
        self.cloth.step(1)
        self.subscribe()
        # Seen from above, the flat cloth's normal is +z: (1 + n) / 2 is (0.5, 0.5, 1).
        self.shading.update_configuration({"shader": "normal"})

        def mostly_blue(image):
            return np.mean(np.all(np.abs(image.astype(int) - [128, 128, 255]) <= 2, axis=2)) > 0.1
        self.camera.color("a cloth in the colour of its normal", mostly_blue)

        self.shading.update_configuration({"shader": "diffuse", "color_r": 0.0, "color_g": 1.0})
        self.camera.color("a green cloth", lambda image: np.mean(
            (image[..., 1] > 30) & (image[..., 0] == 0) & (image[..., 2] == 0)) > 0.1)
        self.assertFalse(self.has_blue_normal())

    def test_a_spring_family_changes_while_paused(self):
        self.subscribe()
        self.shading.update_configuration({"shader": "wireframe"})
        whole = self.step(1)[1].color
        client = Client("/clothsim", timeout=PATIENCE)
        for shear in (False, True):
            client.update_configuration({"shear": shear})
            self.camera.color("the cloth %s shear springs" % ("with" if shear else "without"),
                              lambda image, shear=shear: np.array_equal(image, whole) == shear)
        client.close()

    def has_blue_normal(self):
        self.camera.clear()
        _, frame = self.step(1)
        return bool(np.any(np.all(np.abs(frame.color.astype(int) - [128, 128, 255]) <= 2, axis=2)))

    def test_each_shader_of_the_dialog(self):
        """And no other shader."""
        self.subscribe()
        pictures = set()
        names = self.shader_names()
        self.assertEqual(len(names), 11)
        for name in names:
            self.assertEqual(self.shading.update_configuration({"shader": name})["shader"], name)
            self.cloth.reset()
            pictures.add(self.step(1)[1].color.tobytes())
        self.assertEqual(len(pictures), len(names))
        self.log.clear()
        self.shading.update_configuration({"shader": "shiny"})
        refusal = self.log.wait("a refusal", lambda log: "shader: got shiny" in log.msg).msg
        self.assertEqual(refusal.split("one of ")[1].split(", "), names)

    def shader_names(self):
        description = wait_for(self.shading.get_parameter_descriptions, "the parameters")
        edit = next(p for p in description if p["name"] == "shader")["edit_method"]
        return [option["value"] for option in eval(edit)["enum"]]

    def test_light_and_background_change_live(self):
        self.subscribe()
        self.light.update_configuration({"background_r": 0.0, "background_g": 0.0,
                                         "background_b": 1.0})
        self.camera.color("a blue background", lambda image: tuple(image[0, 0]) == (0, 0, 255))
        self.light.update_configuration({"intensity": 1.0})
        dark = self.camera.color("a dim cloth", lambda image: 20 < image[..., 0].max() < 200)
        self.light.update_configuration({"intensity": 40.0})
        self.camera.color("a brighter cloth",
                          lambda image: image[..., 0].max() > dark[..., 0].max() + 20)

    def test_camera_changes_live(self):
        self.subscribe()
        self.viewpoint.update_configuration({"width": 80, "height": 60, "cx": 39.5, "cy": 29.5,
                                             "eye_z": 4.0, "target_z": 0.0})
        _, frame = self.step(1)
        self.assertEqual(frame.color.shape, (60, 80, 3))
        self.assertEqual(frame.depth.shape, (60, 80))
        self.assertEqual(frame.infos["color"].K[2], 39.5)
        ray = (frame.infos["color"].P[2], frame.infos["color"].P[6])
        self.assertEqual(ray, (39.5, 29.5))

    def test_refused_values_change_nothing(self):
        self.subscribe()
        broken = tempfile.NamedTemporaryFile(suffix=".png", dir=self.folder)
        broken.write(b"no image")
        broken.flush()
        expected = self.step(1)[1].color.tobytes()
        cases = [(self.shading, "shading/cloth", "texture", "/no/such/file.png"),
                 (self.shading, "shading/cloth", "texture", broken.name),
                 (self.shading, "shading/cloth", "height_map", broken.name),
                 (self.shading, "shading/cloth", "environment", "/no/such/folder"),
                 (self.shading, "shading/cloth", "texture", "x" * 300),  # no file has such a name
                 (self.shading, "shading/cloth", "environment", "x" * 300),
                 (self.shading, "shading/cloth", "color_g", 2.0),
                 (self.shading, "shading/cloth", "alpha", float("nan")),
                 (self.shading, "shading/cloth", "levels", 0),
                 (self.sphere_shading, "shading/sphere", "segments", 2),
                 (self.light, "light", "intensity", -1.0),
                 (self.light, "light", "position_z", float("inf")),
                 (self.light, "light", "background_b", -0.5),
                 (self.light, "light", "sky", "/no/such/folder"),
                 (self.viewpoint, "viewpoint", "fx", 0.0),
                 (self.viewpoint, "viewpoint", "width", 100000),
                 (self.viewpoint, "viewpoint", "eye_x", float("nan")),
                 (self.viewpoint, "viewpoint", "frame", "/camera"),
                 (self.viewpoint, "viewpoint", "rate", 0.0)]
        for client, ns, key, bad in cases:
            self.log.clear()
            before = client.get_configuration(timeout=PATIENCE)[key]
            answer = client.update_configuration({key: bad})
            self.assertEqual(answer[key], before, key)
            name = "/clothsim/%s/%s: got " % (ns, key)
            message = self.log.wait("a message with " + name, lambda log: log.msg.startswith(name))
            self.assertIn("expected", message.msg)
        self.cloth.reset()
        self.assertEqual(self.step(1)[1].color.tobytes(), expected)

    def test_a_texture_of_ones_own(self):
        path = self.image("green.png", (0, 255, 0))
        self.subscribe()
        self.shading.update_configuration({"shader": "texture", "texture": path})
        self.camera.color("a green cloth", lambda image: np.mean(
            np.all(image == [0, 255, 0], axis=2)) > 0.1)

    def test_images_come_from_the_folders_of_the_scene_alone(self):
        inside = self.image("in.png", (0, 255, 0))
        with tempfile.TemporaryDirectory() as elsewhere:
            outside = os.path.join(elsewhere, "out.png")
            os.rename(self.image("out.png", (0, 0, 255)), outside)
            link = os.path.join(self.folder, "link.png")
            os.symlink(outside, link)
            self.addCleanup(os.remove, link)
            around = os.path.join(self.folder, os.path.relpath(outside, self.folder))
            for path in [outside, link, around, "/proc/kmsg"]:
                self.log.clear()
                answer = self.shading.update_configuration({"texture": path})
                self.assertNotEqual(answer["texture"], path)
                self.log.wait("a refusal", lambda log: "image_folders" in log.msg)
        answer = self.shading.update_configuration({"texture": inside})
        self.assertEqual(answer["texture"], inside)

    def test_frames_go_on_while_a_large_image_is_read(self):
        path = self.image("large.png", (0, 0, 255), size=(8192, 8192))
        reading = threading.Thread(
            target=self.shading.update_configuration, args=({"texture": path},))
        reading.start()
        frames = 0
        while reading.is_alive():
            self.cloth.step(1)
            frames += 1
        # If the node's own thread read the file, calls would wait: one before, and one after.
        self.assertGreater(frames, 5)

    def image(self, name, color, size=(1, 1)):
        path = os.path.join(self.folder, name)
        PIL.Image.new("RGB", size, color).save(path)
        self.addCleanup(lambda: os.path.exists(path) and os.remove(path))
        return path


if __name__ == "__main__":
    rospy.init_node("camera_live_test")
    rostest.rosrun("clothsim", "camera_live", CameraLiveTest)
