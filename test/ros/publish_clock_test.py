#!/usr/bin/python3
"""With ~publish_clock the node is the source of time: each state advances it by one frame."""

import subprocess
import unittest

import roslib.packages
import rospy
import rostest
from rosgraph_msgs.msg import Clock
from tf2_ros import TransformBroadcaster

from clothsim.srv import Attach, Detach
from cloth_client import PATIENCE, Cloth, Recorder, call, make_transform, says

NANOSECONDS_A_FRAME = 1e9 / 90


class PublishClock(unittest.TestCase):
    def test_clock(self):
        cloth = Cloth()
        clock = Recorder("/clock", Clock)

        # The simulation runs, and no state has a stamp in the future.
        cloth.states.wait("frame 50", lambda s: s.step >= 50)
        cloth.pause()
        stamp = cloth.step(1).header.stamp
        clock.wait("the clock of the last frame", lambda c: c.clock == stamp)
        self.assertGreater(clock.all()[0].clock.to_nsec(), 0)

        # Paused: the clock stands, for late listeners, too; services answer.
        late = Recorder("/clock", Clock)
        self.assertEqual(late.wait("the clock for a late listener").clock, stamp)

        # Steps move it by the simulated time.
        after = cloth.step(90).header.stamp
        self.assertLessEqual(abs((after - stamp).to_nsec() - 90 * NANOSECONDS_A_FRAME), 1)
        clock.wait("the clock of the last frame", lambda c: c.clock == after)

        # A reset restores the cloth, not the time.
        cloth.reset()
        self.assertGreater(cloth.step(1).header.stamp, after)
        cloth.pause(False)
        cloth.states.wait("frame 20 after the reset",
                          lambda s: s.step == 20 and s.header.stamp > after)

        ticks = [message.clock for message in clock.all()]
        self.assertEqual(ticks, sorted(ticks))

        # From each state to the next it is one frame, running, by steps and over a reset.
        stamps = [s.header.stamp.to_nsec() for s in cloth.states.all()[1:]]
        self.assertGreater(len(stamps), 100)
        for before, after in zip(stamps, stamps[1:]):
            self.assertLessEqual(abs(after - before - NANOSECONDS_A_FRAME), 1)

    def test_attach_to_a_frame_that_goes_by_its_clock(self):
        """While a call waits the clock stands, and so does a broadcaster that follows it."""
        cloth = Cloth()
        cloth.states.wait("a state")
        cloth.pause(False)
        broadcaster = TransformBroadcaster()
        timer = rospy.Timer(rospy.Duration(1 / 90), lambda _: broadcaster.sendTransform(
            make_transform("hand", (0, 0, 1), stamp=rospy.Time.now())))
        before = cloth.states.all()[-1].step
        cloth.states.wait("a second with the hand", lambda s: s.step > before + 90)
        answer = call("/clothsim/attach", Attach, "hand", [1275], 0.0, 0.0, 0.0, "", "")
        timer.shutdown()
        self.assertTrue(answer.success, answer.message)
        self.assertTrue(call("/clothsim/detach", Detach, "hand", [], "", "").success)

    def test_refuses_a_second_source(self):
        Cloth().states.wait("a state of the first source")
        rospy.set_param("/second", {"publish_clock": True, "scene": {"cloth": {"width": 1}}})
        program = roslib.packages.find_node("clothsim", "clothsim_node")[0]
        second = subprocess.run([program, "__name:=second"], capture_output=True, text=True,
                                timeout=PATIENCE)
        self.assertRegex(second.stderr, says("/second/publish_clock: got true ... /clothsim publishes /clock"))
        self.assertGreater(second.returncode, 0)


if __name__ == "__main__":
    rospy.init_node("publish_clock_test")
    rostest.rosrun("clothsim", "publish_clock", PublishClock)
