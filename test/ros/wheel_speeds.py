#!/usr/bin/python3
import sys
import unittest

import rospy
import rostest
from sensor_msgs.msg import JointState

from controller_test_tools import odom_of_run, same_motion

SECONDS = 6.0
WHEELS = ["front_left_axle", "front_right_axle", "rear_left_axle", "rear_right_axle"]
# Both poles of the loop are at 4 1/s (wheel_speeds.launch): after 4 s the error is (1 + 16) e^-16 of the step, 2e-6; what is
# left is what integral action against friction that is not linear leaves.
SETTLED = 4.0  # [s]
LARGEST_ERROR = 0.005  # of the speed asked for


class WheelSpeeds(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        rospy.init_node("wheel_speeds_test")
        cls.states = {}
        rospy.Subscriber("/joint_states", JointState, lambda m: cls.states.setdefault(m.header.stamp.to_nsec(), m),
                         queue_size=10000, tcp_nodelay=True)
        cls.straight = cls.run_with([6.0] * 4)

    @classmethod
    def run_with(cls, speeds):
        cls.states.clear()
        odom = odom_of_run("wheel_speeds.launch", SECONDS, "speeds:=%s" % speeds)
        return odom, dict(cls.states)

    def settled_speeds(self, states, wheel):
        return [m.velocity[m.name.index(wheel)] for stamp, m in states.items() if stamp > 1e9 * SETTLED]

    def test_wheels_turn_as_asked_straight_on_and_so_does_the_robot_drive(self):
        odom, states = self.straight
        for wheel in WHEELS:
            speeds = self.settled_speeds(states, wheel)
            self.assertGreater(len(speeds), 80)
            self.assertLess(max(abs(speed - 6.0) for speed in speeds), 6.0 * LARGEST_ERROR)
        # Rolling: 6 rad/s x 0.165 m, less a permille of slip at most: nothing brakes it.
        self.assertAlmostEqual(odom[max(odom)].twist.twist.linear.x, 6.0 * 0.165, delta=0.01)

    def test_wheels_turn_as_asked_against_the_friction_of_a_skidding_turn(self):
        asked = [3.0, 6.0, 3.0, 6.0]
        odom, states = self.run_with(asked)
        for wheel, speed in zip(WHEELS, asked):
            self.assertLess(max(abs(s - speed) for s in self.settled_speeds(states, wheel)), speed * LARGEST_ERROR)
        self.assertGreater(odom[max(odom)].twist.twist.angular.z, 0.1)

    def test_two_runs_in_lockstep_are_the_same_to_the_last_bit(self):
        same_motion(self, self.straight[0], self.run_with([6.0] * 4)[0])


if __name__ == "__main__":
    rostest.rosrun("ellipsoid_vehicle_sim", "wheel_speeds", WheelSpeeds, sys.argv)
