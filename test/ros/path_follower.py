#!/usr/bin/python3
import math
import subprocess
import sys
import tempfile
import unittest

import roslib.packages
import rospy
import rostest

from controller_test_tools import along_heading, odom_of_run, same_motion

SECONDS = 32.0  # a lap and a half of 90.3 m at 3 m/s take longer: one lap and the start of the next
LENGTH, RADIUS = 20.0, 8.0  # [m] of launch/oval.yaml
AXLE = -1.3  # [m]: the shipped car's rear axle, from base_link
# Where straight meets circle the point pursued is already on the other: the arc to it leaves the path by no more than the
# sagitta of a chord as long as the lookahead, 0.8 s at 3 m/s, on a circle of 8 m.
LOOKAHEAD = 2.4  # [m]
LARGEST_ERROR = LOOKAHEAD ** 2 / (8.0 * RADIUS)  # 0.09 m


def distance_to_oval(x, y):
    """Signed, outwards."""
    if 0.0 <= x <= LENGTH:
        return abs(y - RADIUS) - RADIUS
    return math.hypot(x - (LENGTH if x > LENGTH else 0.0), y - RADIUS) - RADIUS


class PathFollower(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        rospy.init_node("path_follower_test")
        cls.first = odom_of_run("path_follower.launch", SECONDS)
        cls.second = odom_of_run("path_follower.launch", SECONDS)

    def test_axle_stays_on_the_oval(self):
        errors = [abs(distance_to_oval(*along_heading(odom, AXLE))) for stamp, odom in sorted(self.first.items())]
        errors = errors[len(errors) // 10:]  # it starts with its axle behind the first point
        self.assertLess(max(errors), LARGEST_ERROR)
        self.assertLess(math.sqrt(sum(e * e for e in errors) / len(errors)), 0.5 * LARGEST_ERROR)

    def test_goes_all_the_way_round_at_its_speed(self):
        visited = {(odom.pose.pose.position.x > 0.5 * LENGTH, odom.pose.pose.position.y > RADIUS)
                   for odom in self.first.values()}
        self.assertEqual(len(visited), 4)
        late = [odom.twist.twist.linear.x for stamp, odom in self.first.items() if stamp > 5e9]
        self.assertGreater(min(late), 2.8)

    def test_two_runs_in_lockstep_are_the_same_to_the_last_bit(self):
        same_motion(self, self.first, self.second)

    def test_ackermann_commands_follow_as_well(self):
        odom = odom_of_run("path_follower.launch", 10.0, "command:=ackermann")
        errors = [abs(distance_to_oval(*along_heading(m, AXLE))) for stamp, m in odom.items() if stamp > 2e9]
        self.assertLess(max(errors), LARGEST_ERROR)
        self.assertGreater(odom[max(odom)].pose.pose.position.x, 20.0)  # in the first turn

    def refused(self, *arguments):
        """What the program says when it ends with exit code 1."""
        program = roslib.packages.find_node("ellipsoid_vehicle_sim", "path_follower")[0]
        result = subprocess.run([program, "__ns:=/refused"] + list(arguments), stdout=subprocess.PIPE,
                                stderr=subprocess.STDOUT, text=True, timeout=60)
        self.assertEqual(result.returncode, 1, result.stdout)
        self.assertNotIn("Traceback", result.stdout)
        return result.stdout

    def test_bad_parameters_are_named_all_at_once(self):
        output = self.refused("_speed:=-1", "_lookahead_time:=soon", "_command:=telepathy", "_path_file:=/no/such.yaml")
        for text in ("~speed is -1", "~lookahead_time is 'soon'", "~command is 'telepathy'",
                     "~path_file /no/such.yaml: No such file"):
            self.assertIn(text, output)

    def test_bad_path_files_are_refused_with_what_is_wrong(self):
        for content, text in (("points: [[0, 0], [1, x]]", "point 2 is [1, 'x']"), ("points: [[0, 0]]", "at least two"),
                              ("point: [[0, 0], [1, 1]]", "expected 'points:'"), ("points: [[0, 0], [.nan, 1]]", "not finite"),
                              ("{", "no YAML"), ("points: [[0, 0], [1, 0]]\nclose: true", "unknown key 'close'")):
            with tempfile.NamedTemporaryFile("w", suffix=".yaml") as file:
                file.write(content)
                file.flush()
                self.assertIn(text, self.refused("_path_file:=" + file.name))


if __name__ == "__main__":
    rostest.rosrun("ellipsoid_vehicle_sim", "path_follower_tracking", PathFollower, sys.argv)
