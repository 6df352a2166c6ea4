#!/usr/bin/python3
"""Ends of the node and of its master: SIGINT and SIGTERM end it cleanly, a lost master does not."""

import os
import re
import signal
import socket
import subprocess
import tempfile
import threading
import time
import unittest

import PIL.Image
import roslib.packages
import rosunit
import yaml

from cloth_client import KEPT, PATIENCE, Cloth, Recorder, call, complaints, rate, says, wait_for

FRAMES_PER_SECOND = 90


def free_port():
    with socket.socket() as s:
        s.bind(("", 0))
        return s.getsockname()[1]


# A master of the test's own, to kill. It must be known before rospy starts.
PORT = free_port()
os.environ["ROS_MASTER_URI"] = "http://localhost:%d" % PORT

import rosgraph  # noqa: E402
import rospy  # noqa: E402
from diagnostic_msgs.msg import DiagnosticArray  # noqa: E402
from dynamic_reconfigure.encoding import decode_config, encode_config  # noqa: E402
from dynamic_reconfigure.srv import Reconfigure  # noqa: E402
from clothsim.srv import LoadScene  # noqa: E402


def start_master():
    master = subprocess.Popen(["rosmaster", "--core", "-p", str(PORT)],
                              stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    wait_for(rosgraph.is_master_online, "the master")
    return master


class LifeCycle(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.program = roslib.packages.find_node("clothsim", "clothsim_node")[0]
        cls.master = start_master()
        rospy.init_node("life_cycle_test")

    @classmethod
    def tearDownClass(cls):
        cls.master.kill()
        cls.master.wait()

    def start_node(self, name, **parameters):
        rospy.set_param("/%s/scene" % name, {"cloth": {"columns": 20, "rows": 20}})
        for key, value in parameters.items():
            rospy.set_param("/%s/%s" % (name, key), value)
        node = subprocess.Popen([self.program, "__name:=" + name], stdout=subprocess.PIPE,
                                stderr=subprocess.PIPE, text=True)
        cloth = Cloth("/" + name)
        cloth.states.wait("the first state")
        return node, cloth

    def assert_ends_cleanly(self, node, by=signal.SIGINT):
        node.send_signal(by)
        _, errors = node.communicate(timeout=PATIENCE)
        self.assertEqual(node.returncode, 0, errors)
        return errors

    def test_interrupt_while_running(self):
        node, _ = self.start_node("running")
        self.assertEqual(self.assert_ends_cleanly(node), "")

    def test_files_of_scenes_do_not_mix(self):
        """Values beside a file override it; those that one node has left do not override the next one's."""
        scenes = os.path.join(roslib.packages.get_pkg_dir("clothsim"), "config/scenes/")
        node, cloth = self.start_node("of_files", paused=True, scene_file=scenes + "sphere.yaml")
        given = rospy.get_param("/of_files/scene")
        self.assertEqual((given["cloth"]["columns"], given["colliders"][0]["name"]), (20, "sphere"))
        self.assertEqual(len(cloth.states.all()[-1].positions), 3 * 20 * 20)
        self.assert_ends_cleanly(node)
        node, _ = self.start_node("of_files", scene_file="package://clothsim/config/scenes/plane.yaml")
        with open(scenes + "plane.yaml", encoding="utf-8") as file:
            self.assertEqual(rospy.get_param("/of_files/scene"), yaml.safe_load(file))
        self.assert_ends_cleanly(node)

    def test_two_of_one_name(self):
        first, _ = self.start_node("namesake")
        second, _ = self.start_node("namesake")
        _, errors = first.communicate(timeout=PATIENCE)
        self.assertIn("new node registered with same name", errors)
        errors = self.assert_ends_cleanly(second)
        self.assertRegex(errors, "/namesake at http.* __name:=another")

    def test_frames_go_on_while_a_scene_reads_a_large_image(self):
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "texture.png")
            PIL.Image.new("RGB", (1, 1)).save(path)
            node, cloth = self.start_node(
                "loading", image_folders=[folder],
                camera={"cloth": {"shader": "texture", "texture": path}})
            PIL.Image.new("RGB", (8192, 8192), (0, 0, 255)).save(path)  # read again because it has changed
            cloth.states.clear()
            answer = call("/loading/load_scene", LoadScene)
            self.assertTrue(answer.success, answer.message)
            cloth.states.wait("the new start", lambda state: state.step == 0)
            steps = [state.step for state in cloth.states.all()]
            # If the node's own thread read the image, only a few states would come before the new start.
            self.assertGreater(steps.index(0), 10)
            self.assertEqual(self.assert_ends_cleanly(node), "")

    def test_says_which_parameters_have_no_effect(self):
        node, _ = self.start_node("mistaken", kss=5000, ks=123.0, density=150, paused=True,
                                  light={"intensity": 10.5, "colour": 1})
        errors = self.assert_ends_cleanly(node)
        unknown = "got ... unknown ... scene, scene_file, scene_folder, camera ... realtime_factor ... publish_clock"
        holds = " ... ~scene or ~camera ... %s holds"
        for message in ("/mistaken/kss: %s ... ks?" % unknown, "/mistaken/ks: got 123" + holds % 5000,
                        "/mistaken/light/colour: " + unknown, "/mistaken/light/intensity: got 10.5" + holds % 10):
            self.assertRegex(errors, says(message))
        self.assertEqual(errors.count("/mistaken"), 4, errors)
        self.assertEqual(rospy.get_param("/mistaken/ks"), 5000)

    def test_tells_what_auto_takes(self):
        """At the start, and when it changes; as a warning where no method keeps up."""
        node, _ = self.start_node("choosing", paused=True)
        call("/choosing/set_parameters", Reconfigure, encode_config({"ks": 50000.0}))
        call("/choosing/set_parameters", Reconfigure, encode_config({"gravity_x": 0.0}))  # as before
        call("/choosing/set_parameters", Reconfigure, encode_config({"method": "verlet"}))
        call("/choosing/set_parameters", Reconfigure, encode_config({"method": "auto"}))
        time.sleep(0.2)
        node.send_signal(signal.SIGINT)
        said, errors = node.communicate(timeout=PATIENCE)
        self.assertEqual(errors, "")
        found = re.findall(r"Method auto takes (\w+), substeps a frame (\d+) or more, predicted error "
                           r"\S+ of the cloth's size: the cheapest within tolerance", said)
        self.assertEqual(len(found), 3, said)
        self.assertLess(int(found[0][1]), int(found[1][1]))
        self.assertEqual(found[1], found[2])

        node, _ = self.start_node("slow", paused=True, scene={
            "cloth": {"columns": 200, "rows": 200, "ks": 50000}})
        errors = self.assert_ends_cleanly(node)
        self.assertRegex(errors, "Method auto takes .*: none is in real time: the cheapest")

    def test_terminate(self):
        node, _ = self.start_node("terminated")
        self.assertEqual(self.assert_ends_cleanly(node, by=signal.SIGTERM), "")
        self.assertEqual(rospy.get_published_topics("/terminated"), [])  # the master has removed them, too

    def test_interrupt_while_starting(self):
        """While it builds a large cloth: it ends after that, before it simulates."""
        for by in (signal.SIGINT, signal.SIGTERM):
            rospy.set_param("/large/scene", {"cloth": {"columns": 700, "rows": 700}})
            node = subprocess.Popen([self.program, "__name:=large"], stdout=subprocess.PIPE,
                                    stderr=subprocess.PIPE, text=True)
            master = rosgraph.Master("/life_cycle_test")
            wait_for(lambda: "/large/get_loggers" in (name for name, _ in master.getSystemState()[2]),
                     "the node's first service")
            self.assertEqual(self.assert_ends_cleanly(node, by), "")

    def test_interrupt_within_a_frame(self):
        """A frame that takes minutes is interrupted between two of its substeps."""
        for by in (signal.SIGINT, signal.SIGTERM):
            # Paused, so that the first state is received, however busy the machine is.
            node, cloth = self.start_node("endless", paused=True, scene={
                "cloth": {"columns": 300, "rows": 300},
                "simulation": {"method": "rk4", "substeps": 10000}})
            cloth.pause(False)
            time.sleep(0.5)  # into the first frame
            errors = self.assert_ends_cleanly(node, by)
            self.assertRegex(errors, r"\A.*Method rk4 is going to be slower than real time.*\n\Z")

    def test_interrupt_while_paused(self):
        node, _ = self.start_node("paused", paused=True)
        self.assertEqual(self.assert_ends_cleanly(node), "")

    def test_interrupt_in_a_long_step(self):
        node, cloth = self.start_node("stepping", paused=True)
        answers = []

        def step():
            try:
                answers.append(cloth.try_step(1000000))
            except rospy.ServiceException as error:
                answers.append(error)
        caller = threading.Thread(target=step)
        caller.start()
        cloth.states.wait("frame 100", lambda s: s.step >= 100)
        self.assert_ends_cleanly(node)
        caller.join(PATIENCE)
        self.assertEqual(len(answers), 1)

    def test_master_goes_away_and_comes_back(self):
        """The node keeps its rate or reports the reason, also while live values change, of which the
        master is informed."""
        node, cloth = self.start_node("orphan")
        diagnostics = Recorder("/diagnostics", DiagnosticArray)
        diagnostics.wait("diagnostics")
        # Connected before, so that the calls need no master.
        live = rospy.ServiceProxy("/orphan/set_parameters", Reconfigure, persistent=True)
        calls = 0

        def keeps_its_rate():
            nonlocal calls
            cloth.states.wait("a state")
            for recorder in (cloth.states, diagnostics):
                recorder.clear()
            end = time.monotonic() + 2.5  # past the next diagnostics
            while time.monotonic() < end:
                calls += 1
                answer = live(encode_config({"ks": 5000.0 + calls}))
                self.assertEqual(decode_config(answer.config)["ks"], 5000 + calls)
                time.sleep(0.02)
            reached, said = rate(cloth.states.all()), complaints(diagnostics.all(), "/orphan")
            if reached < KEPT * FRAMES_PER_SECOND:
                self.assertTrue([m for m in said if m.startswith("real-time factor")], (reached, said))
            return cloth.states.all()[-1].step

        before = keeps_its_rate()
        self.master.kill()
        self.master.wait()
        without = keeps_its_rate()
        self.assertGreater(without, before + 20)
        type(self).master = start_master()
        self.assertGreater(keeps_its_rate(), without + 20)
        live.close()
        self.assert_ends_cleanly(node)

    def test_interrupt_while_waiting_for_a_master(self):
        self.master.kill()
        self.master.wait()
        try:
            for program, by in (("clothsim_node", signal.SIGINT), ("clothsim_node", signal.SIGTERM),
                                ("clothsim_handles", signal.SIGINT),
                                ("clothsim_handles", signal.SIGTERM)):
                path = roslib.packages.find_node("clothsim", program)[0]
                node = subprocess.Popen([path], stdout=subprocess.DEVNULL, stderr=subprocess.PIPE,
                                        text=True)
                self.assertIn("Failed to contact master", node.stderr.readline())
                self.assert_ends_cleanly(node, by)
        finally:
            type(self).master = start_master()

    def test_interrupt_without_a_master(self):
        node, _ = self.start_node("last")
        self.master.kill()
        self.master.wait()
        try:
            self.assert_ends_cleanly(node)
        finally:
            type(self).master = start_master()


if __name__ == "__main__":
    rosunit.unitrun("clothsim", "life_cycle", LifeCycle)
