#!/usr/bin/python3
import os
import shutil
import sys
import tempfile
import unittest

import rospy
import rostest

sys.path.insert(0, os.path.join(os.path.dirname(os.path.realpath(__file__)), "..", "..", "scripts"))
import make_pictures  # noqa: E402

MISSING = [program for program in ("Xvfb", "rviz") if shutil.which(program) is None]

# Colours as they come to the screen. RViz lights vehicles and arrows, so these are bands of hue, not single values.


def paint(r, g, b):
    """The shipped car's red, in light and in shade; slipping arrows are brighter."""
    return 60 < r < 225 and g < 0.3 * r and b < 0.3 * r


def sticks(r, g, b):
    return g > 110 and r < 0.4 * g and b < 0.5 * g


def slips(r, g, b):
    return r >= 225 and 15 <= g < 0.4 * r and b < 0.35 * r


def force(r, g, b):
    """The yellow of the whole force."""
    return r > 150 and 0.7 * r < g < 0.95 * r and b < 0.35 * r


def asphalt(r, g, b):
    return 60 < g < 140 and abs(r - g) < 12 and 0 <= b - g < 16


def grass(r, g, b):
    return 60 < g < 160 and 1.1 * r < g and 1.6 * b < g


def back_side(r, g, b):
    return 15 < g < 60 and 1.5 * g < r and 2.0 * g < b


def sky(r, g, b):
    return (r, g, b) == (178, 200, 222)  # the background that the shipped configurations ask for


@unittest.skipIf(MISSING, "not installed: " + ", ".join(MISSING))
class RvizPicture(unittest.TestCase):
    """What the shipped configurations show of the shipped car, on a screen of their own, drawn by the processor."""

    def picture(self, scene):
        with tempfile.TemporaryDirectory() as folder:
            try:
                return make_pictures.pictures_of(scene, folder)[-1]
            except RuntimeError as error:
                with open(os.path.join(folder, "output")) as log:
                    self.fail("%s\n%s" % (error, log.read()[-3000:]))

    def between(self, picture, color, low, high):
        share = picture.share(color)
        self.assertGreaterEqual(share, low, "%s: %.4f of the picture" % (color.__name__, share))
        self.assertLessEqual(share, high, "%s: %.4f of the picture" % (color.__name__, share))

    def test_drive_shows_car_normals_and_course(self):
        picture = self.picture(make_pictures.Scene("car", "course", "drive", make_pictures.steady(2.0), [0.5], (480, 300)))
        self.between(picture, paint, 0.01, 0.2)
        self.between(picture, sticks, 0.003, 0.05)
        self.between(picture, asphalt, 0.1, 0.7)
        self.between(picture, grass, 0.1, 0.7)
        self.between(picture, sky, 0.05, 0.5)
        # A car that rolls slides nowhere; the forces are a toggle that is off here, and the world shows its front.
        for color in (slips, force, back_side):
            self.between(picture, color, 0.0, 0.0005)

    def test_contacts_show_slip_forces_and_a_see_through_car(self):
        # Upside down is the world from below: a camera under the road sees back sides.
        scene = make_pictures.Scene("car", "flat", "contacts", make_pictures.skid, [4.0], (480, 300))
        picture = self.picture(scene)
        self.between(picture, slips, 0.0005, 0.1)
        self.between(picture, force, 0.001, 0.1)


if __name__ == "__main__":
    rospy.init_node("rviz_picture", disable_signals=True)
    rostest.rosrun("ellipsoid_vehicle_sim", "rviz_picture", RvizPicture, sys.argv)
