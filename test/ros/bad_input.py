#!/usr/bin/python3
"""Every refusal: exit code 1, a message that says what is wrong, nothing advertised."""
import glob
import os
import sys
import tempfile
import unittest

import rospkg
import rospy
import rostest

from sim_test_tools import NodeProcess

ROBOT = """<?xml version="1.0"?>
<robot name="box">
  <link name="base_link">
    <inertial><mass value="%(mass)s"/><inertia ixx="%(ixx)s" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>
    <collision><geometry>%(shape)s</geometry></collision>
  </link>
%(more)s</robot>
"""
LEGS = "".join('  <link name="leg_%d"><inertial><mass value="1"/><inertia ixx="0.01" iyy="0.01" izz="0.01" ixy="0" ixz="0" '
               'iyz="0"/></inertial><collision><geometry><sphere radius="0.1"/></geometry></collision></link>\n'
               '  <joint name="joint_%d" type="fixed"><parent link="base_link"/><child link="leg_%d"/><origin '
               'xyz="%g %g -0.5"/></joint>\n' % (i, i, i, x, y)
               for i, (x, y) in enumerate([(0.5, 0.5), (0.5, -0.5), (-0.5, 0.0)]))
GOOD = {"mass": "10", "ixx": "1", "shape": '<sphere radius="0.2"/>', "more": LEGS}


class BadInput(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        rospy.init_node("bad_input")
        cls.folder = tempfile.TemporaryDirectory()
        cls.package = rospkg.RosPack().get_path("ellipsoid_vehicle_sim")
        cls.count = 0

    @classmethod
    def tearDownClass(cls):
        cls.folder.cleanup()

    def file(self, name, text):
        path = os.path.join(self.folder.name, name)
        with open(path, "w" if isinstance(text, str) else "wb") as file:
            file.write(text)
        return path

    def robot(self, **changes):
        return self.file("box.urdf", ROBOT % dict(GOOD, **changes))

    def refused(self, *texts, **parameters):
        """The node ends with exit code 1 and says each of the texts in an error line; its output."""
        type(self).count += 1
        values = {"vehicle_file": "car", "world": "flat"}
        values.update(parameters)
        node = NodeProcess("bad_%d" % self.count, **{key: value for key, value in values.items() if value is not None})
        self.assertEqual(node.exit_code(), 1, node.output)
        errors = "".join(line for line in node.output.splitlines(True) if "ERROR" in line)
        for text in texts:
            self.assertIn(text, errors, node.output)
        self.assertIn("not started", errors)
        return errors

    # Where things are.

    def test_vehicle_missing(self):
        self.refused("~vehicle_file: '/no/such.urdf' is no file that can be read", vehicle_file="/no/such.urdf")

    def test_vehicle_not_given(self):
        self.refused("~vehicle_file: no vehicle", vehicle_file=None)

    def test_unknown_vehicle_lists_the_known(self):
        self.refused("'tank' is no known vehicle", "car", "skid_steer", vehicle_file="tank")

    def test_world_missing(self):
        self.refused("~world: '/no/such.stl' is no file that can be read", world="/no/such.stl")

    def test_world_not_given(self):
        self.refused("~world: no world", world=None)

    def test_unknown_world_lists_the_known(self):
        self.refused("'moon' is no known world", "flat", "course", world="moon")

    # The vehicle.

    def test_every_bad_file_of_the_test_data(self):
        files = sorted(glob.glob(os.path.join(self.package, "test", "data", "urdf", "bad_*.urdf")))
        self.assertGreater(len(files), 10)
        for path in files:
            with self.subTest(file=os.path.basename(path)):
                self.refused(os.path.basename(path), vehicle_file=path)

    def test_not_xml(self):
        self.refused("box.urdf", vehicle_file=self.file("box.urdf", "<robot name='box'><link name="))

    def test_empty_file(self):
        self.refused("box.urdf", vehicle_file=self.file("box.urdf", ""))

    def test_no_wheel_nor_anything_else_to_stand_on(self):
        self.refused(vehicle_file=self.file("box.urdf", '<robot name="box"><link name="base_link"/></robot>'))

    def test_negative_mass(self):
        self.refused("box.urdf:4", "-10", vehicle_file=self.robot(mass="-10"))

    def test_zero_mass(self):
        self.refused("mass", vehicle_file=self.robot(mass="0", more=""))

    def test_mass_that_is_not_a_number(self):
        self.refused("box.urdf:4", "nan", vehicle_file=self.robot(mass="nan"))

    def test_inertia_no_body_can_have(self):
        self.refused("box.urdf:4", vehicle_file=self.robot(ixx="100"))

    def test_negative_radius(self):
        self.refused("box.urdf:5", "-0.2", vehicle_file=self.robot(shape='<sphere radius="-0.2"/>'))

    def test_zero_radius(self):
        self.refused("box.urdf:5", vehicle_file=self.robot(shape='<sphere radius="0"/>'))

    def test_shape_that_urdfdom_drops(self):
        self.refused("box.urdf:5", "ellipsoid", vehicle_file=self.robot(shape='<ellipsoid radii="1 1 1"/>'))

    def test_collision_mesh_missing(self):
        self.refused("package://nowhere/mesh.stl",
                     vehicle_file=self.robot(shape='<mesh filename="package://nowhere/mesh.stl"/>'))

    def test_all_problems_of_a_file_at_once(self):
        errors = self.refused("-10", "-0.2", vehicle_file=self.robot(mass="-10", shape='<sphere radius="-0.2"/>'))
        self.assertGreaterEqual(errors.count("box.urdf:"), 2)

    # The world.

    def test_world_empty(self):
        self.refused("world.stl", world=self.file("world.stl", ""))

    def test_world_is_a_git_lfs_pointer(self):
        self.refused("world.stl", "git-lfs", world=self.file(
            "world.stl", "version https://git-lfs.github.com/spec/v1\noid sha256:%s\nsize 84\n" % ("0" * 64)))

    def test_world_with_nan(self):
        self.refused("world.stl", "nan", world=self.file("world.stl", """solid w
facet normal 0 0 1
outer loop
vertex 0 0 0
vertex nan 0 0
vertex 0 1 0
endloop
endfacet
endsolid w
"""))

    def test_world_yaml_with_unknown_key(self):
        self.refused("world.yaml", world=self.file("world.yaml", "meshes:\n  - {fil: flat.stl}\n"))

    def test_no_ground_below_the_start(self):
        self.refused(start=[1e6, 1e6, 0.0])

    # Parameters.

    def test_misspelt_parameter(self):
        self.refused("~stifness: there is no such parameter", "did you mean 'stiffness'?", stifness=1e6)

    def test_parameter_out_of_range(self):
        self.refused("~dt: '-0.001' is out of range", dt=-0.001)

    def test_parameter_of_the_wrong_type(self):
        self.refused("~dt: '1e-3' was read, expected a number", dt="1e-3")

    def test_step_too_large(self):
        self.refused("step", dt=0.1)

    def test_base_frame_that_is_not_the_root(self):
        self.refused("~base_frame: 'chassis' is not the root link", base_frame="chassis")

    def test_problems_of_parameters_vehicle_and_world_at_once(self):
        self.refused("stifness", "tank", "moon", stifness=1e6, vehicle_file="tank", world="moon")


if __name__ == "__main__":
    rostest.rosrun("ellipsoid_vehicle_sim", "bad_input", BadInput, sys.argv)
