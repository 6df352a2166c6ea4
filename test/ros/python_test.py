#!/usr/bin/python3
"""The simulator in this process and in the node: the same bits, and states from one to the other."""

import pathlib
import unittest

import numpy as np
import rospy
import rostest

import clothsim
from clothsim.srv import GetState, SetState
from cloth_client import Cloth, call, wait_for

SCENE = pathlib.Path(__file__).with_name("state_scene.yaml")
FRAMES = 40  # by then the cloth touches the ball


class Python(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.cloth = Cloth()
        wait_for(cls.cloth.states.all, "the first state")

    def setUp(self):
        self.cloth.reset()
        self.simulator = clothsim.Simulator(SCENE)

    def get(self):
        return call("/clothsim/get_state", GetState).state

    def expect_same(self):
        state = self.get()
        self.assertTrue(np.array_equal(np.reshape(state.positions, (-1, 3)),
                                       self.simulator.positions))
        self.assertTrue(np.array_equal(np.reshape(state.velocities, (-1, 3)),
                                       self.simulator.velocities))
        self.assertEqual(state.time, self.simulator.time)
        self.assertTrue(np.array_equal(state.memory, self.simulator.memory))

    def test_both_compute_the_same(self):
        for frames in (1, FRAMES):
            self.cloth.step(frames)
            report = self.simulator.step(frames)
            self.expect_same()
        self.assertGreater(report.contacts, 0)

    def test_a_state_of_the_node_goes_on_here(self):
        self.cloth.step(FRAMES)
        state = self.get()
        self.simulator.set_state(np.reshape(state.positions, (-1, 3)),
                                 np.reshape(state.velocities, (-1, 3)), state.time, state.memory)
        self.cloth.step(FRAMES)
        self.simulator.step(FRAMES)
        self.expect_same()

    def test_a_state_from_here_goes_on_in_the_node(self):
        self.simulator.step(FRAMES)
        state = self.get()
        state.positions = self.simulator.positions.ravel().tolist()
        state.velocities = self.simulator.velocities.ravel().tolist()
        state.time = self.simulator.time
        state.memory = self.simulator.memory.tolist()
        answer = call("/clothsim/set_state", SetState, state)
        self.assertTrue(answer.success, answer.message)
        self.simulator.step(FRAMES)
        self.cloth.step(FRAMES)
        self.expect_same()


if __name__ == "__main__":
    rospy.init_node("python_test")
    rostest.rosrun("clothsim", "python", Python)
