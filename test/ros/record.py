#!/usr/bin/python3
import csv
import hashlib
import os
import shutil
import subprocess
import sys
import tempfile
import unittest

import roslib.packages
import rosbag
import rospy
import rostest
import yaml

from controller_test_tools import odom_of_run

SECONDS = 3.0
TOPICS = {"/odom", "/joint_states", "/cmd_vel", "/clock", "/tf"}


def plot_run(*arguments):
    program = roslib.packages.find_node("ellipsoid_vehicle_sim", "plot_run")[0]
    return subprocess.run([program] + list(arguments), stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, timeout=60)


class Record(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        rospy.init_node("record_test")
        cls.scratch = tempfile.TemporaryDirectory()
        cls.folder = os.path.join(cls.scratch.name, "a run")
        cls.odom = odom_of_run("demo.launch", SECONDS, "record:=true", "record_folder:=" + cls.folder)

    @classmethod
    def tearDownClass(cls):
        cls.scratch.cleanup()

    def rows(self):
        with open(os.path.join(self.folder, "run.csv"), newline="") as file:
            return list(csv.DictReader(file))

    def test_table_says_what_odom_said(self):
        rows = {round(float(row["time"]) * 1e9): row for row in self.rows()}
        compared = 0
        for stamp, odom in self.odom.items():
            row = rows[stamp]
            for column, value in (("x", odom.pose.pose.position.x), ("y", odom.pose.pose.position.y),
                                  ("vx", odom.twist.twist.linear.x), ("wz", odom.twist.twist.angular.z)):
                self.assertEqual(float(row[column]), value)
            compared += 1
        self.assertGreater(compared, 0.9 * 50 * SECONDS)
        self.assertGreater(float(self.rows()[-1]["x"]), 1.0)  # it did drive

    def test_table_covers_the_run(self):
        times = [float(row["time"]) for row in self.rows()]
        self.assertEqual(times[0], 0.0)
        self.assertAlmostEqual(times[-1], SECONDS, delta=0.011)
        self.assertEqual(times, sorted(set(times)))

    def test_manifest_names_version_parameters_and_files_with_their_hashes(self):
        with open(os.path.join(self.folder, "manifest.yaml")) as file:
            manifest = yaml.safe_load(file)
        self.assertEqual(manifest["result"], "ok")
        for key in ("version", "parameters", "seed"):
            self.assertIn(key, manifest)
        self.assertEqual(manifest["parameters"]["dt"], 0.001)
        hashes = {os.path.basename(entry["path"]): entry for entry in manifest["files"]}
        for name in ("car.urdf", "course.yaml", "course_asphalt.stl"):
            with open(hashes[name]["path"], "rb") as file:
                self.assertEqual(hashes[name]["sha256"], hashlib.sha256(file.read()).hexdigest())

    def test_manifest_names_the_meshes_the_vehicle_is_made_from(self):
        share = roslib.packages.get_pkg_dir("ellipsoid_vehicle_sim")
        vehicle, folder = os.path.join(self.scratch.name, "own.urdf"), os.path.join(self.scratch.name, "own mesh")
        with open(os.path.join(share, "urdf", "skid_steer.urdf")) as file:
            text = file.read()
        with open(vehicle, "w") as file:
            file.write(text.replace("package://ellipsoid_vehicle_sim/meshes/unit_sphere.stl", "own_ball.stl"))
        shutil.copy(os.path.join(share, "meshes", "unit_sphere.stl"), os.path.join(self.scratch.name, "own_ball.stl"))
        odom_of_run("demo.launch", 0.2, "vehicle:=" + vehicle, "record:=true", "record_folder:=" + folder)
        with open(os.path.join(folder, "manifest.yaml")) as file:
            files = [os.path.basename(entry["path"]) for entry in yaml.safe_load(file)["files"]]
        self.assertEqual(files.count("own.urdf"), 1)
        self.assertEqual(files.count("own_ball.stl"), 1)

    def test_bag_holds_what_went_in_and_out(self):
        with rosbag.Bag(os.path.join(self.folder, "run.bag")) as bag:
            self.assertLessEqual(TOPICS, set(bag.get_type_and_topic_info().topics))
            self.assertGreater(bag.get_message_count("/odom"), 0.8 * 50 * SECONDS)

    def test_plot_is_drawn_as_png_and_svg(self):
        result = plot_run(self.folder, "-o", os.path.join(self.scratch.name, "plot"))
        self.assertEqual(result.returncode, 0, result.stderr)
        with open(os.path.join(self.scratch.name, "plot.png"), "rb") as file:
            self.assertTrue(file.read().startswith(b"\x89PNG"))
        with open(os.path.join(self.scratch.name, "plot.svg")) as file:
            svg = file.read()
        for title in ("Trajectory", "Speed", "Deepest penetration", "Energy", "Step time"):
            self.assertIn(title, svg)

    def test_bad_files_are_refused_with_place_and_value(self):
        good = "time,x,y,vx,wz,penetration,energy\n0,0,0,0,0,0,0\n"
        for content, text in (("", "the file is empty"), ("a,b\n1,2\n", ":1: no column time, x"),
                              (good, "1 lines of data"), (good + "1,0,0,0,0,0\n", ":3: 6 fields, expected 7"),
                              (good + "1,0,north,0,0,0,0\n", ":3: y is 'north'"), (good + "1,0,0,nan,0,0,0\n", ":3: vx is 'nan'"),
                              (good + "1,0,0,0,0,0,0\n0.5,0,0,0,0,0,0\n", ":4: time goes back"),
                              ("#ROSBAG V2.0\n", "a bag; give the run.csv")):
            path = os.path.join(self.scratch.name, "bad.csv")
            with open(path, "w") as file:
                file.write(content)
            result = plot_run(path)
            self.assertEqual(result.returncode, 1, content)
            self.assertIn(path, result.stderr)
            self.assertIn(text, result.stderr)
        result = plot_run("/no/such/file")
        self.assertEqual(result.returncode, 1)
        self.assertIn("/no/such/file: No such file", result.stderr)

    def test_folder_that_holds_a_run_is_refused(self):
        with self.assertRaisesRegex(AssertionError, "holds a run already"):
            odom_of_run("demo.launch", SECONDS, "record:=true", "record_folder:=" + self.folder)


if __name__ == "__main__":
    rostest.rosrun("ellipsoid_vehicle_sim", "record", Record, sys.argv)
