#!/usr/bin/python3
import math
import os
import sys
import tempfile
import unittest

import rospy
import rostest
from ellipsoid_vehicle_sim.srv import RestoreState, SaveState
from geometry_msgs.msg import Twist
from nav_msgs.msg import Odometry
from sensor_msgs.msg import Imu
from std_srvs.srv import Trigger
from tf2_msgs.msg import TFMessage

from sim_test_tools import Collector, NodeProcess, Stepper, publisher_of, twist, wait_until

SLOPE = math.radians(20.0)
GRAVITY = 9.80665
DISTANCE_NOISE, IMU_NOISE = 0.02, 0.1
STL = """solid slope
facet normal 0 0 1
outer loop
vertex %(low)s
vertex %(right)s
vertex %(high)s
endloop
endfacet
facet normal 0 0 1
outer loop
vertex %(low)s
vertex %(high)s
vertex %(left)s
endloop
endfacet
endsolid slope
"""


def plane():
    """A square of 200 m that rises along +x."""
    def corner(s, y):
        return "%.9g %.9g %.9g" % (s * math.cos(SLOPE), y, s * math.sin(SLOPE))
    return STL % {"low": corner(-100, -100), "right": corner(100, -100), "high": corner(100, 100), "left": corner(-100, 100)}



class SlopeAndSensors(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        rospy.init_node("slope_and_sensors")
        cls.folder = tempfile.TemporaryDirectory()
        world = os.path.join(cls.folder.name, "slope.stl")
        with open(world, "w") as file:
            file.write(plane())
        cls.node = NodeProcess("slope", vehicle_file="car", world=world, odometry="encoders", publish_world_tf=True,
                               # What the rear axle can carry uphill without spinning its wheels.
                               max_acceleration=1.0,
                               odometry_position_noise=DISTANCE_NOISE, imu_acceleration_noise=IMU_NOISE, noise_seed=7)
        cls.sim = Stepper("/slope/simulator")
        cls.odom, cls.truth = Collector("/slope/odom", Odometry), Collector("/slope/ground_truth", Odometry)
        cls.imu, cls.tf = Collector("/slope/imu", Imu), Collector("/tf", TFMessage)
        cls.cmd_vel = publisher_of("/slope/cmd_vel", Twist)

    @classmethod
    def tearDownClass(cls):
        cls.node.kill()
        cls.folder.cleanup()

    def setUp(self):
        response = self.sim.set_pose(0.0, 0.0)
        self.assertTrue(response.success, response.message)
        for topic in (self.odom, self.truth, self.imu, self.tf):
            topic.clear()

    def uphill(self, seconds, speed=2.0):
        for _ in range(round(10 * seconds)):
            self.sim.send(self.cmd_vel, twist(speed))
            stamp = self.sim.step(100)
        return stamp

    def test_a_parked_car_holds_on_20_degrees(self):
        first = self.truth.until(self.sim.step(200))[-1].pose.pose.position
        stamp = self.sim.step(60000)  # a minute
        last = self.truth.until(stamp)[-1].pose.pose.position
        moved = math.dist((first.x, first.y, first.z), (last.x, last.y, last.z))
        self.assertLess(moved, 1e-6)  # friction that creeps loses millimetres in that time

    def test_drives_up_and_the_brakes_hold_it_there(self):
        self.uphill(3.0)
        top = self.truth.until(self.sim.step(3000))[-1]  # the command gets too old, and the car stops
        after = self.truth.until(self.sim.step(5000))[-1]
        self.assertGreater(top.pose.pose.position.z, 1.0)
        self.assertAlmostEqual(after.pose.pose.position.z, top.pose.pose.position.z, delta=1e-5)

    def test_encoders_start_at_zero_tell_the_way_and_not_the_slope(self):
        start = self.odom.until(self.sim.step(20))[-1]
        self.assertEqual(start.header.frame_id, "odom")
        self.assertAlmostEqual(start.pose.pose.position.x, 0.0, delta=1e-6)
        stamp = self.uphill(3.0)
        odom, truth = self.odom.until(stamp)[-1], self.truth.until(stamp)[-1]
        self.assertEqual(truth.header.frame_id, "map")
        way = math.hypot(truth.pose.pose.position.x, truth.pose.pose.position.z - self.truth.messages[0].pose.pose.position.z)
        # Uphill the driven wheels slip: by thrust over the brush's stiffness, a few hundredths.
        self.assertGreater(odom.pose.pose.position.x, way)
        self.assertLess(odom.pose.pose.position.x, 1.1 * way)
        self.assertEqual(odom.pose.pose.position.z, 0.0)
        self.assertAlmostEqual(odom.twist.twist.linear.x, 2.0, delta=0.05)

    def test_covariance_of_the_encoders_grows_with_the_way_and_not_with_time(self):
        parked = self.odom.until(self.sim.step(2000))
        self.assertAlmostEqual(parked[0].pose.covariance[0], parked[-1].pose.covariance[0], delta=1e-9)
        messages = self.odom.until(self.uphill(3.0))
        odom = messages[-1]
        # The way to and fro: the wheels give a little before the motors pull.
        way = sum(abs(b.pose.pose.position.x - a.pose.pose.position.x) for a, b in zip(messages, messages[1:]))
        self.assertAlmostEqual(odom.pose.covariance[0] - parked[0].pose.covariance[0], DISTANCE_NOISE ** 2 * way,
                               delta=0.01 * DISTANCE_NOISE ** 2 * way)
        for index in (0, 7, 35):
            self.assertGreater(odom.pose.covariance[index], parked[0].pose.covariance[index])

    def test_tf_says_what_odom_says_and_with_the_world_the_truth(self):
        stamp = self.uphill(1.0)
        odom, truth = self.odom.until(stamp)[-1], self.truth.until(stamp)[-1]

        def both():
            found = {(t.header.frame_id, t.child_frame_id): t.transform for m in self.tf.messages for t in m.transforms
                     if t.header.stamp == odom.header.stamp}
            return found if ("map", "odom") in found else None
        found = wait_until(both, "tf of that moment")
        base = found["odom", odom.child_frame_id].translation
        self.assertEqual((base.x, base.y, base.z), (odom.pose.pose.position.x, odom.pose.pose.position.y, 0.0))
        # Along x only, turned by the slope about y: the sum is the true pose.
        world = found["map", "odom"]
        pitch = 2.0 * math.atan2(world.rotation.y, world.rotation.w)
        self.assertAlmostEqual(world.translation.x + math.cos(pitch) * base.x, truth.pose.pose.position.x, delta=1e-6)
        self.assertAlmostEqual(world.translation.z - math.sin(pitch) * base.x, truth.pose.pose.position.z, delta=1e-6)

    def test_imu_tells_gravity_in_its_own_axes_with_the_noise_it_says(self):
        for _ in range(20):  # no more at once than the node's queues hold
            samples = self.imu.until(self.sim.step(500))
        n = len(samples)
        self.assertEqual(n, 1000)
        # Up, in the car's own axes: the slope, and the springs that let it lean.
        q = samples[-1].orientation
        up = (2.0 * (q.x * q.z - q.w * q.y), 2.0 * (q.y * q.z + q.w * q.x), 1.0 - 2.0 * (q.x ** 2 + q.y ** 2))
        self.assertAlmostEqual(math.asin(up[0]), SLOPE, delta=math.radians(2.0))
        for axis, expected in zip("xyz", (GRAVITY * component for component in up)):
            values = [getattr(m.linear_acceleration, axis) for m in samples]
            mean = sum(values) / n
            deviation = math.sqrt(sum((v - mean) ** 2 for v in values) / n)
            self.assertAlmostEqual(mean, expected, delta=4 * IMU_NOISE / math.sqrt(n))  # four standard errors
            self.assertAlmostEqual(deviation, IMU_NOISE, delta=4 * IMU_NOISE / math.sqrt(2 * n))
        self.assertAlmostEqual(samples[0].linear_acceleration_covariance[0], IMU_NOISE ** 2, delta=1e-12)

    def test_noise_and_odometry_are_part_of_a_saved_state(self):
        self.uphill(1.0)
        state = self.sim.call("save_state", SaveState, "").state

        def go_on():
            self.imu.clear()
            self.odom.clear()
            stamp = self.sim.step(300)
            # What was under way before is none of these steps.
            begin = stamp - rospy.Duration(0.3)
            return ([m.linear_acceleration.x for m in self.imu.until(stamp) if m.header.stamp > begin],
                    [(m.pose.pose.position.x, m.pose.covariance[0]) for m in self.odom.until(stamp)
                     if m.header.stamp > begin])
        first = go_on()
        self.assertTrue(self.sim.call("reset", Trigger).success)
        self.assertNotEqual(go_on(), first)
        self.assertTrue(self.sim.call("restore_state", RestoreState, state, "").success)
        self.assertEqual(go_on(), first)

    def test_a_pose_in_the_odom_frame_is_taken_through_it(self):
        stamp = self.uphill(2.0)
        here = self.odom.until(stamp)[-1].pose.pose.position.x
        there = self.truth.until(stamp)[-1].pose.pose.position
        response = self.sim.set_pose(here, 0.0, frame="odom")
        self.assertTrue(response.success, response.message)
        # Set down on the ground below that point: the root link stands a wheel's radius off it, along the slope's normal.
        self.assertAlmostEqual(response.pose.pose.position.x, there.x, delta=0.15)
        self.assertIn("'odom' or 'map'", self.sim.set_pose(0.0, 0.0, frame="base_link").message)


if __name__ == "__main__":
    rostest.rosrun("ellipsoid_vehicle_sim", "slope_and_sensors", SlopeAndSensors, sys.argv)
