"""Names of runs: a hash of everything that their results depend on. Equal names have equal results, on any machine."""
import functools
import hashlib
import json
import os
import platform
import re
import subprocess

from .errors import SweepError

PROGRAM = ("lib", "deformable_surface", "simulate")


def hash_bytes(data):
    return hashlib.sha256(data).hexdigest()


def hash_file(path):
    digest = hashlib.sha256()
    try:
        with open(path, "rb") as stream:
            for block in iter(lambda: stream.read(1 << 20), b""):
                digest.update(block)
    except OSError as error:
        raise SweepError("%s: cannot be read (%s); accepted: a readable file" % (path, error.strerror))
    return digest.hexdigest()


def find_program(program=""):
    """The path of `simulate`: the given one, or that of the first catkin workspace that has one."""
    if program:
        if os.access(program, os.X_OK) and os.path.isfile(program):
            return os.path.abspath(program)
        raise SweepError("--simulate: found '%s', which is no program here; accepted: the path of simulate" % program)
    for prefix in os.environ.get("CMAKE_PREFIX_PATH", "").split(os.pathsep):
        path = os.path.join(prefix, *PROGRAM)
        if prefix and os.access(path, os.X_OK):
            return path
    raise SweepError("found no program simulate in the workspaces of CMAKE_PREFIX_PATH; "
                     "accepted: after `source setup.bash` of one that has deformable_surface, or --simulate PROGRAM")


@functools.lru_cache(maxsize=None)
def find_version(program):
    """A hash of the program and its libraries of this package, and the C library, whose functions are part of the results."""
    parts = [program]
    try:
        listed = subprocess.run(["ldd", program], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, universal_newlines=True).stdout
        parts += sorted(re.findall(r"=> (\S*/libdeformable_surface\S*)", listed))
    except OSError:  # a script, on a machine without ldd
        pass
    digest = hash_bytes(" ".join(hash_file(part) for part in parts).encode())
    return "%s-%s" % (digest[:16], "".join(platform.libc_ver()))


def find_package(package):
    """The folder of a ROS package, for file names of a scene."""
    for prefix in os.environ.get("CMAKE_PREFIX_PATH", "").split(os.pathsep):
        if prefix and os.path.isdir(os.path.join(prefix, "share", package)):
            return os.path.join(prefix, "share", package)
    for root in os.environ.get("ROS_PACKAGE_PATH", "").split(os.pathsep):
        for folder in (root, os.path.join(root, package)):
            if root and os.path.basename(folder) == package and os.path.exists(os.path.join(folder, "package.xml")):
                return folder
    raise SweepError("package '%s': not found; accepted: packages on ROS_PACKAGE_PATH" % package)


def resolve(name):
    """The path of a file named in a scene or a plan."""
    match = re.match(r"package://([^/]+)/(.*)", name)
    return os.path.join(find_package(match.group(1)), match.group(2)) if match else os.path.abspath(name)


class Files:
    """Hashes of the input files of runs, each computed once."""

    def __init__(self):
        self.hashes = {}  # path -> hash

    def hash(self, path):
        if path not in self.hashes:
            self.hashes[path] = hash_file(path)
        return self.hashes[path]


def hash_run(document, bag, topics, keep, version):
    """The name of a run. document: its scene, with hashes in place of the names of files; bag: the hash of its bag."""
    scene = {key: value for key, value in document.items() if key not in ("threads", "expect")}  # neither changes a result
    return hash_bytes(json.dumps([scene, bag, topics, keep, version], sort_keys=True).encode())[:32]
