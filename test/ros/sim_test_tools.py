"""What the rostests share: waiting for events with a deadline, playing the commander in lockstep, starting the node."""
import os
import signal
import subprocess
import threading
import time

import roslib.packages
import rospy
from geometry_msgs.msg import Twist
from nav_msgs.msg import Odometry

DEADLINE = 60.0  # [s] of wall time: far above what anything here takes, also on a loaded machine
NODE = "ellipsoid_vehicle_sim_node"


def wait_until(condition, what, deadline=DEADLINE):
    """Returns the first true value of condition(); AssertionError if there is none in time."""
    end = time.monotonic() + deadline
    while time.monotonic() < end and not rospy.is_shutdown():
        value = condition()
        if value:
            return value
        time.sleep(0.005)
    raise AssertionError("waited %g s for: %s" % (deadline, what))


def twist(speed, yaw_rate=0.0):
    message = Twist()
    message.linear.x = speed
    message.angular.z = yaw_rate
    return message


class Commander:
    """The commander of a simulator in lockstep: takes odom messages one by one and answers each."""

    def __init__(self, namespace=""):
        self._arrived = threading.Condition()
        self._messages = []
        self._publisher = rospy.Publisher(namespace + "cmd_vel", Twist, queue_size=100, tcp_nodelay=True)
        wait_until(lambda: self._publisher.get_num_connections() > 0, "a subscriber of cmd_vel")
        rospy.Subscriber(namespace + "odom", Odometry, self._take, queue_size=100, tcp_nodelay=True)

    def _take(self, message):
        with self._arrived:
            if not self._messages or self._messages[-1].header.stamp != message.header.stamp:
                self._messages.append(message)
                self._arrived.notify_all()

    def next_odom(self, deadline=DEADLINE):
        with self._arrived:
            if not self._arrived.wait_for(lambda: self._messages, deadline):
                raise AssertionError("no odom for %g s" % deadline)
            return self._messages.pop(0)

    def answer(self, message):
        self._publisher.publish(message)

    def drive(self, command, odom_messages):
        """Answers so many odom messages with the same command; all of them."""
        received = []
        for _ in range(odom_messages):
            received.append(self.next_odom())
            self.answer(command)
        return received


class NodeProcess:
    """The node's own binary, with private parameters, in a name space of its own."""

    def __init__(self, name, **parameters):
        rospy.set_param("/%s/simulator" % name, parameters)
        for key in ("robot_description",):
            if rospy.has_param("/%s/%s" % (name, key)):
                rospy.delete_param("/%s/%s" % (name, key))
        binary = roslib.packages.find_node("ellipsoid_vehicle_sim", NODE)[0]
        self.process = subprocess.Popen([binary, "__name:=simulator", "__ns:=/" + name], stdout=subprocess.PIPE,
                                        stderr=subprocess.STDOUT, text=True, errors="replace", cwd="/",
                                        env=dict(os.environ, ROSCONSOLE_FORMAT="${severity}: ${message}"))
        self._lines = []
        self._reader = threading.Thread(target=self._read, daemon=True)
        self._reader.start()

    def _read(self):
        for line in self.process.stdout:
            self._lines.append(line)

    @property
    def output(self):
        return "".join(self._lines)

    def exit_code(self, deadline=DEADLINE):
        """Waits for the end; AssertionError with the output if it does not come."""
        try:
            code = self.process.wait(deadline)
        except subprocess.TimeoutExpired:
            self.process.kill()
            raise AssertionError("still running after %g s:\n%s" % (deadline, self.output))
        self._reader.join(5.0)
        return code

    def interrupt(self):
        """Ctrl-C; the exit code and the wall time it took [s]."""
        start = time.monotonic()
        self.process.send_signal(signal.SIGINT)
        code = self.exit_code()
        return code, time.monotonic() - start

    def kill(self):
        if self.process.poll() is None:
            self.process.kill()
            self.process.wait()
