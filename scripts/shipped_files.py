"""Shipped vehicles and worlds by name: the same rules as src/ros/resources.cpp."""
import glob
import os


def share_folder():
    """Installed: <prefix>/share/<package>, this file being in <prefix>/lib/<package>; otherwise the checkout."""
    here = os.path.dirname(os.path.realpath(__file__))
    installed = os.path.join(here, "..", "..", "share", os.path.basename(here))
    return os.path.normpath(installed if os.path.isdir(installed) else os.path.join(here, ".."))


def stem(path):
    return os.path.splitext(os.path.basename(path))[0]


def is_world(path):
    """A YAML file with a top-level list of meshes; simulator.yaml is none."""
    with open(path, encoding="utf-8", errors="replace") as file:
        return any(line.startswith("meshes:") for line in file)


def vehicles():
    return {stem(path): path for path in glob.glob(os.path.join(share_folder(), "urdf", "*.urdf"))}


def worlds():
    files = glob.glob(os.path.join(share_folder(), "launch", "**", "*.yaml"), recursive=True)
    return {stem(path): path for path in files if is_world(path)}


def find(kind, name_or_path):
    """The path of a shipped file, or the absolute path of a given one. LookupError lists the known names."""
    known = vehicles() if kind == "vehicle" else worlds()
    if name_or_path in known:
        return known[name_or_path]
    if os.path.isfile(name_or_path):
        return os.path.abspath(name_or_path)
    raise LookupError("'%s' is no known %s and no file that can be read; known %ss: %s"
                      % (name_or_path, kind, kind, ", ".join(sorted(known)) or "none"))
