#!/usr/bin/python3
import sys
import unittest

import rospy
import rostest
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from ellipsoid_vehicle_sim.msg import ContactStates
from geometry_msgs.msg import Twist
from nav_msgs.msg import Odometry
from sensor_msgs.msg import Imu, JointState
from visualization_msgs.msg import MarkerArray

from sim_test_tools import Collector, NodeProcess, Stepper, publisher_of, twist

UNKNOWN = 1e6  # [m^2], the variance of what is not to be believed
TOPICS = (("odom", Odometry), ("ground_truth", Odometry), ("imu", Imu), ("joint_states", JointState),
          ("contacts", ContactStates), ("contact_markers", MarkerArray), ("diagnostics", DiagnosticArray))


class Run:
    """A node that has driven for a second, and the last message of each of its topics."""
    def __init__(self, name, **parameters):
        self.node = NodeProcess(name, vehicle_file="car", world="flat", **parameters)
        sim = Stepper("/%s/simulator" % name)
        topics = {topic: Collector("/%s/%s" % (name, topic), kind) for topic, kind in TOPICS}
        sim.set_pose(0.0, 0.0)
        cmd_vel = publisher_of("/%s/cmd_vel" % name, Twist)
        for _ in range(10):
            sim.send(cmd_vel, twist(2.0))
            stamp = sim.step(round(0.1 / parameters["dt"]))
        self.last = {topic: collector.until(stamp)[-1] for topic, collector in topics.items() if topic not in
                     ("contact_markers", "diagnostics")}
        self.markers = {marker.ns for message in topics["contact_markers"].messages for marker in message.markers}
        self.node.interrupt()
        self.status = [status for message in topics["diagnostics"].messages for status in message.status]


class Marks(unittest.TestCase):
    """What a step beyond the certificate, and the estimate of the local error, leave in the messages."""
    @classmethod
    def setUpClass(cls):
        rospy.init_node("marks")
        # One after the other: both publish the clock.
        cls.steady = Run("steady", dt=0.001, error_estimate_every=1)
        cls.beyond = Run("beyond", dt=0.005, allow_unstable=True)

    def test_a_step_beyond_the_certificate_marks_every_output(self):
        last = self.beyond.last
        self.assertEqual(last["odom"].pose.covariance[0], UNKNOWN)
        self.assertEqual(last["ground_truth"].pose.covariance[0], UNKNOWN)
        self.assertEqual(last["imu"].linear_acceleration_covariance[0], -1.0)
        self.assertEqual(last["joint_states"].header.frame_id, "unstable")
        self.assertTrue(last["contacts"].unstable)
        self.assertIn("unstable", self.beyond.markers)
        self.assertTrue(self.beyond.status)
        for status in self.beyond.status:
            self.assertGreaterEqual(status.level, DiagnosticStatus.WARN)
            self.assertIn("UNSTABLE", status.message)

    def test_a_step_within_it_has_none_of_the_marks(self):
        last = self.steady.last
        for topic in ("odom", "ground_truth"):
            self.assertLess(last[topic].pose.covariance[0], 1.0)
        self.assertGreaterEqual(last["imu"].linear_acceleration_covariance[0], 0.0)
        self.assertEqual(last["joint_states"].header.frame_id, "")
        self.assertFalse(last["contacts"].unstable)
        self.assertNotIn("unstable", self.steady.markers)
        self.assertFalse([status for status in self.steady.status if "UNSTABLE" in status.message])

    def test_ground_truth_has_the_local_error_for_covariance(self):
        variance = self.steady.last["ground_truth"].pose.covariance[0]
        # A millimetre a tick would be 1 m/s of error.
        self.assertGreater(variance, 0.0)
        self.assertLess(variance, 1e-6)
        self.assertTrue([value for status in self.steady.status for value in status.values
                         if value.key.startswith("local error")])


if __name__ == "__main__":
    rostest.rosrun("ellipsoid_vehicle_sim", "marks", Marks, sys.argv)
