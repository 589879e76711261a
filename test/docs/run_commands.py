"""run_commands.py CHECKOUT BUILD DEVEL: runs every command in the `bash` blocks of README, CONTRIBUTING and docs/.

Each document's commands run in order in one shell that stops at the first failure, in a folder of its own that looks like the
checkout (links to its files, to the build folder under test as `build`); what they write stays there. What is not run as it
stands is listed with its reason in commands.yaml.
"""
import glob
import os
import re
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import time
import unittest

import yaml

CHECKOUT, BUILD, DEVEL = (os.path.realpath(path) for path in sys.argv[1:4])
DOCUMENTS = [os.path.join(CHECKOUT, name) for name in ("README.md", "CONTRIBUTING.md")] + \
    sorted(glob.glob(os.path.join(CHECKOUT, "docs", "*.md")))
LONGEST = 240.0  # [s] for one document
with open(os.path.join(CHECKOUT, "test", "docs", "commands.yaml")) as rules:
    RULES = yaml.safe_load(rules)


def blocks_of(text):
    """(language, lines) of each fenced block."""
    blocks, language, lines = [], None, []
    for line in text.splitlines():
        fence = re.match(r"```(\S*)\s*$", line)
        if fence and language is None:
            language, lines = fence.group(1), []
        elif fence:
            blocks.append((language, lines))
            language = None
        elif language is not None:
            lines.append(line)
    return blocks


def commands_of(lines):
    """The commands of a block, without comments; a here-document belongs to its command."""
    commands, rest = [], list(lines)
    while rest:
        line = re.sub(r"(^|\s+)#\s.*$", "", rest.pop(0)).rstrip()
        while line.endswith("\\") and rest:
            line = line[:-1] + rest.pop(0).strip()
        here = re.search(r"<<\s*'?(\w+)'?", line)
        if here:
            body = []
            while rest and rest[0] != here.group(1):
                body.append(rest.pop(0))
            line = "\n".join([line] + body + [rest.pop(0)])
        if line.strip():
            commands.append(line)
    return commands


def documents():
    """{name: commands}"""
    result = {}
    for path in DOCUMENTS:
        with open(path, encoding="utf-8") as file:
            blocks = blocks_of(file.read())
        result[os.path.relpath(path, CHECKOUT)] = [command for language, lines in blocks if language == "bash"
                                                    for command in commands_of(lines)]
    return result


def free_port():
    with socket.socket() as probe:
        probe.bind(("localhost", 0))
        return probe.getsockname()[1]


class DocumentedCommands(unittest.TestCase):
    def test_every_rule_is_for_a_command_that_is_there_and_has_a_reason(self):
        known = {command for commands in documents().values() for command in commands}
        rules = RULES["not_run"] + RULES["shortened"]
        for rule in rules:
            self.assertIn(rule["command"], known)
            self.assertTrue(rule["reason"].strip(), rule["command"])
        self.assertEqual(len(rules), len({rule["command"] for rule in rules}))
        for rule in RULES["shortened"]:
            self.assertNotEqual(rule["as"], rule["command"])

    def test_blocks_say_what_they_are_and_no_command_hides_outside_of_them(self):
        for path in DOCUMENTS:
            with open(path, encoding="utf-8") as file:
                text = file.read()
            for language, lines in blocks_of(text):
                self.assertIn(language, ("bash", "xml", "yaml", "cmake", "text", "cpp", "python"), "%s: %s" % (path, lines[:1]))
            outside = re.sub(r"```.*?```", "", text, flags=re.S)
            for line in outside.splitlines():
                self.assertIsNone(re.match(r" {4,}(scripts/|ros|source |cmake |sudo |apt)", line), "%s: %s" % (path, line))

    def run_document(self, name, commands):
        leave_out = {rule["command"] for rule in RULES["not_run"]}
        shorter = {rule["command"]: rule["as"] for rule in RULES["shortened"]}
        commands = [shorter.get(command, command) for command in commands if command not in leave_out]
        if not commands:
            return
        with tempfile.TemporaryDirectory() as folder:
            for entry in os.listdir(CHECKOUT):
                if entry not in ("build", ".git"):
                    os.symlink(os.path.join(CHECKOUT, entry), os.path.join(folder, entry))
            os.symlink(BUILD, os.path.join(folder, "build"))
            script = ["set -e", "set +u"]
            for command in commands:
                script += ["echo '>>> '%s >&2" % shell_quoted(command.splitlines()[0]), command]
            environment = {key: value for key, value in os.environ.items()
                           if not key.startswith(("ROS", "GTEST", "CMAKE_PREFIX")) and key not in ("DISPLAY", "PYTHONPATH")}
            # As where ROS works at all: its scripts need a Python that knows it.
            environment["PATH"] = "/usr/bin:/bin:/usr/sbin:/sbin:" + environment["PATH"]
            environment.update(HOME=folder, ROS_HOME=folder, ROS_HOSTNAME="localhost", ELLIPSOID_VEHICLE_SIM_BUILD=BUILD,
                               ELLIPSOID_VEHICLE_SIM_NO_BUILD="1",
                               ROS_MASTER_URI="http://localhost:%d" % free_port())
            start = time.monotonic()
            setup = "if [ -e /opt/ros/noetic/setup.bash ]; then . /opt/ros/noetic/setup.bash; fi; . '%s/setup.bash'\n" % DEVEL
            # A session of its own, so that nothing of it is left when it takes too long.
            shell = subprocess.Popen(["bash", "-c", setup + "\n".join(script)], cwd=folder, env=environment, text=True,
                                     errors="replace", stdin=subprocess.DEVNULL, stdout=subprocess.PIPE,
                                     stderr=subprocess.STDOUT, start_new_session=True)
            try:
                output = shell.communicate(timeout=LONGEST)[0]
            except subprocess.TimeoutExpired:
                os.killpg(shell.pid, signal.SIGKILL)
                self.fail("%s: not at its end after %g s\n%s" % (name, LONGEST, shell.communicate()[0][-4000:]))
            self.assertEqual(shell.returncode, 0, "%s\n%s" % (name, output[-4000:]))
            print("%s: %d commands in %.1f s" % (name, len(commands), time.monotonic() - start), flush=True)

    def test_commands_run(self):
        before = listing()
        for name, commands in documents().items():
            with self.subTest(document=name):
                self.run_document(name, commands)
        self.assertEqual(listing(), before, "a command wrote into the checkout")

    def test_enough_is_run(self):
        self.assertGreater(sum(len(commands) for commands in documents().values()), 25)


def shell_quoted(text):
    return "'" + text.replace("'", "'\\''") + "'"


def listing():
    """What git says of the checkout; without git, its files."""
    if shutil.which("git") and os.path.exists(os.path.join(CHECKOUT, ".git")):
        return subprocess.run(["git", "-C", CHECKOUT, "status", "--porcelain"], stdout=subprocess.PIPE, text=True).stdout
    return sorted(path for path in glob.glob(os.path.join(CHECKOUT, "**"), recursive=True) if not path.startswith(BUILD))


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
