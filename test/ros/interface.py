#!/usr/bin/python3
import math
import os
import sys
import tempfile
import unittest
import xml.etree.ElementTree as ElementTree

import dynamic_reconfigure.client
import rospy
import rosservice
import rostest
from diagnostic_msgs.msg import DiagnosticArray
from ellipsoid_vehicle_sim.msg import ContactStates, ParameterChange
from ellipsoid_vehicle_sim.srv import ExplainContact, RestoreState, SaveState, Step
from geometry_msgs.msg import PoseWithCovarianceStamped, Twist
from nav_msgs.msg import Odometry
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import Imu, JointState
from std_srvs.srv import Trigger
from visualization_msgs.msg import MarkerArray

from sim_test_tools import Collector, Stepper, ackermann_class, publisher_of, twist, wait_until

WHEELBASE, HALF_TRACK, WHEEL_RADIUS = 2.6, 0.75, 0.35  # [m], of urdf/car.urdf
CHASSIS_MASS = 1100.0  # [kg]
GRAVITY = 9.80665
SERVICES = {"reset": "std_srvs/Trigger", "pause": "std_srvs/Trigger", "resume": "std_srvs/Trigger",
            "state_hash": "std_srvs/Trigger", "step": "ellipsoid_vehicle_sim/Step",
            "set_pose": "ellipsoid_vehicle_sim/SetPose", "save_state": "ellipsoid_vehicle_sim/SaveState",
            "restore_state": "ellipsoid_vehicle_sim/RestoreState",
            "explain_contact": "ellipsoid_vehicle_sim/ExplainContact"}
TOPICS = {"/odom": "nav_msgs/Odometry", "/ground_truth": "nav_msgs/Odometry", "/imu": "sensor_msgs/Imu",
          "/contacts": "ellipsoid_vehicle_sim/ContactStates", "/running_parameters": "ellipsoid_vehicle_sim/ParameterChange"}


def joints(**speeds):
    return JointState(name=list(speeds), velocity=list(speeds.values()))


def finite(odom):
    p, q, v = odom.pose.pose.position, odom.pose.pose.orientation, odom.twist.twist
    return all(map(math.isfinite, (p.x, p.y, p.z, q.x, q.y, q.z, q.w, v.linear.x, v.linear.y, v.linear.z, v.angular.x,
                                   v.angular.y, v.angular.z)))


