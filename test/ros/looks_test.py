#!/usr/bin/python3
"""The first picture in RViz: the cloth of each scene whole and large, with nothing before it, and in the
panel that scene with its own values."""

import time
import unittest

import numpy as np
import rospy
import rostest
import yaml
from dynamic_reconfigure.client import Client

from clothsim.srv import LoadScene
from cloth_client import PATIENCE, Cloth, call, wait_for
from rviz_desktop import PACKAGE, Desktop, View, cloth_in, ready, shows_cloth

# Rows of the panel, from the upper edge of its title [pixel].
SCENE_BOX = (slice(95, 118), slice(50, 190))
FIRST_SLIDER = (160, 138)
STEP = (122, 75)
TEXT = slice(5, 340)  # its columns


class Looks(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.cloth = Cloth()
        cls.cloth.states.wait("the first state")
        cls.desktop = Desktop(looks_at_scenes=True)
        cls.view = View(cls.desktop.settled(shows_cloth))

    @classmethod
    def tearDownClass(cls):
        cls.desktop.close()

    def load(self, name):
        """The picture, once the scene of that name is shown and at rest."""
        with open(PACKAGE / "config/scenes" / (name + ".yaml")) as file:
            rospy.set_param("/clothsim/scene", {})
            rospy.delete_param("/clothsim/scene")
            rospy.set_param("/clothsim/scene", yaml.safe_load(file))
        answer = call("/clothsim/load_scene", LoadScene)
        self.assertTrue(answer.success, answer)
        time.sleep(1)
        self.desktop.wait_until_still(self.view)
        return ready(self.desktop, shows_cloth)

    def seen(self, picture):
        """Which pixels of the view show the cloth."""
        left, top = self.view.corner
        right, bottom = self.view.corner + self.view.size
        return cloth_in(picture[top:bottom, left:right])

    def test_cloth_is_whole_and_large(self):
        for name in ("flag", "curtain", "towel", "tablecloth", "sphere", "pinned2"):
            with self.subTest(name):
                seen = self.seen(self.load(name))
                self.cloth.step(30)
                self.desktop.wait_until_still(self.view)
                seen |= self.seen(ready(self.desktop, shows_cloth))
                rows, columns = np.flatnonzero(seen.any(axis=1)), np.flatnonzero(seen.any(axis=0))
                for places, size in ((rows, seen.shape[0]), (columns, seen.shape[1])):
                    self.assertGreater(places.min(), 0)
                    self.assertLess(places.max(), size - 1)
                self.assertGreater(max(np.ptp(rows) / seen.shape[0], np.ptp(columns) / seen.shape[1]), 0.4)

    def test_nothing_hides_the_cloth(self):
        """The tablecloth before it falls: from one side to the other of each row nothing but cloth."""
        seen = self.seen(self.load("tablecloth"))
        rows = [row for row in seen if row.sum() > 30]
        holes = sum(np.ptp(np.flatnonzero(row)) + 1 - row.sum() for row in rows)
        self.assertGreater(len(rows), 50)
        self.assertLess(holes, 0.02 * seen.sum())

    def test_panel_shows_the_scene(self):
        boxes = []
        for name in ("flag", "towel", "sphere", "flag"):
            picture = self.load(name)
            top = self.desktop.panel_top(picture)
            rows, columns = SCENE_BOX
            boxes.append(picture[top + rows.start:top + rows.stop, columns].tobytes())
        self.assertEqual(len(set(boxes)), 3)
        self.assertEqual(boxes[0], boxes[3])

    def test_a_fabric_has_values_of_its_own(self):
        picture = self.load("towel")
        client = Client("/clothsim", timeout=PATIENCE)
        before = client.get_configuration()["stretch_stiffness_warp"]
        place = np.array([0, self.desktop.panel_top(picture)]) + FIRST_SLIDER
        self.desktop.click(place)
        wait_for(lambda: client.get_configuration()["stretch_stiffness_warp"] != before, "another stiffness")
        self.load("sphere")
        self.desktop.click(place)
        wait_for(lambda: client.get_configuration()["ks"] != 5000, "another ks")
        client.close()

    def test_an_error_goes_with_the_next_scene(self):
        def last_line():
            """The lowest row of the panel with text; a report is its last line."""
            picture = self.desktop.picture()
            bottom = self.view.corner[1] + self.view.size[1]
            dark = picture[self.desktop.panel_top(picture):bottom, TEXT].max(axis=2) < 100
            return np.flatnonzero(dark.any(axis=1)).max()
        picture = self.load("pinned2")
        time.sleep(2)  # the diagnostics report that it is paused
        without = last_line()
        self.cloth.pause(False)
        time.sleep(0.5)
        self.desktop.click(np.array([0, self.desktop.panel_top(picture)]) + STEP)  # refused: it runs
        time.sleep(0.5)
        self.cloth.pause()
        time.sleep(2)
        wait_for(lambda: last_line() > without + 5, "the refusal")
        self.load("pinned2")
        wait_for(lambda: last_line() < without + 5, "the refusal to go")


if __name__ == "__main__":
    rospy.init_node("looks_test")
    rostest.rosrun("clothsim", "looks", Looks)
