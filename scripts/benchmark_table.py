#!/usr/bin/python3
"""Runs the benchmark programs of a build folder, ours and the peers' interleaved, and writes the table of scripts/benchmark.

Every program names its measurements FIGURE/WHO. Each repeat runs all programs once, so that ours and the peers' share the
machine's moods; the table has medians over the repeats and their spread.
"""
import argparse
import csv
import glob
import json
import os
import platform
import re
import statistics
import subprocess
import sys

# Figure, unit, what is read of a measurement, whether larger is better, our target (the table's last column), title.
TIME = "cpu_time"
FIGURES = [
    ("near_miss", "ns", TIME, False, 15, "Near miss, ellipsoid against triangle"),
    ("face", "ns", TIME, False, 20, "Face contact"),
    ("edge", "ns", TIME, False, 110, "Edge contact"),
    ("vertex", "ns", TIME, False, 90, "Vertex contact"),
    ("face_error", "m", "worst_error", False, 1e-12, "Face contact: largest depth error"),
    ("edge_error", "m", "worst_error", False, 1e-12, "Edge contact: largest depth error"),
    ("vertex_error", "m", "worst_error", False, 1e-12, "Vertex contact: largest depth error"),
    ("wheel_driving", "ns", TIME, False, 100, "Wheel against 200,000 triangles, driving"),
    ("wheel_cold", "ns", TIME, False, 350, "Wheel against 200,000 triangles, cold random"),
    ("candidates_driving", "ns", TIME, False, 10, "Candidates only, driving"),
    ("candidates_cold", "ns", TIME, False, 200, "Candidates only, cold random"),
    ("build", "million triangles/s", "triangles_per_second", True, 20, "Build of the tree, 2 million triangles"),
    ("memory", "B/triangle", "bytes_per_triangle", False, 40, "Memory, 2 million triangles"),
    ("W1_semi_implicit", "us/step", "us_per_step", False, 0.5, "W1 drop, semi-implicit Euler"),
    ("W1_rk4", "us/step", "us_per_step", False, 1.8, "W1 drop, RK4"),
    ("W2_semi_implicit", "us/step", "us_per_step", False, 1.0, "W2 drive, semi-implicit Euler"),
    ("W2_rk4", "us/step", "us_per_step", False, 3.5, "W2 drive, RK4"),
    ("fleet_20_rk4", "times real time", "real_time_factor", True, 1, "20 cars of five ellipsoids on hills, RK4 at 1 kHz, one core"),
    ("W2_growth", "%", None, False, 15, "W2 from 2 thousand to 2 million triangles: slowest over fastest - 1"),
    ("lidar_scan", "us/scan", "us_per_scan", False, 1250, "Lidar: 1081 rays against 200,000 triangles"),
    ("lidar_scan_own_tree", "us/scan", "us_per_scan", False, 1250, "The same without Embree"),
    ("load", "s", "real_time", False, 1.0, "Loading 2 million triangles with the mesh report (two cores)"),
]
# What another figure's measurement tells beside its time.
TOLD_BY = {"memory": ["build", "load"], "face_error": ["face"], "edge_error": ["edge"], "vertex_error": ["vertex"]}
WORLDS = ["W2_world_2k", "W2_world_20k", "W2_world_200k", "W2_world_2M"]

# Peers that Debian does not package, from the project's own side-by-side study on one core of the same kind of machine.
NOT_RE_RUN = [
    ("near_miss", "Coal 3.0", 655), ("face", "Coal 3.0 EPA", 1668), ("edge", "Coal 3.0 EPA", 3552),
    ("vertex", "Coal 3.0 EPA", 6247), ("face_error", "Coal 3.0 EPA", 2.7e-5), ("edge_error", "Coal 3.0 EPA", 2.7e-5),
    ("vertex_error", "Coal 3.0 EPA", 2.7e-5), ("face", "Jolt 5.5 float EPA", 1359), ("edge", "Jolt 5.5 float EPA", 3044),
    ("vertex", "Jolt 5.5 float EPA", 4191), ("wheel_driving", "Jolt 5.5 float", 3349),
    ("wheel_cold", "Jolt 5.5 float", 4338), ("candidates_driving", "Jolt 5.5 float", 337),
    ("candidates_cold", "Jolt 5.5 float", 814), ("memory", "Jolt 5.5 (rounded corners)", 16),
    ("W1_semi_implicit", "Jolt 5.5 float", 15.2), ("W2_semi_implicit", "Jolt 5.5 float", 25.9),
    ("W1_semi_implicit", "Chrono SMC", 16.3), ("W2_semi_implicit", "Chrono SMC", 98),
]
OURS = ["contact_kernel_benchmark", "lidar_benchmark", "simulation_benchmark", "terrain_benchmark"]
PACKAGES = ["libbullet-dev", "libembree-dev", "libfcl-dev", "libmujoco-dev", "libode-dev", "libeigen3-dev",
            "libbenchmark-dev"]


class Failure(Exception):
    pass


