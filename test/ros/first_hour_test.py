#!/usr/bin/python3
"""The first hour of README.md, line by line as a user types it, and its outputs; the tables of
docs/interface.md."""

import os
import re
import shutil
import signal
import subprocess
import tempfile
import unittest

import numpy as np
import rosgraph
import roslib.packages
import rospy
import rosservice
import rostest
from dynamic_reconfigure.client import Client
from rosgraph_msgs.msg import Log
from visualization_msgs.msg import MarkerArray

from cloth_client import PATIENCE, Cloth, Recorder, is_connected, marker_named, point, wait_for


def read_document(path):
    with open(os.path.join(roslib.packages.get_pkg_dir("clothsim"), path)) as file:
        return file.read()


def read_section(title):
    return read_document("README.md").split("\n## %s\n" % title)[1].split("\n## ")[0]


def read_walk():
    """Blocks of the section by the first words of the paragraph before: lists of commands, or a
    program. Blocks that set up a terminal have no such words: None."""
    walk, title = {}, None
    for part in re.split(r"\n\n(?=\*\*)", read_section("The first hour")):
        found = re.match(r"\*\*(.*?)\.\*\*", part.strip())
        title = found.group(1) if found else None
        for kind, text in re.findall(r"```(\w+)\n(.*?)```", part, re.DOTALL):
            walk[title] = text if kind == "python" else text.splitlines()
    return walk


def read_interface():
    """Types of the topics and services in the tables, by name, for a scene with a sphere."""
    types = {}
    for line in read_document("docs/interface.md").splitlines():
        cells = line.split("|")
        if len(cells) < 4 or not re.match(r" \w+/\w", cells[2]):
            continue
        names = re.findall("`(.*?)`", cells[1])
        kinds = re.sub(r", each .*", "", cells[2]).strip().split(", ")
        for name, kind in zip(names, kinds if len(kinds) == len(names) else kinds * len(names)):
            name = re.sub("FRAME|COLLIDER", "sphere", name.replace("~", "/clothsim/"))
            types[name] = kind if "/" in kind else "clothsim/" + kind
    return types


