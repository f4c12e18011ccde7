"""The plan of a sweep: its runs and the results to keep of each. Reads and checks the YAML file; nothing is run here."""
import glob
import os

from .documents import merge, read_yaml
from .errors import SweepError
from .identity import resolve
from .reduce import REDUCTIONS, name_reduction
from .sampling import METHODS, is_number, limited_product, read_grid, read_paired, read_samples

KEYS = ("scene", "bag", "topics", "clouds", "set", "grid", "paired") + METHODS + ("keep", "timeout")
KEPT = ("statistics", "wrenches", "measure", "final", "frames", "bag")
COMPONENTS = tuple("%s_%s" % (kind, axis) for kind in ("force", "torque") for axis in "xyz")
OWN_KEYS = {"threads": "each run has one thread; --workers says how many run at once"}


class Keep:
    """The results to keep of a run, as values that can be sent and hashed."""

    def __init__(self, section):
        section = require_map("keep", section, KEPT)
        self.statistics = read_reductions("keep: statistics", section.get("statistics", {}))
        self.wrenches = read_reductions("keep: wrenches", section.get("wrenches", {}))
        for name in self.wrenches:
            if name.rpartition(".")[2] not in COMPONENTS or not name.rpartition(".")[0]:
                raise SweepError("keep: wrenches: found '%s'; accepted: ID.COMPONENT, the id of a tool or pins[0] and one of %s" %
                                 (name, ", ".join(COMPONENTS)))
        self.measure = section.get("measure", [])
        if not (isinstance(self.measure, list) and all(isinstance(name, str) for name in self.measure)):
            raise SweepError("keep: measure: found %s; accepted: a list of the quantities of expect" % self.measure)
        self.final, self.bag = (read_flag("keep: " + name, section.get(name, False)) for name in ("final", "bag"))
        self.frames = section.get("frames", 0)
        if not (is_number(self.frames) and self.frames >= 0):
            raise SweepError("keep: frames: found %s; accepted: a rate in Hz, 0 = none" % self.frames)
        columns = self.columns()
        for name in columns:
            if columns.count(name) > 1:
                raise SweepError("keep: found the column '%s' twice; accepted: once" % name)

    def describe(self):
        """All settings that affect the result of a run."""
        return {name: getattr(self, name) for name in KEPT}

    def columns(self):
        """The columns of the table, in its order."""
        return ([name_reduction(name, how) for kept in (self.statistics, self.wrenches) for name, all_of in kept.items()
                 for how in all_of] + list(self.measure))


class Plan:
    """scene: its values; runs: {dotted path: value} of each run, in the order of the table; varied: the paths that differ."""

    def __init__(self, path):
        document = require_map(path, read_yaml(path), KEYS)
        self.path = os.path.abspath(path)
        self.scene_file = self.find(require_text("scene", document.get("scene")))
        self.scene = read_yaml(self.scene_file)
        self.bag = self.find(require_text("bag", document["bag"])) if "bag" in document else ""
        self.topics = require_map("topics", document.get("topics", {}))
        if self.topics and not self.bag:
            raise SweepError("topics: found without bag; accepted: together with bag: FILE.bag")
        self.keep = Keep(document.get("keep", {}))
        self.timeout = document.get("timeout", 3600)
        if not (is_number(self.timeout) and self.timeout > 0):
            raise SweepError("timeout: found %s; accepted: a number above 0 (s of a run)" % self.timeout)
        self.fixed = require_map("set", document.get("set", {}))
        parts = self.read_parts(document)
        self.varied = [name for part in parts for name in part[0]]
        self.check_keys()
        # The file name of a cloud in the plan is relative to the plan; one in the scene is resolved as by `simulate`.
        self.fixed = self.place_files(self.fixed)
        self.runs = []
        for rows in limited_product(parts):
            run = dict(self.fixed)
            for row in rows:
                run.update(row)
            self.runs.append(self.place_files(run))

    def read_parts(self, document):
        parts = []
        if "clouds" in document:
            self.fixed = dict({"cloud.shape": "none"}, **self.fixed)
            parts.append([{"cloud.file": file} for file in self.find_clouds(document["clouds"])])
        for name, read in (("grid", read_grid), ("paired", read_paired)):
            if name in document:
                if not require_map(name, document[name]):
                    raise SweepError("%s: found no key; accepted: at least one KEY: VALUES" % name)
                parts.append(read(name, document[name]))
        for method in METHODS:
            if method in document:
                parts.append(read_samples(method, require_map(method, document[method])))
        return parts

    def check_keys(self):
        names = list(self.fixed) + self.varied
        for name in names:
            if not isinstance(name, str) or not all(name.split(".")) or set(name) & set("[]="):
                raise SweepError("found the key '%s'; accepted: dotted paths of the scene, as in material.thickness or tools.0.friction" % name)
            if name in OWN_KEYS:
                raise SweepError("found the key '%s'; accepted: all but it, %s" % (name, OWN_KEYS[name]))
            if names.count(name) > 1:
                raise SweepError("found the key '%s' twice; accepted: in one of set, clouds, grid, paired, %s" % (name, ", ".join(METHODS)))
        # Paths that do not fit the scene are refused once, here.
        merge(self.scene, dict.fromkeys(names))

    def find(self, name):
        return resolve(name) if name.startswith("package://") else os.path.join(os.path.dirname(self.path), name)

    def find_clouds(self, patterns):
        patterns = [patterns] if isinstance(patterns, str) else patterns
        if not (isinstance(patterns, list) and patterns and all(isinstance(pattern, str) for pattern in patterns)):
            raise SweepError("clouds: found %s; accepted: a file, a pattern as in scans/*.ply, or a list of them" % patterns)
        if self.bag:
            raise SweepError("clouds: found with bag, which has the clouds; accepted: one of them")
        files = []
        for pattern in patterns:
            found = sorted(glob.glob(self.find(pattern), recursive=True))
            if not found:
                raise SweepError("clouds: found no file for '%s'; accepted: files that are there" % self.find(pattern))
            files += [file for file in found if file not in files]
        return files

    def place_files(self, overrides):
        return {name: self.find(value) if name.endswith(".file") and isinstance(value, str) and value else value
                for name, value in overrides.items()}


def require_map(where, value, known=None):
    if not isinstance(value, dict):
        raise SweepError("%s: found %s; accepted: a map of keys" % (where, "nothing" if value is None else value))
    for key in value:
        if known and key not in known:
            raise SweepError("%s: found the key '%s'; accepted: %s" % (where, key, ", ".join(known)))
    return value


def require_text(where, value):
    if not (isinstance(value, str) and value):
        raise SweepError("%s: found %s; accepted: the name of a file" % (where, "nothing" if value is None else value))
    return value


def read_flag(where, value):
    if not isinstance(value, bool):
        raise SweepError("%s: found %s; accepted: true or false" % (where, value))
    return value


def read_reductions(where, section):
    """{column: ways}: the last, max, mean or min over all steps, or a time in s."""
    found = {}
    for name, ways in require_map(where, section).items():
        ways = ways if isinstance(ways, list) else [ways]
        for way in ways:
            if way not in REDUCTIONS and not (is_number(way) and way >= 0):
                raise SweepError("%s: %s: found %s; accepted: %s, or a time in s" % (where, name, way, ", ".join(REDUCTIONS)))
        if not ways:
            raise SweepError("%s: %s: found nothing; accepted: %s, or a time in s" % (where, name, ", ".join(REDUCTIONS)))
        found[str(name)] = ways
    return found
