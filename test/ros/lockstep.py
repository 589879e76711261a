#!/usr/bin/python3
import math
import random
import struct
import sys
import time
import unittest

import rospy
import rostest
from ellipsoid_vehicle_sim.srv import RestoreState, SaveState, Step
from std_srvs.srv import Trigger

from sim_test_tools import Commander, twist

MESSAGES = 60  # of a run; 1.2 simulated seconds
RUNS = 10


def bits(odom):
    pose, velocity = odom.pose.pose, odom.twist.twist
    return struct.pack("<13d", pose.position.x, pose.position.y, pose.position.z, pose.orientation.x, pose.orientation.y,
                       pose.orientation.z, pose.orientation.w, velocity.linear.x, velocity.linear.y, velocity.linear.z,
                       velocity.angular.x, velocity.angular.y, velocity.angular.z)


class Lockstep(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        rospy.init_node("lockstep")
        cls.commander = Commander()
        cls.services = {}
        for name, kind in (("reset", Trigger), ("pause", Trigger), ("resume", Trigger), ("state_hash", Trigger), ("save_state", SaveState),
                           ("restore_state", RestoreState), ("step", Step)):
            rospy.wait_for_service("simulator/" + name, 60.0)
            cls.services[name] = rospy.ServiceProxy("simulator/" + name, kind)
        cls.commander.next_odom()  # the simulator waits from here on

    def hash(self):
        return self.services["state_hash"]().message

    def reset(self):
        response = self.services["reset"]()
        self.assertTrue(response.success, response.message)

    def weave(self, first, last, dawdle=0.0):
        """A controller that steers by what it sees; the messages it saw. The last one stays without an answer."""
        seen = []
        for i in range(first, last):
            odom = self.commander.next_odom()
            seen.append(odom)
            if i + 1 < last:
                time.sleep(random.random() * dawdle)
                self.commander.answer(twist(3.0, 0.4 * math.sin(0.1 * i) - 0.2 * odom.pose.pose.position.y))
        return seen

    def test_ten_runs_give_one_hash_whatever_the_commander_takes(self):
        hashes, drives, last = set(), set(), None
        for run in range(RUNS):
            self.reset()
            seen = self.weave(0, MESSAGES, dawdle=0.002 * (run % 3))
            drives.add(tuple(bits(odom) for odom in seen))
            hashes.add(self.hash())
            if last is not None:
                self.assertGreater(seen[0].header.stamp, last)  # the clock goes on
            last = seen[-1].header.stamp
        self.assertEqual(len(hashes), 1)
        self.assertEqual(len(drives), 1)
        self.assertGreater(len(set(next(iter(drives)))), MESSAGES // 2)  # it did move

    def test_a_state_restored_while_a_command_is_awaited_waits_for_it_again(self):
        self.reset()
        odom = self.weave(0, MESSAGES // 2)[-1]
        state = self.services["save_state"]("").state
        command = twist(2.0, 0.3)

        def go_on():
            seen = []
            for _ in range(10):
                self.commander.answer(command)
                seen.append(bits(self.commander.next_odom()))
            return seen
        first = go_on()
        response = self.services["restore_state"](state, "")
        self.assertTrue(response.success, response.message)
        self.assertEqual(go_on(), first)
        self.assertNotIn(bits(odom), first)

    def test_step_goes_on_without_a_command_and_the_wait_goes_on_after_it(self):
        self.reset()
        before = self.commander.next_odom().header.stamp
        response = self.services["step"](35)
        self.assertTrue(response.success, response.message)
        self.assertEqual(response.stamp - before, rospy.Duration(0.035))
        self.assertEqual(self.commander.next_odom().header.stamp - before, rospy.Duration(0.020))
        after = self.hash()
        self.commander.answer(twist(1.0))
        self.assertEqual(self.commander.next_odom().header.stamp - before, rospy.Duration(0.040))
        self.assertNotEqual(self.hash(), after)

    def test_reset_twice_is_as_good_as_once(self):
        self.reset()
        self.commander.next_odom()
        first = self.hash()
        self.assertTrue(self.services["pause"]().success)
        for _ in range(2):
            self.reset()
        self.assertTrue(self.services["resume"]().success)
        self.commander.next_odom()
        self.assertEqual(self.hash(), first)


if __name__ == "__main__":
    rostest.rosrun("ellipsoid_vehicle_sim", "lockstep", Lockstep, sys.argv)