def run_program(path, min_time):
    """{(figure, who): measurement} of one run, and its errors {(figure, who): text}."""
    command = [path, "--benchmark_format=json", "--benchmark_min_time=%g" % min_time]
    done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, universal_newlines=True)
    if done.returncode != 0:
        raise Failure("%s ended with %d: %s" % (os.path.basename(path), done.returncode, done.stderr.strip()[-500:]))
    measured, errors = {}, {}
    # Some libraries greet on the standard output.
    for one in json.loads(done.stdout[done.stdout.index("{"):])["benchmarks"]:
        figure, who = one["name"].split("/")[:2]
        if one.get("error_occurred"):
            errors[figure, who] = one["error_message"]
        else:
            measured[figure, who] = one
    return measured, errors


def value_of(measurement, unit, key):
    value = measurement.get(key)
    if value is None:
        return None
    if key in (TIME, "real_time"):
        value *= {"ns": 1e-9, "us": 1e-6, "ms": 1e-3, "s": 1.0}[measurement["time_unit"]]
        value *= {"ns": 1e9, "s": 1.0}[unit]
    # Google Benchmark gives an inverse rate in seconds; the counter is already scaled to microseconds.
    return value * 1e-6 if key == "triangles_per_second" else value


class Samples:
    """Median and spread of one quantity over the repeats."""
    def __init__(self, values):
        self.values = sorted(values)
        self.median = statistics.median(self.values)

    def spread(self):
        """Half the distance from the least to the largest, in parts of the median."""
        return 0.5 * (self.values[-1] - self.values[0]) / self.median if self.median else 0.0


def collect(runs):
    """{figure: {who: Samples}} of all repeats."""
    result = {}
    for figure, unit, key, _, _, _ in FIGURES:
        sources = [figure] + TOLD_BY.get(figure, [])
        lists = {}
        for run in runs:
            for (of, who), measurement in run.items():
                value = value_of(measurement, unit, key) if key and of in sources else None
                if value is not None:
                    lists.setdefault(who, []).append(value)
        result[figure] = {who: Samples(values) for who, values in lists.items()}
    growth = {}
    for run in runs:
        for who in {who for figure, who in run if figure in WORLDS}:
            costs = [run[world, who]["us_per_step"] for world in WORLDS if (world, who) in run]
            if len(costs) == len(WORLDS):
                growth.setdefault(who, []).append(costs)
    for who, rows in growth.items():
        medians = [statistics.median(column) for column in zip(*rows)]
        result["W2_growth"][who] = Samples([100.0 * (max(medians) / min(medians) - 1.0)])
    return result


def number(value):
    return "%.0f" % value if 1000 <= abs(value) < 1e6 else "%.3g" % value


def note_of(run, figure, who):
    """How often a peer's contact is more than a millimetre off, or not seen at all."""
    measured = run.get((figure, who), {})
    if not measured.get("wrong_percent") and not measured.get("missed_percent"):
        return ""
    return "%.2g %% wrong by over 1 mm, %.2g %% missed" % tuple(measured.get(key, 0.0) for key in ("wrong_percent", "missed_percent"))


def rows_of(samples, run):
    """Rows of the table: figure, our number, unit, peer, its number, ratio (> 1: ours is better), note."""
    rows = []
    for figure, unit, _, larger_is_better, _, _ in FIGURES:
        ours = samples[figure].get("ours")
        if ours is None:
            raise Failure("no measurement of '%s'" % figure)
        peers = [(who, s) for who, s in samples[figure].items() if not who.startswith("ours")]
        peers.sort(key=lambda peer: peer[1].median, reverse=larger_is_better)
        for who, peer in peers:
            ratio = ""
            if ours.median > 0 and peer.median > 0:
                ratio = number(ours.median / peer.median if larger_is_better else peer.median / ours.median)
            rows.append((figure, number(ours.median), unit, who, number(peer.median), ratio, note_of(run, figure, who)))
        for of, who, value in NOT_RE_RUN:
            if of == figure:
                rows.append((figure, number(ours.median), unit, who, number(value), "", "not re-run"))
        if not peers and not any(of == figure for of, _, _ in NOT_RE_RUN):
            rows.append((figure, number(ours.median), unit, "", "", "", "no packaged peer measured"))
    return rows


def first_line(command):
    try:
        return subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, universal_newlines=True,
                              check=True).stdout.splitlines()[0].strip()
    except (OSError, subprocess.CalledProcessError, IndexError):
        return "unknown"


