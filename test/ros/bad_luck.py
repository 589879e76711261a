#!/usr/bin/python3
import math
import os
import sys
import tempfile
import unittest

import rospy
import rostest
from geometry_msgs.msg import Twist
from nav_msgs.msg import Odometry
from rosgraph_msgs.msg import Clock
from std_msgs.msg import Bool

from sim_test_tools import Commander, NodeProcess, twist, wait_until

NEEDED = {"vehicle_file": "skid_steer", "world": "flat"}


class BadLuck(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        rospy.init_node("bad_luck")
        cls.count = 0

    def start(self, **parameters):
        """The node in a name space of its own: process and name space."""
        type(self).count += 1
        name = "luck_%d" % self.count
        node = NodeProcess(name, **dict(NEEDED, **parameters))
        self.addCleanup(node.kill)
        return node, "/%s/" % name

    def ready(self, node, namespace):
        def told():
            if node.process.poll() is not None:
                raise AssertionError("ended early:\n" + node.output)
            return seen
        seen = []
        rospy.Subscriber(namespace + "ready", Bool, seen.append)
        wait_until(told, "ready")

    def test_interrupt_ends_within_a_second_with_exit_code_0(self):
        node, namespace = self.start()
        self.ready(node, namespace)
        code, seconds = node.interrupt()
        self.assertEqual(code, 0, node.output)
        self.assertLess(seconds, 1.0)

    def test_interrupt_while_waiting_for_a_command_ends_within_a_second(self):
        node, namespace = self.start(lockstep=True)
        self.ready(node, namespace)
        code, seconds = node.interrupt()
        self.assertEqual(code, 0, node.output)
        self.assertLess(seconds, 1.0)

    def test_lockstep_without_commander_names_the_topic(self):
        node, namespace = self.start(lockstep=True, lockstep_timeout=0.5)
        self.assertEqual(node.exit_code(), 3, node.output)
        self.assertIn("no command on '%scmd_vel'" % namespace, node.output)

    def test_second_source_of_time_is_refused(self):
        clock = rospy.Publisher("/clock", Clock, queue_size=1)
        try:
            node, _ = self.start()
            self.assertEqual(node.exit_code(), 1, node.output)
            self.assertIn("/bad_luck publishes /clock already", node.output)
        finally:
            clock.unregister()

    def test_own_clock_without_use_sim_time_is_refused_with_the_remedy(self):
        rospy.set_param("/use_sim_time", False)
        try:
            node, _ = self.start()
            self.assertEqual(node.exit_code(), 1, node.output)
            self.assertIn("rosparam set /use_sim_time true", node.output)
        finally:
            rospy.set_param("/use_sim_time", True)

    def test_commands_that_are_not_finite_are_dropped(self):
        node, namespace = self.start(lockstep=True, real_time_factor=0.0)
        commander = Commander(namespace)
        for bad in (math.nan, math.inf, -math.inf):
            commander.answer(twist(bad))
            commander.answer(twist(0.5, bad))
        # Only the good commands count as answers, so the simulator keeps step with them.
        odom = commander.drive(twist(0.5), 100)
        for message in odom:
            self.assertTrue(math.isfinite(message.pose.pose.position.x))
            self.assertTrue(math.isfinite(message.twist.twist.linear.x))
        self.assertGreater(odom[-1].twist.twist.linear.x, 0.3)
        wait_until(lambda: "not finite was dropped" in node.output, "the warning")

    def test_duration_ends_the_run_and_leaves_a_report(self):
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "summary")
            node, _ = self.start(duration=2.0, real_time_factor=0.0, summary_file=path)
            self.assertEqual(node.exit_code(), 0, node.output)
            with open(path) as file:
                lines = file.read().splitlines()
        self.assertEqual(lines[0], "simulated time: 2.000 s")
        self.assertEqual([line.split(":")[0] for line in lines],
                         ["simulated time", "distance", "real-time factor", "step time mean", "step time p99",
                          "largest penetration", "most contacts", "result"])
        self.assertEqual(lines[-1], "result: ok")

    def test_parked_vehicle_stays_where_it_is(self):
        node, namespace = self.start(real_time_factor=0.0)
        odom = []
        rospy.Subscriber(namespace + "odom", Odometry, odom.append, queue_size=10000)
        rospy.Publisher(namespace + "cmd_vel", Twist, queue_size=1)
        wait_until(lambda: odom and odom[-1].header.stamp.to_sec() > odom[0].header.stamp.to_sec() + 10.0, "10 s to pass")
        # A micrometre: far below what a creeping friction law loses in ten seconds.
        self.assertLess(abs(odom[-1].pose.pose.position.x - odom[0].pose.pose.position.x), 1e-6)
        self.assertLess(abs(odom[-1].pose.pose.position.y - odom[0].pose.pose.position.y), 1e-6)


if __name__ == "__main__":
    rostest.rosrun("ellipsoid_vehicle_sim", "bad_luck", BadLuck, sys.argv)
