#!/usr/bin/python3
"""Each scene's launch file has every argument of scene.launch and passes it on."""

import os
import tempfile
import unittest

import roslaunch.arg_dump
import roslaunch.config
import roslaunch.xmlloader
import roslib.packages
import rosunit

FOLDER = os.path.join(roslib.packages.get_pkg_dir("clothsim"), "launch")
ARGUMENTS = {"rviz": "false", "interactive": "false", "paused": "true", "realtime_factor": "0.25",
             "view": os.path.join(FOLDER, "../config/views/drape.yaml"), "world_frame": "odom",
             "publish_clock": "true", "jump_speed": "60",
             "params": os.path.join(os.path.dirname(os.path.abspath(__file__)), "params.yaml")}
PARAMETERS = {"paused": True, "realtime_factor": 0.25, "world_frame": "odom", "publish_clock": True,
              "jump_speed": 60, "diagnostics/tf_age/warning": 3}


class LaunchFiles(unittest.TestCase):
    def parameters(self, path, *arguments):
        """The parameters that roslaunch sets for a file (as of roslaunch --dump-params, in this process)."""
        config = roslaunch.config.ROSLaunchConfig()
        roslaunch.xmlloader.XmlLoader().load(path, config, argv=list(arguments), verbose=False)
        return {name: parameter.value for name, parameter in config.params.items()}

    def expect_passed_on(self, given):
        for name, value in PARAMETERS.items():
            self.assertEqual(given["/clothsim/" + name], value, name)
        self.assertTrue([name for name in given if name.startswith("/clothsim/camera/")])

    def test_each_can_be_included_with_all(self):
        files = sorted(os.listdir(FOLDER))
        self.assertGreater(len(files), 6)
        arguments = "".join('<arg name="%s" value="%s"/>' % item for item in ARGUMENTS.items())
        for file in files:
            with tempfile.NamedTemporaryFile("w", suffix=".launch") as including:
                including.write('<launch><include file="%s">%s</include></launch>'
                                % (os.path.join(FOLDER, file), arguments))
                including.flush()
                with self.subTest(file):
                    self.expect_passed_on(self.parameters(including.name))

    def test_a_scene_of_ones_own(self):
        scene = os.path.join(os.path.dirname(__file__), "attach_scene.yaml")
        given = self.parameters(os.path.join(FOLDER, "scene.launch"), "scene:=" + scene,
                                *["%s:=%s" % item for item in ARGUMENTS.items()])
        self.expect_passed_on(given)
        self.assertEqual(given["/clothsim/scene_file"], os.path.abspath(scene))

    def test_no_argument_is_required(self):
        """roslaunch takes an argument with an empty default for a required one."""
        for file in sorted(os.listdir(FOLDER)):
            arguments = roslaunch.arg_dump.get_args([os.path.join(FOLDER, file)])
            self.assertEqual([name for name, (_, default) in arguments.items() if not default], [], file)
            self.assertEqual(arguments["jump_speed"][1], "none", file)

    def test_empty_is_none(self):
        """As from a user's own launch file that passes an empty argument on."""
        sphere = os.path.join(FOLDER, "sphere.launch")
        plain = self.parameters(sphere)
        self.assertEqual(self.parameters(sphere, "view:=", "params:=", "jump_speed:="), plain)
        self.assertFalse([name for name in plain if "jump_speed" in name or "/camera/" in name])

    def test_paths_of_scenes(self):
        """Paths are relative to the working directory of roslaunch, or to a package."""
        for scene, file in (("a/b.yaml", os.environ["PWD"] + "/a/b.yaml"),
                            ("package://a/b.yaml", "package://a/b.yaml")):
            given = self.parameters(os.path.join(FOLDER, "scene.launch"), "scene:=" + scene)
            self.assertEqual(given["/clothsim/scene_file"], file)


if __name__ == "__main__":
    rosunit.unitrun("clothsim", "launch_files", LaunchFiles)
