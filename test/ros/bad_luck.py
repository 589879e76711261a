#!/usr/bin/python3
import math
import os
import signal
import sys
import tempfile
import threading
import time
import unittest

import rospy
import rostest
from ellipsoid_vehicle_sim.srv import Spawn, Step
from geometry_msgs.msg import Twist
from nav_msgs.msg import Odometry
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import JointState
from std_msgs.msg import Bool
from std_srvs.srv import Empty, Trigger

from sim_test_tools import (Collector, Commander, NodeProcess, Stepper, ackermann_class, publisher_of, twist, wait_until)

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
        self.assertIn("no command on '%scmd_vel' (0 publishers)" % namespace, node.output)

    def test_lockstep_on_two_topics_waits_for_both_and_names_the_one_that_is_missing(self):
        node, namespace = self.start(vehicle_file="car", lockstep=True, real_time_factor=0.0, lockstep_timeout=5.0,
                                     lockstep_topics=["ackermann_cmd", "joint_commands"])
        ackermann = ackermann_class()
        steer = publisher_of(namespace + "ackermann_cmd", ackermann)
        turn = publisher_of(namespace + "joint_commands", JointState)
        odom = Collector(namespace + "odom", Odometry)
        command = ackermann()
        command.drive.speed, command.drive.steering_angle = 1.0, 0.2
        for i in range(1, 6):  # each pair of commands is worth one period, in whatever order they come
            self.assertEqual(odom.until(rospy.Time(0, 20000000 * i))[-1].header.stamp, rospy.Time(0, 20000000 * i))
            for publisher, message in ((steer, command), (turn, JointState(name=["rear_left_axle"], velocity=[2.0]))):
                publisher.publish(message)
        odom.until(rospy.Time(0, 120000000))
        steer.publish(command)
        self.assertEqual(node.exit_code(), 3, node.output)
        self.assertIn("no command on '%sjoint_commands' (1 publishers)" % namespace, node.output)
        self.assertEqual(odom.messages[-1].header.stamp, rospy.Time(0, 120000000))

    def test_unknown_lockstep_topic_is_refused(self):
        node, _ = self.start(lockstep=True, lockstep_topics=["cmd_vel", "cmd_val"])
        self.assertEqual(node.exit_code(), 1, node.output)
        self.assertIn("~lockstep_topics: 'cmd_val' is no topic of commands", node.output)

    def test_interrupt_while_paused_or_stepping_ends_within_a_second(self):
        for busy in (False, True):
            node, namespace = self.start()
            self.ready(node, namespace)
            sim = Stepper(namespace + "simulator")
            if busy:
                # A step of hours: its reply never comes.
                threading.Thread(target=self.step_for_hours, args=(sim,), daemon=True).start()
                odom = Collector(namespace + "odom", Odometry)
                wait_until(lambda: len(odom.messages) > 10, "the steps")
            code, seconds = node.interrupt()
            self.assertEqual(code, 0, node.output)
            self.assertLess(seconds, 1.0)

    def test_a_master_that_stands_still_stops_neither_the_run_nor_its_end(self):
        node, namespace = self.start()
        self.ready(node, namespace)
        odom = Collector(namespace + "odom", Odometry)
        commands = publisher_of(namespace + "cmd_vel", Twist)
        spawn = rospy.ServiceProxy(namespace + "simulator/spawn", Spawn, persistent=True)
        self.assertIn("must be finite", spawn(name="other", vehicle="skid_steer", x=math.nan).message)
        wait_until(lambda: odom.messages, "odom")
        master = rospy.get_master().getPid()[2]
        os.kill(master, signal.SIGSTOP)
        try:
            commands.publish(twist(math.nan))
            wait_until(lambda: "a command was dropped" in node.output, "a line of the log")
            refused = spawn(name="other", vehicle="skid_steer")
            self.assertFalse(refused.success)
            self.assertIn("the ROS master does not answer", refused.message)
            odom.clear()
            wait_until(lambda: len(odom.messages) > 10, "the run to go on")
            code, seconds = node.interrupt()
        finally:
            os.kill(master, signal.SIGCONT)
        self.assertEqual(code, -signal.SIGINT, node.output)
        self.assertLess(seconds, 1.0)
        self.assertIn("result: ok", node.output)
        self.assertIn("the ROS master does not answer", node.output)

    @staticmethod
    def step_for_hours(sim):
        try:
            sim.step(10000000)
        except (rospy.ServiceException, AssertionError, OSError):
            pass

    def test_a_followed_clock_sets_the_pace_also_when_it_stands_and_jumps(self):
        clock = rospy.Publisher("/clock", Clock, queue_size=100)
        self.addCleanup(clock.unregister)
        node, namespace = self.start(clock="follow")

        def tick_until(time, condition, what):
            def tick():
                clock.publish(Clock(rospy.Time(time)))
                return condition()
            wait_until(tick, what)
        # rospy's own time is this clock's too: nothing here waits by it.
        tick_until(100.0, lambda: rospy.resolve_name(namespace + "odom") in dict(rospy.get_published_topics()), "odom")
        odom = Collector(namespace + "odom", Odometry)

        def run(start, end):
            for i in range(1, round((end - start) * 100) + 1):
                clock.publish(Clock(rospy.Time.from_sec(start + i / 100.0)))
                time.sleep(0.001)
            wanted = rospy.Time.from_sec(end - 0.021)
            tick_until(end, lambda: odom.messages and odom.messages[-1].header.stamp > wanted, "odom at %g" % end)
            return odom.messages[-1].header.stamp.to_sec()
        # The node hears this clock once it is connected to it; until then time may pass unheard.
        heard = [100.0]

        def tick_on():
            heard[0] += 0.001
            clock.publish(Clock(rospy.Time.from_sec(heard[0])))
            return odom.messages
        wait_until(tick_on, "the first odom")
        begin = heard[0]
        self.assertAlmostEqual(run(begin, begin + 1.0), begin + 1.0, delta=0.025)
        stamps = [m.header.stamp for m in odom.messages]
        self.assertEqual(stamps, sorted(stamps))
        # It stands: so does the simulation.
        count = len(odom.messages)
        for _ in range(50):
            clock.publish(Clock(rospy.Time.from_sec(begin + 1.0)))
            time.sleep(0.002)
        self.assertLessEqual(len(odom.messages), count + 1)
        # Back, and far ahead: told, and nothing is simulated for it.
        for there, word in ((50.0, "jumped back"), (5000.0, "jumped ahead")):
            odom.clear()
            tick_until(there, lambda: word in node.output, word)
            self.assertAlmostEqual(run(there, there + 0.5), there + 0.5, delta=0.025)
            self.assertLess(len(odom.messages), 30)
        self.assertAlmostEqual(odom.messages[-1].twist.twist.linear.x, 0.0, delta=1e-6)

    def test_stamps_are_the_walls_where_the_clock_is(self):
        rospy.set_param("/use_sim_time", False)
        try:
            node, namespace = self.start(clock="wall")
            odom = Collector(namespace + "odom", Odometry)
            message = wait_until(lambda: odom.messages and odom.messages[-1], "odom")
            # Late by the way here on a busy machine; early never.
            self.assertLess(abs(time.time() - message.header.stamp.to_sec()), 5.0)
            sim = Stepper(namespace + "simulator")
            stood = sim.step(1).to_sec()
            time.sleep(0.3)  # what is tested is that this time passes for the stamps
            self.assertTrue(sim.call("resume", Trigger).success)
            after = wait_until(lambda: odom.messages[-1].header.stamp.to_sec() > stood + 0.1 and odom.messages[-1], "odom")
            self.assertGreater(after.header.stamp.to_sec(), stood + 0.29)
        finally:
            rospy.set_param("/use_sim_time", True)

    def test_gazebo_names_are_offered_on_request(self):
        node, namespace = self.start(gazebo_services=True)
        self.ready(node, namespace)
        for name in ("reset_simulation", "reset_world", "pause_physics", "unpause_physics"):
            rospy.wait_for_service("/gazebo/" + name, 30.0)
            rospy.ServiceProxy("/gazebo/" + name, Empty)()
        rospy.ServiceProxy("/gazebo/pause_physics", Empty)()
        stepped = rospy.ServiceProxy(namespace + "simulator/step", Step)(1)
        self.assertTrue(stepped.success, stepped.message)

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
        wait_until(lambda: "a command was dropped" in node.output and "not finite" in node.output, "the warning")

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
