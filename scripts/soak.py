"""Lets the simulator's node run for simulated hours, as fast as it can, while everything that can go wrong around it does.

Starts a master of its own on a free port and the node with two lidars on it. Then client after client (test/soak) subscribes
to every topic, floods and garbles commands, and goes away, while another process calls every service with sane and absurd
arguments and changes parameters; in between the master is killed and started anew. Last, the node is interrupted (SIGINT) at
random moments.

Fails if the node ends by itself, a message holds a NaN, /clock goes back, a service takes longer than 100 ms, the memory it holds for good
grows by more than 1 MiB after the warm-up, or SIGINT takes longer than a second.
"""
import argparse
import json
import os
import random
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import threading
import time
import xmlrpc.client

LONGEST_ANSWER = 0.1  # [s]
LONGEST_END = 1.0  # [s]
MOST_GROWTH = 1.0  # [MiB]
WARM_UP = 0.1  # of the time,
SHORTEST_WARM_UP = 6.0  # but at least so long [s of wall time]
SHORTEST_RUN = 20.0  # [s of wall time]: to see what becomes of the memory
SAMPLE = 0.1  # of the memory [s]: between two floods it is small for a moment only
QUIET = 5.0  # nobody listens any more, so that memory is seen without what waits for somebody [s]
MOST_LOST = 0.002  # of the calls: answers that roscpp's client lost, which asked again (ros_comm issue 1976)
CALLER = "/soak"
PARAMETERS = {"vehicle_file": "car", "world": "course", "real_time_factor": 0.0, "noise_seed": 1, "imu_acceleration_noise": 0.1,
              "lidars": ["front", "top"], "front": {"pose": [1.9, 0.0, 0.35, 0.0, 0.0, 0.0], "noise": 0.01, "samples": 361},
              "top": {"kind": "spatial", "pose": [0.0, 0.0, 1.4, 0.0, 0.0, 0.0], "rings": 8, "samples": 180, "rate": 5.0}}


def free_port():
    with socket.socket() as probe:
        probe.bind(("localhost", 0))
        return probe.getsockname()[1]


def processor_wait(pid):
    """Time that the threads of a process were ready to run and got no processor [s]."""
    waited = 0.0
    try:
        for task in os.listdir("/proc/%d/task" % pid):
            with open("/proc/%d/task/%s/schedstat" % (pid, task)) as file:
                waited += 1e-9 * float(file.read().split()[1])
    except (OSError, IndexError):
        pass
    return waited


class Master:
    """A ROS master that can be killed and started anew on the same port."""

    def __init__(self, log):
        self.port, self.log, self.process = free_port(), log, None
        os.environ["ROS_MASTER_URI"] = "http://localhost:%d" % self.port
        self.server = xmlrpc.client.ServerProxy(os.environ["ROS_MASTER_URI"])
        self.start()

    def start(self):
        self.process = subprocess.Popen(["rosmaster", "--core", "-p", str(self.port)], stdout=self.log, stderr=self.log)
        self.wait(lambda: self.server.getPid(CALLER)[0] == 1, "the master")

    def wait(self, condition, what, deadline=120.0):
        end = time.monotonic() + deadline
        while time.monotonic() < end:
            try:
                if condition():
                    return
            except (OSError, xmlrpc.client.Error):
                pass
            time.sleep(0.05)
        raise RuntimeError("waited %g s for %s" % (deadline, what))

    def set_up(self):
        self.server.setParam(CALLER, "/use_sim_time", True)
        self.server.setParam(CALLER, "/simulator", PARAMETERS)

    def knows(self, node):
        """Whether the node has registered all: its subscriptions come last."""
        _, _, (_, subscribers, _) = self.server.getSystemState(CALLER)
        return any(node in nodes for _, nodes in subscribers)

    def kill(self):
        self.process.kill()
        self.process.wait()


