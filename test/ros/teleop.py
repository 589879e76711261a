#!/usr/bin/python3
import math
import os
import pty
import signal
import subprocess
import sys
import termios
import threading
import unittest

import rospy
import rostest
from geometry_msgs.msg import Twist
from nav_msgs.msg import Odometry

from controller_test_tools import Launch
from sim_test_tools import DEADLINE, wait_until


class Terminal:
    """Both ends of a terminal: keys go in, what is shown is collected."""

    def __init__(self):
        self.ours, self.theirs = pty.openpty()
        self.shown = ""
        self._reader = threading.Thread(target=self._read, daemon=True)
        self._reader.start()

    def _read(self):
        while True:
            try:
                self.shown += os.read(self.ours, 4096).decode(errors="replace")
            except OSError:
                return

    def type(self, keys):
        os.write(self.ours, keys.encode())

    def modes(self):
        return termios.tcgetattr(self.theirs)


class Teleop(unittest.TestCase):
    """teleop.launch in a terminal of its own, with somebody at its keys; skid_steer, which turns on the spot."""

    def start(self):
        self.terminal = Terminal()
        self.before = self.terminal.modes()
        self.commands, self.odom = [], []
        self.subscribers = [rospy.Subscriber("/cmd_vel", Twist, self.commands.append, queue_size=1000),
                            rospy.Subscriber("/odom", Odometry, self.odom.append, queue_size=1000)]
        for subscriber in self.subscribers:
            self.addCleanup(subscriber.unregister)
        self.launch = Launch("teleop.launch", "rviz:=false", "vehicle:=skid_steer", "world:=flat",
                             stdin=self.terminal.theirs)
        self.addCleanup(self.launch.__exit__)
        wait_until(lambda: "space or x" in self.terminal.shown and self.commands, "the help on the terminal, and cmd_vel")

    def asked(self, speed, yaw_rate):
        wait_until(lambda: math.isclose(self.commands[-1].linear.x, speed, abs_tol=1e-9) and
                   math.isclose(self.commands[-1].angular.z, yaw_rate, abs_tol=1e-9),
                   "cmd_vel (%g, %g), last was %s" % (speed, yaw_rate, self.commands[-1]))

    def test_keys_drive_and_the_terminal_is_given_back(self):
        self.start()
        self.asked(0.0, 0.0)
        self.terminal.type("w")
        self.asked(0.5, 0.0)
        self.terminal.type("\x1b[A")  # up
        self.asked(1.0, 0.0)
        wait_until(lambda: self.odom[-1].twist.twist.linear.x > 0.9, "the vehicle to drive at 1 m/s")
        self.terminal.type("aa")
        self.asked(1.0, 0.2)
        self.terminal.type("\x1bOC")  # right, in the other mode of terminals
        self.asked(1.0, 0.1)
        self.terminal.type("c")
        self.asked(1.0, 0.0)
        self.terminal.type("z\x1b")  # nothing, and half an arrow
        self.terminal.type("ss")
        self.asked(0.0, 0.0)
        self.terminal.type("sd ")
        self.asked(0.0, 0.0)
        wait_until(lambda: abs(self.odom[-1].twist.twist.linear.x) < 0.01, "the vehicle to stand")
        self.assertIn("m/s", self.terminal.shown)
        self.terminal.type("w" * 30)  # beyond the largest speed, 10 m/s
        self.asked(10.0, 0.0)
        self.terminal.type("q")
        self.launch.wait_for_end(DEADLINE)
        self.assertEqual(self.terminal.modes(), self.before)
        self.asked(0.0, 0.0)

    def test_terminal_is_given_back_when_the_launch_is_interrupted(self):
        self.start()
        self.assertNotEqual(self.terminal.modes(), self.before)
        self.launch.process.send_signal(signal.SIGINT)
        self.launch.wait_for_end(DEADLINE)
        self.assertEqual(self.terminal.modes(), self.before)

    def test_without_a_terminal_it_says_that_it_needs_one(self):
        with Launch("teleop.launch", "rviz:=false", "vehicle:=skid_steer", "world:=flat", stdin=subprocess.DEVNULL) as launch:
            launch.wait_for_end(DEADLINE)
            self.assertIn("there is no terminal to read keys from", launch.output)


if __name__ == "__main__":
    rospy.init_node("teleop_test")
    rostest.rosrun("ellipsoid_vehicle_sim", "teleop", Teleop, sys.argv)
