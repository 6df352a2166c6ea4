#!/usr/bin/python3
"""Another scene at run time: everything follows it, or it is refused and the old one goes on."""

import os
import re
import shutil
import subprocess
import tempfile
import unittest

import numpy as np
import roslib.packages
import rospy
import rostest
import yaml
from dynamic_reconfigure.client import Client
from rosgraph_msgs.msg import Log
from sensor_msgs.msg import PointCloud2
from visualization_msgs.msg import Marker, MarkerArray

from clothsim.msg import ClothTopology, Colliders
from clothsim.srv import LoadScene, RestoreState, SaveState
from cloth_client import PATIENCE, Cloth, Recorder, call, content, marker_named, positions, says, wait_for

LOAD = "/clothsim/load_scene"
PACKAGE = roslib.packages.get_pkg_dir("clothsim")
START = {"cloth": {"columns": 50, "rows": 50, "pinned": [[0, 0], [49, 0]]}}
SMALL = {"cloth": {"columns": 9, "rows": 7, "ks": 700.0},
         "colliders": [{"name": "ball", "shape": "sphere", "center": [0.5, 0.5, 0.6]}]}

COLLISIONS = {  # collisions of a robot's links, and the reason for which one is left out
    "good": ('<geometry><sphere radius="0.1"/></geometry>', None),
    "of a mesh": ('<geometry><mesh filename="package://clothsim/config/robots/finger.stl"/></geometry>', None),
    "missing": ('<geometry><mesh filename="package://clothsim/none.stl"/></geometry>', "No such file or directory"),
    "stranger": ('<geometry><mesh filename="package://no_such/a.stl"/></geometry>', "the package no_such"),
    "flat": ('<geometry><box size="0 1 1"/></geometry>', "size of <box> is not above 0"),
    "nowhere": ('<origin xyz="nan 0 0"/><geometry><sphere radius="1"/></geometry>', 'xyz of <origin> is "nan 0 0"')}
URDF = '<robot name="arm">%s</robot>' % "".join(
    '<link name="%s"><collision>%s</collision></link>' % (link, of) for link, (of, _) in COLLISIONS.items())
ARMS = {**SMALL, "robots": [{"description": "/robot_description", "prefix": p} for p in ("", "left_", "right_")]}


