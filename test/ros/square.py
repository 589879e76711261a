#!/usr/bin/python3
import math
import sys
import unittest

import rospy
import rostest

from controller_test_tools import odom_of_run, same_motion

SECONDS = 30.0  # the square of 4 x 14 m at 2 m/s, corners cut
SIDE, NEAR = 14.0, 4.0  # [m], the defaults of scripts/square_driver
CORNERS = [(SIDE, 0.0), (SIDE, SIDE), (0.0, SIDE), (0.0, 0.0)]


class Square(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        rospy.init_node("square_test")
        cls.first = odom_of_run("square.launch", SECONDS)
        cls.second = odom_of_run("square.launch", SECONDS)
        cls.path = [(m.pose.pose.position.x, m.pose.pose.position.y) for _, m in sorted(cls.first.items())]

    def test_comes_near_the_corners_in_their_order(self):
        left = list(CORNERS)
        for x, y in self.path:
            if left and math.hypot(x - left[0][0], y - left[0][1]) < NEAR:
                left.pop(0)
        self.assertEqual(left, [])

    def test_stays_on_the_sides_but_for_the_turns(self):
        # A turn of radius v / yaw rate = 2 / 0.5 m, begun 4 m before the corner, at right angles: outside of the square it
        # comes by no more than that radius less the 4 m, 0 m; the car's steering takes 0.6 rad / (2 rad/s) to get there.
        outside = max(max(-x, x - SIDE, -y, y - SIDE) for x, y in self.path)
        self.assertLess(outside, 2.0 * 0.3 + 0.2)

    def test_two_runs_in_lockstep_are_the_same_to_the_last_bit(self):
        same_motion(self, self.first, self.second)


if __name__ == "__main__":
    rostest.rosrun("ellipsoid_vehicle_sim", "square", Square, sys.argv)
