#!/usr/bin/python3
import math
import sys
import unittest
import xml.etree.ElementTree as ElementTree

import rospy
import rostest
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import JointState
from std_msgs.msg import Bool
from tf2_msgs.msg import TFMessage
from visualization_msgs.msg import Marker, MarkerArray

from sim_test_tools import Commander, twist, wait_until

ODOM_MESSAGES = 50  # one simulated second
TYPES = {"/odom": "nav_msgs/Odometry", "/joint_states": "sensor_msgs/JointState", "/tf": "tf2_msgs/TFMessage",
         "/contact_markers": "visualization_msgs/MarkerArray", "/collision_shapes": "visualization_msgs/MarkerArray",
         "/world": "visualization_msgs/MarkerArray", "/clock": "rosgraph_msgs/Clock", "/ready": "std_msgs/Bool",
         "/diagnostics": "diagnostic_msgs/DiagnosticArray"}


class TopicContract(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        rospy.init_node("topic_contract")
        cls.received = {"joints": [], "tf": [], "clock": [], "contacts": [], "shapes": [], "world": [], "ready": []}
        for key, topic, kind in (("joints", "joint_states", JointState), ("tf", "/tf", TFMessage),
                                 ("clock", "/clock", Clock), ("contacts", "contact_markers", MarkerArray),
                                 ("shapes", "collision_shapes", MarkerArray), ("world", "world", MarkerArray),
                                 ("ready", "ready", Bool)):
            rospy.Subscriber(topic, kind, cls.received[key].append, queue_size=1000)
        wait_until(lambda: cls.received["shapes"] and cls.received["world"], "the latched messages")
        cls.commander = Commander()
        cls.odom = cls.commander.drive(twist(1.0), ODOM_MESSAGES)
        last = cls.odom[-1].header.stamp
        wait_until(lambda: cls.received["joints"] and cls.received["joints"][-1].header.stamp >= last, "joint_states")
        wait_until(lambda: any(t.header.stamp >= last for m in cls.received["tf"] for t in m.transforms), "tf")
        wait_until(lambda: cls.received["contacts"], "contact_markers")
        cls.urdf = ElementTree.fromstring(rospy.get_param("robot_description"))
        children = {joint.find("child").get("link") for joint in cls.urdf.iter("joint") if joint.find("child") is not None}
        cls.root = [link.get("name") for link in cls.urdf.findall("link") if link.get("name") not in children][0]

    def test_types(self):
        published = dict(rospy.get_published_topics())
        for topic, kind in TYPES.items():
            self.assertEqual(published.get(topic), kind, topic)

    def test_odom_frames(self):
        for message in self.odom:
            self.assertEqual((message.header.frame_id, message.child_frame_id), ("odom", self.root))

    def test_odom_comes_at_the_publish_rate_in_simulated_time(self):
        stamps = [message.header.stamp.to_nsec() for message in self.odom]
        self.assertEqual({b - a for a, b in zip(stamps, stamps[1:])}, {20000000})

    def test_messages_of_a_step_share_their_stamp(self):
        odom = {message.header.stamp for message in self.odom}
        joints = {message.header.stamp for message in self.received["joints"]}
        tf = {t.header.stamp for m in self.received["tf"] for t in m.transforms if t.child_frame_id == self.root}
        # The first may have been missed while subscribing.
        self.assertGreater(len(odom & joints & tf), ODOM_MESSAGES - 5)

    def test_tf_says_what_odom_says(self):
        poses = {message.header.stamp: message.pose.pose.position for message in self.odom}
        compared = 0
        for transform in (t for m in self.received["tf"] for t in m.transforms):
            if transform.child_frame_id != self.root:
                continue
            self.assertEqual(transform.header.frame_id, "odom")
            if transform.header.stamp in poses:
                position, translation = poses[transform.header.stamp], transform.transform.translation
                self.assertEqual((position.x, position.y, position.z), (translation.x, translation.y, translation.z))
                compared += 1
        self.assertGreater(compared, 0)

    def test_clock_is_never_zero_and_never_goes_back(self):
        times = [message.clock.to_nsec() for message in self.received["clock"]]
        self.assertGreater(min(times), 0)
        self.assertEqual(times, sorted(times))

    def test_joint_states_hold_every_movable_joint(self):
        movable = [j.get("name") for j in self.urdf.findall("joint") if j.get("type") != "fixed"]
        message = self.received["joints"][-1]
        self.assertEqual(sorted(message.name), sorted(movable))
        for values in (message.position, message.velocity, message.effort):
            self.assertEqual(len(values), len(message.name))
            self.assertTrue(all(math.isfinite(value) for value in values))

    def test_collision_shapes_are_ellipsoids_locked_to_links(self):
        links = {link.get("name") for link in self.urdf.findall("link")}
        for marker in self.received["shapes"][0].markers:
            self.assertEqual(marker.type, Marker.SPHERE)
            self.assertTrue(marker.frame_locked)
            self.assertIn(marker.header.frame_id, links)
            self.assertGreater(min(marker.scale.x, marker.scale.y, marker.scale.z), 0.0)
        self.assertEqual(sum(marker.ns.endswith("wheels") for marker in self.received["shapes"][0].markers), 4)

    def test_world_is_triangles_front_and_back(self):
        for marker in self.received["world"][0].markers:
            self.assertEqual((marker.type, marker.header.frame_id), (Marker.TRIANGLE_LIST, "odom"))
            self.assertEqual(len(marker.points) % 6, 0)
            self.assertEqual(len(marker.colors), len(marker.points) // 3)
            self.assertLessEqual(len(marker.colors), 100000)

    def test_wheels_stand_on_arrows_that_point_up(self):
        arrows = [m for m in self.received["contacts"][-1].markers if m.ns == "normal" and m.action == Marker.ADD]
        self.assertGreaterEqual(len(arrows), 4)
        for arrow in arrows:
            self.assertEqual((arrow.type, arrow.header.frame_id), (Marker.ARROW, "odom"))
            self.assertGreater(arrow.points[1].z, arrow.points[0].z)

    def test_ready_is_true(self):
        wait_until(lambda: self.received["ready"], "ready")
        self.assertTrue(self.received["ready"][-1].data)

    def test_use_of_simulated_time_is_set(self):
        self.assertTrue(rospy.get_param("/use_sim_time"))


if __name__ == "__main__":
    rostest.rosrun("ellipsoid_vehicle_sim", "topic_contract", TopicContract, sys.argv)
