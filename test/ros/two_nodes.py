#!/usr/bin/python3
"""Two simulators on one master: one publishes /clock, the other follows."""
import unittest

import rospy
import rostest
from nav_msgs.msg import Odometry
from std_srvs.srv import Trigger

from sim_test_tools import Collector, publisher_of, twist, wait_until
from geometry_msgs.msg import Twist


class TwoNodesTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        rospy.init_node("two_nodes_test")
        cls.odom = {name: Collector("/%s/odom" % name, Odometry) for name in ("first", "second")}

    def call(self, name, service):
        rospy.wait_for_service("/%s/simulator/%s" % (name, service), 60.0)
        return rospy.ServiceProxy("/%s/simulator/%s" % (name, service), Trigger)()

    def test_both_have_one_time_and_each_its_own_commander(self):
        command = publisher_of("/second/cmd_vel", Twist)
        start = wait_until(lambda: self.odom["second"].messages, "odom of the second")[-1]

        def moved():
            command.publish(twist(0.5))
            rospy.rostime.wallsleep(0.02)
            last = self.odom["second"].messages[-1]
            return last.pose.pose.position.x - start.pose.pose.position.x > 0.2 and last
        last = wait_until(moved, "the second vehicle to drive")
        first = self.odom["first"].until(last.header.stamp)
        self.assertAlmostEqual(first[-1].pose.pose.position.x, first[0].pose.pose.position.x, delta=1e-3)
        self.assertEqual(last.header.frame_id, "second/odom")
        self.assertEqual(first[-1].child_frame_id, "first/base_link")

    def test_the_follower_stands_still_while_the_clock_does(self):
        self.assertTrue(self.call("first", "pause").success)
        try:
            # What is under way still comes; from then on the stamps stay.
            stamps = []

            def stands():
                stamps.append(self.odom["second"].messages[-1].header.stamp)
                rospy.rostime.wallsleep(0.1)
                return len(stamps) > 5 and len(set(stamps[-5:])) == 1
            wait_until(lambda: self.odom["second"].messages and stands(), "the second to stand still")
            before = self.call("second", "state_hash").message
            rospy.rostime.wallsleep(0.3)
            self.assertEqual(self.call("second", "state_hash").message, before)
        finally:
            self.assertTrue(self.call("first", "resume").success)
        stamp = stamps[-1] + rospy.Duration(0.5)
        self.odom["second"].until(stamp)
        self.odom["first"].until(stamp)


if __name__ == "__main__":
    rostest.rosrun("ellipsoid_vehicle_sim", "two_nodes", TwoNodesTest)
