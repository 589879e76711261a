#!/usr/bin/python3
import math
import struct
import sys
import unittest

import rospy
import rostest
from std_srvs.srv import Trigger

from sim_test_tools import Commander, twist

MESSAGES = 150  # three simulated seconds


def bits(odom):
    pose, velocity = odom.pose.pose, odom.twist.twist
    return struct.pack("<13d", pose.position.x, pose.position.y, pose.position.z, pose.orientation.x, pose.orientation.y,
                       pose.orientation.z, pose.orientation.w, velocity.linear.x, velocity.linear.y, velocity.linear.z,
                       velocity.angular.x, velocity.angular.y, velocity.angular.z)


class ResetReplay(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        rospy.init_node("reset_replay")
        cls.commander = Commander()
        rospy.wait_for_service("simulator/reset", 60.0)
        cls.reset = rospy.ServiceProxy("simulator/reset", Trigger)

    def drive(self):
        """A weaving drive of its own after a reset: each odom as bits, and the stamps."""
        response = self.reset()
        self.assertTrue(response.success, response.message)
        odom = []
        for i in range(MESSAGES):
            odom.append(self.commander.next_odom())
            if i + 1 < MESSAGES:  # the last one is left unanswered: the simulator waits until the next reset
                self.commander.answer(twist(3.0, 0.4 * math.sin(0.1 * i)))
        return [bits(message) for message in odom], [message.header.stamp for message in odom]

    def test_replay_is_bit_identical_and_time_goes_on(self):
        self.commander.next_odom()  # the simulator is waiting now, whatever came before
        first, first_stamps = self.drive()
        second, second_stamps = self.drive()
        self.assertGreater(len(set(first)), MESSAGES // 2)  # it did move
        self.assertEqual(first, second)
        self.assertGreater(second_stamps[0], first_stamps[-1])

    def test_reset_twice_is_as_good_as_once(self):
        for _ in range(2):
            self.assertTrue(self.reset().success)


if __name__ == "__main__":
    rostest.rosrun("ellipsoid_vehicle_sim", "reset_replay", ResetReplay, sys.argv)
