"""The demo itself, in the environment that scripts/demo prepares: one roslaunch with a master of its own."""
import argparse
import ctypes
import math
import os
import re
import shlex
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import time
import xml.etree.ElementTree as ElementTree

import shipped_files

SCRIPTS = os.path.dirname(os.path.realpath(__file__))
LEAST_DISTANCE = 1.0  # [m] that the vehicle must have moved
DEFAULT_SECONDS = 20.0  # [s] simulated, headless; with a window until it is closed
# Wall time allowed beyond the simulated time: a slow machine, RViz starting.
PATIENCE = 180.0  # [s]
DISTANCE_PER_REACH = 6.0  # of RViz's camera, over the largest distance of a joint from its parent
KEYS = ["simulated time", "distance", "real-time factor", "step time mean", "step time p99", "largest penetration",
        "most contacts", "result"]
UNITS = {"simulated time": " s", "distance": " m", "step time mean": " us", "step time p99": " us",
         "largest penetration": " mm"}
PR_SET_PDEATHSIG, PR_SET_CHILD_SUBREAPER = 1, 36  # linux/prctl.h


def parse_arguments():
    parser = argparse.ArgumentParser(
        prog="scripts/demo", description="A vehicle drives a world in RViz, or headless as fast as the machine can.")
    parser.add_argument("--headless", action="store_true", help="no window; in lockstep, as fast as possible")
    parser.add_argument("--seconds", type=float, help="simulated time (headless: %g; with a window: until it is closed)"
                        % DEFAULT_SECONDS)
    parser.add_argument("--vehicle", default="car", help="shipped name or path of a URDF: %s"
                        % ", ".join(sorted(shipped_files.vehicles())))
    parser.add_argument("--world", default="course", help="shipped name or path of a mesh or world YAML: %s"
                        % ", ".join(sorted(shipped_files.worlds())))
    parser.add_argument("--view", default="drive", choices=["drive", "contacts"],
                        help="what RViz shows: the drive (default), or its contacts close up")
    parser.add_argument("--check", action="store_true", help=argparse.SUPPRESS)  # look at the arguments, do nothing
    arguments = parser.parse_args()
    if arguments.seconds is not None and not 0.0 < arguments.seconds < 1e6:
        parser.error("--seconds must be above 0, and below 1e6")
    for kind in ("vehicle", "world"):
        name = getattr(arguments, kind)
        try:
            path = shipped_files.find(kind, name)
        except LookupError as error:
            parser.error(str(error))
        # A shipped name stays a name: the simulator knows where its build put the file.
        if os.path.isfile(name):
            setattr(arguments, kind, path)
    return arguments


def rviz_config(view, vehicle, folder):
    """A shipped RViz configuration with the camera on this vehicle's root link, as far away as its size asks for."""
    with open(os.path.join(shipped_files.share_folder(), "launch", view + ".rviz")) as file:
        text = file.read()
    try:
        urdf = ElementTree.parse(shipped_files.find("vehicle", vehicle)).getroot()
        joints = urdf.findall("joint")
        children = {joint.find("child").get("link") for joint in joints}
        root = [link.get("name") for link in urdf.findall("link") if link.get("name") not in children][0]
        # How far its joints reach from one another: about its length.
        reach = max(math.hypot(*(float(x) for x in joint.find("origin").get("xyz").split()))
                    for joint in joints if joint.find("origin") is not None and joint.find("origin").get("xyz"))
        text = text.replace("Target Frame: base_link", "Target Frame: " + root)
        for view_distance, share in (("9", 1.0), ("6.5", 0.7)):  # of drive.rviz, of contacts.rviz
            text = text.replace("Distance: %s\n" % view_distance,
                                "Distance: %.3g\n" % min(30.0, max(1.5, share * DISTANCE_PER_REACH * reach)))
    except (ElementTree.ParseError, AttributeError, IndexError, ValueError):
        pass  # the simulator will say what is wrong with it; the shipped view will do
    path = os.path.join(folder, "demo.rviz")
    with open(path, "w") as file:
        file.write(text)
    return path


def free_port():
    with socket.socket() as probe:
        probe.bind(("localhost", 0))
        return probe.getsockname()[1]


def descendants():
    """Ids of all processes below this one, which as their reaper also inherits orphans."""
    children = {}
    for entry in os.listdir("/proc"):
        if not entry.isdigit():
            continue
        try:
            with open("/proc/%s/stat" % entry) as file:
                fields = file.read().rsplit(")", 1)[1].split()
        except OSError:
            continue
        children.setdefault(int(fields[1]), []).append(int(entry))
    found, open_list = [], [os.getpid()]
    while open_list:
        below = children.get(open_list.pop(), [])
        found += below
        open_list += below
    return found


def reap():
    try:
        while os.waitpid(-1, os.WNOHANG)[0]:
            pass
    except ChildProcessError:
        pass


