#!/usr/bin/python3
"""Tries vehicles in worlds with the program vehicle_trial and writes one table, as Markdown and as CSV.

Called by scripts/vehicle_table, which builds that program first. Needs the standard library only.
"""
import argparse
import concurrent.futures
import csv
import json
import os
import subprocess
import sys

CHECKS = ["stands", "straight", "left", "right", "stop", "climb", "drive"]
TITLES = {"stands": "stands", "straight": "10 m straight", "left": "turns left", "right": "turns right",
          "stop": "stops on timeout", "climb": "climbs 10°", "drive": "free straight"}
WORLD_ENDINGS = (".yaml", ".yml", ".stl", ".dae", ".obj")
SHIPPED_WORLDS = ["flat", "ramp"]
LONGEST = 900.0  # [s] of wall clock for one pair: nothing that terminates takes as long


def parse(words):
    parser = argparse.ArgumentParser(prog="scripts/vehicle_table", description=(
        "Tries every URDF (.urdf, and .xacro where there is no .urdf beside it) below a folder in every world of another: "
        "stands, drives straight on, turns, stops, climbs. Exit code: 0 table written, 1 a trial broke down, 2 bad usage."))
    parser.add_argument("--vehicles", metavar="DIR", required=True, action="append",
                        help="folder of URDFs, packages beside each, or one URDF; may be given again")
    parser.add_argument("--worlds", metavar="DIR", action="append",
                        help="folder of mesh files or world YAMLs, or one of them; default: the shipped flat and ramp")
    parser.add_argument("--out", metavar="DIR", required=True, help="for vehicle_table.md and .csv; made if need be")
    parser.add_argument("--jobs", type=int, default=os.cpu_count() or 1, help="trials side by side; default: %(default)s")
    parser.add_argument("--program", help=argparse.SUPPRESS)
    parser.add_argument("--only-check", action="store_true", help=argparse.SUPPRESS)
    arguments = parser.parse_args(words)
    for option, folders in (("--vehicles", arguments.vehicles), ("--worlds", arguments.worlds or [])):
        for folder in folders:
            if not os.path.exists(folder):
                parser.error("%s %s: there is no such folder" % (option, folder))
    if arguments.jobs < 1:
        parser.error("--jobs %d: allowed is at least 1" % arguments.jobs)
    try:
        os.makedirs(arguments.out, exist_ok=True)
    except OSError as error:
        parser.error("--out %s: %s" % (arguments.out, error.strerror))
    if not os.access(arguments.out, os.W_OK):
        parser.error("--out %s: cannot be written to" % arguments.out)
    return parser, arguments


def files_below(path, wanted):
    if os.path.isfile(path):
        return [os.path.abspath(path)]
    found, seen = [], set()
    for folder, folders, names in os.walk(path, followlinks=True):
        if os.path.realpath(folder) in seen:  # a link back, or a second one to the same folder
            folders[:] = []
            continue
        seen.add(os.path.realpath(folder))
        folders[:] = sorted(name for name in folders if not name.startswith("."))
        found += [os.path.abspath(os.path.join(folder, name)) for name in sorted(names) if wanted(folder, name)]
    return found


def is_vehicle(folder, name):
    if name.endswith(".urdf"):
        return True
    if not name.endswith(".xacro"):
        return False
    # One that includes others and is a robot, not a part of one.
    stem = name[:-len(".xacro")]
    stem = stem[:-len(".urdf")] if stem.endswith(".urdf") else stem
    if os.path.exists(os.path.join(folder, stem + ".urdf")):
        return False
    with open(os.path.join(folder, name), encoding="utf-8", errors="replace") as file:
        text = file.read()
    start = text.find("<robot")
    return start >= 0 and " name=" in text[start:text.find(">", start)]


def is_world(folder, name):
    if not name.lower().endswith(WORLD_ENDINGS):
        return False
    if not name.lower().endswith((".yaml", ".yml")):
        return not worlds_beside(folder)
    return True


def worlds_beside(folder):
    """Whether world YAMLs say which meshes are meant."""
    for name in os.listdir(folder):
        if name.lower().endswith((".yaml", ".yml")):
            with open(os.path.join(folder, name), encoding="utf-8", errors="replace") as file:
                if any(line.startswith("meshes:") for line in file):
                    return True
    return False


def try_pair(program, vehicle, world):
    command = [program, vehicle, world]
    failure = None
    try:
        done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, timeout=LONGEST)
    except subprocess.TimeoutExpired:
        failure = "took longer than %g s" % LONGEST
    else:
        if done.returncode in (0, 1):
            try:
                row = json.loads(done.stdout.strip().splitlines()[-1])
                row["problems"] = [without_folders(p, vehicle, world) for p in row["problems"]]
                return row, False
            except (ValueError, IndexError):
                failure = "printed no result: " + done.stderr.strip()
        elif done.returncode == 2:
            failure = done.stderr.split("usage:")[0].strip()
            return refused(vehicle, world, failure), False
        else:
            failure = "ended with code %d: %s" % (done.returncode, done.stderr.strip()[-500:])
    return refused(vehicle, world, failure), True


def without_folders(message, *paths):
    """Files by their own names: a table is read elsewhere than it was made."""
    for path in paths:
        folder = os.path.dirname(path)
        if folder:
            message = message.replace(folder + os.sep, "")
    return message


