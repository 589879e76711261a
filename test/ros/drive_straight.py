#!/usr/bin/python3
import math
import sys
import unittest

import rospy
import rostest

from sim_test_tools import Commander, twist

SPEED = 1.0  # [m/s]
DISTANCE = 10.0  # [m]
MOST_MESSAGES = 1000  # 20 s: twice what the distance takes


class DriveStraight(unittest.TestCase):
    def test_ten_metres(self):
        rospy.init_node("drive_straight")
        commander = Commander()
        start = commander.next_odom()
        commander.answer(twist(SPEED))
        q = start.pose.pose.orientation
        yaw = 2.0 * math.atan2(q.z, q.w)
        ahead = aside = 0.0
        for _ in range(MOST_MESSAGES):
            odom = commander.next_odom()
            dx = odom.pose.pose.position.x - start.pose.pose.position.x
            dy = odom.pose.pose.position.y - start.pose.pose.position.y
            ahead = math.cos(yaw) * dx + math.sin(yaw) * dy
            aside = -math.sin(yaw) * dx + math.cos(yaw) * dy
            if ahead >= DISTANCE:
                break
            commander.answer(twist(SPEED))
        self.assertGreaterEqual(ahead, DISTANCE)
        # A symmetric robot on a flat floor has no reason to turn; 1 % leaves room for the order of its contacts.
        self.assertLess(abs(aside), 0.01 * DISTANCE)
        # Child frame: forward speed is along x. Skid steering slips a little, also straight ahead.
        self.assertAlmostEqual(odom.twist.twist.linear.x, SPEED, delta=0.05)
        self.assertAlmostEqual(odom.twist.twist.linear.y, 0.0, delta=0.02)


if __name__ == "__main__":
    rostest.rosrun("ellipsoid_vehicle_sim", "drive_straight", DriveStraight, sys.argv)
