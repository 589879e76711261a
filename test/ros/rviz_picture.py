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

# Colours as they come to the screen. RViz lights vehicles and arrows, so these are bands, not single values.


def paint(r, g, b):
    """The shipped car's red, in light and in shade."""
    return 60 < r < 225 and g < 0.3 * r and b < 0.3 * r


def sticks(r, g, b):
    return g > 110 and r < 0.4 * g and b < 0.5 * g


def slid(r, g, b):
    """The track of a sliding wheel; lines are not lit."""
    return abs(r - 204) < 4 and abs(g - 26) < 4 and abs(b - 26) < 4


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
    """What the shipped views show of the shipped car, on a screen of their own, drawn by the processor."""

    def shows(self, scene, **shares):
        """Waits until each colour takes a share of the picture within its limits; says which does not."""
        def outside(picture):
            found = {name: picture.share(globals()[name]) for name in shares}
            return ["%s: %.4f of the picture, expected %g to %g" % (name, found[name], low, high)
                    for name, (low, high) in shares.items() if not low <= found[name] <= high]

        def wanted(picture):
            self.last = outside(picture)
            return not self.last

        self.last = ["nothing was drawn"]
        with tempfile.TemporaryDirectory() as folder:
            try:
                make_pictures.pictures_of(scene, folder, wanted)
            except RuntimeError as error:
                with open(os.path.join(folder, "output")) as log:
                    self.fail("%s: %s\n%s" % (error, "; ".join(self.last), log.read()[-3000:]))

    def test_drive_shows_car_normals_and_course(self):
        # A car that rolls slides nowhere; the forces are a toggle that is off here; the world shows its front.
        self.shows(make_pictures.Scene("car", "course", "drive", make_pictures.steady(2.0), [0.5], (480, 300)),
                   paint=(0.01, 0.2), sticks=(0.003, 0.05), asphalt=(0.1, 0.7), grass=(0.1, 0.7), sky=(0.05, 0.5),
                   slid=(0.0, 0.0005), force=(0.0, 0.0005), back_side=(0.0, 0.0005))

    def test_contacts_show_slip_and_force(self):
        self.shows(make_pictures.Scene("car", "flat", "contacts", make_pictures.skid, [4.0], (480, 300)),
                   slid=(0.001, 0.1), force=(0.001, 0.1), sky=(0.02, 0.6))


if __name__ == "__main__":
    rospy.init_node("rviz_picture", disable_signals=True)
    rostest.rosrun("ellipsoid_vehicle_sim", "rviz_picture", RvizPicture, sys.argv)
