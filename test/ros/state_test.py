#!/usr/bin/python3
"""States read from the node and set again: the same bits, or a refusal that changes nothing."""

import copy
import re
import time
import unittest

import numpy as np
import rospy
import rostest
from dynamic_reconfigure.client import Client
from std_srvs.srv import Trigger
from tf2_ros import StaticTransformBroadcaster

from clothsim.srv import GetState, LoadScene, RestoreState, SaveState, SetState
from cloth_client import PATIENCE, Cloth, call, content, make_transform, positions, says, wait_for

# By then the cloth touches the ball.
FRAMES = 40
COLUMNS, N = 12, 144
PIN = 11  # carried by the frame


class State(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.cloth = Cloth()
        cls.broadcaster = StaticTransformBroadcaster()
        wait_for(cls.cloth.states.all, "the first state")

    def setUp(self):
        self.cloth.reset()

    def get(self):
        return call("/clothsim/get_state", GetState).state

    def set(self, state):
        answer = call("/clothsim/set_state", SetState, state)
        self.assertTrue(answer.success, answer.message)

    def save(self, name):
        return call("/clothsim/save_state", SaveState, name)

    def restore(self, name):
        return call("/clothsim/restore_state", RestoreState, name)

    def test_get_run_set_run(self):
        before = content(self.cloth.step(FRAMES))
        state = self.get()
        expected = content(self.cloth.step(FRAMES))
        self.cloth.states.clear()
        self.set(state)
        published = self.cloth.states.wait("the state that was set", lambda s: s.step == FRAMES)
        self.assertEqual(content(published), before)
        self.assertEqual(content(self.cloth.step(FRAMES)), expected)
        self.assertEqual(content(self.cloth.step(1))[0], 2 * FRAMES + 1)

    def test_get_changes_nothing(self):
        self.cloth.step(FRAMES)
        self.assertEqual(self.get(), self.get())
        with_get = content(self.cloth.step(5))
        self.cloth.reset()
        self.assertEqual(content(self.cloth.step(FRAMES + 5)), with_get)

    def test_state_is_the_published_one(self):
        published = self.cloth.step(FRAMES)
        state = self.get()
        self.assertEqual((state.step, state.time), (published.step, published.time))
        self.assertEqual(np.array(state.positions, np.float32).tolist(), list(published.positions))
        self.assertEqual(np.array(state.velocities, np.float32).tolist(),
                         list(published.velocities))

    def test_a_state_of_ones_own(self):
        """Without a memory: well defined, the same each time."""
        state = self.get()
        lifted = np.reshape(state.positions, (N, 3)).copy()
        free = np.ones(N, bool)
        free[[0, COLUMNS - 1]] = False
        lifted[free, 2] += 0.05
        state.positions = lifted.ravel().tolist()
        state.memory = []
        runs = []
        for _ in range(2):
            self.set(state)
            runs.append(content(self.cloth.step(FRAMES)))
        self.assertEqual(runs[0], runs[1])
        self.cloth.reset()
        self.assertNotEqual(content(self.cloth.step(FRAMES)), runs[0])

    def test_refused(self):
        self.cloth.step(FRAMES)
        good = self.get()

        def changed(field, index, value):
            bad = copy.deepcopy(good)
            values = list(getattr(bad, field))
            values[index] = value
            setattr(bad, field, values)
            return bad

        def cut(field, length):
            bad = copy.deepcopy(good)
            setattr(bad, field, getattr(bad, field)[:length])
            return bad

        late = copy.deepcopy(good)
        late.time = float("inf")
        nan = float("nan")
        for bad, message in (
                (cut("positions", -3), "state/positions: got 143 ... 144"),
                (cut("positions", -1), "state/positions: got 431 ... three"),
                (cut("velocities", 0), "state/velocities: got 0 ... 144"),
                (changed("positions", 31, nan), "state/positions/10: got ["),
                (changed("velocities", 5, float("inf")), "state/velocities/1: got ["),
                (changed("velocities", 5, -1000), "state/velocities/1: got [ ... 1000 [m/s]"),
                (changed("positions", 2, 1.1), "state/positions/0: got [0, 0, 1.1] ... [0, 0, 1]"),
                (late, "state/time: got inf"),
                (cut("memory", 5), "state/memory: got ... another cloth"),
                (cut("memory", -1), "state/memory: got"),
                (changed("memory", 9, nan), "state/memory: got nan")):
            answer = call("/clothsim/set_state", SetState, bad)
            self.assertFalse(answer.success, message)
            self.assertRegex(answer.message, says(message))
            self.assertEqual(self.get(), good, message)

    def test_a_state_that_crosses_itself(self):
        state = self.get()
        folded = np.reshape(state.positions, (N, 3)).copy()
        over = folded[:, 1] > 0.5
        folded[over, 1] = 1 - folded[over, 1]
        folded[over, 2] += 0.05 + 0.16 * np.sin(2 * np.pi * folded[over, 0]) * (0.5 - folded[over, 1])
        state.positions = folded.ravel().tolist()
        state.memory = []
        answer = call("/clothsim/set_state", SetState, state)
        self.assertTrue(answer.success)
        self.assertRegex(answer.message, r"crosses itself in \d+ pairs of triangles")

        answer = call("/clothsim/untangle", Trigger)
        self.assertTrue(answer.success, answer.message)
        self.assertRegex(answer.message, r"^[1-9]\d* pairs of triangles crossed, 0 do now$")
        answer = call("/clothsim/set_state", SetState, self.get())
        self.assertEqual((answer.success, answer.message), (True, ""))

    def test_save_run_restore_run(self):
        self.cloth.step(FRAMES)
        self.assertTrue(self.save("on the ball").success)
        expected = content(self.cloth.step(FRAMES))
        self.cloth.reset()
        self.assertTrue(self.save("start").success)
        for _ in range(2):
            self.assertTrue(self.restore("on the ball").success)
            self.assertEqual(content(self.cloth.step(FRAMES)), expected)
        self.assertTrue(self.restore("start").success)
        self.assertEqual(content(self.cloth.step(2 * FRAMES)), expected)

    def test_save_and_restore_refused(self):
        self.cloth.step(3)
        state = self.get()
        answer = self.save("")
        self.assertFalse(answer.success)
        self.assertIn("name: got nothing", answer.message)
        answer = self.restore("never saved")
        self.assertFalse(answer.success)
        self.assertIn('name: got "never saved"', answer.message)
        self.assertEqual(self.get(), state)

    def test_states_kept_have_a_limit(self):
        """In bytes, which the node counts: more than positions, velocities and memory take."""
        self.assertTrue(call("/clothsim/load_scene", LoadScene).success)  # forgets those of other tests
        state = self.get()
        numbers = len(state.positions) + len(state.velocities) + len(state.memory)
        most = 1000000 // (8 * numbers)
        kept = next(i for i in range(most + 1) if not self.save("state %02d" % i).success)
        self.assertGreater(kept, most // 4)
        answer = self.save("one more")
        self.assertRegex(answer.message, r"^state: got (\d+) bytes .*\b(\d+)\b.* ~save_limit.* 1000000$")
        one, others = map(int, re.findall(r"\d+", answer.message)[:2])
        self.assertGreater(one + others, 1000000)
        self.assertEqual(others // kept, one)  # all names have the same length
        self.assertTrue(self.save("state 00").success)
        self.assertTrue(self.restore("state 01").success)
        self.assertTrue(call("/clothsim/load_scene", LoadScene).success)
        self.assertTrue(self.save("one more").success)

    def test_long_names(self):
        self.assertTrue(self.save("n" * 255).success)
        self.assertTrue(self.restore("n" * 255).success)
        self.assertRegex(self.save("n" * 1000000).message, says("name: got ... 1000000 bytes ... most 255"))
        message = self.restore("n" * 1000000).message
        self.assertLess(len(message), 2000)
        self.assertRegex(message, "saved state$")

    def test_restore_after_other_values(self):
        """Another spring family: the saved impulses are dropped, the state is restored."""
        client = Client("/clothsim", timeout=PATIENCE)
        self.cloth.step(FRAMES)
        state = self.get()
        self.assertTrue(self.save("with shear").success)
        client.update_configuration({"shear": False})
        self.cloth.step(3)
        self.assertTrue(self.restore("with shear").success)
        restored = self.get()
        self.assertEqual(restored.positions, state.positions)
        answer = call("/clothsim/set_state", SetState, state)
        self.assertRegex(answer.message, says("state/memory: got ... another cloth"))
        client.update_configuration({"shear": True})
        self.set(state)

    def carry(self, x, wait=0.2):
        """Moves the frames of pin and ball to their start, shifted by x."""
        self.broadcaster.sendTransform([make_transform("hand", (1 - x, 0, 1)),
                                        make_transform("ball", (0.5 + x, 0.5, 0.75))])
        time.sleep(wait)

    def test_with_moving_frames(self):
        """After the frames are moved back, the same bits follow."""
        carry = self.carry
        carry(0, wait=1.0)  # until the node receives it
        self.cloth.step(20)
        carry(0.02)
        self.cloth.step(20)
        self.assertTrue(self.save("carried").success)
        carry(0.04)
        expected = content(self.cloth.step(20))
        carry(0.1)
        self.cloth.step(10)
        carry(0.02)
        self.assertTrue(self.restore("carried").success)
        carry(0.04)
        self.assertEqual(content(self.cloth.step(20)), expected)

    def test_pins_keep_their_place_in_frames(self):
        """Also after a reset, which starts at another place in the frame."""
        self.carry(0, wait=1.0)
        self.cloth.step(20)
        self.assertTrue(self.save("held").success)
        expected = content(self.cloth.step(20))
        self.carry(0.3)
        self.cloth.reset()
        self.cloth.step(1)
        self.carry(0)
        self.assertTrue(self.restore("held").success)
        self.assertEqual(content(self.cloth.step(20)), expected)

    def test_a_pin_whose_frame_jumps(self):
        """The pin travels there at ~jump_speed, and goes on so from a state saved under way."""
        self.carry(0, wait=1.0)
        self.cloth.step(2)
        self.carry(-1000)
        x = 1
        for _ in range(10):
            was, x = x, positions(self.cloth.step(1))[PIN, 0]
            self.assertGreaterEqual(x, was)  # less where its own cloth holds it back
            self.assertLessEqual(x, was + 15 / 90 + 1e-5)
        self.assertGreater(x, 2)
        self.assertTrue(self.save("on the way").success)
        expected = content(self.cloth.step(5))
        self.assertTrue(self.restore("on the way").success)
        self.assertEqual(content(self.cloth.step(5)), expected)
        # Back nearby, it arrives.
        self.carry(-2.7)
        self.cloth.step(10)
        self.assertLess(np.abs(positions(self.cloth.step(1))[PIN] - [3.7, 0, 1]).max(), 1e-6)


if __name__ == "__main__":
    rospy.init_node("state_test")
    rostest.rosrun("clothsim", "state", State)