def facts(build, repeats, absent):
    """What the numbers were measured with, as lines."""
    cache = dict(re.findall(r"^([A-Za-z_]+):\w+=(.*)$", open(os.path.join(build, "CMakeCache.txt")).read(), re.M))
    cpu = re.findall(r"^model name\s*:\s*(.*)$", open("/proc/cpuinfo").read(), re.M) or ["unknown CPU"]
    versions = []
    for package in PACKAGES:
        version = first_line(["dpkg-query", "-W", "-f=${Version}\n", package])
        if version not in ("", "unknown"):
            versions.append("%s %s" % (package, version))
    source = cache.get("CMAKE_HOME_DIRECTORY", build)
    flags = " ".join([cache.get("CMAKE_CXX_FLAGS", ""), cache.get("CMAKE_CXX_FLAGS_RELEASE", "")]).strip()
    lines = [
        "machine: %s, %d cores, %s; one core is used" % (cpu[0], os.cpu_count(), platform.platform()),
        "load average at the end: %s (the programs themselves are one of it)" % " ".join("%.2f" % x for x in os.getloadavg()),
        "compiler: %s; build type %s, flags %s" % (first_line([cache.get("CMAKE_CXX_COMPILER", "c++"), "--version"]),
                                                   cache.get("CMAKE_BUILD_TYPE", ""), flags),
        "source: %s" % first_line(["git", "-C", source, "describe", "--always", "--dirty"]),
        "versions: " + ", ".join(versions),
        "repeats: %d, every program once in each; numbers are medians of CPU time (loading: wall time)" % repeats,
    ]
    if absent:
        lines.append("not measured, because not installed: " + ", ".join(absent))
    return lines


def markdown(samples, rows, lines, errors):
    def cells(*values):
        return "| " + " | ".join(values) + " |"
    text = ["# Benchmark", ""] + ["- " + line for line in lines]
    text += ["", "Ratio > 1: ours is better. Targets are ours; ± is half the spread of the repeats.", "",
             cells("figure", "ours", "±", "target", "met", "unit", "best peer measured here", "its value", "ratio"),
             cells(*["---"] * 9)]
    for figure, unit, _, larger, target, title in FIGURES:
        ours = samples[figure]["ours"]
        met = ours.median >= target if larger else ours.median <= target
        best = next((row for row in rows if row[0] == figure and row[5]), None)
        text.append(cells(title, number(ours.median), "%.0f %%" % (100 * ours.spread()), number(target), "yes" if met else "**no**",
                          unit, best[3] if best else "", best[4] if best else "", best[5] if best else ""))
    text += ["", "## All peers", "", cells("figure", "ours", "unit", "peer", "its value", "±", "ratio", "note"), cells(*["---"] * 8)]
    for figure, ours, unit, peer, value, ratio, note in rows:
        spread = samples[figure][peer].spread() if peer in samples[figure] else None
        text.append(cells(figure, ours, unit, peer, value, "" if spread is None else "%.0f %%" % (100 * spread), ratio, note))
    for (figure, who), message in sorted(errors.items()):
        text += ["", "%s by %s could not be measured: %s." % (figure, who, message)]
    return "\n".join(text) + "\n"


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--build", required=True)
    parser.add_argument("--out", required=True)
    parser.add_argument("--quick", action="store_true", help="three short repeats instead of seven")
    arguments = parser.parse_args()
    repeats, min_time = (3, 0.02) if arguments.quick else (7, 0.2)

    folder = os.path.join(arguments.build, "benchmark")
    with open(os.path.join(folder, "absent_peers.txt")) as file:
        absent = [name for name in file.read().split(";") if name]
    gone = [name.split(" (")[0].split()[0].lower() for name in absent]
    # Programs of a peer that has been removed since may be left in the build folder.
    programs = [path for path in sorted(glob.glob(os.path.join(folder, "*_benchmark")))
                if not any(os.path.basename(path).startswith(name) for name in gone)]
    runs, errors = [], {}
    for repeat in range(repeats):
        run = {}
        for path in programs:
            print("repeat %d of %d: %s" % (repeat + 1, repeats, os.path.basename(path)), file=sys.stderr)
            try:
                measured, failed = run_program(path, min_time)
            except Failure as failure:
                if os.path.basename(path) in OURS:
                    raise
                # A peer that breaks down costs its own rows only, and is named in the table.
                measured, failed = {}, {("everything", os.path.basename(path)): str(failure)}
            run.update(measured)
            errors.update(failed)
        runs.append(run)

    ours_failed = sorted("%s: %s" % (key[0], text) for key, text in errors.items() if key[1].startswith("ours"))
    if ours_failed:
        raise Failure("\n".join(ours_failed))
    samples = collect(runs)
    rows = rows_of(samples, runs[-1])
    text = markdown(samples, rows, facts(arguments.build, repeats, absent), errors)
    with open(os.path.join(arguments.out, "benchmark.md"), "w") as file:
        file.write(text)
    with open(os.path.join(arguments.out, "benchmark.csv"), "w", newline="") as file:
        table = csv.writer(file)
        table.writerow(["figure", "ours", "unit", "peer", "peer_value", "ratio"])
        for figure, ours, unit, peer, value, ratio, note in rows:
            quoted = " (not re-run)" if note == "not re-run" else ""
            table.writerow([figure, ours, unit, peer + quoted if peer else note, value, ratio])
    print(text, end="")


if __name__ == "__main__":
    try:
        main()
    except Failure as failure:
        sys.exit(str(failure))
