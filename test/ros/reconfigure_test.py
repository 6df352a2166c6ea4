#!/usr/bin/python3
"""dynamic_reconfigure: every value has its effect, and invalid values have none."""

import ast
import unittest

import numpy as np
import rospy
import rostest
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from dynamic_reconfigure.client import Client
from rosgraph_msgs.msg import Log
from std_srvs.srv import Trigger

from clothsim.msg import ClothTopology
from cloth_client import PATIENCE, Cloth, Recorder, call, content, positions, velocities, wait_for

DEFAULTS = {
    "ks": 5000.0, "density": 150.0, "damping": 5.4, "structural": True, "shear": True,
    "bending": True, "strain_limit_enabled": True, "strain_limit": 0.1, "gravity_x": 0.0,
    "gravity_y": 0.0, "gravity_z": -9.8, "frames_per_second": 90.0, "substeps": 0,
    "method": "auto"}


class Reconfigure(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.cloth = Cloth()
        cls.topology = Recorder("/clothsim/topology", ClothTopology)
        cls.diagnostics = Recorder("/diagnostics", DiagnosticArray)
        cls.log = Recorder("/rosout", Log)
        cls.client = Client("/clothsim", timeout=PATIENCE)
        cls.initial = cls.client.get_configuration(timeout=PATIENCE)

    def setUp(self):
        self.cloth.pause()
        self.assertEqual(self.values(self.client.update_configuration(DEFAULTS)), DEFAULTS)
        self.cloth.reset()

    @staticmethod
    def values(config):
        return {name: config[name] for name in DEFAULTS}

    def run_with(self, frames, **changes):
        """The state after some frames from the start with changed values."""
        answer = self.values(self.client.update_configuration(changes))
        self.assertEqual(answer, {**self.values(answer), **changes})
        self.cloth.reset()
        return self.cloth.step(frames)

    def lowest(self, frames, **changes):
        return positions(self.run_with(frames, **changes))[:, 2].min()

    def test_starts_from_the_scene(self):
        self.assertEqual(self.values(self.initial), DEFAULTS)

    def resting(self, **changes):
        """Lowest point [m] of the cloth at rest."""
        return self.lowest(270, damping=20.0, **changes)

    def test_values_of_the_scene_come_back(self):
        """~reset keeps live values, and its answer says so; ~reset_values restores them, to the same bits."""
        call("/clothsim/reset_values", Trigger)  # changes by other tests
        expected = content(self.cloth.step(10))
        self.assertEqual(call("/clothsim/reset", Trigger).message, "at the scene's start")
        changes = {"ks": 700.0, "shear": False, "method": "xpbd", "strain_limit": 0.02}
        self.client.update_configuration(changes)
        light = Client("/clothsim/light", timeout=PATIENCE)
        intensity = light.get_configuration(timeout=PATIENCE)["intensity"]
        light.update_configuration({"intensity": 3.0})
        answer = call("/clothsim/reset", Trigger)
        self.assertTrue(answer.success)
        for value in ("ks 700", "shear false", 'method "xpbd"', "strain_limit 0.02", "~reset_values"):
            self.assertIn(value, answer.message)
        self.assertNotIn("density", answer.message)

        answer = call("/clothsim/reset_values", Trigger)
        self.assertTrue(answer.success, answer.message)
        self.assertIn("light/intensity 3", answer.message)
        wait_for(lambda: self.values(self.client.get_configuration()) == DEFAULTS, "the scene's values")
        wait_for(lambda: light.get_configuration()["intensity"] == intensity, "the scene's light")
        light.close()
        self.assertEqual(rospy.get_param("/clothsim/ks"), 5000.0)
        self.assertEqual(call("/clothsim/reset", Trigger).message, "at the scene's start")
        self.assertEqual(content(self.cloth.step(10)), expected)
        self.assertEqual(call("/clothsim/reset_values", Trigger).message, "as the scene has them")

    def test_lower_ks_hangs_lower(self):
        soft = self.resting(strain_limit_enabled=False, ks=1000.0)
        stiff = self.resting(strain_limit_enabled=False, ks=20000.0)
        self.assertLess(soft, stiff - 0.2)

    def test_higher_density_hangs_lower(self):
        heavy = self.resting(strain_limit_enabled=False, density=600.0)
        light = self.resting(strain_limit_enabled=False, density=60.0)
        self.assertLess(heavy, light - 0.2)

    def test_damping_slows_the_fall(self):
        free = self.lowest(30, damping=0.0)
        slow = self.lowest(30, damping=50.0)
        self.assertLess(free, slow - 0.1)

    def test_strain_limit_holds_or_not(self):
        limited = self.resting(ks=500.0, strain_limit=0.02)
        off = self.resting(ks=500.0, strain_limit_enabled=False)
        self.assertLess(off, limited - 0.2)

    def test_gravity(self):
        still = self.run_with(30, gravity_z=0.0)
        self.assertLess(np.abs(velocities(still)).max(), 1e-9)  # rounding of rest lengths
        sideways = positions(self.run_with(30, gravity_z=0.0, gravity_y=5.0))
        self.assertGreater(sideways[:, 1].max(), positions(still)[:, 1].max() + 0.01)
        up = positions(self.run_with(30, gravity_z=9.8, gravity_y=0.0))
        self.assertGreater(up[:, 2].max(), 1.1)

    def test_frames_per_second(self):
        self.assertAlmostEqual(self.run_with(30, frames_per_second=30.0).time, 1, delta=1e-9)

    def test_substeps(self):
        self.run_with(1, substeps=17)
        self.diagnostics.clear()

        def says_17(array):
            return any(v.key == "substeps" and v.value == "17"
                       for status in array.status for v in status.values)
        says = self.diagnostics.wait("17 substeps in the diagnostics", says_17)
        keys = [v.key for status in says.status for v in status.values]
        self.assertNotIn("intersecting pairs", keys)  # without self collision there is no count

    def test_method(self):
        # The offered names are those in the refusal of another name.
        self.log.clear()
        self.client.update_configuration({"method": "magic"})
        refusal = self.log.wait("a refusal", lambda log: "/method: got" in log.msg).msg
        known = refusal.split("expected one of ")[1].split(", ")
        method = next(p for p in self.client.get_parameter_descriptions(PATIENCE)
                      if p["name"] == "method")
        offered = [choice["value"] for choice in ast.literal_eval(method["edit_method"])["enum"]]
        self.assertEqual(offered, known)

        # Each name is another method.
        states = [positions(self.run_with(3, method=name)) for name in known[1:]]
        self.assertTrue(np.isfinite(states).all())
        self.assertEqual(len({state.tobytes() for state in states}), len(known) - 1)

        # A change is applied between two frames, while the cloth moves.
        self.run_with(5, method="verlet")
        self.client.update_configuration({"method": "bdf2"})
        self.assertEqual(self.cloth.step(1).step, 6)
        self.diagnostics.clear()
        self.diagnostics.wait("bdf2 in the diagnostics", lambda array: any(
            v.key == "method" and v.value == "bdf2" for s in array.status for v in s.values))

    def test_self_collision(self):
        """Each offered kind is accepted, and its crossings are counted in the diagnostics; another is refused."""
        kind = next(p for p in self.client.get_parameter_descriptions(PATIENCE)
                    if p["name"] == "self_collision")
        offered = [choice["value"] for choice in ast.literal_eval(kind["edit_method"])["enum"]]
        self.log.clear()
        self.client.update_configuration({"self_collision": "magic"})
        refusal = self.log.wait("a refusal", lambda log: "/self_collision: got" in log.msg).msg
        self.assertEqual(offered, refusal.split("expected one of ")[1].split(", "))
        for name in ("true", "True", "false", "False"):  # as in a scene, and as dynparam sends it
            self.assertEqual(self.client.update_configuration({"self_collision": name})["self_collision"], name)
            self.assertEqual(call("/clothsim/reset_values", Trigger).success, True)
        for name in offered:
            answer = self.client.update_configuration({"self_collision": name, "thickness": 0.004})
            self.assertEqual((answer["self_collision"], answer["thickness"]), (name, 0.004))
            self.cloth.step(1)
            self.diagnostics.clear()
            self.diagnostics.wait("the diagnostics with " + name, lambda array, n=name: any(
                (n != "off") == any(v.key == "intersecting pairs" for v in s.values)
                for s in array.status if s.name == "clothsim: simulation"))
        self.client.update_configuration({"self_collision": "off"})

    def test_spring_families(self):
        before = self.topology.wait("a topology")
        self.client.update_configuration({"shear": False})
        after = self.topology.wait("a topology without shear", lambda t: not t.shear)
        self.assertGreater(after.seq, before.seq)
        self.assertEqual(after.structural, before.structural)
        self.assertEqual(self.cloth.step(1).topology_seq, after.seq)

        self.client.update_configuration({"shear": True})
        again = self.topology.wait("a topology with shear", lambda t: t.seq > after.seq)
        self.assertEqual(again.shear, before.shear)

    def test_refused_values_change_nothing(self):
        nan = float("nan")
        for bad in ({"ks": -5.0}, {"ks": nan}, {"density": 0.0}, {"damping": -1.0},
                    {"strain_limit": nan}, {"gravity_z": float("inf")},
                    {"frames_per_second": 0.0}, {"substeps": -1}, {"method": "magic"},
                    {"thickness": 0.0}, {"friction": nan}, {"self_collision": "maybe"},
                    {"ks": 100.0, "damping": nan}):
            self.cloth.reset()
            expected = content(self.cloth.step(3))
            self.log.clear()
            answer = self.client.update_configuration(bad)
            self.assertEqual(self.values(answer), DEFAULTS, bad)
            name = "/clothsim/%s: got " % list(bad)[-1]
            self.log.wait("a message with " + name, lambda log: log.msg.startswith(name))
            self.cloth.reset()
            self.assertEqual(expected, content(self.cloth.step(3)), bad)

    def test_divergence_is_caught(self):
        """A step far too long for the stiffness: the run stops at a good state with a report."""
        self.client.update_configuration(
            {"ks": 1e9, "substeps": 1, "strain_limit_enabled": False, "method": "verlet"})
        self.cloth.states.clear()
        answer = self.cloth.try_step(1000)
        self.assertFalse(answer.success)
        self.assertIn("finite", answer.message)
        self.diagnostics.wait("an error in the diagnostics", lambda array: any(
            s.level == DiagnosticStatus.ERROR and s.message.endswith(answer.message)
            for s in array.status))
        for state in self.cloth.states.all():
            self.assertTrue(np.isfinite(positions(state)).all(), state.step)
            self.assertTrue(np.isfinite(velocities(state)).all(), state.step)

        # The run stops again, until a reset with better values.
        self.log.clear()
        self.cloth.pause(False)
        self.log.wait("the pause", lambda log: "paused at the last good frame" in log.msg)
        self.assertFalse(self.cloth.try_step(1).success)
        self.client.update_configuration(DEFAULTS)
        self.cloth.reset()
        self.cloth.step(10)
        self.diagnostics.clear()
        self.diagnostics.wait("diagnostics without an error", lambda array: any(
            s.name == "clothsim: simulation" and s.level == DiagnosticStatus.OK
            for s in array.status))

    def test_beyond_the_sliders(self):
        """The limits of the sliders are not limits of the model."""
        answer = self.client.update_configuration({"ks": 200000.0})
        self.assertEqual(answer["ks"], 200000.0)

    def test_same_values_same_bits(self):
        expected = content(self.run_with(10))
        self.run_with(10, ks=700.0, substeps=50)
        self.assertEqual(expected, content(self.run_with(10, **DEFAULTS)))


if __name__ == "__main__":
    rospy.init_node("reconfigure_test")
    rostest.rosrun("clothsim", "reconfigure", Reconfigure)
