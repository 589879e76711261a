"""Draws the pictures of docs/pictures with RViz on a screen of its own: see scripts/make_pictures.

The simulator runs in lockstep and this program is its commander, so that each picture shows a certain step, however slow
the machine draws: a picture is taken once the screen does not change any more while time stands still.
"""
import argparse
import math
import os
import re
import subprocess
import sys
import tempfile
import threading
import time

import rosgraph
import rospy
from geometry_msgs.msg import Twist
from nav_msgs.msg import Odometry

from run_demo import free_port
from shipped_files import share_folder
from virtual_screen import VirtualScreen

PERIOD = 0.02  # [s] between two odom messages
DEADLINE = 60.0  # [s] of wall time for anything to happen
QUIET = 1.0  # [s] of wall time without a change on the screen: RViz draws at 30 Hz, a slow machine at 3


class Scene:
    """What to show: a drive, where to look from, and at which simulated times."""

    def __init__(self, vehicle, world, view, drive, times, size, start=None, changes=(), first=""):
        """first: name space of the vehicle that this program drives, of the convoy; "": there is one vehicle."""
        self.vehicle, self.world, self.view, self.drive, self.times = vehicle, world, view, drive, times
        self.size, self.start, self.changes, self.first = size, start, changes, first

    def launch(self):
        arguments = ["world:=" + self.world, "lockstep:=true", "real_time_factor:=0"]
        if self.first:
            return ["convoy.launch", "driver:=false", "rviz:=false"] + arguments
        return ["simulator.launch", "vehicle:=" + self.vehicle] + arguments


def steady(speed, yaw_rate=0.0):
    return lambda seconds: (speed, yaw_rate)


def skid(seconds):
    """Straight on, then the wheel hard over."""
    return (9.0, 0.0) if seconds < 3.0 else (9.0, 2.0)


SCENES = {
    # Both axles of the car among the bumps.
    "course.png": Scene("car", "course", "drive", steady(4.0), [4.5], (760, 460),
                        changes=[("Distance: 9", "Distance: 8"), ("Pitch: 0.35", "Pitch: 0.4"), ("Yaw: 3.8", "Yaw: 3.9")]),
    "contacts.png": Scene("car", "course", "contacts", skid, [4.0], (760, 460), start=[60.0, -16.0, math.pi]),
    # The first of the four comes off the kerb.
    "convoy.png": Scene("", "course", "convoy", steady(3.0), [6.0], (760, 460), first="/alpha/",
                        changes=[("Distance: 22", "Distance: 23"), ("Pitch: 0.35", "Pitch: 0.4"), ("Yaw: 3.8", "Yaw: 4.1")]),
    "drive.gif": Scene("car", "course", "drive", steady(5.0), [0.6 + 0.1 * k for k in range(60)], (560, 340),
                       changes=[("Distance: 9", "Distance: 8.5"), ("Pitch: 0.35", "Pitch: 0.3")]),
}


class Commander:
    """Answers odom with commands, one for each; what it does not answer stands still."""

    def __init__(self, namespace):
        self._arrived = threading.Condition()
        self._messages = []
        self._publisher = rospy.Publisher(namespace + "cmd_vel", Twist, queue_size=100, tcp_nodelay=True)
        # A command sent before the simulator has connected would be lost, and lockstep would wait for it for ever.
        wait_until(lambda: self._publisher.get_num_connections() > 0, "the simulator to listen to cmd_vel")
        self._subscriber = rospy.Subscriber(namespace + "odom", Odometry, self._take, queue_size=100, tcp_nodelay=True)

    def _take(self, message):
        with self._arrived:
            if not self._messages or self._messages[-1].header.stamp != message.header.stamp:
                self._messages.append(message)
                self._arrived.notify_all()

    def next_odom(self):
        with self._arrived:
            if not self._arrived.wait_for(lambda: self._messages, DEADLINE):
                raise RuntimeError("no odom for %g s" % DEADLINE)
            return self._messages.pop(0)

    def answer(self, speed, yaw_rate):
        command = Twist()
        command.linear.x, command.angular.z = speed, yaw_rate
        self._publisher.publish(command)

    def close(self):
        self._publisher.unregister()
        self._subscriber.unregister()


def wait_until(condition, what):
    end = time.monotonic() + DEADLINE
    while not condition():
        if time.monotonic() > end:
            raise RuntimeError("waited %g s for %s" % (DEADLINE, what))
        time.sleep(0.02)


def subscribed(topic, node):
    _, subscribers, _ = rosgraph.Master("/make_pictures").getSystemState()
    return any(name == topic and node in nodes for name, nodes in subscribers)


def view_file(scene, folder):
    """The shipped configuration, filling the screen, with the scene's changes."""
    with open(os.path.join(share_folder(), "launch", scene.view + ".rviz")) as file:
        text = file.read()
    width, height = scene.size
    changes = [("Width: 1200", "Width: %d" % width), ("Height: 846", "Height: %d" % height), ("X: 60", "X: 0"),
               ("Y: 60", "Y: 0")]
    for old, new in changes + list(scene.changes):
        if len(re.findall("(?m)^ *%s$" % re.escape(old), text)) != 1:
            raise RuntimeError("%s.rviz has not just one line '%s'" % (scene.view, old))
        text = re.sub("(?m)^( *)%s$" % re.escape(old), lambda match: match.group(1) + new, text)
    path = os.path.join(folder, "view.rviz")
    with open(path, "w") as file:
        file.write(text)
    return path


