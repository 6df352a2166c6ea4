#!/usr/bin/python3
"""An arm picks up a towel near its front edge, weighs it, folds it, lays it down and lets go.

No point is attached: two fingers close on a ridge of the cloth, and friction holds it. The arm is
config/robots/arm.urdf. This script publishes the positions of its joints, robot_state_publisher broadcasts their tf
frames, and the links follow those. Positions are in the arm's own frame, arm_base, x ahead. The towel is ~side [m]
long, and its front edge is ~distance [m] ahead:

    roslaunch clothsim arm.launch
"""

import math
import threading

import rospy
from sensor_msgs.msg import JointState

from clothsim.msg import ClothState, Contacts

JOINTS = ("pan", "shoulder", "elbow", "wrist", "roll", "finger_a", "finger_b")
# Lengths of the arm [m]: shoulder above the ground, both long links, wrist to the tips of the fingers.
SHOULDER, UPPER_ARM, FOREARM, HAND = 0.35, 0.45, 0.45, 0.20

OPEN, CLOSED = 0.05, 0.001  # gap between the fingers [m]
RIDGE = 0.03  # distance behind the edge at which the fingers close [m]
TOUCH = 0.0015  # tips above the table [m]: half into the cloth's upper side, so that they take it along
RELEASE = 0.03  # tips above the table [m], above the layers
HANG = 0.07  # more than the towel's length, so that it hangs free [m]


def inverse_kinematics(x, y, z, between):
    """Positions of the joints, in the order of JOINTS [rad] or [m], that put the tips of downward fingers
    at a place [m], with this gap between them [m]. The blades stay perpendicular to the x axis."""
    ahead, up = math.hypot(x, y), z + HAND - SHOULDER  # of the wrist, seen from the shoulder
    cosine = (ahead**2 + up**2 - UPPER_ARM**2 - FOREARM**2) / (2 * UPPER_ARM * FOREARM)
    if abs(cosine) > 1:
        raise ValueError("the arm does not reach (%g, %g, %g)" % (x, y, z))
    pan, elbow = math.atan2(y, x), math.acos(cosine)
    shoulder = math.atan2(ahead, up) - math.atan2(FOREARM * math.sin(elbow), UPPER_ARM + FOREARM * cosine)
    return (pan, shoulder, elbow, math.pi - shoulder - elbow, pan, between / 2, between / 2)


def line(start, end):
    """Pose of the arm, (x, y, z, gap), by the share of its path."""
    return lambda share: tuple(a + share * (b - a) for a, b in zip(start, end))


def arc(start, end):
    """A quarter of an ellipse, which begins horizontally and ends vertically downwards."""
    def place(share):
        angle = share * math.pi / 2
        straight = line(start, end)
        return (straight(math.sin(angle))[0], *straight(share)[1:2], straight(1 - math.cos(angle))[2], end[3])
    return place


def moves(edge, side):
    """Two lists of (seconds, path): until the towel hangs freely, and from there until it lies folded."""
    take, lay = edge + RIDGE, edge + 0.62 * side  # x of the grasp, and of the hanging towel
    half, hung = (take, 0, side / 2, CLOSED), (lay, 0, side + HANG, CLOSED)
    lowered, back = (lay, 0, side, CLOSED), (lay - 0.6 * side, 0, 0.4 * side, CLOSED)
    over = (lay - 0.055, 0, RELEASE, CLOSED)
    far, above, down, closed = ((take, 0.3, 0.3, OPEN), (take, 0, 0.1, OPEN), (take, 0, TOUCH, OPEN),
                                (take, 0, TOUCH, CLOSED))
    opened, away = (over[0], 0, 0.05, OPEN), (over[0], 0, 0.25, OPEN)
    return ([(1.5, line(far, above)), (0.8, line(above, down)), (1.0, line(down, closed)), (1.2, line(closed, half)),
             (1.5, line(half, hung)), (2.5, line(hung, hung))],
            [(0.8, line(hung, lowered)), (2.0, line(lowered, back)), (1.6, arc(back, over)),
             (0.5, line(over, opened)), (0.8, line(opened, away)), (1.0, line(away, away))])


class Arm:
    """Moves in simulated time, and publishes its joints all the time, as a robot does."""

    def __init__(self, start):
        self.lock = threading.Lock()
        self.joints = inverse_kinematics(*start)
        self.time = 0.0  # simulated [s]
        self.frame_came = threading.Condition()
        self.publisher = rospy.Publisher("joint_states", JointState, queue_size=1)
        self.timer = rospy.Timer(rospy.Duration(0.05), self.send)
        self.states = rospy.Subscriber("clothsim/state", ClothState, self.tell, queue_size=1)

    def tell(self, state):
        with self.frame_came:
            self.time = state.time
            self.frame_came.notify()

    def send(self, _event=None):
        with self.lock:
            message = JointState(name=JOINTS, position=self.joints)
            message.header.stamp = rospy.Time.now()
            self.publisher.publish(message)

    def next_time(self):
        """Waits for the next frame and returns its simulated time [s]."""
        with self.frame_came:
            while not self.frame_came.wait(0.1):
                if rospy.is_shutdown():
                    raise rospy.ROSInterruptException
            return self.time

    def go(self, way, duration):
        """Moves along a path, with zero velocity at both ends."""
        begin, passed = self.next_time(), 0.0
        while passed < duration:
            passed = min(self.next_time() - begin, duration)
            share = passed / duration
            self.joints = inverse_kinematics(*way(share * share * (3 - 2 * share)))
            self.send()


def main():
    rospy.init_node("fold_with_arm")
    pick_up, lay_down = moves(rospy.get_param("~distance", 0.5), rospy.get_param("~side", 0.4))
    arm = Arm(pick_up[0][1](0))
    for duration, way in pick_up:
        arm.go(way, duration)
    contacts = rospy.wait_for_message("clothsim/contacts", Contacts)
    carried = sum(-c.wrench.force.z for c in contacts.colliders if c.name.startswith("arm/"))
    rospy.loginfo("the arm carries %.4f N", carried)
    for duration, way in lay_down:
        arm.go(way, duration)
    rospy.loginfo("the towel is folded")
    rospy.spin()  # keeps publishing: without the joints the tf frames would be lost
    arm.timer.shutdown()
    arm.timer.join()


if __name__ == "__main__":
    try:
        main()
    except rospy.ROSInterruptException:
        pass  # Ctrl-C
