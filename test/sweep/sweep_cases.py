"""Shared by the tests of sweeps: a folder with a plan and a scene, and a stand-in for `simulate` of known duration."""
import csv
import os
import subprocess
import sys
import tempfile
import time
import unittest

HERE = os.path.dirname(os.path.realpath(__file__))
ROOT = os.path.join(HERE, "..", "..")
STUB = os.path.join(HERE, "stub_simulate")
SKIPPED = 77
PATIENCE = 120.0  # s; only a test that fails takes that long
sys.path.insert(0, os.path.join(ROOT, "src"))

SCENE = """
model: mass_spring
cloud: {shape: sheet, points: 100}
simplification: {target_points: 40}
pins: [{box: {min: [-1, -1, -1], max: [-0.3, 1, 1]}}]
duration: 0.1
"""
STUB_PLAN = """
scene: scene.yaml
set: {stub.seconds: %g}
grid: {a: {from: 1, to: %d, steps: %d}}
keep: {measure: [min_z]}
"""


def require_dask():
    """Skips a test if it is missing."""
    try:
        import distributed  # noqa: F401
    except ImportError as error:
        print("skipped: no Dask here, the package python3-distributed (%s)" % error)
        sys.exit(SKIPPED)


def make_environment(of=None):
    """Workers import the module of this repository."""
    of = of or os.environ
    path = os.pathsep.join([os.path.join(ROOT, "src")] + of.get("PYTHONPATH", "").split(os.pathsep))
    return dict(of, PYTHONPATH=path.rstrip(os.pathsep))


class SweepCase(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = folder.name
        self.write("scene.yaml", SCENE)

    def path(self, name):
        return os.path.join(self.folder, name)

    def write(self, name, text):
        with open(self.path(name), "w") as stream:
            stream.write(text)
        return self.path(name)

    def start(self, plan, *options, out="out", before=(), environment=None):
        """Starts the command. plan: text; before: words before the command, for another host; environment: replaces the present one."""
        command = list(before) + [sys.executable, os.path.join(ROOT, "scripts", "sweep"), self.write("plan.yaml", plan), "--out", self.path(out)]
        process = subprocess.Popen(command + list(options), stdout=subprocess.PIPE, stderr=subprocess.STDOUT, universal_newlines=True,
                                   env=make_environment(environment), cwd=self.folder)
        self.addCleanup(end, process)
        return process

    def sweep(self, plan, *options, status=0, **how):
        """Runs the command and returns its output; how: arguments of start()."""
        process = self.start(plan, *options, **how)
        said, _ = process.communicate(timeout=PATIENCE)
        self.assertEqual(process.returncode, status, said)
        return said

    def table(self, out="out"):
        with open(os.path.join(self.folder, out, "table.csv"), newline="") as stream:
            return list(csv.DictReader(stream))

    def text(self, out="out"):
        with open(os.path.join(self.folder, out, "table.csv")) as stream:
            return stream.read()

    def await_runs(self, number, out="out"):
        """Waits until this number of runs is kept."""
        begin = time.monotonic()
        while self.count_runs(out) < number:
            self.assertLess(time.monotonic() - begin, PATIENCE)
            time.sleep(0.02)

    def count_runs(self, out="out"):
        folder = os.path.join(self.folder, out, "runs")
        count = 0
        for name in os.listdir(folder) if os.path.isdir(folder) else []:
            with open(os.path.join(folder, name)) as stream:
                count += stream.read().count("\n")
        return count


def end(process):
    if process.poll() is None:
        process.kill()
        process.communicate()