class FirstHour(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.mkdtemp()
        self.going_on = []
        self.set_up = "".join(line.partition("#")[0] + ";" for line in read_walk()[None]
                              if not line.startswith("source"))  # already sourced
        # Another python first, which has no ROS.
        python = os.path.join(self.folder, "python3")
        with open(python, "w") as file:
            file.write("#!/bin/sh\necho no ROS here >&2\nexit 1\n")
        os.chmod(python, 0o755)
        self.environment = dict(os.environ, PATH=self.folder + ":" + os.environ["PATH"])

    def tearDown(self):
        for process in reversed(self.going_on):
            self.stop(process)
        shutil.rmtree(self.folder)

    @staticmethod
    def stop(process):
        if process.poll() is None:
            os.killpg(process.pid, signal.SIGINT)
            process.wait(PATIENCE)

    def go_on(self, command):
        process = subprocess.Popen(self.set_up + command, shell=True, cwd=self.folder,
                                   env=self.environment, start_new_session=True,
                                   stdout=subprocess.DEVNULL)
        self.going_on.append(process)
        return process

    def run_lines(self, lines):
        """The output of each command. Commands that go on are started; RViz has no display here."""
        printed = {}
        for line in lines:
            command, _, comment = (part.strip() for part in line.partition("#"))
            if command.startswith("roslaunch"):
                command += " rviz:=false"
            if comment == "goes on":
                self.go_on(command)
                continue
            self.wait_until_possible(command)
            done = subprocess.run(self.set_up + command, shell=True, cwd=self.folder,
                                  env=self.environment, capture_output=True, text=True,
                                  timeout=PATIENCE)
            self.assertEqual(done.returncode, 0, command + "\n" + done.stdout + done.stderr)
            self.assertNotIn("success: False", done.stdout, command)
            printed[command] = done.stdout
        return printed

    def wait_until_possible(self, command):
        """A user types slower than the test: earlier programs are ready by then."""
        service = re.match(r"rosservice call (\S+)", command)
        if service:
            rospy.wait_for_service(service.group(1), PATIENCE)
        for process in self.going_on:
            if "record" in process.args:
                for topic in re.findall(r"/clothsim/\w+", process.args):
                    wait_for(lambda p=process, t=topic: p.poll() is not None
                             or is_connected(t, "/recorder"), "the recorder")
        if "replay_bag" in command:
            wait_for(lambda: os.path.exists(os.path.join(self.folder, "run.bag")), "the bag")
        if "attach" in command:
            rospy.sleep(1)  # the hand's frame

    def test_interface_tables(self):
        """The node has the topics and services of the tables, and no others."""
        self.run_lines(["roslaunch clothsim sphere.launch paused:=true # goes on",
                        "rosrun tf2_ros static_transform_publisher 0 0 0 0 0 0 map sphere # goes on",
                        'rosservice call /clothsim/attach "{frame: sphere, points: [0]}"'])
        topics = {name: kind for name, kind in rospy.get_published_topics()
                  if name.startswith(("/clothsim/", "/diagnostics"))}
        master = rosgraph.Master("/first_hour")
        _, heard, provided = master.getSystemState()
        kinds = dict(master.getTopicTypes())
        topics.update({name: kinds[name] for name, nodes in heard
                       if "/clothsim" in nodes and name.startswith("/clothsim/")})
        services = {name: rosservice.get_service_type(name) for name, nodes in provided
                    if "/clothsim" in nodes}
        # Topics and services that libraries add.
        theirs = r"parameter_(updates|descriptions)$|camera_info$|logger"
        found = {name: kind for name, kind in {**topics, **services}.items()
                 if not re.search(theirs, name)}
        self.assertEqual(found, read_interface())

    def test_walk(self):
        walk = read_walk()
        self.assertEqual(list(walk)[1:], [
            "Launch and look", "Tune it while it moves", "Drive the sphere from your node", "Grasp",
            "Record and replay", "All of it at once"])

        printed = self.run_lines(walk["Launch and look"])
        self.assertIn("real-time factor asked", printed["rostopic echo -n 1 /diagnostics"])
        self.assertIn("frame_id: \"map\"", printed["rostopic echo -n 1 /clothsim/state/header"])
        cloth = Cloth()
        cloth.states.wait("the cloth on the sphere", lambda s: s.step > 60)

        *changes, load = walk["Tune it while it moves"]
        self.run_lines(changes)
        values = Client("/clothsim", timeout=PATIENCE).get_configuration(timeout=PATIENCE)
        self.assertEqual([values[k] for k in ("ks", "density", "damping", "shear", "method")],
                         [500.0, 15.0, 27.0, False, "xpbd"])
        seen = cloth.states.all()[-1].step
        cloth.states.wait("a second with them", lambda s: s.step > seen + 90)
        self.run_lines([load])
        self.assertEqual(rospy.get_param("/clothsim/ks"), 5000.0)

        code = walk["Drive the sphere from your node"]
        lines = [line for line in code.splitlines() if line and not line.startswith("#!")]
        self.assertLessEqual(len(lines), 10)
        program = os.path.join(self.folder, "move_sphere.py")
        with open(program, "w") as file:
            file.write(code)
        mover = self.go_on("exec python3 " + program)
        markers = Recorder("/clothsim/markers", MarkerArray)

        def ways():
            where = [point(marker_named(a, "colliders").pose.position)[0] for a in markers.all()]
            return np.ptp(where) if where else 0
        wait_for(lambda: ways() > 0.05, "the sphere's motion")
        markers.close()
        mover.kill()  # rospy may wait for itself where a signal comes as it publishes
        mover.wait()

        printed = self.run_lines(walk["Grasp"])
        wrench = printed["rostopic echo -n 1 /clothsim/wrench/hand"]
        force = dict(re.findall(r"(\w): (\S+)", wrench.split("force:")[1].split("torque:")[0]))
        self.assertAlmostEqual(float(force["z"]), -600, delta=60)  # 'some 600 N'

        printed = self.run_lines(walk["Record and replay"])
        self.assertEqual(printed["rosrun clothsim replay_bag run.bag"], "90 frames, the same bits\n")

        self.stop(self.going_on[0])  # the first launch
        log = Recorder("/rosout", Log)
        self.run_lines(walk["All of it at once"])
        log.wait("the fold", lambda m: m.msg == "the cloth is folded")


if __name__ == "__main__":
    rospy.init_node("first_hour_test")
    rostest.rosrun("clothsim", "first_hour", FirstHour)