def has_sky(picture):
    """RViz has begun to draw: the background colour of the shipped views is to be seen."""
    return picture.share(lambda r, g, b: (r, g, b) == (178, 200, 222)) > 0.02


def settled(screen, wanted):
    """The screen once nothing has moved on it for a while and it is what was wanted."""
    picture, since = screen.grab(), time.monotonic()
    end = since + DEADLINE
    while time.monotonic() - since < QUIET or not wanted(picture):
        time.sleep(0.05)
        now = screen.grab()
        if now != picture:
            picture, since = now, time.monotonic()
        if time.monotonic() > end:
            raise RuntimeError("in %g s the screen did not show what was wanted, at rest" % DEADLINE)
    return picture


def pictures_of(scene, folder, wanted=has_sky):
    """One picture for each time of the scene; each is waited for until wanted(picture)."""
    if scene.start:
        rospy.set_param("/simulator/start", scene.start)
    log = open(os.path.join(folder, "output"), "a")
    with VirtualScreen(*scene.size) as screen:
        simulator = subprocess.Popen(["roslaunch", "--wait", "ellipsoid_vehicle_sim"] + scene.launch(),
                                     stdout=log, stderr=log)
        rviz = None
        commander = None
        try:
            commander = Commander(scene.first)
            first = commander.next_odom()
            rviz = subprocess.Popen(["rviz", "--fullscreen", "-d", view_file(scene, folder), "__name:=rviz"],
                                    env=screen.environment(), stdout=log, stderr=log)
            own = scene.first or "/"
            for topic in (own + "contact_markers", own + "collision_shapes", "/world"):
                wait_until(lambda: subscribed(topic, "/rviz"), "RViz to subscribe %s" % topic)
            settled(screen, has_sky)
            result, odom, start = [], first, first.header.stamp.to_sec()
            for moment in scene.times:
                while odom.header.stamp.to_sec() - start < moment - 1e-6:
                    commander.answer(*scene.drive(odom.header.stamp.to_sec() - start))
                    odom = commander.next_odom()
                result.append(settled(screen, wanted))
                print("%.1f s" % moment, end=" ", flush=True)
            print()
            return result
        finally:
            if commander:
                commander.close()
            for process in (rviz, simulator):
                if process:
                    process.terminate()
                    process.wait()
            log.close()
            if scene.start:
                rospy.delete_param("/simulator")


def write(pictures, path):
    """One picture as PNG, several as an endless GIF at their pace; few colours, as few bytes as that gives."""
    from PIL import Image
    images = [Image.frombytes("RGB", (picture.width, picture.height), picture.rgb) for picture in pictures]
    if path.endswith(".png"):
        images[0].quantize(192, dither=Image.Dither.NONE).save(path, optimize=True)
        return
    # One palette for all, or colours would flicker.
    everything = Image.new("RGB", (images[0].width, images[0].height * 4))
    for k in range(4):
        everything.paste(images[k * (len(images) - 1) // 3], (0, k * images[0].height))
    palette = everything.quantize(96, dither=Image.Dither.NONE)
    frames = [image.quantize(palette=palette, dither=Image.Dither.NONE) for image in images]
    frames[0].save(path, save_all=True, append_images=frames[1:], duration=100, loop=0, optimize=True)


def main():
    parser = argparse.ArgumentParser(prog="scripts/make_pictures", description=__doc__.splitlines()[0])
    parser.add_argument("--folder", default=os.path.join(share_folder(), "docs", "pictures"))
    parser.add_argument("names", nargs="*", metavar="NAME", help="of %s; default: all" % ", ".join(SCENES))
    arguments = parser.parse_args()
    unknown = [name for name in arguments.names if name not in SCENES]
    if unknown:
        parser.error("no picture is called %s; there are %s" % (", ".join(unknown), ", ".join(SCENES)))
    try:
        import PIL  # noqa: F401
    except ImportError:
        parser.error("python3-pil is not installed")

    os.makedirs(arguments.folder, exist_ok=True)
    with tempfile.TemporaryDirectory() as folder:
        port = free_port()
        os.environ.update(ROS_MASTER_URI="http://localhost:%d" % port, ROS_HOSTNAME="localhost", ROS_HOME=folder,
                          ROS_LOG_DIR=os.path.join(folder, "log"))
        with open(os.path.join(folder, "master"), "w") as log:
            master = subprocess.Popen(["roscore", "-p", str(port)], stdout=log, stderr=log)
        try:
            wait_until(rosgraph.is_master_online, "the master")
            rospy.init_node("make_pictures", anonymous=True, disable_signals=True)
            for name in arguments.names or SCENES:
                print("%s:" % name, end=" ", flush=True)
                try:
                    pictures = pictures_of(SCENES[name], folder)
                except (RuntimeError, FileNotFoundError) as error:
                    with open(os.path.join(folder, "output")) as log:
                        print("\n".join(log.read().splitlines()[-30:]), file=sys.stderr)
                    print(error, file=sys.stderr)
                    return 1
                write(pictures, os.path.join(arguments.folder, name))
        finally:
            master.terminate()
            master.wait()
    return 0


if __name__ == "__main__":
    sys.exit(main())
