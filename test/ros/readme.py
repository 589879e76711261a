#!/usr/bin/python3
"""What the README says is tried: its launch file with its vehicle, its table of topics, the names it mentions."""
import math
import os
import re
import sys
import tempfile
import unittest

import rosgraph
import roslib.packages
import rospy
import rosservice
import rostest
from nav_msgs.msg import Odometry

from controller_test_tools import Launch
from sim_test_tools import wait_until

CHECKOUT = os.path.join(os.path.dirname(os.path.realpath(__file__)), "..", "..")


class Readme(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        rospy.init_node("readme_test")
        with open(os.path.join(CHECKOUT, "README.md"), encoding="utf-8") as file:
            cls.text = file.read()
        blocks = re.findall(r"```xml\n(.*?)```", cls.text, re.S)
        launch, = [block for block in blocks if block.startswith("<launch>")]
        robot, = [block for block in blocks if block.startswith("<robot")]
        lockstep, = [block for block in blocks if 'name="lockstep"' in block]
        cls.blocks = launch, robot

        # Their launch file with our controller in the place of theirs, no window, and lockstep as the README has it.
        cls.folder = tempfile.TemporaryDirectory()
        urdf = os.path.join(cls.folder.name, "mine.urdf")
        with open(urdf, "w") as file:
            file.write(robot)
        for old, new in (('name="vehicle" value="car"', 'name="vehicle" value="%s"' % urdf),
                         ('name="world" value="course"', 'name="world" value="flat"'),
                         ('pkg="my_package" type="my_controller"', 'pkg="ellipsoid_vehicle_sim" type="square_driver"'),
                         ("  </include>", lockstep + "  </include>")):
            assert old in launch, old
            launch = launch.replace(old, new)
        launch = re.sub(r".*pkg=\"rviz\".*\n", "", launch)
        path = os.path.join(cls.folder.name, "my.launch")
        with open(path, "w") as file:
            file.write(launch)
        cls.odom = []
        rospy.Subscriber("/odom", Odometry, cls.odom.append, queue_size=100)
        cls.launch = Launch(path)

    @classmethod
    def tearDownClass(cls):
        cls.launch.__exit__()
        cls.folder.cleanup()

    def test_controller_drives_the_vehicle_at_the_first_try(self):
        def moved():
            self.assertIsNone(self.launch.process.poll(), self.launch.output)
            return self.odom and math.hypot(self.odom[-1].pose.pose.position.x, self.odom[-1].pose.pose.position.y) > 3.0
        wait_until(moved, "the vehicle to drive 3 m")

    def test_snippets_are_as_short_as_promised(self):
        launch, robot = self.blocks
        self.assertLessEqual(len(launch.splitlines()), 15)
        self.assertLessEqual(len(robot.splitlines()), 12)

    def test_table_of_topics_and_services_is_true(self):
        rows = re.findall(r"^\| (in|out|service) \| `([^`]+)` \| ([a-z_]+/[A-Za-z]+)", self.text, re.M)
        self.assertGreater(len(rows), 8)
        wait_until(lambda: self.odom, "odom")
        master = rosgraph.Master("/readme_test")
        publishers, subscribers, _ = master.getSystemState()
        types = dict(master.getTopicTypes())
        of_simulator = {kind: {topic for topic, nodes in topics if "/simulator" in nodes}
                        for kind, topics in (("out", publishers), ("in", subscribers))}
        for direction, name, kind in rows:
            with self.subTest(name=name):
                if direction == "service":
                    self.assertEqual(rosservice.get_service_type(name.replace("~", "/simulator/")), kind)
                    continue
                topic = rospy.resolve_name(name.replace("~", "/simulator/"))
                self.assertIn(topic, of_simulator[direction])
                self.assertEqual(types.get(topic, kind), kind)

    def test_what_it_names_is_there(self):
        for path in re.findall(r"\]\(([^)#]+)\)", self.text) + re.findall(r"`((?:docs|scripts|launch|include)/[^` ]+)`", self.text):
            self.assertTrue(os.path.exists(os.path.join(CHECKOUT, path)), path)
        for name in re.findall(r"rosrun ellipsoid_vehicle_sim (\w+)", self.text):
            self.assertTrue(roslib.packages.find_node("ellipsoid_vehicle_sim", name), name)
        for name in re.findall(r"`?(\w+\.launch)`?", self.text):
            self.assertTrue(name == "my.launch" or os.path.exists(os.path.join(CHECKOUT, "launch", name)), name)


if __name__ == "__main__":
    rostest.rosrun("ellipsoid_vehicle_sim", "readme", Readme, sys.argv)
