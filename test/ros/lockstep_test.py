#!/usr/bin/python3
"""Pause, ~step and ~reset: the frames that are computed, and that they are the same each time."""

import time
import unittest

import numpy as np
import rospy
import rostest
from std_srvs.srv import SetBool

from clothsim.srv import GetState
from cloth_client import PATIENCE, Cloth, call, content, real_time, says, wait_for

# The cloth is on the sphere by then, so contact and friction are part of the comparison.
FRAMES = 60


class Lockstep(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.cloth = Cloth()
        wait_for(cls.cloth.states.all, "the first state")

    def setUp(self):
        self.cloth.pause()
        now = rospy.Time.now()
        self.cloth.reset()
        # After this one, no state of the test before is under way.
        self.cloth.states.wait("the start", lambda s: s.header.stamp >= now)
        self.cloth.states.clear()

    def run_frames(self, *counts):
        """Contents of the states after each call, from the scene's start."""
        self.cloth.reset()
        return [content(self.cloth.step(count)) for count in counts]

    def test_same_bits_after_reset(self):
        first = self.run_frames(FRAMES)[-1]
        self.assertEqual(first, self.run_frames(FRAMES)[-1])

    def test_same_bits_however_the_frames_are_split(self):
        whole = self.run_frames(FRAMES)[-1]
        self.assertEqual(whole, self.run_frames(1, 2, FRAMES - 3)[-1])

    def test_same_bits_after_running_free(self):
        first = self.run_frames(FRAMES)[-1]
        self.cloth.pause(False)
        self.cloth.states.clear()
        self.cloth.states.wait("a state of the running simulation", lambda s: s.step > FRAMES + 10)
        self.cloth.pause()
        self.assertEqual(first, self.run_frames(FRAMES)[-1])

    def test_running_free_computes_the_same_frames(self):
        self.cloth.states.clear()
        self.cloth.pause(False)
        free = self.cloth.states.wait("frame 20", lambda s: s.step >= 20)
        self.cloth.pause()
        self.assertEqual(content(free), self.run_frames(free.step)[-1])

    def test_every_frame_is_published_before_the_answer(self):
        self.cloth.states.clear()
        last = self.cloth.step(40)
        wait_for(lambda: [s for s in self.cloth.states.all() if s.step == 40], "frame 40")
        published = [s for s in self.cloth.states.all() if s.step > 0]
        self.assertEqual([s.step for s in published], list(range(1, 41)))
        self.assertEqual(content(published[-1]), content(last))
        self.assertEqual(published[-1].header.stamp, last.header.stamp)

    def test_time_and_step_count(self):
        self.assertEqual(self.cloth.step(1).step, 1)
        state = self.cloth.step(44)
        self.assertEqual(state.step, 45)
        self.assertAlmostEqual(state.time, 0.5, delta=1e-9)  # 45 frames at 90 Hz

    def test_reset_publishes_the_start(self):
        self.cloth.step(5)
        self.cloth.states.clear()
        self.cloth.reset()
        start = self.cloth.states.wait("the state after a reset", lambda s: s.step == 0)
        self.assertEqual(start.time, 0)
        self.assertEqual(set(start.velocities), {0})

    def test_pause_stops_and_resume_goes_on(self):
        self.cloth.pause(False)
        self.cloth.states.wait("frame 10", lambda s: s.step >= 10)
        self.cloth.pause()
        stopped_at = self.cloth.step(1).step
        time.sleep(0.5)
        self.assertEqual(self.cloth.step(1).step, stopped_at + 1)
        self.cloth.pause(False)
        self.cloth.states.wait("more frames", lambda s: s.step > stopped_at + 10)

    def test_resume_while_it_runs_changes_nothing(self):
        """Calls come far more often than frames, and frames still come."""
        resume = rospy.ServiceProxy("/clothsim/pause", SetBool, persistent=True)

        def runs_on():
            self.assertTrue(resume(False).success)
            return self.cloth.states.all() and self.cloth.states.all()[-1].step >= 20
        end = time.monotonic() + PATIENCE
        while not runs_on():
            self.assertLess(time.monotonic(), end, "no frames")
        resume.close()

    @real_time
    def test_stamps_rise_evenly(self):
        self.cloth.pause(False)
        self.cloth.states.wait("frame 30", lambda s: s.step >= 30)
        self.cloth.states.clear()
        self.cloth.states.wait("frame 60", lambda s: s.step >= 60)
        states = self.cloth.states.all()
        gaps = np.array([(b.header.stamp - a.header.stamp).to_sec() for a, b in zip(states, states[1:])])
        even = np.abs(gaps - 1 / 90) < 1e-8
        self.assertGreater(np.count_nonzero(even), len(gaps) / 2)
        # Where the computer was too busy to catch up, the stamps begin again from now.
        self.assertGreater(gaps[~even].min(initial=1), 5 / 90)

    def test_refused(self):
        self.cloth.step(3)
        before = call("/clothsim/get_state", GetState).state
        for frames in (0, 1000001, 2**32 - 1):
            answer = self.cloth.try_step(frames)
            self.assertFalse(answer.success)
            self.assertRegex(answer.message, says("frames: got %d ... 1 to 1000000" % frames))
        self.assertEqual(call("/clothsim/get_state", GetState).state, before)

        # While it runs: the frames go on one by one.
        self.cloth.states.clear()
        self.cloth.pause(False)
        answer = self.cloth.try_step(1000)
        self.assertFalse(answer.success)
        self.assertIn("pause", answer.message)
        self.cloth.states.wait("frames", lambda s: s.step > 10)
        steps = [s.step for s in self.cloth.states.all()]
        self.assertEqual(steps, list(range(4, 4 + len(steps))))


if __name__ == "__main__":
    rospy.init_node("lockstep_test")
    rostest.rosrun("clothsim", "lockstep", Lockstep)