class Interface(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        rospy.init_node("interface")
        cls.sim = Stepper()
        cls.topics = {name: Collector(name, kind) for name, kind in (
            ("odom", Odometry), ("ground_truth", Odometry), ("imu", Imu), ("contacts", ContactStates),
            ("joint_states", JointState), ("contact_markers", MarkerArray), ("diagnostics", DiagnosticArray),
            ("/clock", Clock))}
        cls.cmd_vel = publisher_of("cmd_vel", Twist)
        cls.joint_commands = publisher_of("joint_commands", JointState)
        cls.initialpose = publisher_of("initialpose", PoseWithCovarianceStamped)
        cls.ackermann = ackermann_class()
        cls.ackermann_cmd = publisher_of("ackermann_cmd", cls.ackermann)

    def setUp(self):
        self.assertTrue(self.sim.call("pause", Trigger).success)
        self.assertTrue(self.sim.set_pose(0.0, 0.0).success)
        for topic in self.topics.values():
            topic.clear()

    def odom(self):
        """The next odom; at most one publication away."""
        return self.topics["odom"].until(self.sim.step(20))[-1]

    def diagnostics(self):
        stamp = self.sim.step(1000)
        status = self.topics["diagnostics"].until(stamp - rospy.Duration(1.0))[-1].status[0]
        return status, {pair.key: pair.value for pair in status.values}

    def command(self, steering_angle, speed, **bounds):
        message = self.ackermann()
        message.drive.steering_angle, message.drive.speed = steering_angle, speed
        for name, value in bounds.items():
            setattr(message.drive, name, value)
        return message

    def drive(self, publisher, message, seconds):
        """The same command ten times a second."""
        for _ in range(round(10 * seconds)):
            self.sim.send(publisher, message)
            stamp = self.sim.step(100)
        return stamp

    # What there is.

    def test_types_of_topics_and_services(self):
        published = dict(rospy.get_published_topics())
        for topic, kind in TOPICS.items():
            self.assertEqual(published.get(topic), kind, topic)
        for service, kind in SERVICES.items():
            self.assertEqual(rosservice.get_service_type("/simulator/" + service), kind, service)

    def test_ackermann_definition_has_the_checksum_the_node_asks_for(self):
        # rospy works the sum out from the definition; the node would not connect to any other.
        self.assertEqual(self.ackermann._md5sum, "1fd5d7f58889cefd44d29f6653240d0c")
        self.assertGreater(self.ackermann_cmd.get_num_connections(), 0)

    def test_rates_in_simulated_time(self):
        period = rospy.Duration(0.02)
        first = self.sim.step(20)
        for name in ("odom", "ground_truth", "contacts", "joint_states", "imu", "/clock"):
            self.topics[name].until(first)
        for topic in self.topics.values():
            topic.clear()
        for _ in range(5):  # no more at once than the node's queues hold
            last = self.sim.step(200)
            self.topics["imu"].until(last)
        for name, count in (("odom", 50), ("ground_truth", 50), ("contacts", 50), ("joint_states", 50), ("imu", 100)):
            stamps = [m.header.stamp for m in self.topics[name].until(last)]
            self.assertEqual(len(stamps), count, name)
            spacing = {b - a for a, b in zip([first] + stamps, stamps)}
            self.assertEqual(spacing, {period if count == 50 else period / 2}, name)
        clock = [m.clock for m in self.topics["/clock"].until(last)]
        # rospy's own subscription to the clock keeps only the latest: what comes is in order and on whole periods.
        self.assertGreater(len(set(clock)), 5)
        self.assertEqual(clock, sorted(clock))
        wait_until(lambda: len(self.topics["contact_markers"].messages) == 20, "20 contact_markers")
        wait_until(lambda: len(self.topics["diagnostics"].messages) == 1, "one status")

    # Time.

    def test_pause_and_resume_are_idempotent_and_time_stands_between(self):
        self.assertTrue(self.sim.call("pause", Trigger).success)
        a = self.sim.step(1)
        self.assertTrue(self.sim.call("pause", Trigger).success)
        self.assertEqual(self.sim.step(1) - a, rospy.Duration(0.001))
        for _ in range(2):
            self.assertTrue(self.sim.call("resume", Trigger).success)
        self.topics["odom"].until(a + rospy.Duration(0.1))
        self.assertTrue(self.sim.call("pause", Trigger).success)

    def test_step_refuses_while_running_and_out_of_range(self):
        for steps in (0, 4000000000):
            response = self.sim.call("step", Step, steps)
            self.assertFalse(response.success)
            self.assertIn("'%d' is out of range" % steps, response.message)
        self.assertTrue(self.sim.call("resume", Trigger).success)
        response = self.sim.call("step", Step, 1)
        self.assertFalse(response.success)
        self.assertIn("call ~pause first", response.message)

    def test_the_clock_goes_on_over_reset_and_restore(self):
        state = self.sim.call("save_state", SaveState, "").state
        times = [self.sim.step(5)]
        self.assertTrue(self.sim.call("reset", Trigger).success)
        times.append(self.sim.step(5))
        self.assertTrue(self.sim.call("restore_state", RestoreState, state, "").success)
        times.append(self.sim.step(5))
        self.assertEqual([b - a for a, b in zip(times, times[1:])], [rospy.Duration(0.005)] * 2)

    # Commands.

    def test_ackermann_circle_has_the_radius_of_its_steering_angle(self):
        angle, speed = 0.3, 2.0
        stamp = self.drive(self.ackermann_cmd, self.command(angle, speed), 4.0)
        odom, imu = self.topics["odom"].until(stamp)[-1], self.topics["imu"].until(stamp)[-1]
        # The rear axle rolls on L / tan(angle); slip at 2 m/s takes less than two per cent.
        yaw_rate = speed * math.tan(angle) / WHEELBASE
        self.assertAlmostEqual(odom.twist.twist.linear.x, speed, delta=0.02 * speed)
        self.assertAlmostEqual(odom.twist.twist.angular.z, yaw_rate, delta=0.02 * yaw_rate)
        # The root link, 1.3 m ahead of it, circles about the same centre: v^2 / R sideways, and inwards along the car.
        # The body leans out of the curve: gravity has a share in its sideways axis.
        q = odom.pose.pose.orientation
        leaning = GRAVITY * 2.0 * (q.y * q.z + q.w * q.x)
        self.assertAlmostEqual(imu.linear_acceleration.y - leaning, speed * yaw_rate, delta=0.05 * speed * yaw_rate)
        self.assertAlmostEqual(imu.angular_velocity.z, odom.twist.twist.angular.z, delta=1e-3)

    def test_ackermann_bounds_are_kept(self):
        self.drive(self.ackermann_cmd, self.command(0.4, 3.0, acceleration=0.5, steering_angle_velocity=0.1), 2.0)
        odom = self.odom()
        self.assertAlmostEqual(odom.twist.twist.linear.x, 0.5 * 2.0, delta=0.1)
        names = self.topics["joint_states"].messages[-1]
        steering = [p for n, p in zip(names.name, names.position) if n.endswith("_steer")]
        self.assertAlmostEqual(sum(steering) / len(steering), 0.1 * 2.0, delta=0.02)

    def test_joint_commands_turn_wheels_and_zero_holds_them(self):
        stamp = self.drive(self.joint_commands, joints(rear_left_axle=4.0, rear_right_axle=4.0), 3.0)
        self.assertAlmostEqual(self.topics["odom"].until(stamp)[-1].twist.twist.linear.x, 4.0 * WHEEL_RADIUS, delta=0.12)  # sag and slip
        stamp = self.drive(self.joint_commands, joints(rear_left_axle=0.0, rear_right_axle=0.0), 2.0)
        self.assertAlmostEqual(self.topics["odom"].until(stamp)[-1].twist.twist.linear.x, 0.0, delta=0.01)

    def test_joint_states_tell_efforts_also_of_prescribed_joints(self):
        self.sim.send(self.ackermann_cmd, self.command(0.4, 0.0))
        stamp = self.sim.step(200)
        message = self.topics["joint_states"].until(stamp)[-1]
        effort = dict(zip(message.name, message.effort))
        # A path takes some effort to follow, and the springs carry the chassis.
        self.assertNotEqual(effort["front_left_steer"], 0.0)
        springs = sum(value for name, value in effort.items() if name.endswith("_suspension"))
        self.assertAlmostEqual(abs(springs), CHASSIS_MASS * GRAVITY, delta=0.01 * CHASSIS_MASS * GRAVITY)

    def test_a_flood_of_bad_commands_is_dropped_counted_and_harmless(self):
        before = int(self.diagnostics()[1]["dropped commands"])
        bad = self.command(0.0, math.nan), self.command(0.1, 1.0, jerk=-1.0)
        wrong = (joints(rear_left_axle=math.inf), joints(no_such_joint=1.0), JointState(name=["rear_left_axle"]),
                 JointState(name=["rear_left_axle"], velocity=[1.0, 2.0]), JointState())
        for _ in range(10):  # no more at once than the node's queues hold: it counts what it reads
            for value in (math.nan, math.inf, -math.inf):
                self.cmd_vel.publish(twist(value))
                self.cmd_vel.publish(twist(0.0, value))
            for message in bad:
                self.ackermann_cmd.publish(message)
            for message in wrong:
                self.joint_commands.publish(message)
        count = before + 10 * (6 + len(bad) + len(wrong))
        values = wait_until(lambda: (lambda v: int(v["dropped commands"]) >= count and v)(self.diagnostics()[1]),
                            "all to be counted")
        self.assertEqual(int(values["dropped commands"]), count)
        self.assertNotEqual(values["last dropped command"], "none")
        # A megabyte of names: refused by their number, before any is looked at.
        self.joint_commands.publish(joints(**{"joint_%d" % number: 1.0 for number in range(20000)}))
        wait_until(lambda: "names 20000 joints; the vehicle has " in self.diagnostics()[1]["last dropped command"], "that to be said")
        for _ in range(3000):  # far more than it can queue: it still answers, and a good command still counts
            self.cmd_vel.publish(twist(math.nan))
        self.sim.send(self.cmd_vel, twist(0.0))
        self.assertTrue(all(map(finite, self.topics["odom"].messages)))
        self.assertLess(abs(self.odom().twist.twist.linear.x), 1e-6)

    # Places.

    def test_set_pose_sets_down_where_asked_and_reset_leads_there(self):
        response = self.sim.set_pose(3.0, -2.0, 1.0)
        self.assertTrue(response.success, response.message)
        self.assertEqual(response.pose.header.frame_id, "odom")
        self.assertAlmostEqual(response.pose.pose.position.x, 3.0, delta=0.01)
        at_rest = self.sim.hash()
        self.drive(self.cmd_vel, twist(2.0), 1.0)
        self.assertTrue(self.sim.call("reset", Trigger).success)
        self.assertEqual(self.sim.hash(), at_rest)
        pose = self.odom().pose.pose
        self.assertAlmostEqual(pose.position.y, -2.0, delta=0.01)
        self.assertAlmostEqual(2.0 * math.atan2(pose.orientation.z, pose.orientation.w), 1.0, delta=0.01)

    def test_set_pose_in_the_air_falls(self):
        self.assertTrue(self.sim.set_pose(0.0, 0.0, z=5.0, settle=False).success)
        self.assertAlmostEqual(self.odom().pose.pose.position.z, 5.0, delta=0.003)
        # The centre of mass falls by g t^2 / 2; the body lags behind by no more than its suspension's way.
        stamp = self.sim.step(480)
        fallen = 5.0 - self.topics["odom"].until(stamp)[-1].pose.pose.position.z
        self.assertAlmostEqual(fallen, 0.5 * GRAVITY * 0.5 ** 2, delta=0.1)
        self.assertEqual(self.topics["contacts"].until(stamp)[-1].contacts, [])

    def test_set_pose_refuses_with_the_reason_and_changes_nothing(self):
        before = self.sim.hash()
        for reason, response in (("allowed is 'odom'", self.sim.set_pose(0.0, 0.0, frame="map")),
                                 ("no ground", self.sim.set_pose(1e5, 0.0)),
                                 ("finite", self.sim.set_pose(math.nan, 0.0))):
            self.assertFalse(response.success)
            self.assertIn(reason, response.message)
        self.assertEqual(self.sim.hash(), before)

    def test_initialpose_sets_down_in_the_odom_frame_alone(self):
        message = PoseWithCovarianceStamped()
        message.header.frame_id = "map"
        message.pose.pose.position.x, message.pose.pose.orientation.w = 7.0, 1.0
        self.initialpose.publish(message)
        message.header.frame_id = "odom"
        message.pose.pose.position.x = 4.0
        self.sim.send(self.initialpose, message)  # the first one was taken before it, and refused
        self.assertAlmostEqual(self.odom().pose.pose.position.x, 4.0, delta=0.01)

    # State.

    def test_a_restored_state_goes_on_bit_for_bit(self):
        self.drive(self.ackermann_cmd, self.command(0.2, 3.0, acceleration=2.0, jerk=5.0), 1.0)
        self.sim.step(7)
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "state")
            saved = self.sim.call("save_state", SaveState, path)
            self.assertTrue(saved.success, saved.message)
            with open(path, "rb") as file:
                self.assertEqual(file.read(), saved.state)

            def go_on():
                hashes = []
                for _ in range(20):
                    self.sim.step(49)
                    hashes.append(self.sim.hash())
                return hashes
            first = go_on()
            self.assertEqual(len(set(first)), 20)
            self.sim.set_pose(20.0, 0.0)
            restored = self.sim.call("restore_state", RestoreState, saved.state, "")
            self.assertTrue(restored.success, restored.message)
            self.assertEqual(restored.hash, saved.hash)
            self.assertEqual(go_on(), first)
            self.assertTrue(self.sim.call("restore_state", RestoreState, b"", path).success)
            self.assertEqual(go_on(), first)

    def test_restore_state_refuses_with_the_reason_and_changes_nothing(self):
        state = bytearray(self.sim.call("save_state", SaveState, "").state)
        state[len(state) // 2] ^= 4
        before = self.sim.hash()
        for reason, data, file in (("checksum is wrong", bytes(state), ""), ("is no saved state", b"nonsense", ""),
                                   ("no such file", b"", "/no/such/file"), ("either a state or a file", b"", "")):
            response = self.sim.call("restore_state", RestoreState, data, file)
            self.assertFalse(response.success)
            self.assertIn(reason, response.message)
        self.assertEqual(self.sim.hash(), before)
        response = self.sim.call("save_state", SaveState, "/no/such/folder/file")
        self.assertFalse(response.success)
        self.assertIn("/no/such/folder/file", response.message)
        # A device would be gone, and a file in its place.
        response = self.sim.call("save_state", SaveState, "/dev/null")
        self.assertFalse(response.success)
        self.assertIn("'/dev/null' cannot be written: it is no file", response.message)
        self.assertFalse(os.path.isfile("/dev/null"))

    # Contacts.

    def test_contacts_carry_the_car(self):
        contacts = self.topics["contacts"].until(self.sim.step(20))[-1]
        self.assertEqual(contacts.header.frame_id, "odom")
        self.assertEqual(sorted(c.ellipsoid for c in contacts.contacts), sorted(
            "%s_%s_wheel" % (end, side) for end in ("front", "rear") for side in ("left", "right")))
        urdf = ElementTree.fromstring(rospy.get_param("robot_description"))
        mass = sum(float(m.get("value")) for m in urdf.iter("mass"))
        self.assertAlmostEqual(sum(c.force.z for c in contacts.contacts), mass * GRAVITY, delta=0.001 * mass * GRAVITY)
        for contact in contacts.contacts:
            self.assertEqual((contact.surface, contact.sliding), ("flat", False))
            self.assertAlmostEqual(contact.normal.z, 1.0, delta=1e-9)
            self.assertAlmostEqual(contact.point.z, 0.0, delta=1e-9)
            self.assertGreater(contact.depth, 0.0)
            self.assertAlmostEqual(contact.force.z, contact.normal_force, delta=1e-6)

    def test_explain_contact(self):
        self.sim.step(20)
        response = self.sim.call("explain_contact", ExplainContact, "front_left_wheel")
        self.assertTrue(response.success, response.message)
        winners = [c for c in response.candidates if c.rank == 0]
        self.assertEqual(len(winners), 1)
        self.assertEqual((winners[0].feature, winners[0].surface), ("face", "flat"))
        self.assertEqual(winners[0].triangle, response.contacts[0].triangle)
        self.assertIn("pushes, with its face", winners[0].reason)
        self.assertGreater(response.contacts[0].normal_force, 1000.0)
        self.assertIn("sticking", response.message)
        response = self.sim.call("explain_contact", ExplainContact, "wing")
        self.assertFalse(response.success)
        self.assertIn("front_left_wheel", response.message)

    # Running parameters and diagnostics.

    def test_running_parameters_change_between_two_steps_and_are_told(self):
        changes = Collector("running_parameters", ParameterChange)
        wait_until(lambda: changes.messages, "the latched parameters")
        client = dynamic_reconfigure.client.Client("simulator", timeout=30.0)
        self.addCleanup(client.update_configuration, {"publish_rate": 50.0, "friction_scale": 1.0})
        before = self.sim.hash()
        client.update_configuration({"publish_rate": 20.0, "friction_scale": 0.5})
        self.assertNotEqual(self.sim.hash(), before)  # the friction scale is part of the state
        stamp = self.sim.step(1000)
        wait_until(lambda: dict(zip(changes.messages[-1].names, changes.messages[-1].values))["publish_rate"] == 20.0,
                   "the change")
        change = changes.messages[-1]
        self.assertEqual(dict(zip(change.names, change.values))["friction_scale"], 0.5)
        self.assertEqual(change.step, round(stamp.to_sec() * 1000) - 1000)
        stamps = [m.header.stamp for m in self.topics["odom"].until(stamp - rospy.Duration(0.05))]
        self.assertEqual({b - a for a, b in zip(stamps, stamps[1:])}, {rospy.Duration(0.05)})
        # Out of range: the server clamps to what the table allows.
        self.assertEqual(client.update_configuration({"friction_scale": -3.0})["friction_scale"], 0.0)

    def test_diagnostics_are_complete(self):
        status, values = self.diagnostics()
        self.assertEqual(status.name, "simulator: simulation")
        self.assertEqual(status.level, 0)
        for key in ("simulated time [s]", "real-time factor", "real-time factor, mean", "step time mean [us]",
                    "step time p99 [us]", "penetration [mm]", "largest penetration [mm]", "energy [J]",
                    "command age [s]", "stability margin", "friction scale", "dropped commands"):
            self.assertTrue(math.isfinite(float(values[key])), key)
        self.assertGreater(float(values["stability margin"]), 1.0)
        self.assertGreater(float(values["penetration [mm]"]), 0.0)
        self.assertEqual(float(values["command age [s]"]), -1.0)
        self.assertRegex(values["state hash"], "^0x[0-9a-f]{16}$")


if __name__ == "__main__":
    rostest.rosrun("ellipsoid_vehicle_sim", "interface", Interface, sys.argv)