class Node:
    """The simulator's node; its memory is sampled all the time."""
    all = []

    def __init__(self, folder):
        binary = shutil.which("ellipsoid_vehicle_sim_node") or subprocess.check_output(
            ["catkin_find", "--first-only", "--libexec", "ellipsoid_vehicle_sim", "ellipsoid_vehicle_sim_node"], text=True).strip()
        self.output = open(os.path.join(folder, "node.log"), "a+")
        self.process = subprocess.Popen([binary, "__name:=simulator"], stdout=self.output, stderr=subprocess.STDOUT, cwd=folder)
        Node.all.append(self)
        self.curve = []  # (wall time [s], resident memory [MiB], that part of it which is no file's [MiB])
        threading.Thread(target=self.sample, daemon=True).start()

    def sample(self):
        start = time.monotonic()
        while self.process.poll() is None:
            try:
                with open("/proc/%d/statm" % self.process.pid) as file:
                    resident, of_files = (int(pages) * os.sysconf("SC_PAGE_SIZE") / 2.0 ** 20 for pages in file.read().split()[1:3])
            except (OSError, ValueError):
                return
            if resident:
                self.curve.append((time.monotonic() - start, resident, resident - of_files))
            time.sleep(SAMPLE)

    def interrupt(self):
        """SIGINT; how long the end took, and how long without what the machine did not give it [s]; the exit code."""
        before, start = processor_wait(self.process.pid), time.monotonic()
        self.process.send_signal(signal.SIGINT)
        waited = before
        while self.process.poll() is None and time.monotonic() < start + 30.0:
            waited = max(waited, processor_wait(self.process.pid))
            time.sleep(0.005)
        took = time.monotonic() - start
        if self.process.poll() is None:
            self.process.kill()
        return took, took - (waited - before), self.process.wait()

    def end_of_log(self):
        self.output.flush()
        with open(self.output.name, errors="replace") as file:
            return "".join(file.readlines()[-15:])


