#!/usr/bin/python3
"""Several vehicles in one node: name spaces, frames, spawn and remove, vehicles that touch, saved states."""
import unittest

import rospy
import rostest
from diagnostic_msgs.msg import DiagnosticArray
from ellipsoid_vehicle_sim.msg import ContactStates
from ellipsoid_vehicle_sim.srv import Remove, RestoreState, SaveState, SetPose, SetPoseRequest, Spawn
from geometry_msgs.msg import Twist
from nav_msgs.msg import Odometry
from std_srvs.srv import Trigger
from tf2_msgs.msg import TFMessage
from visualization_msgs.msg import Marker, MarkerArray

from sim_test_tools import Collector, NodeProcess, Stepper, publisher_of, twist, wait_until

PERIOD = 20  # ticks between two odom messages


def topics_of(name):
    return {topic for topic, _ in rospy.get_published_topics("/" + name)}


class FleetTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        rospy.init_node("fleet_test")
        cls.sim = Stepper()

    def setUp(self):
        self.assertTrue(self.sim.call("reset", Trigger).success)

    def remove_if_there(self, name):
        self.sim.call("remove", Remove, name)

    def spawn(self, name, **fields):
        self.addCleanup(self.remove_if_there, name)
        return self.sim.call("spawn", Spawn, name=name, **fields)

    def test_each_vehicle_has_its_own_topics_and_obeys_its_own_commands(self):
        odom = {name: Collector(name + "/odom", Odometry) for name in ("red", "blue")}
        command = publisher_of("red/cmd_vel", Twist)
        publisher_of("blue/cmd_vel", Twist)
        start = self.sim.step(PERIOD)
        first = {name: collector.until(start)[-1].pose.pose.position for name, collector in odom.items()}
        for _ in range(50):
            command.publish(twist(2.0))
            end = self.sim.step(PERIOD)
        last = {name: collector.until(end)[-1] for name, collector in odom.items()}
        self.assertGreater(last["red"].pose.pose.position.x - first["red"].x, 0.5)
        self.assertAlmostEqual(last["blue"].pose.pose.position.x, first["blue"].x, delta=1e-3)
        self.assertEqual(last["red"].header.frame_id, "red/odom")
        self.assertEqual(last["red"].child_frame_id, "red/base_link")
        self.assertEqual(last["blue"].child_frame_id, "blue/base_link")

    def test_tf_is_one_tree_with_a_branch_for_each(self):
        tf = Collector.__new__(Collector)
        tf.messages, tf.topic = [], "/tf"
        tf._subscriber = rospy.Subscriber("/tf", TFMessage, tf.messages.append, queue_size=1000)
        wait_until(lambda: tf._subscriber.get_num_connections() > 0, "a publisher of tf")
        self.sim.step(2 * PERIOD)
        parents = {}

        def complete():
            for message in list(tf.messages):
                for transform in message.transforms:
                    parents.setdefault(transform.child_frame_id, set()).add(transform.header.frame_id)
            return "red/base_link" in parents and "blue/base_link" in parents
        wait_until(complete, "both vehicles' frames")
        self.assertTrue(all(len(of) == 1 for of in parents.values()), parents)
        for name in ("red", "blue"):
            self.assertEqual(parents[name + "/odom"], {"map"})
            self.assertEqual(parents[name + "/base_link"], {name + "/odom"})
        frames = [frame for frame in parents if "/" not in frame]
        self.assertEqual(frames, [], "every frame is under a vehicle's name")
        self.assertGreater(len([frame for frame in parents if frame.startswith("red/")]), 6, "links too")
        self.assertTrue(rospy.has_param("/red/robot_description") and rospy.has_param("/blue/robot_description"))

    def test_services_of_one_leave_the_other_alone(self):
        self.sim.step(PERIOD)
        blue = self.sim.call("blue/state_hash", Trigger).message
        request = SetPoseRequest(settle=True)
        request.pose.pose.position.x, request.pose.pose.orientation.w = -5.0, 1.0
        self.assertTrue(self.sim.call("red/set_pose", SetPose, request).success)
        self.assertEqual(self.sim.call("blue/state_hash", Trigger).message, blue)
        self.assertTrue(self.sim.call("red/reset", Trigger).success)
        request.pose.pose.position.x = 7.5
        answer = self.sim.call("red/set_pose", SetPose, request)
        self.assertFalse(answer.success)
        self.assertIn("would stand in vehicle 'blue'", answer.message)
        # Back there for the other tests.
        request.pose.pose.position.x = 0.0
        self.assertTrue(self.sim.call("red/set_pose", SetPose, request).success)

    def test_vehicles_that_drive_into_each_other_say_so_in_contacts(self):
        contacts = {name: Collector(name + "/contacts", ContactStates) for name in ("red", "blue")}
        command = publisher_of("red/cmd_vel", Twist)
        touching = None
        for _ in range(400):
            command.publish(twist(4.0))
            end = self.sim.step(PERIOD)
            message = contacts["red"].until(end)[-1]
            touching = [contact for contact in message.contacts if contact.other_vehicle]
            if touching:
                break
        self.assertTrue(touching, "they never met")
        self.assertEqual(touching[0].other_vehicle, "blue")
        self.assertEqual(touching[0].triangle, -1)
        self.assertTrue(touching[0].other_ellipsoid)
        theirs = [c for c in contacts["blue"].until(end)[-1].contacts if c.other_vehicle]
        self.assertEqual(theirs[0].other_vehicle, "red")
        self.assertAlmostEqual(theirs[0].force.x, -touching[0].force.x)
        self.assertAlmostEqual(theirs[0].normal_force, touching[0].normal_force)
        # Everything of it is in a saved state.
        saved = self.sim.call("save_state", SaveState, "")
        self.assertTrue(saved.success, saved.message)
        self.sim.step(100)
        later = self.sim.hash()
        answer = self.sim.call("restore_state", RestoreState, saved.state, "")
        self.assertTrue(answer.success, answer.message)
        self.assertEqual(answer.hash, saved.hash)
        self.sim.step(100)
        self.assertEqual(self.sim.hash(), later)

    def test_a_vehicle_comes_and_goes(self):
        answer = self.spawn("green", vehicle="car", x=0.0, y=10.0, yaw=1.0, parameters="max_speed: 2.0\nodom_frame: odometry")
        self.assertTrue(answer.success, answer.message)
        odom = Collector("green/odom", Odometry)
        markers = Collector("green/contact_markers", MarkerArray)
        shapes = Collector("green/collision_shapes", MarkerArray)
        command = publisher_of("green/cmd_vel", Twist)
        command.publish(twist(1.0))
        end = self.sim.step(5 * PERIOD)
        message = odom.until(end)[-1]
        self.assertAlmostEqual(message.pose.pose.position.y, 10.0, delta=0.1)
        self.assertEqual(message.header.frame_id, "green/odometry")
        self.assertIn("/green/odom", topics_of("green"))
        wait_until(lambda: shapes.messages, "collision shapes")
        self.assertTrue(all(m.header.frame_id.startswith("green/") for m in shapes.messages[0].markers))

        self.assertTrue(self.sim.call("remove", Remove, "green").success)
        for collector in (markers, shapes):
            wait_until(lambda c=collector: c.messages and c.messages[-1].markers[0].action == Marker.DELETEALL,
                       "the markers of the vehicle to be deleted")
        del odom.messages[:]
        wait_until(lambda: "/green/odom" not in topics_of("green"), "the topics to go")
        self.sim.step(5 * PERIOD)
        self.assertEqual(odom.messages, [])
        self.assertFalse(rospy.has_param("/green/robot_description"))
        # The name is free again, also for a text.
        urdf = rospy.get_param("/blue/robot_description")
        answer = self.spawn("green", urdf=urdf, x=0.0, y=-10.0)
        self.assertTrue(answer.success, answer.message)

    def test_what_cannot_be_spawned_or_removed_is_refused_with_the_reason(self):
        before = self.sim.hash()
        for fields, reason in (({"name": "red"}, "is taken already"),
                               ({"name": ""}, "is empty"),
                               ({"name": "a/b"}, "is no name of ROS"),
                               ({"name": "9x"}, "is no name of ROS"),
                               ({"name": "world"}, "is the name of a parameter"),
                               ({"name": "green", "vehicle": "tank"}, "tank"),
                               ({"name": "green", "urdf": "<robot"}, "URDF"),
                               ({"name": "green", "x": 0.3}, "would stand in vehicle 'red'"),
                               ({"name": "green", "x": 1e6}, "green"),
                               ({"name": "green", "x": float("nan")}, "finite"),
                               ({"name": "green", "y": 9.0, "parameters": "max_sped: 1"}, "max_sped"),
                               ({"name": "green", "y": 9.0, "parameters": "dt: 0.002"}, "step 0.002 s"),
                               ({"name": "green", "y": 9.0, "parameters": "lockstep: true"}, "whole node"),
                               ({"name": "green", "y": 9.0, "parameters": "[1"}, "YAML")):
            answer = self.sim.call("spawn", Spawn, **fields)
            self.assertFalse(answer.success, fields)
            if reason != "green":
                self.assertIn(reason, answer.message, fields)
            self.assertTrue(answer.message)
        answer = self.sim.call("remove", Remove, "green")
        self.assertFalse(answer.success)
        self.assertIn("red, blue", answer.message)
        self.assertEqual(self.sim.hash(), before)

    def test_diagnostics_tell_of_each(self):
        diagnostics = Collector("diagnostics", DiagnosticArray)
        message = diagnostics.until(self.sim.step(1000))[-1]
        self.assertEqual([status.name for status in message.status],
                         ["simulator red: simulation", "simulator blue: simulation"])
        self.assertEqual(message.status[0].hardware_id, "red/base_link")

    def test_a_start_with_wrong_names_or_in_one_place_is_refused(self):
        for parameters, reason in (({"vehicles": ["a", "a"]}, "'a' is taken already"),
                                   ({"vehicles": ["a b"]}, "'a b' is no name of ROS"),
                                   ({"vehicles": ["a", "b"]}, "would stand in vehicle 'a'"),
                                   ({"vehicles": ["a", "b"], "b": {"clock": "wall"}}, "~b/clock: is one for the whole node"),
                                   ({"vehicles": ["a", "b"], "integrator": "rk4_events",
                                     "b": {"start": [9, 0, 0], "integrator": "rk4"}},
                                    "has the integrator rk4, allowed is that of 'a', which is there already: rk4_events")):
            node = NodeProcess("refused", vehicle_file="car", world="flat", clock="follow", **parameters)
            self.addCleanup(node.kill)
            self.assertEqual(node.exit_code(), 1, node.output)
            self.assertIn(reason, node.output)


if __name__ == "__main__":
    rostest.rosrun("ellipsoid_vehicle_sim", "fleet", FleetTest)
