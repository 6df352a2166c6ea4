#!/usr/bin/python3
"""Under use_sim_time the simulation follows /clock: it waits for it, stops and goes on with it."""

import time
import unittest

import rospy
import rostest
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from dynamic_reconfigure.client import Client
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import Image
from tf2_ros import StaticTransformBroadcaster

from clothsim.srv import Attach, Detach
from cloth_client import (PATIENCE, Cloth, Recorder, call, make_transform, positions, real_time,
                          wait_for)

FRAME = 1 / 90  # [s]
TICK = 0.01  # of the clock [s]


class SimTime(unittest.TestCase):
    def setUp(self):
        self.cloth = Cloth()
        self.clock = rospy.Publisher("/clock", Clock, queue_size=1000)

    def run_clock(self, begin, end):
        """Ticks from begin to end [s], each once the node has finished the one before."""
        self.cloth.states.clear()
        for tick in range(round(begin / TICK), round(end / TICK) + 1):
            now = tick * TICK
            self.clock.publish(Clock(rospy.Time.from_sec(now)))
            time.sleep(0.002)
            if now > begin + 0.1:  # past the first ticks, some of which may be lost
                wait_for(lambda: self.behind(now) < 2 * FRAME, "the frames up to %g s" % now)

    def behind(self, now):
        states = self.cloth.states.all()
        return now - states[-1].header.stamp.to_sec() if states else now

    def newest(self):
        return self.cloth.states.all()[-1]

    def settled(self):
        """The newest state, once no more are published."""
        time.sleep(0.5)
        return self.newest()

    @real_time
    def test_follows_the_clock(self):
        # No time yet: no frame, but the services answer.
        diagnostics = Recorder("/diagnostics", DiagnosticArray)
        diagnostics.wait("the word that there is no time", lambda a: any(
            s.level == DiagnosticStatus.WARN and "waits for /clock" in s.message for s in a.status))
        diagnostics.close()
        wait_for(lambda: self.clock.get_num_connections() >= 2, "the clock's subscribers")
        self.assertEqual(self.cloth.states.wait("the start").step, 0)
        self.cloth.pause()
        self.assertEqual(self.cloth.step(2).step, 2)
        self.frames_and_live_values_without_time()
        self.cloth.reset()
        self.cloth.pause(False)
        self.assertEqual(self.settled().step, 0)

        # The clock starts, late and slow: a frame for each 1/90 s of it.
        self.run_clock(100, 102)
        self.cloth.states.wait("the frames of two seconds", lambda s: s.step >= 175)
        stopped = self.settled()
        self.assertLessEqual(stopped.step, 2 / FRAME)
        self.assertGreater(stopped.header.stamp.to_sec(), 102 - 2 * FRAME)
        self.assertLessEqual(stopped.header.stamp.to_sec(), 102)

        # The clock stands, and so does the cloth. Services answer, diagnostics come.
        diagnostics = Recorder("/diagnostics", DiagnosticArray)
        diagnostics.wait("diagnostics while the clock stands")
        self.assertEqual(self.settled().step, stopped.step)
        self.images_while_the_clock_stands(stopped.header.stamp)
        self.cloth.pause(False)

        # The clock goes on.
        self.run_clock(102, 103)
        self.cloth.states.wait("frames of the third second", lambda s: s.step > stopped.step + 80)

        # The clock goes on from an earlier time, as when a bag starts again.
        before = self.settled().step
        self.run_clock(50, 51)
        again = self.cloth.states.wait("frames after the jump back",
                                       lambda s: s.step > before + 80)
        self.assertLess(again.header.stamp.to_sec(), 51.001)

        # The clock goes on from a later time: no frame for the time in between.
        before = self.settled().step
        diagnostics = Recorder("/diagnostics", DiagnosticArray)
        wait_for(diagnostics.connected, "the diagnostics")
        self.run_clock(3600, 3601)
        frames = self.settled().step - before
        time.sleep(1)  # time for a report of a factor of 0.00 over the hour
        told = [s.message for a in diagnostics.all() for s in a.status if s.level == DiagnosticStatus.ERROR]
        self.assertEqual([message for message in told if "real-time factor 0.0" in message], [])
        diagnostics.close()
        self.assertGreater(frames, 80)
        self.assertLess(frames, 95)

    def images_while_the_clock_stands(self, stamp):
        """A new subscriber gets an image, and so does a change of look. They show the last frame."""
        images = Recorder("/clothsim/camera/color/image_raw", Image)
        before = images.wait("the image for a new subscriber")
        look = Client("/clothsim/shading/cloth", timeout=PATIENCE)
        look.update_configuration({"shader": "normal"})
        after = images.wait("the image of another look", lambda i: i.data != before.data)
        self.assertEqual((before.header.stamp, after.header.stamp), (stamp, stamp))
        look.close()
        images.close()

    def frames_and_live_values_without_time(self):
        """Paused, and no time: tf frames are followed, timers run and live values change."""
        hand = make_transform("hand", (0.5, 0, 1))
        broadcaster = StaticTransformBroadcaster()
        broadcaster.sendTransform(hand)  # the node waits for a frame that has not been broadcast yet
        answer = call("/clothsim/attach", Attach, "hand", [1275], 0.0, 0.0, 0.0, "", "")
        self.assertTrue(answer.success, answer.message)
        before = positions(self.cloth.step(1))[1275]
        hand.transform.translation.z += 0.01
        broadcaster.sendTransform(hand)
        time.sleep(0.2)
        lifted = positions(self.cloth.step(1))[1275]
        self.assertAlmostEqual(lifted[2] - before[2], 0.01, delta=1e-6)
        self.assertTrue(call("/clothsim/detach", Detach, "hand", [], "", "").success)

        # The image of a step's last frame comes.
        images = Recorder("/clothsim/camera/color/image_raw", Image)
        wait_for(images.connected, "the images")
        images.wait("the image for a new subscriber")
        images.clear()
        self.cloth.step(2)
        images.wait("the image of the last frame")
        images.close()

        client = Client("/clothsim", timeout=PATIENCE)
        self.assertEqual(client.update_configuration({"damping": 6.0})["damping"], 6.0)
        client.update_configuration({"damping": 5.4})
        diagnostics = Recorder("/diagnostics", DiagnosticArray)
        for _ in range(2):
            diagnostics.clear()
            diagnostics.wait("diagnostics without time")


if __name__ == "__main__":
    rospy.init_node("sim_time_test")
    rostest.rosrun("clothsim", "sim_time", SimTime)