def refused(vehicle, world, message):
    def stem(path):
        return os.path.splitext(os.path.basename(path))[0]
    message = without_folders(message, vehicle, world)
    return {"vehicle": stem(vehicle), "world": stem(world), "mass": 0.0, "layout": "", "ground": "", "passed": False,
            "problems": [message], "checks": []}


def cell(check):
    if check is None:
        return ""
    sign = {"passed": "yes", "failed": "**no**", "not tried": "–"}[check["verdict"]]
    if check["verdict"] == "not tried":
        return sign
    value = check["value"]
    return "%s (%.3g %s)" % (sign, 0.0 if value is None else value, check["unit"])


def markdown(rows, text):
    shown = [name for name in CHECKS if any(check["name"] == name for row in rows for check in row["checks"])]
    lines = ["# Vehicles in worlds", "", text, "",
             "| vehicle | world | mass kg | layout | " + " | ".join(TITLES[name] for name in shown) + " |",
             "|" + "---|" * (4 + len(shown))]
    remarks = []
    for row in rows:
        checks = {check["name"]: check for check in row["checks"]}
        if row["problems"]:
            middle = "**refused**" + " |" * (len(shown) + 1)
        else:
            middle = "%s | %s" % (row["layout"], " | ".join(cell(checks.get(name)) for name in shown))
            middle += " |"
        mass = "%.4g" % row["mass"] if row["mass"] else ""
        lines.append("| %s | %s | %s | %s" % (row["vehicle"], row["world"], mass, middle))
        said = ["%s: %s" % (c["name"], c["text"]) for c in row["checks"] if c["verdict"] != "passed"]
        if row["problems"] or said:
            remarks.append("- %s, %s: %s" % (row["vehicle"], row["world"],
                                             "; ".join([p.replace("\n", " ") for p in row["problems"]] + said)))
    passed = sum(row["passed"] for row in rows)
    lines += ["", "%d of %d pairs passed every trial." % (passed, len(rows))]
    if remarks:
        lines += ["", "## What did not pass, in its own words", ""] + remarks
    return "\n".join(lines) + "\n"


def write_csv(path, rows):
    with open(path, "w", newline="", encoding="utf-8") as file:
        table = csv.writer(file)
        head = ["vehicle", "world", "ground", "mass_kg", "layout", "passed", "message"]
        for name in CHECKS:
            head += [name, name + "_value", name + "_unit", name + "_text"]
        table.writerow(head)
        for row in rows:
            checks = {check["name"]: check for check in row["checks"]}
            line = [row["vehicle"], row["world"], row["ground"], row["mass"], row["layout"],
                    "yes" if row["passed"] else "no", "; ".join(row["problems"])]
            for name in CHECKS:
                c = checks.get(name)
                line += [c["verdict"], c["value"], c["unit"], c["text"]] if c else ["", "", "", ""]
            table.writerow(line)


TEXT = """Made by `scripts/vehicle_table`: every vehicle in every world, without a person's hand.

- *stands*: moved between 10 s and 70 s after the set-down; passed below 1 mm
- *10 m straight*: off its line, in per cent of the way; passed below 2 %
- *turns*: yaw rate at walking pace against the law of its layout (Ackermann; the wheels' difference; where wheels have to
  skid, the balance of their friction, `skid_steer.h`); passed within 5 %
- *stops on timeout*: when it was for good slower than 10 mm/s after the last command
- *climbs 10°*: how far up it got; passed too where its torque or grip is less than the slope asks for, which is then told
- *free straight*: the longest free way of up to 10 m from a place the tool finds"""


def main():
    parser, arguments = parse(sys.argv[1:])
    vehicles = [vehicle for folder in arguments.vehicles for vehicle in files_below(folder, is_vehicle)]
    worlds = [world for folder in arguments.worlds or [] for world in files_below(folder, is_world)]
    if not vehicles:
        parser.error("--vehicles %s: no .urdf or .xacro in it" % ", ".join(arguments.vehicles))
    if arguments.worlds and not worlds:
        parser.error("--worlds %s: no %s in it" % (", ".join(arguments.worlds), ", ".join(WORLD_ENDINGS)))
    if arguments.only_check:
        return 0
    if not arguments.program:
        parser.error("call scripts/vehicle_table, which knows the program")
    pairs = [(vehicle, world) for vehicle in vehicles for world in worlds or SHIPPED_WORLDS]
    rows, broke_down = [], 0
    with concurrent.futures.ThreadPoolExecutor(arguments.jobs) as pool:
        results = pool.map(lambda pair: try_pair(arguments.program, *pair), pairs)
        for pair, (row, broken) in zip(pairs, results):
            rows.append(row)
            broke_down += broken
            print("%-30s %-16s %s" % (row["vehicle"], row["world"], "passed" if row["passed"] else
                                      "refused" if row["problems"] else "failed"), flush=True)
    with open(os.path.join(arguments.out, "vehicle_table.md"), "w", encoding="utf-8") as file:
        file.write(markdown(rows, TEXT))
    write_csv(os.path.join(arguments.out, "vehicle_table.csv"), rows)
    print("%s: vehicle_table.md, vehicle_table.csv" % arguments.out)
    return 1 if broke_down else 0


if __name__ == "__main__":
    sys.exit(main())
