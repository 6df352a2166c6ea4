#!/usr/bin/python3
"""Two hands take a cloth by two corners, lift them, fold it in half and lay it down.

A hand is nothing but a tf frame. Made for config/scenes/grasp.yaml:

    roslaunch clothsim grasp.launch
"""

import math

import rospy
import tf2_ros
from geometry_msgs.msg import TransformStamped, WrenchStamped

from clothsim.srv import Attach, Detach

HANDS = {"left_hand": 0.0, "right_hand": 1.0}  # tf frame: x of its corner [m]
GRASP = 0.02  # the hands take what is this near [m]
SPEED = 0.5  # [m/s]
RATE = 90  # [Hz], as the simulation

# Where both hands go, y and z [m]: up, over the middle, down beside the far edge.
TAKE = (0.0, 0.0)
PATH = [(0.0, 0.1), (0.15, 0.4), (0.5, 0.55), (0.85, 0.4), (1.01, 0.1), (1.03, 0.04)]


class Hands:
    """Both at the same y and z. Broadcasts all the time, as a robot does, also while a call waits."""

    def __init__(self):
        self.place = TAKE
        self.broadcaster = tf2_ros.TransformBroadcaster()
        self.timer = rospy.Timer(rospy.Duration(1 / RATE), self.send)

    def send(self, _event):
        transforms = []
        for frame, x in HANDS.items():
            t = TransformStamped()
            t.header.stamp, t.header.frame_id, t.child_frame_id = rospy.Time.now(), "map", frame
            t.transform.translation.x = x
            t.transform.translation.y, t.transform.translation.z = self.place
            t.transform.rotation.w = 1
            transforms.append(t)
        self.broadcaster.sendTransform(transforms)

    def go(self, target):
        """In a straight line at SPEED."""
        start, rate = self.place, rospy.Rate(RATE)
        steps = max(1, int(math.dist(start, target) / SPEED * RATE))
        for i in range(1, steps + 1):
            self.place = tuple(a + (b - a) * i / steps for a, b in zip(start, target))
            rate.sleep()


def main():
    rospy.init_node("fold_cloth")
    rospy.wait_for_service("clothsim/attach")
    attach = rospy.ServiceProxy("clothsim/attach", Attach)
    detach = rospy.ServiceProxy("clothsim/detach", Detach)

    hands = Hands()
    rospy.sleep(1)  # the cloth comes to rest
    for frame in HANDS:
        answer = attach(frame=frame, radius=GRASP)
        if not answer.success:
            raise SystemExit(answer.message)
        rospy.loginfo("%s holds points %s", frame, list(answer.points))

    for place in PATH[:3]:
        hands.go(place)
    rospy.sleep(2)  # it hangs still
    for frame in HANDS:
        wrench = rospy.wait_for_message("clothsim/wrench/" + frame, WrenchStamped)
        rospy.loginfo("%s carries %.1f N", frame, -wrench.wrench.force.z)
    for place in PATH[3:]:
        hands.go(place)

    rospy.sleep(1)  # the fold settles
    detach()
    rospy.loginfo("the cloth is folded")
    hands.timer.shutdown()
    hands.timer.join()


if __name__ == "__main__":
    try:
        main()
    except rospy.ROSInterruptException:
        pass  # Ctrl-C