def leave_no_process(patience=5.0):
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGKILL):
        deadline = time.monotonic() + patience
        for process in descendants():
            try:
                os.kill(process, number)
            except ProcessLookupError:
                pass
        while time.monotonic() < deadline:
            reap()
            if not descendants():
                return
            time.sleep(0.05)


def run(arguments, folder):
    """Starts roslaunch and waits for its end; why it was ended early, or None."""
    port = free_port()
    seconds = arguments.seconds or (DEFAULT_SECONDS if arguments.headless else 0.0)
    environment = dict(os.environ, ROS_MASTER_URI="http://localhost:%d" % port, ROS_HOSTNAME="localhost",
                       ROS_HOME=folder, ROS_LOG_DIR=os.path.join(folder, "log"))
    command = ["roslaunch", "-p", str(port), "ellipsoid_vehicle_sim", "demo.launch",
               "vehicle:=" + arguments.vehicle, "world:=" + arguments.world, "duration:=%r" % seconds,
               "rviz:=" + ("false" if arguments.headless else "true"),
               "rviz_config:=" + rviz_config(arguments.view, arguments.vehicle, folder),
               "lockstep:=" + ("true" if arguments.headless else "false"),
               "real_time_factor:=" + ("0" if arguments.headless else "1"),
               "summary_file:=" + os.path.join(folder, "summary"),
               "launch_prefix:=%s %s" % (shlex.quote(os.path.join(SCRIPTS, "record_exit_status")),
                                         shlex.quote(os.path.join(folder, "exit_status")))]
    print("to join from a second terminal:  export ROS_MASTER_URI=http://localhost:%d ROS_HOSTNAME=localhost" % port)
    print("log: %s" % os.path.join(folder, "roslaunch.txt"), flush=True)

    libc = ctypes.CDLL(None)
    libc.prctl(PR_SET_CHILD_SUBREAPER, 1, 0, 0, 0)
    stopped = []
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        signal.signal(number, lambda received, _: stopped.append(received))
    with open(os.path.join(folder, "roslaunch.txt"), "w") as log:
        # A session of its own: Ctrl-C in the terminal reaches this program alone, which ends the others in order.
        # roslaunch ends its nodes on SIGINT; it gets one too should this program be killed.
        launch = subprocess.Popen(command, env=environment, stdout=log, stderr=subprocess.STDOUT, stdin=subprocess.DEVNULL,
                                  start_new_session=True,
                                  preexec_fn=lambda: libc.prctl(PR_SET_PDEATHSIG, signal.SIGINT, 0, 0, 0))
        deadline = time.monotonic() + PATIENCE + 10.0 * seconds if seconds else float("inf")
        reason = None
        while launch.poll() is None:
            if stopped or time.monotonic() > deadline:
                reason = "stopped by hand" if stopped else "not done after %.0f s" % (PATIENCE + 10.0 * seconds)
                launch.send_signal(signal.SIGINT)
                try:
                    launch.wait(30.0)
                except subprocess.TimeoutExpired:
                    pass
                break
            time.sleep(0.05)
    leave_no_process()
    return reason


def read_text(path):
    try:
        with open(path, errors="replace") as file:
            return file.read()
    except OSError:
        return ""


def first_error(log):
    """The first thing a node called an error, without colours and time."""
    found = re.search(r"\[ *(?:ERROR|FATAL)\] \[[^]]*\]: ([^\x1b\n]*)", log)
    return ": " + found.group(1) if found else ""


def verdict(summary, status, stopped, log):
    """ok, or the first thing that went wrong. The simulator's own exit status counts, not roslaunch's."""
    if not summary:
        end = "ended with exit status " + status if status else "did not start"
        return "the simulator %s%s" % (end, first_error(log))
    if summary["result"] != "ok":
        return summary["result"]
    if status != "0":
        return "the simulator ended with exit status %s" % (status or "unknown")
    if float(summary["distance"].split()[0]) < LEAST_DISTANCE:
        return "the vehicle moved less than %g m" % LEAST_DISTANCE
    if stopped and stopped != "stopped by hand":
        return stopped
    return "ok"


def main():
    arguments = parse_arguments()
    if arguments.check:
        return 0
    folder = tempfile.mkdtemp(prefix="ellipsoid_vehicle_sim_demo_")
    stopped = run(arguments, folder)

    lines = [line.partition(": ") for line in read_text(os.path.join(folder, "summary")).splitlines()]
    summary = {key: value for key, _, value in lines}
    status = read_text(os.path.join(folder, "exit_status")).strip()
    log = read_text(os.path.join(folder, "roslaunch.txt"))
    result = verdict(summary, status, stopped, log)
    if result != "ok":
        print("\n".join(log.splitlines()[-40:]), file=sys.stderr, flush=True)
    else:
        shutil.rmtree(folder, ignore_errors=True)
    for key in KEYS[:-1]:
        print("%s: %s" % (key, summary.get(key, "0" + UNITS.get(key, ""))))
    print("result: %s" % result, flush=True)
    return 0 if result == "ok" else 1


if __name__ == "__main__":
    sys.exit(main())
