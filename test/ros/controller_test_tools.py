"""Runs one of the package's launch files beside a test, in lockstep, and keeps what the vehicle did."""
import math
import os
import signal
import subprocess
import tempfile

import rospy
from nav_msgs.msg import Odometry

from sim_test_tools import DEADLINE, wait_until


def heading_of(odom):
    q = odom.pose.pose.orientation
    return math.atan2(2.0 * (q.w * q.z + q.x * q.y), 1.0 - 2.0 * (q.y * q.y + q.z * q.z))


def along_heading(odom, distance):
    """x, y of the point that lies so far ahead of odom's."""
    heading = heading_of(odom)
    return (odom.pose.pose.position.x + distance * math.cos(heading), odom.pose.pose.position.y + distance * math.sin(heading))


class Launch:
    """`roslaunch FILE ARGUMENTS` on this test's master, FILE of the package or a path; ends with the `with` block."""

    def __init__(self, file, *arguments, **popen):
        self._log = tempfile.TemporaryFile("w+", errors="replace")
        self.process = subprocess.Popen(["roslaunch", "--wait", *([file] if "/" in file else ["ellipsoid_vehicle_sim", file]),
                                         *arguments],
                                        stdout=self._log, stderr=subprocess.STDOUT, **popen)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        if self.process.poll() is None:
            self.process.send_signal(signal.SIGINT)
            try:
                self.process.wait(DEADLINE)
            except subprocess.TimeoutExpired:
                os.kill(self.process.pid, signal.SIGKILL)
                self.process.wait()
        self._log.close()

    @property
    def output(self):
        self._log.seek(0)
        return self._log.read()

    def wait_for_end(self, deadline=DEADLINE):
        try:
            self.process.wait(deadline)
        except subprocess.TimeoutExpired:
            raise AssertionError("still running after %g s:\n%s" % (deadline, self.output))


def odom_of_run(file, seconds, *arguments):
    """Launches without a window, in lockstep, for so many simulated seconds; the odom messages by their stamp."""
    messages = {}
    subscriber = rospy.Subscriber("/odom", Odometry, lambda m: messages.setdefault(m.header.stamp.to_nsec(), m),
                                  queue_size=10000, tcp_nodelay=True)
    with Launch(file, "rviz:=false", "lockstep:=true", "real_time_factor:=0", "duration:=%g" % seconds,
                *arguments) as launch:
        launch.wait_for_end(2.0 * DEADLINE)
        # The last message may still be in the socket.
        try:
            wait_until(lambda: messages and max(messages) >= round(1e9 * (seconds - 0.05)), "the last odom", 5.0)
        except AssertionError:
            raise AssertionError("the run did not last %g s:\n%s" % (seconds, launch.output))
    subscriber.unregister()
    return messages


def same_motion(test, one, other):
    """Both runs are the same to the last bit wherever both were seen; a few first messages may have been missed."""
    common = set(one) & set(other)
    test.assertGreater(len(common), 0.9 * max(len(one), len(other)))
    for stamp in sorted(common):
        test.assertEqual((one[stamp].pose, one[stamp].twist), (other[stamp].pose, other[stamp].twist))
