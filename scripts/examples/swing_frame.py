#!/usr/bin/python3
"""Broadcasts a tf frame that swings to and fro along an axis of the world, as a curtain's rod.

    roslaunch clothsim curtain.launch

Parameters: ~frame (rod), ~world_frame (that of clothsim), ~axis (x), ~amplitude [m] (0.15), ~period [s] (4).
"""

import math

import rospy
import tf2_ros
from geometry_msgs.msg import TransformStamped

RATE = 90  # [Hz] of the broadcasts


def main():
    rospy.init_node("swing_frame")
    world = rospy.get_param("~world_frame", rospy.get_param("clothsim/world_frame", "map"))
    axis = rospy.get_param("~axis", "x")
    if axis not in ("x", "y", "z"):
        raise SystemExit("~axis: got %s, expected x, y or z" % axis)
    amplitude, period = rospy.get_param("~amplitude", 0.15), rospy.get_param("~period", 4.0)
    if not period > 0:
        raise SystemExit("~period: got %s, expected a time above 0 [s]" % period)

    broadcaster = tf2_ros.TransformBroadcaster()
    transform = TransformStamped()
    transform.header.frame_id = world
    transform.child_frame_id = rospy.get_param("~frame", "rod")
    transform.transform.rotation.w = 1
    begin = rospy.Time()
    rate = rospy.Rate(RATE)
    while not rospy.is_shutdown():
        now = rospy.Time.now()
        if begin.is_zero():
            begin = now
        if now > transform.header.stamp:  # listeners drop a second transform of one time
            phase = 2 * math.pi * (now - begin).to_sec() / period
            # It starts at rest where the scene has the frame.
            setattr(transform.transform.translation, axis, amplitude * (1 - math.cos(phase)) / 2)
            transform.header.stamp = now
            broadcaster.sendTransform(transform)
        rate.sleep()


if __name__ == "__main__":
    try:
        main()
    except rospy.ROSInterruptException:
        pass  # Ctrl-C
