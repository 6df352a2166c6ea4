#!/usr/bin/python3
"""The plugins of RViz: objects are drawn at their places, the mouse grabs the cloth, the panel runs the node,
and errors are reported and do no harm."""

import math
import time
import unittest

import numpy as np
import rospy
import rostest
from diagnostic_msgs.msg import DiagnosticArray
from dynamic_reconfigure.client import Client

from clothsim.msg import ClothState, ClothTopology
from clothsim.srv import LoadScene
from cloth_client import PATIENCE, Cloth, Recorder, call, is_connected, positions, wait_for
from rviz_desktop import Desktop, View, cloth_in, pixels_of, ready, shows_cloth

GREEN = (51, 191, 89)    # of pins
YELLOW = (255, 217, 26)  # of held points
COLUMNS = 50

# From the upper edge of the panel's title [pixel].
PAUSE, STEP, RESET = (49, 75), (122, 75), (315, 75)
SCENES, LOAD = (122, 106), (230, 106)
KS = (188, 138)  # the middle of the slider
VALUES = (180, 292)  # the button that takes live values back, of a cloth of springs


def distance(a, b):
    return np.linalg.norm(np.asarray(a) - np.asarray(b))


class Rviz(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.cloth = Cloth()
        cls.topologies = Recorder("/clothsim/topology", ClothTopology)
        cls.cloth.states.wait("the first state")
        cls.desktop = Desktop()
        cls.desktop.settled(shows_cloth)

    @classmethod
    def tearDownClass(cls):
        cls.desktop.close()

    def setUp(self):
        self.cloth.pause()
        self.cloth.reset()
        self.view = View(self.desktop.settled(shows_cloth))  # a fabric's panel is higher

    def panel(self, place):
        """A place on the screen, from a place in the panel."""
        return place[0], self.desktop.panel_top(self.desktop.picture()) + place[1]

    def newest(self):
        return self.cloth.states.all()[-1]

    def test_pins_are_where_they_are(self):
        picture = ready(self.desktop, lambda p: len(pixels_of(p, GREEN, 10)) > 80)
        where = positions(self.newest())
        green = pixels_of(picture, GREEN, 10)
        for point in (0, COLUMNS - 1):
            expected, _ = self.view.pixel(where[point])
            near = green[np.linalg.norm(green - expected, axis=1) < 20]
            self.assertGreater(len(near), 30)
            self.assertLess(distance(near.mean(axis=0) + 0.5, expected), 1.5)

    def test_the_cloth_follows_its_states(self):
        """The cloth swings down: at the former place of its edge the background is seen."""
        def height(picture):
            return np.flatnonzero(cloth_in(picture).any(axis=1)).max()
        before = height(ready(self.desktop, shows_cloth))
        self.cloth.step(40)
        ready(self.desktop, lambda p: height(p) > before + 100)

    def take(self):
        """Grabs the middle of the cloth, which has fallen a little: the state, and the mouse's position."""
        middle = positions(self.cloth.step(60))[COLUMNS * COLUMNS // 2 + COLUMNS // 2]
        pixel = np.round(self.view.pixel(middle)[0]).astype(int)
        self.desktop.wait_until_still(self.view)
        self.desktop.mouse("mousemove", self.view.corner[0] + 30, self.view.corner[1] + 30,
                           "click", 1, "key", "g")
        self.desktop.press(pixel)
        states = []

        def is_held():
            states.append(self.cloth.step(1))
            return states[-1].held
        wait_for(is_held, "the cloth to be held")
        return states[-1], pixel

    def test_grab(self):
        try:
            state, pixel = self.take()
            held = list(state.held)
            before = positions(state)[held]
            self.assertGreater(len(held), 3)
            _, ahead = self.view.pixel(before.mean(axis=0))
            self.assertLess(distance(self.view.pixel(before.mean(axis=0))[0], pixel), 15)

            target = pixel + [30, -40]  # farther the cloth does not reach
            self.desktop.drag(target)
            # By as many pixels as the mouse has moved, in the plane of the picture.
            start = self.view.pixel(before.mean(axis=0))[0]
            states = []

            def has_followed():
                states.append(self.cloth.step(10))
                after = positions(states[-1])[held]
                # The points keep their places relative to each other, once the hand holds them again.
                apart = np.abs((after - after[0]) - (before - before[0])).max()
                place = self.view.pixel(after.mean(axis=0))[0]
                return distance(place - start, target - pixel) < 3 and apart < 1e-4
            wait_for(has_followed, "the points to follow the mouse")
            after = positions(states[-1])[held]
            self.assertAlmostEqual(self.view.pixel(after.mean(axis=0))[1], ahead, delta=0.002)
            # The points are shown in yellow.
            ready(self.desktop, lambda p: any(
                distance(place, target) < 20 for place in pixels_of(p, YELLOW, 10)))
        finally:
            self.desktop.release()
        wait_for(lambda: not self.cloth.step(1).held, "the cloth to be let go")

    def test_grab_where_nothing_is(self):
        self.desktop.mouse("mousemove", self.view.corner[0] + 30, self.view.corner[1] + 30,
                           "click", 1, "key", "g")
        self.desktop.press(self.view.corner + [40, 40])
        self.desktop.release()
        self.assertFalse(self.cloth.step(5).held)

    def test_panel_runs_the_node(self):
        wait_for(lambda: self.newest().step == 0, "the start")
        self.desktop.click(self.panel(STEP))
        wait_for(lambda: self.newest().step == 1, "a frame")
        # The panel reads from the diagnostics that the node is paused.
        Recorder("/diagnostics", DiagnosticArray).wait("word that it is paused", lambda array: any(
            value.key == "paused" and value.value == "True"
            for status in array.status for value in status.values))
        time.sleep(0.5)
        self.desktop.click(self.panel(PAUSE))
        wait_for(lambda: self.newest().step > 20, "the simulation to run")
        self.desktop.click(self.panel(PAUSE))
        def stands():
            step = self.newest().step
            time.sleep(0.3)
            return self.newest().step == step
        wait_for(stands, "the simulation to pause")
        self.desktop.click(self.panel(RESET))
        wait_for(lambda: self.newest().step == 0, "the start")

    def test_panel_sets_live_values(self):
        client = Client("/clothsim", timeout=PATIENCE)
        self.assertEqual(client.get_configuration()["ks"], 5000)
        self.desktop.press(self.panel(KS))
        self.desktop.drag(np.array(self.panel(KS)) + [30, 0])
        self.desktop.release()
        wait_for(lambda: client.get_configuration()["ks"] != 5000, "another ks")
        # In the middle of 1 to 1e5, on a logarithmic scale, or a little more.
        self.assertAlmostEqual(math.log10(client.get_configuration()["ks"]), 2.5, delta=1.5)
        self.desktop.click(self.panel(VALUES))
        wait_for(lambda: client.get_configuration()["ks"] == 5000, "the scene's ks")
        client.close()

    def test_panel_loads_a_scene(self):
        """A scene with a cloth of another size, and back; the first one of the list is that of the arm."""
        scene = rospy.get_param("/clothsim/scene")
        try:
            self.desktop.click(self.panel(SCENES))
            self.desktop.mouse("sleep", 0.5, "key", "Home", "key", "Return", "sleep", 0.5)
            self.desktop.click(self.panel(LOAD))
            self.topologies.wait("the towel", lambda t: (t.columns, t.rows) != (COLUMNS, COLUMNS))
            self.assertIn("arm.urdf", str(rospy.get_param("/clothsim/scene")))
            ready(self.desktop, shows_cloth)
        finally:
            rospy.set_param("/clothsim/scene", scene)
            self.assertTrue(call("/clothsim/load_scene", LoadScene).success)
        ready(self.desktop, lambda p: len(pixels_of(p, GREEN, 10)) > 80)

    def test_bad_messages_do_no_harm(self):
        topology = self.topologies.all()[-1]
        good = self.newest()
        state_publisher = rospy.Publisher("/clothsim/state", ClothState, queue_size=10)
        wait_for(lambda: state_publisher.get_num_connections() > 1, "RViz")

        def publish(**changes):
            message = ClothState(header=good.header, topology_seq=good.topology_seq,
                                 positions=good.positions, velocities=good.velocities)
            for key, value in changes.items():
                setattr(message, key, value)
            state_publisher.publish(message)
            time.sleep(0.1)

        nan = list(good.positions)
        nan[7] = float("nan")
        for changes in ({"positions": nan}, {"positions": []}, {"velocities": good.velocities[:-1]},
                        {"positions": [1e30] * len(nan)}, {"held": [10**6]},
                        {"topology_seq": topology.seq + 1}):
            publish(**changes)
        state_publisher.publish(ClothState())
        time.sleep(0.2)
        ready(self.desktop, shows_cloth)  # the last drawing
        state_publisher.unregister()
        self.cloth.step(40)
        ready(self.desktop, shows_cloth)
        self.assertTrue(is_connected("/clothsim/state", "rviz"))


if __name__ == "__main__":
    rospy.init_node("rviz_test")
    rostest.rosrun("clothsim", "rviz", Rviz)
