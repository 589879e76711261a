#!/usr/bin/python3
"""A hand on the interactive marker of place_vehicle, without RViz: the messages that RViz sends."""
import math
import sys
import unittest

import rospy
import rostest
from nav_msgs.msg import Odometry
from visualization_msgs.msg import InteractiveMarkerFeedback, InteractiveMarkerInit

from sim_test_tools import wait_until

TOPIC = "/place_vehicle/"


class PlaceVehicle(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        rospy.init_node("place_vehicle_test")
        cls.odom, cls.markers = [], []
        rospy.Subscriber("/odom", Odometry, cls.odom.append, queue_size=1000)
        rospy.Subscriber(TOPIC + "update_full", InteractiveMarkerInit, cls.markers.append, queue_size=10)
        cls.hand = rospy.Publisher(TOPIC + "feedback", InteractiveMarkerFeedback, queue_size=10)
        wait_until(lambda: cls.odom and cls.markers and cls.markers[-1].markers and cls.hand.get_num_connections(),
                   "the marker")
        # For a second after it has made a marker the server takes no feedback of a client that is new to it.
        first = cls.odom[-1].header.stamp
        wait_until(lambda: (cls.odom[-1].header.stamp - first).to_sec() > 1.5, "1.5 s to pass")

    def drag_to(self, x, y, yaw):
        for event in (InteractiveMarkerFeedback.MOUSE_DOWN, InteractiveMarkerFeedback.POSE_UPDATE,
                      InteractiveMarkerFeedback.MOUSE_UP):
            message = InteractiveMarkerFeedback(client_id="test", marker_name="vehicle", control_name="carry", event_type=event)
            message.header.frame_id = "odom"
            message.pose.position.x, message.pose.position.y, message.pose.position.z = x, y, 3.0
            message.pose.orientation.z, message.pose.orientation.w = math.sin(0.5 * yaw), math.cos(0.5 * yaw)
            self.hand.publish(message)

    def test_1_marker_is_a_handle_and_a_ring_around_the_vehicle(self):
        marker = self.markers[-1].markers[0]
        self.assertEqual([control.name for control in marker.controls], ["carry", "turn"])
        # Its box is as high as the car's ellipsoids reach: from the ground 0.35 m below base_link to the roof at 0.98 m.
        heights = [point.z for shape in marker.controls[0].markers for point in shape.points]
        self.assertAlmostEqual(min(heights), -0.35, delta=0.02)

    def test_2_vehicle_is_set_down_where_it_is_let_go(self):
        self.drag_to(10.0, -5.0, 1.0)
        wait_until(lambda: abs(self.odom[-1].pose.pose.position.x - 10.0) < 1e-3, "the vehicle to be at x = 10 m")
        pose = self.odom[-1].pose.pose
        self.assertAlmostEqual(pose.position.y, -5.0, delta=1e-3)
        self.assertAlmostEqual(pose.position.z, 0.35, delta=0.05)  # on its wheels, not where the hand was
        self.assertAlmostEqual(2.0 * math.atan2(pose.orientation.z, pose.orientation.w), 1.0, delta=1e-3)

    def test_3_where_there_is_no_ground_it_stays_and_the_marker_says_why(self):
        before = self.odom[-1].pose.pose.position
        self.drag_to(1e4, 0.0, 0.0)
        wait_until(lambda: "not here" in self.markers[-1].markers[0].description, "the marker to say why")
        self.assertAlmostEqual(self.odom[-1].pose.pose.position.x, before.x, delta=1e-3)


if __name__ == "__main__":
    rostest.rosrun("ellipsoid_vehicle_sim", "place_vehicle_test", PlaceVehicle, sys.argv)
