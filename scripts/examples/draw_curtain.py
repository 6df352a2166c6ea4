#!/usr/bin/python3
"""Draws a curtain together on its rod, so that it falls in pleats, and slides it to and fro.

Each ring is a tf frame that a pin of the scene follows. The rings move by the simulation's time:

    roslaunch clothsim curtain.launch

Parameters: ~gathered (0.6), final width of the curtain as a share of its width; ~depth [m] (0.025), distance of
every other ring before and behind the rod then; ~amplitude [m] (0.15) and ~period [s] (5) of the slide.
"""

import math

import rospy
import tf2_ros
from geometry_msgs.msg import Quaternion, Transform, TransformStamped, Vector3
from std_msgs.msg import Header

from clothsim.msg import ClothState

RATE = 90      # [Hz] of the broadcasts
WAIT = 0.5     # [s] at the start, so that the node receives the rings' initial frames
GATHERING = 2  # [s] until the curtain is drawn together


def ease(share):
    """Maps the share of a motion's time to 0 to 1, with zero velocity at both ends."""
    return (1 - math.cos(math.pi * min(max(share, 0.0), 1.0))) / 2


class Rings:
    def __init__(self):
        cloth = rospy.get_param("clothsim/scene/cloth")
        cell = cloth["width"] / (cloth["columns"] - 1)
        pins = [pin for pin in cloth["pinned"] if isinstance(pin, dict) and "frame" in pin]
        if not pins:
            raise SystemExit("~scene/cloth/pinned of clothsim: got no pin with a frame, expected the rings")
        # Position of each ring along the rod, from its middle [m].
        self.places = {pin["frame"]: pin["point"][0] * cell - cloth["width"] / 2 for pin in pins}
        self.gathered = rospy.get_param("~gathered", 0.6)
        self.depth = rospy.get_param("~depth", 0.025)
        self.amplitude = rospy.get_param("~amplitude", 0.15)
        self.period = rospy.get_param("~period", 5.0)
        self.world = rospy.get_param("~world_frame", rospy.get_param("clothsim/world_frame", "map"))
        self.time = 0.0                                       # of the simulation [s]
        self.start = {frame: (0.0, 0.0) for frame in self.places}  # x and y at the start of the run [m]
        rospy.Subscriber("clothsim/state", ClothState, self.hear, queue_size=1)

    def hear(self, state):
        if state.time < self.time:  # the run restarts, with the rings at their present places
            self.start = {frame: self.place(frame) for frame in self.places}
        self.time = state.time

    def place(self, frame):
        """x and y of a ring's frame [m]."""
        moving = self.time - WAIT
        drawn = ease(moving / GATHERING)
        swing = 0.0
        if moving > GATHERING:
            swing = self.amplitude * math.sin(2 * math.pi * (moving - GATHERING) / self.period)
        side = 1 if list(self.places).index(frame) % 2 else -1
        x, y = self.start[frame]
        return (x - drawn * (1 - self.gathered) * self.places[frame] + swing,
                y + drawn * self.depth * side)

    def transforms(self, stamp):
        for frame in self.places:
            pose = Transform(Vector3(*self.place(frame), 0), Quaternion(w=1))
            yield TransformStamped(Header(0, stamp, self.world), frame, pose)


def main():
    rospy.init_node("draw_curtain")
    rospy.wait_for_service("clothsim/reset")  # the node has set its parameters before
    rings = Rings()
    broadcaster = tf2_ros.TransformBroadcaster()
    last = rospy.Time()
    rate = rospy.Rate(RATE)
    while not rospy.is_shutdown():
        now = rospy.Time.now()
        if now > last:  # listeners drop a second transform with the same stamp
            broadcaster.sendTransform(list(rings.transforms(now)))
            last = now
        rate.sleep()


if __name__ == "__main__":
    try:
        main()
    except rospy.ROSInterruptException:
        pass  # Ctrl-C
