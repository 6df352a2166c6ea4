"""Shared by the tests of the node: waiting, recording topics, reading messages as arrays."""

import math
import os
import pathlib
import sys
import threading
import time
import unittest
import warnings
from xmlrpc.client import ServerProxy

import numpy as np
import rosgraph
import rospy
from diagnostic_msgs.msg import DiagnosticStatus
from geometry_msgs.msg import TransformStamped
from std_srvs.srv import SetBool, Trigger
from tf2_msgs.msg import TFMessage

from clothsim.msg import ClothState
from clothsim.srv import Step

sys.path.append(str(pathlib.Path(__file__).resolve().parent.parent))
from says import says  # noqa: E402, F401

# Long enough for a machine that is busy with other work; a test that passes never waits so long.
# scripts/sanitize sets the factor by which its programs are slower; so do the time limits of the .test files.
SLOWER = float(os.environ.get("CLOTHSIM_SLOWER", "1"))
PATIENCE = 30.0 * SLOWER

# Share of its rate below which a node has to report the reason in the diagnostics.
KEPT = 0.9

# For tests of a node that keeps up with the clock.
real_time = unittest.skipIf(SLOWER > 1, "too slow for real time")


def wait_for(condition, what):
    """The first value of condition() that is true. Waits by the computer's clock, not by ROS time."""
    end = time.monotonic() + PATIENCE
    while time.monotonic() < end:
        value = condition()
        if value:
            return value
        time.sleep(0.01)
    raise AssertionError("waited %g s for %s" % (PATIENCE, what))


def call(name, service_type, *args):
    """The answer of a service, which may not be available yet."""
    rospy.wait_for_service(name, PATIENCE)
    return rospy.ServiceProxy(name, service_type)(*args)


def publisher_at_once(topic, message_type):
    """A publisher whose publish() returns once the message is sent; rospy's publishers send it later."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # rospy's warning that there is no queue
        return rospy.Publisher(topic, message_type, queue_size=None)


class Frames:
    """Sends tf frames to the node, which has received them when send() returns."""

    def __init__(self):
        self._tf = publisher_at_once("/tf", TFMessage)
        wait_for(self.count, "the node to listen to tf")

    def count(self):
        """Nodes that listen."""
        return self._tf.get_num_connections()

    def send(self, *transforms):
        self._tf.publish(transforms)
        time.sleep(0.003)  # they come by another socket than a call


def make_transform(frame, place, angle=0.0, parent="map", stamp=None):
    """A transform to a place [m], turned about z by an angle [rad]; without a stamp its time is 0."""
    t = TransformStamped()
    t.header.stamp = stamp or rospy.Time()
    t.header.frame_id, t.child_frame_id = parent, frame
    t.transform.translation.x, t.transform.translation.y, t.transform.translation.z = place
    t.transform.rotation.z, t.transform.rotation.w = math.sin(angle / 2), math.cos(angle / 2)
    return t


def is_connected(topic, name, cloth="/clothsim"):
    """Whether a topic of the node `cloth` goes to a node with that in its name."""
    node = ServerProxy(rosgraph.Master("/test").lookupNode(cloth))
    return any(name in c[1] and c[4] == topic for c in node.getBusInfo("/test")[2])


class Recorder:
    """Keeps all messages of a topic, in order."""

    def __init__(self, topic, message_type):
        self._lock = threading.Lock()
        self._messages = []
        self._subscriber = rospy.Subscriber(topic, message_type, self._keep, queue_size=1000)

    def _keep(self, message):
        with self._lock:
            self._messages.append(message)

    def all(self):
        with self._lock:
            return list(self._messages)

    def clear(self):
        with self._lock:
            self._messages.clear()

    def wait(self, what, condition=lambda message: True):
        """The newest message for which the condition holds."""
        def newest():
            return next((m for m in reversed(self.all()) if condition(m)), None)
        return wait_for(newest, what)

    def connected(self):
        """Whether all publishers of the topic send to this node, by their own account: the node of a subscriber knows
        of a connection a moment earlier, and would miss a message in between."""
        topic = self._subscriber.resolved_name
        publishers = dict(rospy.get_master().getSystemState()[2][0]).get(topic, [])
        return bool(publishers) and all(is_connected(topic, rospy.get_name(), node) for node in publishers)

    def close(self):
        self._subscriber.unregister()


class Cloth:
    """A clothsim node: its states, and its services."""

    def __init__(self, name="/clothsim"):
        self.name = name
        self.states = Recorder(name + "/state", ClothState)

    def pause(self, paused=True):
        assert call(self.name + "/pause", SetBool, paused).success

    def reset(self):
        assert call(self.name + "/reset", Trigger).success

    def step(self, frames, targets=(), twists=()):
        """The state after `frames` frames."""
        answer = self.try_step(frames, targets, twists)
        assert answer.success, answer.message
        return answer.state

    def try_step(self, frames, targets=(), twists=()):
        return call(self.name + "/step", Step, frames, targets, twists)


def positions(state):
    """N x 3 [m]"""
    return np.asarray(state.positions, dtype=np.float32).reshape(-1, 3)


def velocities(state):
    """N x 3 [m/s]"""
    return np.asarray(state.velocities, dtype=np.float32).reshape(-1, 3)


def rate(states):
    """Rate [Hz] by the stamps, because some tests wait for a busy machine; 0 for fewer than two messages."""
    if len(states) < 2:
        return 0
    return (len(states) - 1) / (states[-1].header.stamp - states[0].header.stamp).to_sec()


def complaints(diagnostics, name="/clothsim"):
    """Statuses of a node in recorded diagnostics that are not OK."""
    return sorted({s.message for array in diagnostics for s in array.status
                   if s.name == name[1:] + ": simulation" and s.level != DiagnosticStatus.OK})


def content(state):
    """The bytes of a state that do not depend on the time of its computation."""
    return (state.step, state.time, positions(state).tobytes(), velocities(state).tobytes())


def point(p):
    return np.array([p.x, p.y, p.z])


def points(marker):
    """N x 3 [m]"""
    return np.array([[p.x, p.y, p.z] for p in marker.points])


def marker_named(array, ns):
    return next((m for m in array.markers if m.ns == ns), None)
