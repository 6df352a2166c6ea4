#!/usr/bin/python3
"""In a namespace: RViz, started there with our configuration, subscribes to existing topics."""

import os
import unittest

import roslib.packages
import rosgraph.names
import rospy
import rostest
import tf2_ros
import yaml

from cloth_client import wait_for

# Topics of the displays in our configuration.
TYPES = {"clothsim/Cloth": "clothsim/ClothState",
         "rviz/MarkerArray": "visualization_msgs/MarkerArray",
         "rviz/InteractiveMarkers": "visualization_msgs/InteractiveMarkerUpdate",
         "rviz/PointCloud2": "sensor_msgs/PointCloud2",
         "rviz/Image": "sensor_msgs/Image"}


class Namespace(unittest.TestCase):
    def test_rviz_finds_its_topics(self):
        path = os.path.join(roslib.packages.get_pkg_dir("clothsim"), "config/rviz/clothsim.rviz")
        with open(path) as file:
            displays = yaml.safe_load(file)["Visualization Manager"]["Displays"]
        wanted = {(rosgraph.names.resolve_name(display[key], "/left/rviz"), TYPES[display["Class"]])
                  for display in displays for key in display if key.endswith("Topic")}
        self.assertEqual(len(wanted), len(TYPES))
        wait_for(lambda: wanted <= {tuple(topic) for topic in rospy.get_published_topics()},
                 "the topics %s" % sorted(wanted))

    def test_rviz_finds_its_fixed_frame(self):
        """From the start, before anybody has driven a collider or subscribed to an image."""
        buffer = tf2_ros.Buffer()
        listener = tf2_ros.TransformListener(buffer)
        wait_for(lambda: buffer.can_transform("map", "left_clothsim_camera_optical", rospy.Time(0)),
                 "the world frame")
        listener.unregister()


if __name__ == "__main__":
    rospy.init_node("namespace_test")
    rostest.rosrun("clothsim", "namespace", Namespace)
