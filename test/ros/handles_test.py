#!/usr/bin/python3
"""Handles on colliders: dragged through the cloth at any speed, and never against another node."""

import math
import subprocess
import time
import unittest

import numpy as np
import rosgraph
import roslaunch.config
import roslib.packages
import rospy
import rostest
import yaml
from diagnostic_msgs.msg import DiagnosticArray
from dynamic_reconfigure.client import Client
from geometry_msgs.msg import Pose
from rosgraph_msgs.msg import Log
from tf2_msgs.msg import TFMessage
from visualization_msgs.msg import (InteractiveMarkerFeedback, InteractiveMarkerInit,
                                    InteractiveMarkerUpdate, MarkerArray)

from clothsim.msg import ClothTopology
from clothsim.srv import LoadScene
from cloth_client import PATIENCE, Cloth, Recorder, call, point, positions, wait_for

HANDLES = "/clothsim/handles"
BALL, PLATE = np.array([0.5, 0.5, 0.5]), np.array([0, 0, -1.0])  # their places in the scene [m]
RADIUS = 0.2  # of the ball [m]
FRAME = 1 / 90  # [s]


def make_pose(place, tilt=0.0):
    """A pose, turned about x by `tilt`."""
    pose = Pose()
    pose.position.x, pose.position.y, pose.position.z = place
    pose.orientation.x, pose.orientation.w = math.sin(tilt / 2), math.cos(tilt / 2)
    return pose


def same_pose(transform, pose):
    t, r, o = transform.translation, transform.rotation, pose.orientation
    return (np.allclose(point(t), point(pose.position), rtol=0, atol=1e-9)
            and np.allclose([r.x, r.y, r.z, r.w], [o.x, o.y, o.z, o.w], rtol=0, atol=1e-9))


class Shown:
    """The handles that RViz would show: poses by name."""

    def __init__(self):
        self.markers = {}
        self.full = rospy.Subscriber(HANDLES + "/update_full", InteractiveMarkerInit, self._init)
        self.updates = rospy.Subscriber(HANDLES + "/update", InteractiveMarkerUpdate, self._update,
                                        queue_size=1000)

    def _init(self, message):
        for marker in message.markers:
            self.markers.setdefault(marker.name, marker)

    def _update(self, message):
        for marker in message.markers:
            self.markers[marker.name] = marker
        for moved in message.poses:
            if moved.name in self.markers:
                self.markers[moved.name].pose = moved.pose
        for name in message.erases:
            self.markers.pop(name, None)

    def at(self, name, place):
        marker = self.markers.get(name)
        return marker and np.allclose(point(marker.pose.position), place, atol=1e-9)


class OtherNode:
    """Broadcasts the ball's frame as a user's program does. In a process of its own: two
    broadcasters in one process would have the same name."""

    def __enter__(self):
        code = ("import rospy, sys; from tf2_ros import TransformBroadcaster\n"
                "import time; from geometry_msgs.msg import TransformStamped\n"
                "rospy.init_node('mover', anonymous=True, disable_rosout=True)\n"
                "b = TransformBroadcaster(); t = TransformStamped()\n"
                "t.header.frame_id, t.child_frame_id = 'map', 'ball'\n"
                "t.transform.translation.x = 3; t.transform.rotation.w = 1\n"
                "i = 0\n"
                "while not rospy.is_shutdown():\n"
                "    i += 1; t.header.stamp = rospy.Time.now() + rospy.Duration(1e-3 * i)\n"
                "    b.sendTransform(t); time.sleep(0.02)\n")
        self.process = subprocess.Popen(["/usr/bin/python3", "-c", code])
        return self

    def __exit__(self, *_):
        self.process.kill()  # rospy may wait for itself where a signal comes as it publishes
        self.process.wait()


class HandlesNode:
    """Another node of handles, with arguments of its own."""

    def __init__(self, *arguments):
        program = roslib.packages.find_node("clothsim", "clothsim_handles")[0]
        self.process = subprocess.Popen([program, *arguments], stderr=subprocess.PIPE, text=True)

    def __enter__(self):
        return self.process

    def __exit__(self, *_):
        self.process.terminate()
        self.process.communicate()


class HandlesTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.cloth = Cloth()
        cls.shown = Shown()
        cls.markers = Recorder("/clothsim/markers", MarkerArray)
        cls.tf = Recorder("/tf", TFMessage)
        cls.diagnostics = Recorder("/diagnostics", DiagnosticArray)
        cls.log = Recorder("/rosout", Log)
        cls.feedback = rospy.Publisher(HANDLES + "/feedback", InteractiveMarkerFeedback,
                                       queue_size=100)
        wait_for(cls.cloth.states.all, "the first state")
        wait_for(cls.feedback.get_num_connections, "the handles' node")

    def send(self, name, pose, event=InteractiveMarkerFeedback.POSE_UPDATE, frame="map"):
        message = InteractiveMarkerFeedback()
        message.header.frame_id = frame
        message.client_id = "/test"
        message.marker_name = name
        message.event_type = event
        message.pose = pose
        self.feedback.publish(message)

    def drag(self, name, place, tilt=0.0):
        """Drags a handle, and computes the next frame once the cloth's node has received it."""
        self.tf.clear()
        self.markers.clear()
        self.send(name, make_pose(place, tilt))
        wait_for(lambda: any(same_pose(t.transform, make_pose(place, tilt))
                             for t in self.transforms(name)), "the frame of the handle")
        time.sleep(0.01)  # the node receives it at about the same time as the test
        return self.cloth.step(1)

    def transforms(self, name):
        """Transforms of a frame, since the last drag or clear()."""
        return [t for m in self.tf.all() for t in m.transforms if t.child_frame_id == name]

    def expect_still(self, name, place):
        """The frame is still broadcast, at one place."""
        self.tf.clear()
        wait_for(lambda: len(self.transforms(name)) >= 3, "the frame, again and again")
        for t in self.transforms(name):
            self.assertTrue(same_pose(t.transform, make_pose(place)), t)

    def ball_marker(self, state):
        """Centre of the ball as drawn in the frame of a state [m]"""
        array = self.markers.wait(
            "the markers of frame %d" % state.step,
            lambda a: a.markers[0].header.stamp == state.header.stamp)
        return point(next(m for m in array.markers if m.ns == "colliders").pose.position)

    def test_1_shown_where_the_scene_has_them(self):
        wait_for(lambda: self.shown.at("ball", BALL), "the ball's handle")
        wait_for(lambda: self.shown.at("plate", PLATE), "the plate's handle")
        self.assertEqual(set(self.shown.markers), {"ball", "plate"})  # the wall follows no frame
        ball = self.shown.markers["ball"]
        self.assertEqual(ball.header.frame_id, "map")
        self.assertTrue(ball.header.stamp.is_zero())
        self.assertGreater(ball.scale, 2 * RADIUS)
        kinds = sorted(c.interaction_mode for c in ball.controls)
        self.assertEqual(kinds, [3, 3, 3, 5, 5, 5])  # MOVE_AXIS, ROTATE_AXIS
        # Nothing is broadcast until a handle is taken.
        self.assertEqual(self.transforms("ball") + self.transforms("plate"), [])

    def test_2_dragged_through_the_cloth(self):
        """Up and down again through the middle; at 200 m/s in one frame from side to side."""
        for speed in (0.5, 5.0, 50.0, 200.0):
            self.cloth.reset()
            self.drag("ball", BALL)
            self.cloth.step(5)
            frames = max(1, round(1.5 / (speed * FRAME)))
            heights = np.linspace(0, 1.5, frames + 1)[1:121]
            nearest = []
            for height in list(heights) + list(heights[::-1]) + [0]:
                place = BALL + [0, 0, height]
                state = self.drag("ball", place)
                centre = self.ball_marker(state)
                self.assertTrue(np.allclose(centre, place, atol=1e-9), (centre, place))
                distance = np.linalg.norm(positions(state) - centre, axis=1)
                nearest.append(distance.min())
                self.assertGreaterEqual(distance.min(), RADIUS, "%g m/s" % speed)
                if len(nearest) == len(heights):  # at its highest
                    taken = positions(state)[:, 2].max() - centre[2]
            self.assertGreater(taken, 0, "%g m/s: it went past the cloth" % speed)
            if speed < 200:  # there springs pull the cloth off the ball before the frame ends
                self.assertLess(min(nearest), RADIUS + 0.01)
        wait_for(lambda: self.shown.at("ball", BALL), "the handle back where it was")

    def test_3_a_tilted_plane(self):
        self.cloth.reset()
        self.drag("plate", PLATE)
        for height in (0.2, 0.6, 0.8, 0.9):
            state = self.drag("plate", [0, 0, height], tilt=0.3)
            normal = np.array([0, -math.sin(0.3), math.cos(0.3)])
            above = (positions(state) - [0, 0, height]) @ normal
            self.assertGreaterEqual(above.min(), 0, height)
        self.drag("plate", PLATE)

    def test_4_refused(self):
        """Invalid poses: nothing is broadcast, the handle goes back."""
        self.drag("ball", BALL)
        nan = float("nan")
        for place in ([nan, 0, 0], [0, float("inf"), 0], [0, 0, 1e9]):
            self.log.clear()
            self.send("ball", make_pose(place))
            self.log.wait("a warning", lambda m: m.msg.startswith("Ignored where the handle"))
            self.expect_still("ball", BALL)
            wait_for(lambda: self.shown.at("ball", BALL), "the handle back where it was")
        self.log.clear()
        self.send("ball", make_pose([1, 1, 1]), frame="elsewhere")
        self.log.wait("a warning", lambda m: m.msg.startswith("Ignored where the handle"))
        wait_for(lambda: self.shown.at("ball", BALL), "the handle back where it was")
        # A move of the mouse that does not drag, and a handle that does not exist.
        self.send("ball", make_pose([1, 1, 1]), event=InteractiveMarkerFeedback.KEEP_ALIVE)
        self.send("cube", make_pose([1, 1, 1]))
        time.sleep(0.3)
        self.expect_still("ball", BALL)
        self.assertEqual(self.transforms("cube"), [])

    def test_5_another_node_broadcasts(self):
        self.drag("ball", BALL)
        with OtherNode():
            wait_for(lambda: "ball" not in self.shown.markers, "the handle to go")
            self.assertIn("plate", self.shown.markers)
            self.tf.clear()
            self.send("ball", make_pose(BALL))
            time.sleep(0.5)
            theirs = self.transforms("ball")
            self.assertGreater(len(theirs), 3)
            self.assertEqual({t.transform.translation.x for t in theirs}, {3.0})
            self.assertTrue(np.allclose(self.ball_marker(self.cloth.step(2)), [3, 0, 0]))
        # The other node has ended: the handle is back where that node left the frame, and works again.
        wait_for(lambda: self.shown.at("ball", [3, 0, 0]), "the handle to come back")
        state = self.drag("ball", BALL)
        self.assertTrue(np.allclose(self.ball_marker(state), BALL))
        # The node follows the handle, well after the other's last stamp.
        time.sleep(2)
        self.diagnostics.clear()
        array = self.diagnostics.wait("diagnostics", lambda a: "simulation" in a.status[0].name)
        ages = [float(v.value) for v in array.status[0].values if v.key == "tf age of ball [s]"]
        self.assertEqual(len(ages), 1)
        self.assertLess(ages[0], 0.9)
        self.assertNotIn("lost tf frame", array.status[0].message)

    def test_6_another_scene(self):
        scene = rospy.get_param("/clothsim/scene")
        rospy.set_param("/clothsim/scene/colliders", [
            {"name": "egg", "shape": "sphere", "center": [0, 0, 3], "frame": "egg"}])
        self.switch_springs()
        time.sleep(0.5)
        self.assertEqual(set(self.shown.markers), {"ball", "plate"}, "it is not loaded yet")
        self.assertTrue(call("/clothsim/load_scene", LoadScene).success)
        wait_for(lambda: self.shown.at("egg", [0, 0, 3]), "the handle of the new scene")
        wait_for(lambda: set(self.shown.markers) == {"egg"}, "the old handles to go")
        rospy.set_param("/clothsim/scene", scene)
        self.assertTrue(call("/clothsim/load_scene", LoadScene).success)
        wait_for(lambda: set(self.shown.markers) == {"ball", "plate"}, "the old handles")

    def switch_springs(self):
        topologies = Recorder("/clothsim/topology", ClothTopology)
        live = Client("/clothsim", timeout=PATIENCE)
        for shear in (False, True):
            live.update_configuration({"shear": shear})
            topologies.wait("a topology", lambda t, shear=shear: bool(t.shear) == shear)
        live.close()
        topologies.close()


