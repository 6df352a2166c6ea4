#!/usr/bin/python3
"""Diagnostics: their values, and that each limit causes a warning and an error for its value."""

import copy
import os
import subprocess
import sys
import tempfile
import threading
import time
import unittest

import roslib.packages
import rospy
import rostest
import tf2_ros
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from dynamic_reconfigure.client import Client
from rosgraph_msgs.msg import Log
from sensor_msgs.msg import Image

from clothsim.srv import GetState, SetState
from cloth_client import PATIENCE, Cloth, Recorder, call, is_connected, make_transform, wait_for

OK, WARN, ERROR = DiagnosticStatus.OK, DiagnosticStatus.WARN, DiagnosticStatus.ERROR
OFF = {"speed": {"warning": "off", "error": "off"}}  # the computer may be busy
OFTEN = {"diagnostic_period": 0.2}  # [s] for tests that wait for a report, whatever its period
SMALL = {"cloth": {"columns": 12, "rows": 12}}
HELD = {"cloth": {"columns": 12, "rows": 12,
                  "pinned": [[0, 0], {"point": [11, 0], "frame": "hand"}]}}


class Node:
    """A clothsim node with parameters of its own, and its log and diagnostics."""

    count = 0

    def __init__(self, program, scene, limits, **parameters):
        Node.count += 1
        self.name = "/watched_%d" % Node.count
        rospy.set_param(self.name, {"scene": scene, **parameters})
        rospy.set_param(self.name + "/diagnostics", limits)
        self.diagnostics = Recorder("/diagnostics", DiagnosticArray)
        # Not /rosout: nobody may have connected to that yet when a node writes its first lines.
        self._errors = tempfile.TemporaryFile()
        self.process = subprocess.Popen([program, "__name:=" + self.name[1:]], stderr=self._errors)
        self.cloth = Cloth(self.name)
        self.cloth.states.wait("the first state")

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.process.terminate()
        self.process.wait()
        sys.stderr.write(self.log())
        self._errors.close()

    def log(self):
        """All that the node has written to its error stream."""
        size = os.fstat(self._errors.fileno()).st_size
        return os.pread(self._errors.fileno(), size, 0).decode()

    def statuses(self, part):
        wanted = self.name[1:] + ": " + part
        return [s for a in self.diagnostics.all() for s in a.status if s.name == wanted]

    def wait(self, level, text, part="simulation"):
        """The values of a status of that level whose message has the text."""
        def found():
            return next((s for s in reversed(self.statuses(part))
                         if s.level == level and text in s.message), None)
        try:
            status = wait_for(found, "a status")
        except AssertionError:
            said = [(s.level, s.message) for s in self.statuses(part)]
            raise AssertionError("no status of level %d with %r among %s" % (level, text, said))
        return {v.key: v.value for v in status.values}


