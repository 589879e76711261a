#!/usr/bin/python3
"""Lidars of the node, on the shipped flat world: what they measure is known in closed form."""
import math
import struct
import sys
import unittest

import rospy
import rostest
from nav_msgs.msg import Odometry
from sensor_msgs.msg import LaserScan, PointCloud2
from std_srvs.srv import Trigger
from tf2_msgs.msg import TFMessage
from visualization_msgs.msg import MarkerArray

from sim_test_tools import Collector, NodeProcess, Stepper, wait_until

PERIOD = 25  # [ticks] of a scan at 40 Hz and the default step of 1 ms
FLOAT = 2e-6  # a float's rounding of what is below 30 m [m]
LIDARS = {
    # Looks 0.3 rad down, ahead: half of its turn meets the ground.
    "front": {"pose": [0.4, 0.1, 1.2, 0.0, 0.3, 0.2], "angle_min": -3.1, "angle_max": 3.1, "samples": 541, "range_max": 20.0,
              "range_min": 6.0},
    "noisy": {"pose": [0.4, 0.1, 1.2, 0.0, 0.3, 0.2], "samples": 541, "noise": 0.03},
    "top": {"kind": "spatial", "pose": [0.0, 0.0, 2.0, 0.0, 0.0, 0.0], "samples": 90, "angle_min": -3.0, "angle_max": 3.0,
            "rings": 8, "vertical_angle_min": -0.6, "vertical_angle_max": 0.1, "rate": 10.0, "range_max": 15.0},
    # Straight down on the car's back.
    "own": {"pose": [0.0, 0.0, 3.0, 0.0, math.pi / 2, 0.0], "samples": 1, "angle_min": 0.0, "angle_max": 0.0,
            "sees_own_vehicle": True},
}


def turned(q, v):
    """v turned by the quaternion q."""
    x, y, z, w = q.x, q.y, q.z, q.w
    tx, ty, tz = 2 * (y * v[2] - z * v[1]), 2 * (z * v[0] - x * v[2]), 2 * (x * v[1] - y * v[0])
    return (v[0] + w * tx + y * tz - z * ty, v[1] + w * ty + z * tx - x * tz, v[2] + w * tz + x * ty - y * tx)


def from_rpy(v, roll, pitch, yaw):
    """v turned about the fixed axes x, y, z, one after the other."""
    c, s = math.cos(roll), math.sin(roll)
    v = (v[0], c * v[1] - s * v[2], s * v[1] + c * v[2])
    c, s = math.cos(pitch), math.sin(pitch)
    v = (c * v[0] + s * v[2], v[1], -s * v[0] + c * v[2])
    c, s = math.cos(yaw), math.sin(yaw)
    return (c * v[0] - s * v[1], s * v[0] + c * v[1], v[2])


