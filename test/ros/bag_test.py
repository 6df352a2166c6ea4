#!/usr/bin/python3
"""A lockstep run is recorded with rosbag, and its bag replayed: the same bits, or a report of the difference."""

import os
import shutil
import signal
import subprocess
import tempfile
import time
import unittest
from concurrent.futures import ThreadPoolExecutor

import rosbag
import roslib.packages
import rospy
import rostest
from dynamic_reconfigure.client import Client
from geometry_msgs.msg import Twist, Vector3, Vector3Stamped
from tf2_msgs.msg import TFMessage

from clothsim.msg import Change
from clothsim.srv import (Attach, Detach, EnableCollider, GetState, LoadScene, RestoreState,
                          SaveState, SetState)
from cloth_client import (PATIENCE, Cloth, Recorder, call, content, is_connected, make_transform,
                          positions, publisher_at_once, wait_for)

FRAMES = 60  # by then the cloth is on the sphere
STATES, CHANGES = "/clothsim/state", "/clothsim/changes"
CORNER = 0  # where the hand is
LIVE = {"ks": 5000.0, "damping": 5.4, "gravity_x": 0.0}  # at the start


class Bag(unittest.TestCase):
    """Runs that replay to the same bits by any clock."""

    @classmethod
    def setUpClass(cls):
        cls.cloth = Cloth()
        wait_for(cls.cloth.states.all, "the first state")
        cls.tf = publisher_at_once("/tf", TFMessage)
        cls.folder = tempfile.mkdtemp()
        cls.wind = publisher_at_once("/clothsim/wind", Vector3Stamped)
        cls.changes = Recorder(CHANGES, Change)
        cls.live = Client("/clothsim", timeout=PATIENCE)
        cls.sphere = Client("/clothsim/collider/sphere", timeout=PATIENCE)
        cls.friction = cls.sphere.get_configuration(timeout=PATIENCE)["friction"]
        cls.replay_bag = roslib.packages.find_node("clothsim", "replay_bag")[0]

    @classmethod
    def tearDownClass(cls):
        shutil.rmtree(cls.folder)

    def put_sphere(self, x, height):
        self.tf.publish([make_transform("sphere", (x, 0.5, height), stamp=rospy.Time.now())])

    def record(self, name, run):
        """The bag of the messages that are published while run() runs."""
        path = os.path.join(self.folder, name + ".bag")
        recorder = subprocess.Popen(["rosbag", "record", "-O", path, STATES, CHANGES],
                                    stdout=subprocess.DEVNULL)
        for topic in (STATES, CHANGES):
            wait_for(lambda t=topic: is_connected(t, "/record"), "the recorder of " + topic)
        run()
        wait_for(lambda: os.path.exists(path + ".active"), "the bag")
        time.sleep(1)  # messages that are still under way
        recorder.send_signal(signal.SIGINT)
        recorder.wait(PATIENCE)
        wait_for(lambda: os.path.exists(path), "the bag")
        return path

    def run_lockstep(self):
        """The sphere rises and goes aside under the cloth, a step at a time."""
        self.put_sphere(0.5, 0.25)
        self.cloth.reset()
        for i in range(FRAMES // 2):
            self.put_sphere(0.5 + 0.002 * i, 0.25 + 0.004 * i)
            self.cloth.step(2)

    def run_with_targets(self):
        """~step moves the sphere, from the start on; in the end with a twist."""
        self.cloth.reset()
        for i in range(3):
            self.cloth.step(15, [make_transform("sphere", (0.5, 0.5, 0.3 + 0.03 * i), 0.2 * i)])
        target = make_transform("sphere", (0.55, 0.5, 0.3))
        self.cloth.step(FRAMES - 45, [target], [Twist(angular=Vector3(0, 0, 1))])

    def put_hand(self, x, height):
        self.tf.publish([make_transform("hand", (x, 0, height), stamp=rospy.Time.now())])

    def blow(self, x):
        """Returns when the node has received it."""
        self.changes.clear()
        self.wind.publish(Vector3Stamped(vector=Vector3(x=x)))
        self.changes.wait("the wind", lambda m: m.what == "wind" and m.wind.x == x)

    def run_with_calls(self):
        """Live values change, a wind rises, a hand takes the cloth at a corner, carries it and lets go;
        another hand is torn off; the sphere is turned off."""
        self.blow(0.0)
        self.put_sphere(0.5, 0.25)
        self.put_hand(0, 1)
        self.cloth.reset()
        self.cloth.step(10)
        self.live.update_configuration({"ks": 3000.0, "damping": 3.0})
        self.cloth.step(5)
        self.blow(3.0)
        self.cloth.step(5)
        corner = positions(self.cloth.step(1))[CORNER]
        self.put_hand(corner[0], corner[2])
        answer = call("/clothsim/attach", Attach, "hand", [], 0.01 + abs(corner[1]), 0.0, 0.0, "", "")
        self.assertIn(CORNER, answer.points, answer.message)
        for i in range(15):
            self.put_hand(corner[0] + 0.01 * i, corner[2] + 0.005 * i)
            self.cloth.step(1)
        self.assertTrue(call("/clothsim/detach", Detach, "hand", [], "", "").success)
        self.assertTrue(call("/clothsim/attach", Attach, "sphere", [2499], 0.0, 1.0, 0.0, "", "").success)
        self.cloth.step(10)
        self.assertFalse(call("/clothsim/detach", Detach, "sphere", [], "", "").success)  # it is torn off
        self.live.update_configuration({"gravity_x": 2.0})
        self.cloth.step(9)
        self.sphere.update_configuration({"friction": 0.4})
        self.assertTrue(call("/clothsim/enable_collider", EnableCollider, "sphere", False).success)
        self.cloth.step(FRAMES - 55)
        self.sphere.update_configuration({"friction": self.friction})

    def replay(self, path, *options):
        return subprocess.run([self.replay_bag, path, *options], capture_output=True, text=True,
                              timeout=2 * PATIENCE)

    @staticmethod
    def contents(path):
        with rosbag.Bag(path) as bag:
            states = [content(m) for _, m, _ in bag.read_messages(STATES)]
        start = max(i for i, state in enumerate(states[:-1]) if state[0] == 0 and states[i + 1][0] == 1)
        return states[start:start + FRAMES + 1]  # without the restored state at the end

    def repeat_run(self):
        """Its bag."""
        wait_for(lambda: self.tf.get_num_connections() == 1, "the node to listen")
        path = self.record("run", self.run_lockstep)
        recorded = self.contents(path)
        self.assertEqual([state[0] for state in recorded], list(range(FRAMES + 1)))

        # Replayed from the frames as they are now, and recorded again: the same bytes.
        answers = []
        again = self.record("again", lambda: answers.append(self.replay(path)))
        self.assertEqual((answers[0].returncode, answers[0].stderr), (0, ""))
        self.assertEqual(answers[0].stdout, "%d frames, the same bits\n" % FRAMES)
        self.assertEqual(self.contents(again), recorded)

        # A state that was published twice counts once.
        answer = self.replay(self.with_each_state_twice(path))
        self.assertEqual((answer.stdout, answer.stderr), ("%d frames, the same bits\n" % FRAMES, ""))
        return path

    def test_bag(self):
        self.repeat_run()

    def test_bag_with_targets(self):
        path = self.record("targets", self.run_with_targets)
        recorded = self.contents(path)
        self.assertEqual([state[0] for state in recorded], list(range(FRAMES + 1)))
        self.put_sphere(0.2, 0.3)  # it starts at its place in the bag
        answers = []
        again = self.record("targets_again", lambda: answers.append(self.replay(path)))
        self.assertEqual((answers[0].stdout, answers[0].stderr), ("%d frames, the same bits\n" % FRAMES, ""))
        self.assertEqual(self.contents(again), recorded)

    def repeat_calls(self):
        """Live values and attached points come from the bag, which it returns."""
        path = self.record("calls", self.run_with_calls)
        with rosbag.Bag(path) as bag:
            calls = [m.what for _, m, _ in bag.read_messages(CHANGES) if m.what != "tf"]
        self.assertEqual(calls, ["wind", "reset", "wind", "set_parameters", "wind", "attach", "detach",
                                 "attach", "set_parameters", "set_parameters", "enable_collider",
                                 "set_parameters"])
        recorded = self.contents(path)
        self.assertEqual([state[0] for state in recorded], list(range(FRAMES + 1)))

        # From another state, with other values and the hands elsewhere: the same bytes.
        self.cloth.reset()
        self.put_hand(5, 5)
        self.blow(-1.0)
        self.live.update_configuration({"ks": 700.0, "damping": 9.0, "gravity_x": -1.0})
        self.assertTrue(call("/clothsim/attach", Attach, "hand", [CORNER, 60], 0.0, 0.0, 0.0, "", "").success)
        answers = []
        again = self.record("calls_again", lambda: answers.append(self.replay(path)))
        self.assertEqual((answers[0].returncode, answers[0].stderr), (0, ""))
        self.assertEqual(answers[0].stdout, "%d frames, the same bits\n" % len(recorded[1:]))
        self.assertEqual(self.contents(again), recorded)
        self.live.update_configuration(LIVE)
        self.blow(0.0)
        return path

    def test_bag_with_calls(self):
        self.repeat_calls()

    def all_of_the_node(self):
        """The node's state, whether it runs, and its live values."""
        now = call("/clothsim/get_state", GetState)
        return (now.state.positions, now.state.velocities, now.state.step, now.paused, now.wind, now.frames,
                [client.get_configuration(timeout=PATIENCE) for client in (self.live, self.sphere)])

    def test_the_node_is_afterwards_as_it_was(self):
        path = self.record("run_to_bring_back", self.run_with_calls)
        try:
            self.cloth.reset()
            self.blow(-1.0)
            self.put_sphere(0.4, 0.3)
            self.put_hand(0, 1.1)
            self.assertTrue(call("/clothsim/attach", Attach, "hand", [CORNER], 0.0, 0.0, 0.0, "", "").success)
            self.live.update_configuration({"ks": 700.0, "damping": 9.0})
            self.cloth.step(7)
            before = self.all_of_the_node()
            answer = self.replay(path)
            self.assertEqual((answer.returncode, answer.stderr), (0, ""))
            self.assertEqual(self.all_of_the_node(), before)
            after = content(self.cloth.step(5))
            self.assertTrue(call("/clothsim/restore_state", RestoreState, "replay_bag").success)
            self.assertEqual(content(self.cloth.step(5)), after)
            # Also after a run that differs.
            before = self.all_of_the_node()
            self.assertEqual(self.replay(self.without(path, "attach")).returncode, 1)
            self.assertEqual(self.all_of_the_node(), before)
        finally:
            self.live.update_configuration(LIVE)
            self.cloth.reset()

    def with_each_state_twice(self, path):
        copy = os.path.join(self.folder, "more.bag")
        with rosbag.Bag(path) as whole, rosbag.Bag(copy, "w") as more:
            for topic, message, stamp in whole.read_messages():
                for _ in range(2 if topic == STATES else 1):
                    more.write(topic, message, stamp)
        return copy

    def without(self, path, what):
        copy = os.path.join(self.folder, "less.bag")
        with rosbag.Bag(path) as whole, rosbag.Bag(copy, "w") as less:
            for topic, message, stamp in whole.read_messages():
                if topic != CHANGES or message.what != what:
                    less.write(topic, message, stamp)
        return copy


class BagInWallTime(Bag):
    """Also replays that differ or are refused: the same by any clock, so that one run with them is enough."""

    def test_bag(self):
        path = self.repeat_run()
        with ThreadPoolExecutor() as pool:
            # It waits 10 s for the node to come: meanwhile the others.
            elsewhere = pool.submit(self.replay, self.of_another_node(path), "--node", "elsewhere")
            self.replay_otherwise(path)
            answer = elsewhere.result()
        self.assertEqual((answer.returncode, answer.stderr),
                         (1, "no node /elsewhere: nobody serves /elsewhere/step\n"))

    def replay_otherwise(self, path):
        # Another scene is detected.
        for height, code, message in (
                (1.001, 1, r"^the bag is of another scene: cloth.origin is \[0, 0, 1\] there, \[0, 0, 1.001\] in"),
                (1, 0, "^$")):
            rospy.set_param("/clothsim/scene/cloth/origin", [0, 0, height])
            self.assertTrue(call("/clothsim/load_scene", LoadScene).success)
            answer = self.replay(path)
            self.assertEqual(answer.returncode, code)
            self.assertRegex(answer.stderr, message)

        # The node's name is resolved as in ROS.
        answer = self.replay(path, "--node", "clothsim")
        self.assertEqual((answer.stdout, answer.stderr), ("%d frames, the same bits\n" % FRAMES, ""))

        # A bag without the start of a run.
        answer = self.replay(self.record("late", lambda: self.cloth.step(3)))
        self.assertEqual(answer.returncode, 1)
        self.assertIn("no ~reset on /clothsim/changes", answer.stderr)

    def test_bag_with_calls(self):
        path = self.repeat_calls()

        # Without one of the changes the states differ, and the replay reports it.
        for what, frame in (("set_parameters", 11), ("wind", 16), ("attach", 22), ("detach", 37), ("tf", 22),
                            ("enable_collider", 56)):
            answer = self.replay(self.without(path, what))
            self.assertEqual(answer.returncode, 1, what)
            self.assertRegex(answer.stderr, "^frame %d: " % frame, what)

    def test_another_scene_is_left_alone(self):
        """The node keeps its scene, a towel of a fabric with self contact, and goes on with it."""
        path = self.record("run_of_another", self.run_lockstep)
        scene = rospy.get_param("/clothsim/scene")
        try:
            self.assertTrue(
                call("/clothsim/load_scene", LoadScene, "package://clothsim/config/scenes/towel.yaml").success)
            live = Client("/clothsim", timeout=PATIENCE)
            values, state = live.get_configuration(timeout=PATIENCE), call("/clothsim/get_state", GetState)
            changes = Recorder(CHANGES, Change)
            wait_for(changes.connected, "the node's changes")
            answer = self.replay(path)
            self.assertEqual(answer.returncode, 1)
            self.assertRegex(answer.stderr, "^the bag is of another scene: cloth.* in the node\n$")
            self.assertEqual(live.get_configuration(), values)
            self.assertEqual(call("/clothsim/get_state", GetState), state)
            self.assertEqual(changes.all(), [])
            changes.close()
            live.close()
        finally:
            rospy.delete_param("/clothsim/scene")
            rospy.set_param("/clothsim/scene", scene)
            self.assertTrue(call("/clothsim/load_scene", LoadScene).success)

    def test_files_that_are_no_bags(self):
        missing = os.path.join(self.folder, "missing.bag")
        answer = self.replay(missing)
        self.assertEqual((answer.returncode, answer.stderr),
                         (1, "cannot read %s: No such file or directory\n" % missing))
        for name, content in (("empty.bag", ""), ("text.bag", "no bag\n")):
            path = os.path.join(self.folder, name)
            with open(path, "w", encoding="ascii") as file:
                file.write(content)
            answer = self.replay(path)
            self.assertEqual(answer.returncode, 1, name)
            self.assertRegex(answer.stderr, "^cannot read .*%s: .*\n$" % name)

    def of_another_node(self, path):
        copy = os.path.join(self.folder, "other.bag")
        with rosbag.Bag(path) as whole, rosbag.Bag(copy, "w") as other:
            for topic, message, stamp in whole.read_messages():
                other.write(topic.replace("/clothsim/", "/elsewhere/"), message, stamp)
        return copy

    def test_calls_that_are_not_repeated(self):
        state = call("/clothsim/get_state", GetState).state
        for name, args in (("set_state", (SetState, state)), ("restore_state", (RestoreState, "a")),
                           ("load_scene", (LoadScene,))):
            def run(name=name, args=args):
                self.cloth.reset()
                self.cloth.step(3)
                self.assertTrue(call("/clothsim/save_state", SaveState, "a").success)
                answer = call("/clothsim/" + name, *args)
                self.assertTrue(answer.success, answer.message)
            answer = self.replay(self.record(name, run))
            self.assertEqual(answer.returncode, 1)
            self.assertEqual(answer.stderr, "frame 3: ~%s was called, which is not repeated\n" % name)

    def test_a_call_that_is_refused_is_no_change(self):
        changes = Recorder(CHANGES, Change)
        wait_for(changes.connected, "the node's changes")
        self.cloth.reset()
        self.assertFalse(call("/clothsim/attach", Attach, "nowhere", [0], 0.0, 0.0, 0.0, "", "").success)
        self.assertFalse(call("/clothsim/detach", Detach, "", [], "", "").success)
        self.assertFalse(call("/clothsim/restore_state", RestoreState, "never saved").success)
        self.live.update_configuration({"ks": -1.0})
        self.live.update_configuration(LIVE)
        wait_for(lambda: len(changes.all()) >= 2, "the calls that were not refused")
        self.assertEqual([m.what for m in changes.all()], ["reset", "set_parameters"])
        self.assertEqual([m.step for m in changes.all()][1:], [0])
        changes.close()


if __name__ == "__main__":
    rospy.init_node("bag_test")
    rostest.rosrun("clothsim", "bag", Bag if rospy.get_param("/use_sim_time") else BagInWallTime)
