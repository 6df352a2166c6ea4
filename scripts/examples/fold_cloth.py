#!/usr/bin/python3
"""Two hands take a cloth by two corners, lift them, fold it in half and lay it down.

A hand is only a tf frame. The script is made for config/scenes/grasp.yaml and towel.yaml, square cloths with a
corner at the origin. ~side [m] is the side of the cloth, by default 1:

    roslaunch clothsim grasp.launch
    roslaunch clothsim towel.launch
"""

import math
import threading

import rospy
import tf2_ros
from geometry_msgs.msg import TransformStamped, WrenchStamped

from clothsim.msg import ClothState
from clothsim.srv import Attach, Detach

HANDS = {"left_hand": 0.0, "right_hand": 1.0}  # tf frame: x of its corner, of the side
GRASP = 0.02  # radius within which a hand takes points, as a share of the side
SPEED = 0.5  # [m/s] in simulated time
RATE = 90  # [Hz] of the broadcasts at least

# Targets of both hands, y and z, as shares of the side: up, over the middle, down beside the far edge.
TAKE = (0.0, 0.0)
PATH = [(0.0, 0.1), (0.15, 0.4), (0.5, 0.55), (0.85, 0.4), (1.01, 0.1), (1.03, 0.04)]


class Hands:
    """Both hands, at the same y and z. They move in simulated time, and are broadcast all the time, as by a
    robot, also during a service call."""

    def __init__(self):
        self.world = rospy.get_param("clothsim/world_frame", "map")
        self.side = rospy.get_param("~side", 1.0)  # [m]
        self.place = TAKE
        self.stamp = rospy.Time()
        self.lock = threading.Lock()
        self.time = 0.0  # simulated [s]
        self.frame_came = threading.Condition()
        self.broadcaster = tf2_ros.TransformBroadcaster()
        self.timer = rospy.Timer(rospy.Duration(1 / RATE), self.send)
        self.states = rospy.Subscriber("clothsim/state", ClothState, self.tell, queue_size=1)

    def tell(self, state):
        with self.frame_came:
            self.time = state.time
            self.frame_came.notify()

    def send(self, _event=None):
        with self.lock:
            # Listeners drop a second transform with the same stamp.
            self.stamp = max(rospy.Time.now(), self.stamp + rospy.Duration(0, 1000))
            transforms = []
            for frame, x in HANDS.items():
                t = TransformStamped()
                t.header.stamp, t.header.frame_id, t.child_frame_id = self.stamp, self.world, frame
                y, z = self.place
                t.transform.translation.x = x * self.side
                t.transform.translation.y, t.transform.translation.z = y * self.side, z * self.side
                t.transform.rotation.w = 1
                transforms.append(t)
            self.broadcaster.sendTransform(transforms)

    def next_time(self):
        """Waits for the next frame and returns its simulated time [s]."""
        with self.frame_came:
            while not self.frame_came.wait(0.1):
                if rospy.is_shutdown():
                    raise rospy.ROSInterruptException
            return self.time

    def passed(self, duration):
        """Yields the simulated time since the call [s], frame by frame, until `duration`."""
        begin, passed = self.next_time(), 0.0
        while passed < duration:
            passed = min(self.next_time() - begin, duration)
            yield passed

    def wait(self, duration):
        for _ in self.passed(duration):
            pass

    def go(self, target):
        """Moves in a straight line at SPEED."""
        start, duration = self.place, math.dist(self.place, target) * self.side / SPEED
        for passed in self.passed(duration):
            self.place = tuple(a + (b - a) * passed / duration for a, b in zip(start, target))
            self.send()


def main():
    rospy.init_node("fold_cloth")
    rospy.wait_for_service("clothsim/attach")
    attach = rospy.ServiceProxy("clothsim/attach", Attach)
    detach = rospy.ServiceProxy("clothsim/detach", Detach)

    hands = Hands()
    hands.wait(1)  # the cloth comes to rest
    for frame in HANDS:
        answer = attach(frame=frame, radius=GRASP * hands.side)
        if not answer.success:
            raise SystemExit(answer.message)
        rospy.loginfo("%s holds points %s", frame, list(answer.points))

    for place in PATH[:3]:
        hands.go(place)
    hands.wait(2)  # the cloth hangs still
    for frame in HANDS:
        wrench = rospy.wait_for_message("clothsim/wrench/" + frame, WrenchStamped)
        rospy.loginfo("%s carries %.2f N", frame, -wrench.wrench.force.z)
    for place in PATH[3:]:
        hands.go(place)

    hands.wait(1)  # the fold settles
    detach()
    rospy.loginfo("the cloth is folded")
    hands.timer.shutdown()
    hands.timer.join()


if __name__ == "__main__":
    try:
        main()
    except rospy.ROSInterruptException:
        pass  # Ctrl-C
