#!/usr/bin/python3
"""A node with a bad parameter says the parameter's full name and ends with an error."""

import re
import subprocess
import unittest

import roslib.packages
import rosparam
import rospy
import rostest

from cloth_client import PATIENCE, says

# One for each class of mistake: the parameters as YAML, the message's parameter, and value and reason.
BAD = {
    "no scene": ("{}", "scene", "got nothing ... scene"),
    "scene of the wrong type": ("scene: 7", "scene", "got 7 ... map"),
    "no cloth": ("scene: {simulation: {seed: 2}}", "scene/cloth", "got nothing"),
    "unknown key": ("scene: {cloth: {colour: 3}}", "scene/cloth/colour", "got ... unknown"),
    "wrong type": ("scene: {cloth: {ks: [1]}}", "scene/cloth/ks", "got [1]"),
    "number in quotes": ("scene: {cloth: {ks: '50'}}", "scene/cloth/ks", 'got "50" ... text'),
    "fraction of a point": ("scene: {cloth: {columns: 9.5}}", "scene/cloth/columns", "got 9.5"),
    "not finite": ("scene: {cloth: {ks: .inf}}", "scene/cloth/ks", "got .inf"),
    "not a number": ("scene: {cloth: {width: .nan}}", "scene/cloth/width", "got .nan"),
    "out of range": ("scene: {cloth: {ks: -5}}", "scene/cloth/ks", "got -5 ... least 0 [N/m]"),
    "absurd size": ("scene: {cloth: {columns: 100000, rows: 100000}}", "scene/cloth/columns",
                    "got 100000 ... 1000000 points"),
    "pin off the grid": ("scene: {cloth: {pinned: [[0, 0], [50, 0]]}}", "scene/cloth/pinned/1",
                         "got [50, 0]"),
    "unknown shape": ("scene: {cloth: {width: 1}, colliders: [{shape: cone}]}",
                      "scene/colliders/0/shape", 'got "cone"'),
    "mistake in a list": (
        "scene: {cloth: {width: 1}, colliders: [{name: a, shape: plane}, "
        "{name: b, shape: sphere, radius: -1}]}", "scene/colliders/1/radius", "got -1"),
    "two of a name": (
        "scene: {cloth: {width: 1}, colliders: [{name: a, shape: plane}, "
        "{name: a, shape: sphere}]}", "scene/colliders/1/name", 'got "a" ... again'),
    "unknown method": ("scene: {cloth: {width: 1}, simulation: {method: magic}}",
                       "scene/simulation/method", 'got "magic"'),
    "no step small enough": ("scene: {cloth: {ks: 1.0e+12, density: 1.0e-6}, "
                             "simulation: {method: verlet}}", "scene/cloth/ks",
                             "got ... needs"),
    "vector too short": ("scene: {cloth: {origin: [0, 1]}}", "scene/cloth/origin", "got [0, 1]"),
    "jump speed": ("{jump_speed: -1, scene: {cloth: {width: 1}}}", "jump_speed",
                   "got -1 ... least 0 [m/s]"),
    "diagnostic period": ("{diagnostic_period: 0, scene: {cloth: {width: 1}}}", "diagnostic_period",
                          "got 0 ... least 0.1 [s]"),
    "real-time factor": ("{realtime_factor: -1, scene: {cloth: {width: 1}}}", "realtime_factor",
                         "got -1 ... 0 or"),
    "paused as a number": ("{paused: 1, scene: {cloth: {width: 1}}}", "paused", "got 1"),
    "world frame with a slash": ("{world_frame: /map, scene: {cloth: {width: 1}}}", "world_frame",
                                 'got "/map"'),
    "limit of the wrong type": ("{diagnostics: {tf_age: {warning: soon}}, scene: {cloth: {width: 1}}}",
                                "diagnostics/tf_age/warning",
                                'got "soon" ... number ... off'),
    "limit of nothing": ("{diagnostics: {mood: {warning: 1}}, scene: {cloth: {width: 1}}}",
                         "diagnostics/mood", "got ... unknown"),
    "limit below zero": ("{diagnostics: {violation: {error: -1}}, scene: {cloth: {width: 1}}}",
                         "diagnostics/violation/error", "got -1"),
    "error before the warning": ("{diagnostics: {speed: {warning: 0.2}}, scene: {cloth: {width: 1}}}",
                                 "diagnostics/speed/error",
                                 "got 0.5 ... most ... warning ... 0.2"),
    "warning after the error": (
        "{diagnostics: {tf_age: {warning: 2, error: 1}}, scene: {cloth: {width: 1}}}",
        "diagnostics/tf_age/error", "got 1 ... least ... warning ... 2"),
    "camera of the wrong type": ("{camera: 3, scene: {cloth: {width: 1}}}", "camera", "got 3"),
    "unknown key of the camera": ("{camera: {widht: 3}, scene: {cloth: {width: 1}}}",
                                  "camera/widht", "got ... unknown"),
    "look outside of cloth": ("{camera: {color: [1, 0, 0]}, scene: {cloth: {width: 1}}}",
                              "camera/color", "got ... unknown"),
    "key beside image_transport's": ("{camera: {depth: {image_raw: {compressed: {format: png}}, "
                                     "near: 1}}, scene: {cloth: {width: 1}}}",
                                     "camera/depth", "got ... unknown"),
    "key after image_transport's": ("{camera: {mask: {image_raw: {compressed: {format: png}}}, "
                                    "near: -1}, scene: {cloth: {width: 1}}}",
                                    "camera/near", "got -1"),
    "unknown shader": ("{camera: {cloth: {shader: shiny}}, scene: {cloth: {width: 1}}}",
                       "camera/cloth/shader", 'got "shiny" ... texture'),
    "missing texture": ("{camera: {cloth: {texture: no.png}}, scene: {cloth: {width: 1}}}",
                        "camera/cloth/texture", 'got "no.png" ... image in'),
    "texture outside the folders": (
        "{camera: {cloth: {texture: /etc/hostname}}, image_folders: [/usr], "
        "scene: {cloth: {width: 1}}}",
        "camera/cloth/texture", 'got "/etc/hostname" ... image in'),
    "image folder of the wrong type": ("{image_folders: /usr, scene: {cloth: {width: 1}}}",
                                       "image_folders", 'got "/usr" ... list'),
    "value of another shader": ("{camera: {cloth: {alpha: 2}}, scene: {cloth: {width: 1}}}",
                                "camera/cloth/alpha", "got 2"),
    "camera on its own target": ("{camera: {eye: [1, 1, 1], target: [1, 1, 1]}, "
                                 "scene: {cloth: {width: 1}}}", "camera/target", "got"),
    "look of no collider": ("{camera: {colliders: {ball: {levels: 3}}}, scene: {cloth: {width: 1}}}",
                            "camera/colliders/ball", "got ... collider"),
    "no such EGL device": ("{camera: {egl_device: 99}, scene: {cloth: {width: 1}}}",
                           "camera/egl_device", "got 99 ... index ... 0 to"),
    "clock without simulated time": ("{publish_clock: true, scene: {cloth: {width: 1}}}",
                                     "publish_clock", "got true ... /use_sim_time"),
}


class BadParameters(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.program = roslib.packages.find_node("clothsim", "clothsim_node")[0]

    def run_node(self, name, parameters):
        for parameter_list, _ in rosparam.load_str(parameters, "test", "/" + name):
            if parameter_list:
                rosparam.upload_params("/" + name, parameter_list)
        return subprocess.run([self.program, "__name:=" + name], capture_output=True, text=True,
                              timeout=PATIENCE)

    def check(self, number, parameters, key, message):
        name = "bad_%d" % number
        node = self.run_node(name, parameters)
        self.assertRegex(node.stderr, says("/%s/%s: %s" % (name, key, message)))
        self.assertGreater(node.returncode, 0)


def add_tests():
    for number, (mistake, case) in enumerate(BAD.items()):
        def test(self, number=number, case=case):
            self.check(number, *case)
        setattr(BadParameters, "test_" + re.sub(r"\W", "_", mistake), test)


add_tests()

if __name__ == "__main__":
    rospy.init_node("bad_parameters_test")
    rostest.rosrun("clothsim", "bad_parameters", BadParameters)