class Load(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.cloth = Cloth()
        cls.topology = Recorder("/clothsim/topology", ClothTopology)
        cls.markers = Recorder("/clothsim/markers", MarkerArray)
        cls.points = Recorder("/clothsim/points", PointCloud2)
        for recorder in (cls.cloth.states, cls.topology, cls.markers, cls.points):
            wait_for(recorder.all, "the first messages")

    def load(self, scene):
        rospy.delete_param("/clothsim/scene")
        rospy.set_param("/clothsim/scene", scene)
        return call("/clothsim/load_scene", LoadScene)

    def setUp(self):
        answer = self.load(START)
        self.assertTrue(answer.success, answer.message)

    def write(self, text):
        """The path of a scene's file in a folder of its own, with a mesh beside it."""
        folder = tempfile.mkdtemp()
        self.addCleanup(shutil.rmtree, folder)
        shutil.copy(os.path.join(PACKAGE, "config/robots/finger.stl"), folder)
        path = os.path.join(folder, "scene.yaml")
        with open(path, "w", encoding="ascii") as file:
            file.write(text)
        return path

    def test_a_file_replaces_all_of_the_scene_before(self):
        """Parameters would be merged: ks beside a fabric is refused, and the ball would stay."""
        self.assertTrue(self.load(SMALL).success)
        answer = call(LOAD, LoadScene, "package://clothsim/config/scenes/towel.yaml")
        self.assertTrue(answer.success, answer.message)
        with open(os.path.join(PACKAGE, "config/scenes/towel.yaml"), encoding="utf-8") as file:
            self.assertEqual(rospy.get_param("/clothsim/scene"), yaml.safe_load(file))
        from_file = content(self.cloth.step(10))
        self.assertTrue(call(LOAD, LoadScene).success)  # the current parameters
        self.assertEqual(content(self.cloth.step(10)), from_file)

    def test_several_cloths(self):
        self.assertTrue(call(LOAD, LoadScene, "package://clothsim/config/scenes/napkins.yaml").success)
        self.assertTrue(call(LOAD, LoadScene).success)  # the parameters that the file left

    def test_what_rosparam_would_drop_or_misread(self):
        path = self.write("cloth: {}\nsimulation: {tolerance: 1e-3}\n"
                          "colliders: [{name: finger, shape: mesh, file: finger.stl, center: [0, 0, 5]}]\n")
        answer = call(LOAD, LoadScene, path)
        self.assertTrue(answer.success, answer.message)
        self.assertEqual(rospy.get_param("/clothsim/scene/cloth"), {})
        self.assertEqual(rospy.get_param("/clothsim/scene_file"), path)
        self.assertTrue(call(LOAD, LoadScene).success)  # its mesh is still found
        self.assertTrue(self.load(START).success)  # which comes from no file
        self.assertFalse(rospy.has_param("/clothsim/scene_file"))

    def test_examples_of_the_docs_are_the_same_in_simulate(self):
        """Each example gives the same positions in both, except with motions, which the node does not play."""
        simulate = roslib.packages.find_node("clothsim", "simulate")[0]
        count = 0
        for page in ("docs/scenes.md", "docs/fabrics.md"):
            with open(os.path.join(PACKAGE, page), encoding="utf-8") as file:
                examples = re.findall(r"```yaml\n(.*?)```", file.read(), re.DOTALL)
            for example in examples:
                count += 1
                path = self.write(example if "cloth:" in example else "cloth: {}\n" + example)
                folder = os.path.dirname(path)
                run = subprocess.run([simulate, path, "--seconds", "0.1", "--output", folder],
                                     capture_output=True, text=True)
                self.assertEqual(run.returncode, 0, example + run.stderr)
                answer = call(LOAD, LoadScene, path)
                self.assertTrue(answer.success, example + answer.message)
                state = self.cloth.step(9)
                if "motions:" not in example:
                    table = np.loadtxt(os.path.join(folder, "final.csv"), delimiter=",", skiprows=1)
                    self.assertTrue(np.array_equal(positions(state), table[:, :3].astype(np.float32)), example)
        self.assertGreaterEqual(count, 5)

    def test_files_that_are_refused_change_nothing(self):
        self.assertTrue(self.load(SMALL).success)
        for file, message in (
                ("/no/such.yaml", 'scene_file: got "/no/such.yaml" ... not there'),
                ("towel.yaml", 'scene_file: got "towel.yaml" ... package://PACKAGE/path'),
                ("/etc/passwd", 'scene_file: got "/etc/passwd"'),
                (self.write("cloth: {ks: 1, fabric: denim}"), "scene/cloth/ks: got 1 ... fabric"),
                (self.write("cloth: [}"), "scene_file/")):
            answer = call(LOAD, LoadScene, file)
            self.assertFalse(answer.success, file)
            self.assertRegex(answer.message, says("/clothsim/" + message))
            self.assertEqual(rospy.get_param("/clothsim/scene"), SMALL)
        self.assertEqual(len(self.cloth.step(1).positions), 3 * 63)

    def test_all_topics_follow(self):
        self.cloth.step(3)
        before = self.topology.wait("the old topology", lambda t: t.columns == 50)
        self.topology.clear()  # of other tests
        answer = self.load(SMALL)
        self.assertTrue(answer.success, answer.message)

        after = self.topology.wait("the new topology", lambda t: t.columns == 9)
        self.assertGreater(after.seq, before.seq)
        self.assertEqual((after.rows, len(after.rest_positions), list(after.pinned)), (7, 189, []))
        start = self.cloth.states.wait("the new start", lambda s: s.topology_seq == after.seq)
        self.assertEqual((start.step, start.time, len(start.positions)), (0, 0, 189))
        self.points.wait("a cloud of the new size", lambda c: (c.width, c.height) == (9, 7))

        self.markers.wait("the ball and the new cloth", lambda a: (
            marker_named(a, "colliders") and len(marker_named(a, "surface").points) == 2 * 2 * 3 * 8 * 6))
        state = self.cloth.step(40)
        self.assertEqual((state.step, state.topology_seq), (40, after.seq))
        self.assertEqual(positions(state).shape, (63, 3))

    def test_markers_of_the_old_scene_go(self):
        def pins(array):
            return marker_named(array, "pins")
        self.markers.wait("pins", lambda a: pins(a) and pins(a).points)
        self.markers.clear()
        self.load(SMALL)
        self.markers.wait("an array that takes all others away",
                          lambda a: a.markers[0].action == Marker.DELETEALL and not pins(a))

    def test_live_values_are_the_scenes(self):
        self.load(SMALL)
        client = Client("/clothsim", timeout=PATIENCE)
        self.assertEqual(client.get_configuration(timeout=PATIENCE)["ks"], 700.0)
        self.assertEqual(client.update_configuration({"density": 20.0})["density"], 20.0)
        Client("/clothsim/shading/ball", timeout=PATIENCE).update_configuration({"levels": 3})
        client.close()
        self.load(START)
        self.assertEqual(rospy.get_param("/clothsim/ks"), 5000.0)
        self.assertEqual(rospy.get_param("/clothsim/density"), 150.0)

    def test_parameters_of_the_scenes_method(self):
        """The parameters are restored with the method, after another one."""
        self.load({**SMALL, "simulation": {"method": "xpbd", "method_parameters": {"iterations": 20}}})
        expected = content(self.cloth.step(10))
        client = Client("/clothsim", timeout=PATIENCE)
        states = []
        for method in ("verlet", "xpbd"):
            self.assertEqual(client.update_configuration({"method": method})["method"], method)
            self.cloth.reset()
            states.append(content(self.cloth.step(10)))
        client.close()
        self.assertNotEqual(states[0], expected)
        self.assertEqual(states[1], expected)

    def start_values(self, part):
        """The live values of a part of the view, which the node keeps."""
        client = Client("/clothsim/" + part, timeout=PATIENCE)
        values = client.get_configuration(timeout=PATIENCE)
        client.close()
        return values

    def test_looks_are_those_of_the_start(self):
        changes = {"shading/cloth": {"shader": "mirror"}, "light": {"intensity": 3.0},
                   "viewpoint": {"eye_z": 7.0}, "shading/ball": {"levels": 9}}
        self.load(SMALL)
        before = {part: self.start_values(part) for part in changes}
        for part, values in changes.items():
            client = Client("/clothsim/" + part, timeout=PATIENCE)
            self.assertEqual({k: client.update_configuration(values)[k] for k in values}, values)
            client.close()
        # A refused scene leaves them.
        self.assertFalse(self.load({"cloth": {"ks": -5}}).success)
        self.assertEqual(self.start_values("shading/cloth")["shader"], "mirror")
        self.load(START)  # without the ball
        self.load(SMALL)
        self.assertEqual({part: self.start_values(part) for part in changes}, before)

    def test_same_bits_as_a_node_that_started_with_it(self):
        expected = content(self.cloth.step(20))
        self.load(SMALL)
        self.cloth.step(20)
        self.load(START)
        self.assertEqual(content(self.cloth.step(20)), expected)

    def test_saved_states_are_gone(self):
        self.assertTrue(call("/clothsim/save_state", SaveState, "old").success)
        self.load(SMALL)
        self.assertFalse(call("/clothsim/restore_state", RestoreState, "old").success)

    def test_robots_with_faults(self):
        """Three faults in each of ten scenes: unusable parts are left out, with the link and the reason."""
        log, colliders = Recorder("/rosout", Log), Recorder("/clothsim/colliders", Colliders)
        rospy.set_param("/robot_description", URDF)
        for _ in range(10):
            answer = self.load(ARMS)
            self.assertTrue(answer.success, answer.message)
        step = self.cloth.step(1).step
        usable = [link for link, (_, fault) in COLLISIONS.items() if not fault]
        self.assertEqual([c.name for c in colliders.wait("the links", lambda m: m.step == step).colliders],
                         ["ball"] + ["arm/" + prefix + link for prefix in ("", "left_", "right_") for link in usable])
        for link, (_, fault) in COLLISIONS.items():
            if fault:
                log.wait("a line of " + link,
                         lambda m, start="Left out: arm/left_%s: got " % link, why=fault:
                         m.msg.startswith(start) and why in m.msg)
        for recorder in (log, colliders):
            recorder.close()

    def test_no_robots_are_refused(self):
        rospy.set_param("/robot_description", URDF)
        self.assertTrue(self.load(ARMS).success)
        expected = content(self.cloth.step(5))
        self.assertTrue(self.load(ARMS).success)
        at = "/clothsim/scene/robots/0/"
        for urdf in ("", "<robot", "<sdf/>", 7, ["a"], {"a": 1}, URDF.replace("stranger", "good")):
            rospy.delete_param("/robot_description")
            rospy.set_param("/robot_description", urdf)
            answer = self.load(ARMS)
            self.assertFalse(answer.success, urdf)
            self.assertTrue(answer.message.startswith(at + "description: got "), answer.message)
        rospy.delete_param("/robot_description")
        self.assertRegex(self.load(ARMS).message, says("description: got /robot_description ... not set"))
        rospy.set_param("/robot_description", URDF)
        for changes, message in (({"links": ["good", "thumb"]}, 'links/1: got "thumb" ... good, '),
                                 ({"padding": -0.1}, "padding: got -0.1"), ({"name": ""}, "name: got")):
            answer = self.load({**SMALL, "robots": [{"description": "/robot_description", **changes}]})
            self.assertRegex(answer.message, says(at + message))
        answer = self.load({**SMALL, "robots": 2 * ARMS["robots"]})
        self.assertRegex(answer.message, says('/clothsim/scene/robots/3/name: got "arm/good" ... again'))
        self.assertEqual(content(self.cloth.step(5)), expected)  # the old scene goes on

    def test_refused(self):
        self.cloth.step(10)
        expected = content(self.cloth.step(1))
        self.setUp()
        seq = self.cloth.step(10).topology_seq
        for scene, message in (
                ({"cloth": {"ks": -5}}, "/clothsim/scene/cloth/ks: got -5"),
                ({"cloth": {"columns": 100000, "rows": 100000}}, "/clothsim/scene/cloth/columns"),
                ({"cloth": {"colour": 3}}, "/clothsim/scene/cloth/colour: got ... unknown"),
                ({"cloth": {"ks": 1e12, "density": 1e-6}, "simulation": {"method": "verlet"}},
                 "/clothsim/scene/cloth/ks: got ... needs"),
                (7, "/clothsim/scene: got 7 ... map")):
            answer = self.load(scene)
            self.assertFalse(answer.success, scene)
            self.assertRegex(answer.message, says(message))
        rospy.delete_param("/clothsim/scene")
        self.assertIn("/clothsim/scene: got nothing",
                      call("/clothsim/load_scene", LoadScene).message)
        rospy.set_param("/clothsim/scene", START)
        after = self.cloth.step(1)
        self.assertEqual(content(after), expected)
        self.assertEqual(after.topology_seq, seq)


if __name__ == "__main__":
    rospy.init_node("load_scene_test")
    rostest.rosrun("clothsim", "load_scene", Load)
