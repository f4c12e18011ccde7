"""Runs batches in the processes of a cluster, each with a persistent `simulate`. All data are passed as arguments; a
worker and the sweep need not share a disk."""
import atexit
import os
import queue
import shutil
import tempfile

from .errors import SweepError
from .identity import find_program, find_version
from .simulator import Simulator
from .store import write_whole


class WrongWorker(Exception):
    """This worker must not run this sweep; another one may."""


simulators = {}  # program -> idle simulators; a worker with several threads has several
folder = None    # of the files sent by the sweep; created with the first one


def describe_version(program):
    """(version of simulate here, "") or ("", the reason why there is none)."""
    try:
        return find_version(find_program(program)), ""
    except SweepError as error:
        return "", str(error)


def require_version(job):
    version, problem = describe_version(job["program"])
    if version != job["version"]:
        raise WrongWorker(problem or "found simulate of another build, %s; accepted: that of the sweep, %s" % (version, job["version"]))


def keep_value(value):
    """A task that only holds a value for other tasks: each worker fetches it once, and copies survive the death of a worker."""
    return value


def place_file(name, content):
    """The path of an input: a path is returned unchanged, bytes are written to a file with this name, which is their hash."""
    global folder
    if isinstance(content, str):
        return content
    if folder is None:
        folder = tempfile.mkdtemp(prefix="sweep_inputs_")
        atexit.register(shutil.rmtree, folder, ignore_errors=True)
    path = os.path.join(folder, name)
    if not os.path.exists(path):
        write_whole(path, content)
    return path


def run_batch(job, runs, inputs):
    """Results of the runs, in order. job: their shared values; runs: (assignments KEY=VALUE, {KEY: input} of files); inputs: {name: path
    or bytes}."""
    require_version(job)
    waiting = simulators.setdefault(job["program"], queue.Queue())
    try:
        simulator = waiting.get_nowait()
    except queue.Empty:
        simulator = Simulator(find_program(job["program"]))
        atexit.register(simulator.close)
    try:
        return [run_one(simulator, job, assignments, files, inputs) for assignments, files in runs]
    finally:
        waiting.put(simulator)


def run_one(simulator, job, assignments, files, inputs):
    paths = {name: place_file(name, inputs[name]) for name in [job["scene"], *files.values()] + ([job["bag"]] if job["bag"] else [])}
    assignments = assignments + ["%s=%s" % (key, paths[name]) for key, name in files.items()]
    return simulator.run(paths[job["scene"]], assignments, paths.get(job["bag"], ""), job["topics"], job["keep"], job["timeout"])