class Soak:
    def __init__(self, options, folder):
        self.options, self.folder = options, folder
        self.random = random.Random(options.seed)
        self.log = open(os.path.join(folder, "others.log"), "w")
        self.faults, self.latencies = [], {}
        self.messages = self.commands = self.restarts = self.clients = self.lost = 0
        self.simulated, self.heard_all = 0.0, False

    def fault(self, text):
        self.faults.append(text)
        print("FAULT: " + text, flush=True)

    def start(self, program, *arguments):
        """One of the programs of test/soak. What it prints is its report."""
        return subprocess.Popen([os.path.join(self.options.clients, program), "/simulator"] + ["%.15g" % value for value in arguments],
                                stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=self.log, text=True)

    def seed(self):
        return self.random.randrange(2 ** 31)

    def report(self, node, program, process, patience):
        """What a program saw, or None if it could not tell."""
        output, _ = process.communicate(timeout=patience)
        try:
            return json.loads(output.strip().splitlines()[-1])
        except (IndexError, ValueError):
            if node.process.poll() is None:
                self.fault("%s ended with %d and no report" % (program, process.returncode))
            return None

    def client(self, node, master, seconds, wall):
        """One client for so many simulated seconds, and a caller beside it; whether both told what they saw, and when it ended."""
        caller = self.start("soak_caller", node.process.pid, master.process.pid, self.seed(), LONGEST_ANSWER)
        seen = self.report(node, "soak_client", self.start("soak_client", self.seed(), seconds, wall), wall + 900.0)
        answered = self.report(node, "soak_caller", caller, 60.0)  # which ends as its input does
        if seen is None or answered is None:
            return None
        for text in seen["faults"] + answered["faults"]:
            self.fault(text)
        for name, seen_of in answered["services"].items():
            of = self.latencies.setdefault(name, {"calls": 0, "worst": 0.0, "served": 0.0, "late": [0, 0]})
            of["calls"] += seen_of["calls"]
            of["served"] = max(of["served"], seen_of["served"])
            of["late"] = [before + seen for before, seen in zip(of["late"], seen_of["late"])]
            if seen_of["worst"] > of["worst"]:
                of["worst"], of["kept"] = seen_of["worst"], seen_of["kept"]
        self.lost += answered["lost"]
        self.messages += seen["messages"]
        self.commands += seen["commands"]
        self.heard_all = self.heard_all or not seen["silent"]
        self.silent = seen["silent"]
        return seen["to"]

    def bother(self, master):
        """The hours themselves."""
        target = 3600.0 * self.options.hours
        segment = min(900.0, target / 8.0)
        node = Node(self.folder)
        last, start, told = 0.0, time.monotonic(), 0.0
        while (self.simulated < target or time.monotonic() - start < SHORTEST_RUN) and len(self.faults) < 20:
            left = self.options.wall - (time.monotonic() - start)
            if left <= 0.0:
                break
            now = self.client(node, master, min(segment, max(60.0, target - self.simulated)), min(left, 600.0))
            if node.process.poll() is not None:
                self.fault("the node ended by itself with %d:\n%s" % (node.process.returncode, node.end_of_log()))
                return
            if now is None:
                return
            self.clients += 1
            if now < last:
                self.fault("/clock went back from %.3f to %.3f between two clients" % (last, now))
            self.simulated = last = now
            if time.monotonic() - told > 30.0:
                told = time.monotonic()
                print("%8.2f h simulated in %6.0f s, %5.1f MiB, %d faults" %
                      (self.simulated / 3600.0, told - start, node.curve[-1][1], len(self.faults)), flush=True)
            if self.random.random() < 0.5 or self.clients == 1:
                self.restart(master)
        self.wall = time.monotonic() - start
        time.sleep(QUIET)
        self.judge_memory(node.curve)
        self.judge_end("after %.2f simulated hours" % (self.simulated / 3600.0), node.interrupt())

    def restart(self, master):
        master.kill()
        time.sleep(self.random.uniform(0.0, 3.0))
        master.start()
        try:
            master.wait(lambda: master.knows("/simulator"), "the node to register with the new master", 15.0)
        except RuntimeError as error:
            self.fault(str(error))
        self.restarts += 1

    def judge_memory(self, curve):
        self.curve = curve
        end_of_warm_up = max(SHORTEST_WARM_UP, WARM_UP * curve[-1][0]) if curve else 0.0
        warm = sum(1 for point in curve if point[0] < end_of_warm_up)
        if len(curve) - warm < 10.0 / SAMPLE:
            return self.fault("the run was too short to say anything about memory")
        # What waits in queues for a subscriber that is slow at the moment comes and goes: the least of a half of the time is
        # what the node holds for good.
        after = curve[warm:]
        halves = after[:len(after) // 2], after[len(after) // 2:]
        self.held, self.held_own = ([min(point[kind] for point in half) for half in halves] for kind in (1, 2))
        self.growth = self.held[1] - self.held[0]
        if self.growth > self.options.growth:
            self.fault("memory grew by %.2f MiB after the warm-up" % self.growth)

    def judge_end(self, when, result):
        took, served, code = result
        self.ends.append((when, took, served))
        if served > LONGEST_END:
            self.fault("SIGINT %s took %.2f s (%.2f s with a processor)" % (when, took, served))
        if code not in (0, -signal.SIGINT):
            self.fault("SIGINT %s: exit code %d" % (when, code))

    def interrupt_at_random(self, master):
        """Fresh nodes, interrupted while they load, run, serve, or have no master."""
        for number in range(self.options.interrupts):
            kind = ("while it starts", "while it runs", "while it serves", "while it steps", "without a master")[number % 5]
            node = Node(self.folder)
            others = []
            if kind == "while it starts":
                time.sleep(self.random.uniform(0.0, 0.6))
            else:
                master.wait(lambda: master.server.lookupService(CALLER, "/simulator/state_hash")[0] == 1, "the node's services")
                time.sleep(self.random.uniform(0.0, 0.5))
            if kind == "while it serves":
                others = [self.start("soak_client", number, 1e9, 60.0),
                          self.start("soak_caller", node.process.pid, master.process.pid, number, LONGEST_ANSWER)]
                time.sleep(self.random.uniform(0.5, 2.0))
            if kind == "while it steps":
                # Hours of simulated time: it would answer long after we are gone.
                for service, arguments in (("pause", []), ("step", ["10000000"])):
                    others = [subprocess.Popen(["rosservice", "call", "/simulator/" + service] + arguments, stdout=self.log,
                                               stderr=self.log)]
                    if service == "pause":
                        others[0].wait(60.0)
                time.sleep(self.random.uniform(1.0, 3.0))
                if others[0].poll() is not None:
                    self.fault("ten million ticks were answered at once: rosservice ended with %d" % others[0].returncode)
            if kind == "without a master":
                master.kill()
            self.judge_end(kind, node.interrupt())
            for other in others:
                other.kill()
                other.wait()
            if kind == "without a master":
                master.start()
                master.set_up()
            # What a killed node leaves behind in the master.
            for name in ("/simulator/" + service for service in ("state_hash",)):
                found = master.server.lookupService(CALLER, name)
                if found[0] == 1:
                    master.server.unregisterService("/simulator", name, found[2])

    def run(self):
        self.ends, self.curve, self.growth, self.wall, self.silent = [], [], None, 0.0, []
        master = Master(self.log)
        try:
            master.set_up()
            self.bother(master)
            master.set_up()
            self.interrupt_at_random(master)
        finally:
            for node in Node.all:
                if node.process.poll() is None:
                    node.process.kill()
            master.kill()
        for name, of in sorted(self.latencies.items()):
            if of["late"][1]:
                self.fault("%s took longer than %.0f ms %d times, up to %.0f ms (%.0f ms by the wall clock)" %
                           (name, 1e3 * LONGEST_ANSWER, of["late"][1], 1e3 * of["served"], 1e3 * of["worst"]))
        calls = sum(of["calls"] for of in self.latencies.values())
        if self.lost > 1 + MOST_LOST * calls:
            self.fault("%d of %d calls had to be made twice" % (self.lost, calls))
        if not self.heard_all:
            self.fault("no message ever on: " + ", ".join(self.silent))
        if self.simulated < 3600.0 * self.options.hours:
            self.fault("only %.3f of %.3f hours were simulated" % (self.simulated / 3600.0, self.options.hours))
        return self.summary()

    def summary(self):
        lines = ["simulated %.3f h in %.0f s of wall time, seed %d" % (self.simulated / 3600.0, self.wall, self.options.seed),
                 "%d clients, %d messages looked at, %d commands sent, %d restarts of the master" %
                 (self.clients, self.messages, self.commands, self.restarts)]
        step = max(1, len(self.curve) // 20)
        lines.append("memory [MiB] over wall time [s]: " + ", ".join("%.0f: %.2f" % point[:2] for point in self.curve[::step]))
        if self.growth is not None:
            lines.append("least memory in both halves of the time after the warm-up [MiB]: " +
                         ", ".join("%.2f" % value for value in self.held) + "; growth %.2f MiB" % self.growth +
                         " (without pages of libraries %.2f, %.2f)" % tuple(self.held_own))
        lines.append("service: calls; longest answer [ms] (in it waits for a processor of node, master and caller, and a processor that stood "
                     "still); longest less these [ms]; how many above %.0f ms, and of them less these" % (1e3 * LONGEST_ANSWER))
        lines += ["  %-16s %7d %8.1f (%s) %8.1f %4d %2d" % (name, of["calls"], 1e3 * of["worst"],
                                                            " ".join("%5.1f" % (1e3 * kept) for kept in of["kept"]),
                                                            1e3 * of["served"], *of["late"])
                  for name, of in sorted(self.latencies.items())]
        lines.append("%d calls were made a second time, as roscpp's client lost the answer" % self.lost)
        lines += ["SIGINT %s: %.2f s" % (when, took) for when, took, _ in self.ends]
        lines += ["FAULT: " + text for text in self.faults]
        lines.append("%d faults: %s" % (len(self.faults), "failed" if self.faults else "passed"))
        return "\n".join(lines)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--hours", type=float, required=True, help="simulated hours, above 0")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--wall", type=float, default=1e9, help="give up after so many seconds of wall time")
    parser.add_argument("--interrupts", type=int, default=20, help="nodes to interrupt at the end")
    parser.add_argument("--growth", type=float, default=MOST_GROWTH, help="of memory that is allowed after the warm-up [MiB]")
    parser.add_argument("--report", help="file for the summary")
    parser.add_argument("--clients", required=True, help=argparse.SUPPRESS)
    options = parser.parse_args()
    if not options.hours > 0.0:
        parser.error("--hours %g: must be above 0" % options.hours)
    # A shell has its background jobs ignore SIGINT, and the nodes would inherit that until they have a handler.
    if signal.getsignal(signal.SIGINT) == signal.SIG_IGN:
        signal.signal(signal.SIGINT, signal.default_int_handler)
    os.environ["ROS_HOSTNAME"] = "localhost"
    with tempfile.TemporaryDirectory() as folder:
        os.environ["ROS_HOME"], os.environ["ROS_LOG_DIR"] = folder, os.path.join(folder, "log")
        soak = Soak(options, folder)
        summary = soak.run()
    print(summary)
    if options.report:
        with open(options.report, "w") as file:
            file.write(summary + "\n")
    return 1 if soak.faults else 0


if __name__ == "__main__":
    sys.exit(main())
