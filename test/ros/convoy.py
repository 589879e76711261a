#!/usr/bin/python3
"""The shipped convoy drives, keeps together, and nobody touches anybody."""
import math
import unittest

import rospy
import rostest
from ellipsoid_vehicle_sim.msg import ContactStates
from nav_msgs.msg import Odometry

from sim_test_tools import Collector, wait_until

NAMES = ["alpha", "bravo", "charlie", "delta"]


class ConvoyTest(unittest.TestCase):
    def test_each_follows_the_one_ahead(self):
        truth = {name: Collector("/%s/ground_truth" % name, Odometry) for name in NAMES}
        contacts = {name: Collector("/%s/contacts" % name, ContactStates) for name in NAMES}
        wait_until(lambda: all(t.messages for t in truth.values()), "all four")

        def place(name):
            p = truth[name].messages[-1].pose.pose.position
            return p.x, p.y
        wait_until(lambda: place("alpha")[0] > 42.0, "the first to drive 18 m", deadline=200.0)
        for ahead, name in zip(NAMES, NAMES[1:]):
            gap = math.dist(place(ahead), place(name))
            self.assertGreater(gap, 5.0, name)
            self.assertLess(gap, 11.0, name)
            self.assertLess(abs(place(name)[1]), 1.0, name)
        for name in NAMES:
            touching = [c.other_vehicle for m in contacts[name].messages for c in m.contacts if c.other_vehicle]
            self.assertEqual(touching, [], name)


if __name__ == "__main__":
    rospy.init_node("convoy_test")
    rostest.rosrun("ellipsoid_vehicle_sim", "convoy", ConvoyTest)
