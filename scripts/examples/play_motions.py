#!/usr/bin/python3
"""Plays the motions of the scene that a clothsim node has loaded: its key frames as tf frames, in straight lines by the
simulation's time, its attachments by the node's services, and all of them again after a reset. Velocities of key
frames, files of key frames, switches of colliders and changes of values are not played.

    roslaunch clothsim bag.launch

Parameter: ~speed (1), factor on the speed of the motions.
"""

import json
import threading
import time

import numpy as np
import rospy
import tf2_ros
from geometry_msgs.msg import Quaternion, Transform, TransformStamped, Vector3
from scipy.spatial.transform import Rotation, Slerp
from std_msgs.msg import Header

from clothsim.msg import Change, ClothState
from clothsim.srv import Attach, AttachBody, Detach, DetachBody

RATE = 90   # [Hz] of the broadcasts
WAIT = 0.2  # [s] after a start, until the node has received the first frames


class Track:
    """The key frames of one tf frame."""

    def __init__(self, entries):
        keys = sorted(entries, key=lambda entry: entry.get("time", 0))
        self.times = [key.get("time", 0) for key in keys]
        self.axes = list(zip(*(key["position"] for key in keys)))
        self.turns = Rotation.concatenate([
            Rotation.from_quat(key["orientation"]) if "orientation" in key
            else Rotation.from_euler("xyz", key.get("rpy", (0, 0, 0))) for key in keys])

    def pose(self, now):
        """Position and quaternion at the time `now` [s] of the motions."""
        now = min(max(now, self.times[0]), self.times[-1])
        turn = Slerp(self.times, self.turns)(now) if len(self.times) > 1 else self.turns[0]
        return [np.interp(now, self.times, axis) for axis in self.axes], turn.as_quat()


class Player:
    def __init__(self, motions):
        keys = [entry for entry in motions if "frame" in entry and "file" not in entry]
        self.tracks = {name: Track([key for key in keys if key["frame"] == name])
                       for name in {key["frame"] for key in keys}}
        self.events = sorted((e for e in motions if "attach" in e or "detach" in e), key=lambda e: e.get("time", 0))
        self.speed = rospy.get_param("~speed", 1.0)
        self.world = rospy.get_param("clothsim/world_frame", "map")
        self.time = 0.0  # of the motions [s]
        self.begin = None  # simulated time at which the motions begin [s]; None: they have not begun
        self.next_event = 0
        self.held = {}  # bodies by the frame that holds them
        self.started = time.monotonic()
        self.now = 0.0  # simulated time [s]
        self.stamp = rospy.Time()
        self.lock = threading.Lock()
        self.broadcaster = tf2_ros.TransformBroadcaster()
        rospy.Subscriber("clothsim/state", ClothState, self.hear, queue_size=1)
        rospy.Subscriber("clothsim/changes", Change, self.hear_change, queue_size=100)
        self.timer = rospy.Timer(rospy.Duration(1 / RATE), self.send)  # also during a service call

    def hear(self, state):
        self.now = state.time
        if self.begin is not None:
            self.time = self.speed * (state.time - self.begin)

    def hear_change(self, change):
        if change.what in ("reset", "load_scene"):  # the run restarts, with nothing attached
            self.time, self.begin, self.next_event, self.held = 0.0, None, 0, {}
            self.started = time.monotonic()

    def send(self, _event=None):
        with self.lock:
            # Listeners drop a second transform with the same stamp.
            self.stamp = max(rospy.Time.now(), self.stamp + rospy.Duration(0, 1000))
            header = Header(0, self.stamp, self.world)
            transforms = []
            for name, track in self.tracks.items():
                place, turn = track.pose(self.time)
                transforms.append(TransformStamped(header, name, Transform(Vector3(*place), Quaternion(*turn))))
            self.broadcaster.sendTransform(transforms)

    def act(self):
        """Makes the attachments that are due."""
        if self.begin is None and time.monotonic() < self.started + WAIT:
            return
        while self.next_event < len(self.events) and self.events[self.next_event].get("time", 0) <= self.time:
            event = self.events[self.next_event]
            self.next_event += 1
            for answer in self.answers(event):
                if not answer.success:
                    rospy.logwarn("%s: %s", event, answer.message)
        if self.begin is None:
            self.begin = self.now

    def answers(self, event):
        """The answers of the services that an event calls."""
        if "body" in event:
            self.held.setdefault(event["attach"], []).append(event["body"])
            yield call("attach_body", AttachBody, name=event["body"], frame=event["attach"])
        elif "attach" in event:
            values = {key: event[key] for key in ("radius", "tear_force", "strength") if key in event}
            yield call("attach", Attach, frame=event["attach"], **points_of(event), **values)
        else:
            bodies = [] if event.get("points") else self.held.pop(event["detach"], [])
            for body in bodies:
                yield call("detach_body", DetachBody, name=body)
            if not bodies:
                yield call("detach", Detach, frame=event["detach"], **points_of(event))


def points_of(event):
    """The points of an event for a service, which knows the ways to name them in a scene."""
    if not event.get("points"):
        return {}
    return {"places": json.dumps(event["points"], ensure_ascii=False), "cloth": event.get("cloth", "")}


def call(name, service_type, **arguments):
    rospy.wait_for_service("clothsim/" + name)
    return rospy.ServiceProxy("clothsim/" + name, service_type)(**arguments)


def main():
    rospy.init_node("play_motions")
    rospy.wait_for_service("clothsim/attach")
    motions = rospy.get_param("clothsim/scene/motions", [])
    if not motions:
        raise SystemExit("~scene/motions of clothsim: got none, expected some to play")
    player = Player(motions)
    rate = rospy.Rate(RATE)
    while not rospy.is_shutdown():
        player.act()
        rate.sleep()


if __name__ == "__main__":
    try:
        main()
    except rospy.ROSInterruptException:
        pass  # Ctrl-C