class Diagnostics(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.program = roslib.packages.find_node("clothsim", "clothsim_node")[0]

    def node(self, scene, limits, **parameters):
        return Node(self.program, scene, limits, **parameters)

    def test_tells_all(self):
        scene = {"cloth": dict(SMALL["cloth"], self_collision=True, pinned=[[0, 0]])}
        with self.node(scene, OFF) as node:
            node.cloth.states.wait("a second", lambda s: s.step > 100)
            wait_for(lambda: "real-time factor" in node.wait(OK, "running"), "the factor")
            values = node.wait(OK, "running")
        self.assertGreater(float(values["real-time factor"]), 0.2)  # the computer may be busy
        self.assertLess(float(values["real-time factor"]), 1.1)
        self.assertEqual(values["real-time factor asked"], "1")
        self.assertIn(values["method"], ("verlet", "symplectic_euler", "rk4", "xpbd"))
        self.assertNotEqual(values["reason"], "")
        self.assertGreater(int(values["substeps"]), 0)
        self.assertGreater(float(values["worst stretch [%]"]), 0)
        self.assertGreaterEqual(float(values["violation of the strain limit [%]"]), 0)
        self.assertEqual(values["intersecting pairs"], "0")
        for key in ("predicted error", "sweeps", "contacts", "time for simulating [%]",
                    "time for publishing [%]", "time for calls and live values [%]",
                    "time for other work of the computer [%]"):
            self.assertGreaterEqual(float(values[key]), 0, key)

    def test_as_fast_as_possible_tells_its_factor(self):
        with self.node(SMALL, {}, realtime_factor=0) as node:
            node.wait(OK, "running")
            wait_for(lambda: "real-time factor" in node.wait(OK, "running"), "the factor")
            self.assertGreater(float(node.wait(OK, "running")["real-time factor"]), 1)

    def test_period(self):
        with self.node(SMALL, {}, diagnostic_period=0.2, paused=True) as node:
            wait_for(lambda: len(node.statuses("simulation")) > 10, "diagnostics")
            stamps = sorted(a.header.stamp.to_sec() for a in node.diagnostics.all()
                            if a.status[0].name == node.name[1:] + ": simulation")
            # Limits are read at the start: later values, however absurd, have no effect.
            rospy.set_param(node.name + "/diagnostic_period", 1e300)
            node.diagnostics.clear()
            wait_for(lambda: len(node.statuses("simulation")) > 2, "diagnostics")
        gaps = sorted(b - a for a, b in zip(stamps, stamps[1:]))
        self.assertGreater(gaps[len(gaps) // 2], 0.1)
        self.assertLess(gaps[len(gaps) // 2], 0.5)

    def test_speed(self):
        """A factor that no computer reaches."""
        scene = {"cloth": {"pinned": [[0, 0]]}}
        for limits, level in (({}, ERROR), ({"speed": {"error": False}}, WARN),
                              (OFF, OK)):
            with self.node(scene, limits, realtime_factor=1000) as node:
                # The simulation takes all the time, unless the computer has other work.
                text = "of 1000.00: " if level else "running"
                wait_for(lambda: "real-time factor" in node.wait(level, text), "the factor")
                reasons = ("most of its time goes into simulating",
                           "the computer is busy with other work")
                for status in node.statuses("simulation"):
                    if status.level == level != OK:
                        self.assertTrue(status.message.endswith(reasons), status.message)

    def test_a_method_that_cannot_keep_up(self):
        """The node reports it before and after, and does not blame other work, however busy the computer is."""
        busy = [subprocess.Popen(["sh", "-c", "while :; do :; done"]) for _ in range(6)]
        scene = {"cloth": {"pinned": [[0, 0]]}, "simulation": {"method": "bdf2"}}
        try:
            with self.node(scene, {}) as node:
                node.wait(ERROR, "simulating: method bdf2 takes ")
                values = node.statuses("simulation")[-1].values
                self.assertLess(float({v.key: v.value for v in values}["real-time factor"]), 0.5)
                for status in node.statuses("simulation"):
                    self.assertNotIn("other work", status.message)
                self.assertEqual(node.log().count("Method bdf2 is going to be slower"), 1)
        finally:
            for process in busy:
                process.kill()
                process.wait()

    def test_says_when_calls_take_the_time(self):
        """Eight callers that set all live values as fast as they get answers."""
        with self.node(SMALL, {"speed": {"error": False}}) as node:
            stop = threading.Event()

            def storm():
                client, calls = Client(node.name, timeout=PATIENCE), 0
                while not stop.is_set():
                    calls += 1
                    client.update_configuration({"ks": 5000.0 + calls, "density": 150.0 + calls % 7,
                                                 "damping": 5 + 0.1 * (calls % 7),
                                                 "gravity_x": 0.1 * (calls % 7),
                                                 "gravity_y": 0.1 * (calls % 7)})
                client.close()
            callers = [threading.Thread(target=storm) for _ in range(8)]
            for caller in callers:
                caller.start()
            try:
                values = node.wait(WARN, "most of its time goes into calls and live values")
            finally:
                stop.set()
                for caller in callers:
                    caller.join()
            self.assertLess(float(values["real-time factor"]), 0.95)
            self.assertGreater(float(values["time for calls and live values [%]"]), 30)
            # The callers have stopped: the node keeps up again.
            node.diagnostics.clear()
            node.wait(OK, "running")

    def test_a_pin_that_lags(self):
        """A pin is pulled away, farther than the cloth is long."""
        hand = tf2_ros.StaticTransformBroadcaster()
        hand.sendTransform(make_transform("hand", (0, 0, 0)))
        with self.node(HELD, OFF, **OFTEN) as node:
            wait_for(lambda: node.wait(OK, "running")["tf age of hand [s]"] == "0.000", "the frame")
            hand.sendTransform(make_transform("hand", (0.5, 0, 0)))
            values = node.wait(WARN, "mm: it pulls with all its")
            self.assertGreater(int(values["holders that lag"]), 0)

    def test_violation(self):
        """A pin that is stronger than the cloth is pulled away, farther than the cloth is long."""
        strong = {"cloth": dict(HELD["cloth"], pin_strength=1e12)}
        hand = tf2_ros.StaticTransformBroadcaster()
        for limits, level in ((OFF, ERROR), ({**OFF, "violation": {"error": 100}}, WARN)):
            hand.sendTransform(make_transform("hand", (0, 0, 0)))
            with self.node(strong, limits, **OFTEN) as node:
                wait_for(lambda: node.wait(OK, "running")["tf age of hand [s]"] == "0.000",
                         "the frame")
                seen = node.cloth.states.all()[-1].step
                node.cloth.states.wait("frames with it", lambda s: s.step > seen + 2)
                hand.sendTransform(make_transform("hand", (0.5, 0, 0)))
                values = node.wait(level, "over the strain limit")
                self.assertGreater(float(values["violation of the strain limit [%]"]), 10)

    def test_crossings(self):
        """One point is moved over the cloth, another pulled up through the cloth that follows it."""
        scene = {"cloth": dict(SMALL["cloth"], self_collision=True)}
        for limits, level in (({}, WARN), ({"crossings": {"error": 0}}, ERROR),
                              ({"crossings": {"warning": 1000}}, OK)):
            with self.node(scene, limits, paused=True, **OFTEN) as node:
                state = call(node.name + "/get_state", GetState).state
                moved = list(state.positions)
                a, b = 5 * 12 + 5, 8 * 12 + 8
                moved[3 * a:3 * a + 3] = [moved[3 * b], moved[3 * b + 1], 1.05]
                moved[3 * b + 2] = 1.2
                state.positions, state.memory = moved, []
                self.assertTrue(call(node.name + "/set_state", SetState, state).success)
                node.diagnostics.clear()
                values = node.wait(level, "pairs of triangles cross" if level else "paused")
                self.assertGreater(int(values["intersecting pairs"]), 0)

    def test_pinched(self):
        """Two overlapping slabs with the cloth between their sides, as a gripper commands it."""
        slabs = [{"name": name, "shape": "box", "size": [2, 2, 0.1], "center": [0.5, 0.5, z]}
                 for name, z in (("lower", 0.951), ("upper", 1.049))]
        with self.node({**SMALL, "colliders": slabs}, OFF) as node:
            values = node.wait(OK, "running")
            self.assertEqual(values["contacts"], "144")
            self.assertEqual(values["points between colliders"], "144")
            self.assertEqual(values["slipping between colliders"], "0")

    def test_tf_age(self):
        for limits, level in ((OFF, WARN), ({**OFF, "tf_age": {"error": 2}}, ERROR)):
            broadcaster = tf2_ros.TransformBroadcaster()
            scene = copy.deepcopy(HELD)
            frame = "hand_%d" % level
            scene["cloth"]["pinned"][1]["frame"] = frame
            with self.node(scene, limits, **OFTEN) as node:
                self.assertEqual(node.wait(OK, "running")["tf age of %s [s]" % frame],
                                 "not seen yet")
                for _ in range(100):
                    t = make_transform("hand", (0, 0, 0), stamp=rospy.Time.now())
                    t.child_frame_id = frame
                    broadcaster.sendTransform(t)
                    time.sleep(0.02)
                values = node.wait(OK, "running")
                self.assertLess(float(values["tf age of %s [s]" % frame]), 0.5)
                values = node.wait(level, "lost tf frame " + frame)
                self.assertGreaterEqual(float(values["tf age of %s [s]" % frame]), 1)  # rounded

    def test_a_frame_of_nearly_the_name(self):
        """Ball_link for ball_link; reported once in the log."""
        log = Recorder("/rosout", Log)
        broadcaster = tf2_ros.TransformBroadcaster()
        scene = {**SMALL, "colliders": [
            {"name": "ball", "shape": "sphere", "center": [0, 0, -1], "frame": "ball_link"}]}
        with self.node(scene, OFF, diagnostic_period=0.1) as node:
            def told():
                broadcaster.sendTransform(make_transform("Ball_link", (0, 0, 5), stamp=rospy.Time.now()))
                return [m.msg for m in log.all() if m.name == node.name and "Ball_link" in m.msg]
            wait_for(told, "the warning")
            time.sleep(0.5)
            self.assertEqual(told(), ["Nobody broadcasts tf frame ball_link, which the scene follows; did you "
                                      "mean Ball_link?"])
        log.close()

    def test_lost_frames_in_one_line(self):
        """The frames of a robot are lost together: one warning, and no other while they stay lost."""
        links = ["link_%d" % i for i in range(4)]
        scene = {**SMALL, "colliders": [
            {"name": link, "shape": "sphere", "center": [0, 0, -1], "frame": link} for link in links]}
        log = Recorder("/rosout", Log)
        broadcaster = tf2_ros.TransformBroadcaster()
        with self.node(scene, OFF, paused=True) as node:
            wait_for(lambda: is_connected("/rosout", "/diagnostics", node.name), "the log")
            for _ in range(50):
                broadcaster.sendTransform([make_transform(link, (0, 0, -1), stamp=rospy.Time.now())
                                           for link in links])
                time.sleep(0.02)
            node.wait(WARN, "lost tf frame link_0")
            node.diagnostics.clear()
            wait_for(lambda: len(node.statuses("simulation")) > 1, "diagnostics")
        self.assertEqual([m.msg for m in log.all() if "ost tf" in m.msg],
                         ["Lost tf frames %s: what they carry stays where it was" % ", ".join(links)])
        log.close()

    def test_each_frame_once(self):
        """For any number of colliders and pins that follow it."""
        finger = {"shape": "sphere", "center": [0, 0, -1], "frame": "shared"}
        scene = {"cloth": dict(SMALL["cloth"], pinned=[{"point": [0, 0], "frame": "shared"}]),
                 "colliders": [dict(finger, name="a"), dict(finger, name="b")]}
        with self.node(scene, OFF, paused=True) as node:
            node.wait(OK, "paused")
            keys = [v.key for v in node.statuses("simulation")[0].values]
        self.assertEqual(keys.count("tf age of shared [s]"), 1)
        self.assertEqual(len(keys), len(set(keys)))

    def test_frame_below_another_root(self):
        broadcaster = tf2_ros.StaticTransformBroadcaster()
        scene = copy.deepcopy(HELD)
        scene["cloth"]["pinned"][1]["frame"] = "astray"
        with self.node(scene, OFF, **OFTEN) as node:
            node.wait(OK, "running")
            broadcaster.sendTransform(make_transform("astray", (0, 0, 0), parent="elsewhere"))
            values = node.wait(WARN, "tf frame astray has no transform to the world frame, map")
            self.assertEqual(values["tf age of astray [s]"], "no transform to map")
            broadcaster.sendTransform(make_transform("astray", (0, 0, 0)))
            wait_for(lambda: node.statuses("simulation")[-1].level == OK, "the frame")

    def test_images(self):
        """Pictures that take longer to draw than the time between them."""
        camera = {"width": 2000, "height": 1500, "rate": 90, "samples": 4}
        for limits, level in (({"images": {"warning": 1}}, WARN),
                              ({"images": {"warning": 1, "error": 1}}, ERROR)):
            with self.node(SMALL, limits, camera=camera) as node:
                Recorder(node.name + "/camera/color/image_raw", Image)
                values = node.wait(level, "% of the pictures due are drawn", "camera")
                self.assertGreater(int(values["pictures dropped"]), 0)
                self.assertIn("pictures per second", values)


if __name__ == "__main__":
    rospy.init_node("diagnostics_test")
    rostest.rosrun("clothsim", "diagnostics", Diagnostics)
