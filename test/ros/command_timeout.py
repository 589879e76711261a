#!/usr/bin/python3
import sys
import unittest

import rospy
import rostest
from geometry_msgs.msg import Twist
from nav_msgs.msg import Odometry
from std_msgs.msg import Bool

from sim_test_tools import twist, wait_until

SPEED = 1.0  # [m/s]
TIMEOUT = 0.5  # [s] of simulated time: the parameter command_timeout's default
# Longest simulated time for slowing down from SPEED at max_deceleration, and for a message to get through on a busy machine.
BRAKING = 1.0  # [s]


class CommandTimeout(unittest.TestCase):
    def test_silence_brakes_and_the_vehicle_stays(self):
        rospy.init_node("command_timeout")
        self.odom = []
        rospy.Subscriber("odom", Odometry, self.odom.append, queue_size=1000)
        publisher = rospy.Publisher("cmd_vel", Twist, queue_size=1)
        self.assertTrue(rospy.wait_for_message("ready", Bool, 60.0).data)

        def moving():
            publisher.publish(twist(SPEED))
            return self.odom and self.odom[-1].twist.twist.linear.x > 0.9 * SPEED
        wait_until(moving, "the vehicle to move")
        silent_since = self.odom[-1].header.stamp.to_sec()

        wait_until(lambda: self.odom[-1].header.stamp.to_sec() > silent_since + TIMEOUT + BRAKING + 1.0, "time to pass")
        speeds = [(m.header.stamp.to_sec() - silent_since, m.twist.twist.linear.x) for m in self.odom]
        # The last command holds until it is too old ...
        self.assertGreater(min(v for t, v in speeds if 0.0 <= t < TIMEOUT - 0.05), 0.85 * SPEED)
        # ... then the vehicle stands.
        self.assertLess(max(abs(v) for t, v in speeds if t > TIMEOUT + BRAKING), 0.01)


if __name__ == "__main__":
    rostest.rosrun("ellipsoid_vehicle_sim", "command_timeout", CommandTimeout, sys.argv)
