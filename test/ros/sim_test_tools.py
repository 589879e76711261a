"""What the rostests share: waiting for events with a deadline, playing the commander in lockstep, starting the node."""
import math
import os
import signal
import subprocess
import threading
import time

import genpy.dynamic
import roslib.packages
import rospy
from ellipsoid_vehicle_sim.srv import SetPose, SetPoseRequest, Step
from geometry_msgs.msg import Twist
from nav_msgs.msg import Odometry
from std_srvs.srv import Trigger

# How much longer than usual everything may take: scripts/test --sanitize sets it. For deadlines only.
SLOWDOWN = max(1.0, float(os.environ.get("ELLIPSOID_VEHICLE_SIM_SLOWDOWN", "1")))
DEADLINE = 60.0 * SLOWDOWN  # [s] of wall time: far above what anything here takes, also on a loaded machine
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


class Stepper:
    """A simulator that stands still but when told: services by name, commands that have arrived, ticks counted."""

    def __init__(self, node="simulator"):
        self.node = node
        self._proxies = {}
        rospy.wait_for_service(node + "/pause", DEADLINE)
        assert self.call("pause", Trigger).success

    def call(self, service, kind, *arguments, **fields):
        if service not in self._proxies:
            rospy.wait_for_service("%s/%s" % (self.node, service), DEADLINE)
            self._proxies[service] = rospy.ServiceProxy("%s/%s" % (self.node, service), kind)
        return self._proxies[service](*arguments, **fields)

    def step(self, ticks=1):
        """Simulated time afterwards."""
        response = self.call("step", Step, ticks)
        assert response.success, response.message
        return response.stamp

    def hash(self):
        return self.call("state_hash", Trigger).message

    def send(self, publisher, message):
        """Publishes until the simulator has it: a command in force is part of the state."""
        before = self.hash()
        publisher.publish(message)
        wait_until(lambda: self.hash() != before, "the command on " + publisher.name)

    def set_pose(self, x, y, yaw=0.0, frame="", settle=True, z=0.0):
        request = SetPoseRequest(settle=settle)
        request.pose.header.frame_id = frame
        request.pose.pose.position.x, request.pose.pose.position.y, request.pose.pose.position.z = x, y, z
        request.pose.pose.orientation.z, request.pose.pose.orientation.w = math.sin(yaw / 2), math.cos(yaw / 2)
        return self.call("set_pose", SetPose, request)


class Collector:
    """Every message of a topic, in order."""

    def __init__(self, topic, kind):
        self.messages = []
        self._subscriber = rospy.Subscriber(topic, kind, self.messages.append, queue_size=10000)
        self.topic = topic
        wait_until(lambda: self._subscriber.get_num_connections() > 0, "a publisher of " + topic)

    @staticmethod
    def stamp(message):
        return message.clock if hasattr(message, "clock") else message.header.stamp

    def until(self, stamp):
        """The messages so far, once one of that time or later is there."""
        wait_until(lambda: self.messages and self.stamp(self.messages[-1]) >= stamp, "%s at %s" % (self.topic, stamp))
        return list(self.messages)

    def clear(self):
        del self.messages[:]


def publisher_of(topic, kind):
    """A publisher that somebody listens to."""
    publisher = rospy.Publisher(topic, kind, queue_size=5000, tcp_nodelay=True)
    wait_until(lambda: publisher.get_num_connections() > 0, "a subscriber of " + topic)
    return publisher


ACKERMANN = """Header header
AckermannDrive drive
================================================================================
MSG: std_msgs/Header
uint32 seq
time stamp
string frame_id
================================================================================
MSG: ackermann_msgs/AckermannDrive
float32 steering_angle
float32 steering_angle_velocity
float32 speed
float32 acceleration
float32 jerk
"""


def ackermann_class():
    """ackermann_msgs/AckermannDriveStamped as rospy makes it from the definition, without the package."""
    return genpy.dynamic.generate_dynamic("ackermann_msgs/AckermannDriveStamped",
                                          ACKERMANN)["ackermann_msgs/AckermannDriveStamped"]