class HandlesInWallTime(HandlesTest):
    """Also how the handles are launched: the same by any clock, so that one run with it is enough."""

    def test_7_comes_with_rviz(self):
        def nodes(*arguments):
            listed = subprocess.run(["roslaunch", "--nodes", "clothsim", "sphere.launch", *arguments],
                                    capture_output=True, text=True, check=True)
            return set(listed.stdout.split())
        self.assertEqual(nodes(), {"/clothsim", "/rviz", "/clothsim_handles"})
        self.assertEqual(nodes("interactive:=false"), {"/clothsim", "/rviz"})
        self.assertEqual(nodes("rviz:=false"), {"/clothsim"})
        path = roslib.packages.find_resource("clothsim", "sphere.launch")[0]
        cleared = roslaunch.config.load_config_default([path], None, verbose=False).clear_params
        self.assertLessEqual({"/clothsim/", "/clothsim_handles/"}, set(cleared))

    def test_8_the_node_they_belong_to(self):
        def serves(topic, name):
            return any(topic == entry[0] and name in entry[1]
                       for entry in rosgraph.Master("/test").getSystemState()[0])
        for name, (argument, cloth) in {
                "of_the_group": ([], "/a/clothsim"),
                "relative": (["_cloth:=b/cloth"], "/a/b/cloth"),
                "absolute": (["_cloth:=/b/cloth"], "/b/cloth")}.items():
            with HandlesNode("__ns:=/a", "__name:=" + name, *argument):
                wait_for(lambda: serves(cloth + "/handles/update", "/a/" + name),
                         "the handles of " + cloth)

    def test_9_a_bad_name(self):
        for number, (value, got) in enumerate(
                {"no name": '"no name"', "5": "5", "''": '"" (text)', "[1, 2]": "[1, 2]"}.items()):
            name = "bad_%d" % number
            rospy.set_param("/%s/cloth" % name, yaml.safe_load(value))
            with HandlesNode("__name:=" + name) as node:
                _, errors = node.communicate(timeout=PATIENCE)
            self.assertIn("/%s/cloth: got %s, expected" % (name, got), errors)
            self.assertEqual(node.returncode, 1)


if __name__ == "__main__":
    rospy.init_node("handles_test")
    rostest.rosrun("clothsim", "handles", HandlesTest if rospy.get_param("/use_sim_time") else HandlesInWallTime)