class Lidar(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        rospy.init_node("lidar_test")
        cls.node = NodeProcess("scan", vehicle_file="car", world="flat", lidars=sorted(LIDARS), noise_seed=3, **LIDARS)
        cls.sim = Stepper("/scan/simulator")
        cls.truth = Collector("/scan/ground_truth", Odometry)
        cls.front, cls.own = Collector("/scan/front/scan", LaserScan), Collector("/scan/own/scan", LaserScan)
        cls.top = Collector("/scan/top/points", PointCloud2)
        cls.static = Collector("/tf_static", TFMessage)
        cls.shapes = Collector("/scan/collision_shapes", MarkerArray)

    @classmethod
    def tearDownClass(cls):
        cls.node.kill()

    def setUp(self):
        self.assertTrue(self.sim.call("reset", Trigger).success)
        for topic in (self.truth, self.front, self.own, self.top):
            topic.clear()

    def root(self, stamp):
        return {m.header.stamp: m.pose.pose for m in self.truth.until(stamp)}[stamp]

    def ground(self, pose, name, direction):
        """Distance from the lidar `name` along `direction` of its own to the plane z = 0; infinity if it never comes."""
        mount = LIDARS[name]["pose"]
        at = turned(pose.orientation, mount[:3])
        down = turned(pose.orientation, from_rpy(direction, *mount[3:]))[2]
        height = pose.position.z + at[2]
        return height / -down if down < 0.0 else math.inf

    def test_a_scan_of_the_flat_world_is_height_over_the_sine_of_the_way_down(self):
        stamp = self.sim.step(4 * PERIOD)  # a multiple of the 20 ms of ground_truth, too
        scan = self.front.until(stamp)[-1]
        self.assertEqual(scan.header.stamp, stamp)
        self.assertEqual(len(scan.ranges), 541)
        self.assertAlmostEqual(scan.angle_min + 540 * scan.angle_increment, scan.angle_max, delta=1e-4)
        pose, seen, near, far = self.root(stamp), 0, 0, 0
        for i, measured in enumerate(scan.ranges):
            azimuth = -3.1 + i * 6.2 / 540
            expected = self.ground(pose, "front", (math.cos(azimuth), math.sin(azimuth), 0.0))
            if expected > scan.range_max:
                self.assertEqual(measured, math.inf, i)
                far += 1
            elif expected < scan.range_min:
                self.assertEqual(measured, -math.inf, i)
                near += 1
            else:
                # How far a grazing ray goes depends on the pose to the last digit; both have it in doubles.
                self.assertAlmostEqual(measured, expected, delta=FLOAT, msg="ray %d" % i)
                seen += 1
        self.assertGreater(min(seen, near, far), 50)

    def test_all_rays_of_a_scan_leave_at_its_stamp_on_the_ticks_of_its_rate(self):
        first = self.sim.step(PERIOD)
        self.front.until(first)
        self.front.clear()
        last = self.sim.step(10 * PERIOD)
        scans = self.front.until(last)
        stamps = [scan.header.stamp for scan in scans]
        self.assertEqual([(b - a).to_nsec() for a, b in zip([first] + stamps, stamps)], [25000000] * 10)
        self.assertEqual({scan.time_increment for scan in scans}, {0.0})
        self.assertAlmostEqual(scans[0].scan_time, 0.025, delta=1e-9)
        self.assertEqual({scan.header.frame_id for scan in scans}, {"front"})

    def test_frames_of_the_lidars_are_in_tf_static(self):
        frames = {t.child_frame_id: t for m in self.static.messages for t in m.transforms}
        for name, lidar in LIDARS.items():
            self.assertEqual(frames[name].header.frame_id, "base_link")
            p, mount = frames[name].transform.translation, lidar["pose"]
            self.assertEqual((p.x, p.y, p.z), tuple(mount[:3]))
            ahead = turned(frames[name].transform.rotation, (1.0, 0.0, 0.0))
            for a, b in zip(ahead, from_rpy((1.0, 0.0, 0.0), *mount[3:])):
                self.assertAlmostEqual(a, b, delta=1e-12)

    def test_points_of_a_cloud_lie_on_the_ground_and_every_ray_that_meets_it_has_one(self):
        stamp = self.sim.step(100)
        cloud = self.top.until(stamp)[-1]
        self.assertEqual([(f.name, f.offset) for f in cloud.fields], [("x", 0), ("y", 4), ("z", 8), ("ring", 12)])
        self.assertTrue(cloud.is_dense)
        self.assertEqual((cloud.height, cloud.row_step, len(cloud.data)), (1, 16 * cloud.width, 16 * cloud.width))
        pose, expected = self.root(stamp), []
        for ring in range(8):
            elevation = -0.6 + 0.1 * ring
            for i in range(90):
                azimuth = -3.0 + 6.0 * i / 89
                direction = (math.cos(elevation) * math.cos(azimuth), math.cos(elevation) * math.sin(azimuth), math.sin(elevation))
                distance = self.ground(pose, "top", direction)
                if distance <= 15.0:
                    expected.append(tuple(distance * d for d in direction) + (ring,))
        points = list(struct.iter_unpack("<fffHxx", cloud.data))
        self.assertEqual(len(points), len(expected))
        for point, right in zip(points, expected):
            self.assertEqual(point[3], right[3])
            for a, b in zip(point[:3], right[:3]):
                self.assertAlmostEqual(a, b, delta=FLOAT)

    def test_its_own_vehicle_is_seen_where_that_is_asked_for(self):
        scan = self.own.until(self.sim.step(4 * PERIOD))[-1]
        markers = [m for message in self.shapes.messages for m in message.markers if m.header.frame_id == "chassis"]  # in base_link's origin

        def top(marker):
            """Height of the ellipsoid's surface over the root link's origin; its axes are the link's."""
            p, s = marker.pose.position, marker.scale
            inside = 1.0 - (2 * p.x / s.x) ** 2 - (2 * p.y / s.y) ** 2
            return p.z + 0.5 * s.z * math.sqrt(inside) if inside > 0.0 else -math.inf
        self.assertTrue(markers)
        self.assertAlmostEqual(scan.ranges[0], 3.0 - max(top(m) for m in markers), delta=FLOAT)

    def noisy_scan(self):
        """The noisy lidar's scan at 0.3 s after a reset, when there is a ground_truth, too."""
        noisy = Collector("/scan/noisy/scan", LaserScan)
        wait_until(lambda: self.sim.step(PERIOD) and noisy.messages, "the simulator to know the subscriber")
        self.assertTrue(self.sim.call("reset", Trigger).success)
        stamp = self.sim.step(12 * PERIOD)
        scan = {m.header.stamp: m for m in noisy.until(stamp)}[stamp]
        noisy._subscriber.unregister()
        return scan

    def test_noise_is_the_same_after_a_reset_whoever_listened_before(self):
        first = self.noisy_scan()
        self.assertTrue(self.sim.call("reset", Trigger).success)
        self.sim.step(3 * PERIOD)  # nobody listens
        again = self.noisy_scan()
        self.assertEqual(again.ranges, first.ranges)
        pose = self.root(first.header.stamp)
        errors = []
        for i, measured in enumerate(first.ranges):
            azimuth = first.angle_min + i * (first.angle_max - first.angle_min) / 540
            expected = self.ground(pose, "noisy", (math.cos(azimuth), math.sin(azimuth), 0.0))
            if math.isfinite(measured) and expected < 29.0:
                errors.append(measured - expected)
        deviation = math.sqrt(sum(e * e for e in errors) / len(errors))
        self.assertGreater(len(errors), 200)
        self.assertAlmostEqual(deviation, 0.03, delta=4 * 0.03 / math.sqrt(2 * len(errors)))  # four standard errors

    def test_a_lidar_that_cannot_be_is_refused_with_all_its_faults(self):
        node = NodeProcess("bad", vehicle_file="car", world="flat", lidars=["a"],
                           a={"range_min": 50.0, "rings": 4, "link": "lazer", "sample": 3})
        self.assertNotEqual(node.exit_code(), 0)
        for part in ("~a/range_min: '50' is not below range_max '30'", "~a/rings: has no meaning with kind: planar",
                     "did you mean 'samples'?"):
            self.assertIn(part, node.output)
        node = NodeProcess("worse", vehicle_file="car", world="flat", lidars=["a"], a={"link": "lazer"})
        self.assertNotEqual(node.exit_code(), 0)
        self.assertIn("~a/link: the vehicle has no link 'lazer'; there are: ", node.output)
        node = NodeProcess("lost", vehicle_file="car", world="flat", a={"samples": 3})
        self.assertNotEqual(node.exit_code(), 0)
        self.assertIn("~a/samples: there is no such parameter", node.output)

    def test_vehicles_of_a_fleet_see_each_other(self):
        front = {"pose": [2.2, 0.0, 0.22, 0.0, 0.0, 0.0], "samples": 3, "angle_min": -0.6, "angle_max": 0.6}
        node = NodeProcess("pair", vehicles=["red", "blue"], vehicle_file="car", world="flat", clock="follow",
                           red={"start": [0.0, 40.0, 0.0], "lidars": ["front"], "front": front},
                           blue={"start": [8.0, 40.0, 0.0]})
        try:
            scans = Collector("/pair/red/front/scan", LaserScan)
            wait_until(lambda: self.sim.step(20) and scans.messages, "a scan of the red car")
            scan = scans.messages[0]
        finally:
            node.kill()
        self.assertEqual(scan.header.frame_id, "red/front")
        # Straight ahead the tail of the blue car's body, whose centre is as high as the lidar; 3 mm: both stand on springs.
        self.assertAlmostEqual(scan.ranges[1], 8.0 - 2.05 - 2.2, delta=0.003)
        self.assertEqual((scan.ranges[0], scan.ranges[2]), (math.inf, math.inf))

    def test_what_traces_the_rays_is_named_at_the_start(self):
        node = NodeProcess("short", vehicle_file="car", world="flat", duration=0.01, lidars=["front"], clock="follow",
                           front=LIDARS["front"])

        def ended():
            self.sim.step(20)  # the clock it follows
            return node.process.poll() is not None
        wait_until(ended, "the end of its duration")
        self.assertEqual(node.exit_code(), 0, node.output)
        self.assertIn("lidar 'front': 1 x 541 rays", node.output)
        self.assertRegex(node.output, "rays of lidars: (Embree 3|the simulator's own tree: )")


if __name__ == "__main__":
    rostest.rosrun("ellipsoid_vehicle_sim", "lidar", Lidar, sys.argv)
