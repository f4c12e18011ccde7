"""One process of `simulate --serve`, which loads its libraries once and runs scene after scene. The
engine only sees results of runs."""
import collections
import os
import select
import shutil
import signal
import subprocess
import tempfile
import time

from .errors import SweepError
from .identity import hash_bytes
from .reduce import reduce_statistics, reduce_wrenches

Result = collections.namedtuple("Result", "status problem values files hash seconds")
Result.__doc__ = """What became of a run. status: done, refused (its scene or input is wrong), failed or timed out; problem: the sentence;
values: {column: number}; files: {column: [(name, bytes), ...]}; hash: of the final state; seconds: of wall time."""

STATUSES = {0: "done", 2: "refused", 3: "failed"}


class Simulator:
    def __init__(self, program):
        self.program = program
        self.process = None

    def run(self, scene, assignments, bag, topics, keep, timeout):
        """Runs one scene. scene, bag: files; assignments: KEY=VALUE, as for --set."""
        folder = tempfile.mkdtemp(prefix="sweep_")
        try:
            return self.run_in(folder, scene, assignments, bag, topics, keep, timeout)
        finally:
            shutil.rmtree(folder, ignore_errors=True)

    def run_in(self, folder, scene, assignments, bag, topics, keep, timeout):
        begin = time.monotonic()
        status, problem = self.ask([folder, scene] + make_options(assignments, bag, topics, keep), timeout)
        said = read_lines(os.path.join(folder, "err"))
        if not problem and status != 0:
            problem = "; ".join(line[len("simulate: "):] if line.startswith("simulate: ") else line for line in said) or "it said nothing"
        values, files, state = {}, {}, ""
        if status in (0, 3):
            try:
                values, files, state, missing = collect(folder, keep)
                problem = problem or missing
            except SweepError as error:  # the plan keeps a value that this scene lacks
                status, problem = 2, str(error)
            except (OSError, ValueError, KeyError) as error:
                status, problem = 1, "its results cannot be read (%s)" % error
        name = status if isinstance(status, str) else STATUSES.get(status, "failed")
        return Result(name, problem, values, files, state, time.monotonic() - begin)

    def check(self, scene, assignments, bag, topics, keep, timeout):
        """(problems of a run, in sentences, without running it; numeric columns of its statistics)."""
        folder = tempfile.mkdtemp(prefix="sweep_")
        try:
            status, problem = self.ask([folder, scene] + make_options(assignments, bag, topics, keep) + ["--check"], timeout)
            if isinstance(status, str):
                raise SweepError(problem)
            said = [line[len("simulate: "):] for line in read_lines(os.path.join(folder, "err")) if line.startswith("simulate: ")]
            words = [line.split() for line in read_lines(os.path.join(folder, "out"))]
            return said, [word[1] for word in words if word[0] == "statistics"]
        finally:
            shutil.rmtree(folder, ignore_errors=True)

    def ask(self, arguments, timeout):
        """(status, problem): the exit status of a run, or "failed" or "timed out" with the reason."""
        try:
            if self.process is None:
                # A separate process group: an interrupt at the terminal goes to the sweep, which ends its runs itself.
                self.process = subprocess.Popen([self.program, "--serve"], stdin=subprocess.PIPE, stdout=subprocess.PIPE,
                                                start_new_session=True)
            self.process.stdin.write(b"".join(os.fsencode(argument) + b"\0" for argument in arguments) + b"\0")
            self.process.stdin.flush()
        except OSError as error:
            self.close()
            return "failed", "%s: cannot be run (%s); accepted: a simulate that runs here" % (self.program, error.strerror)
        ready, _, _ = select.select([self.process.stdout], [], [], timeout)
        if not ready:
            self.close()
            return "timed out", "found no end after %g s; accepted: runs within the plan's timeout" % timeout
        answer = self.process.stdout.readline().decode().split()
        if not answer:
            status = self.process.wait()
            self.close()
            return "failed", "simulate --serve ended with status %d" % status
        if answer[0] == "signal":
            return "failed", "simulate was ended by signal %s (%s)" % (answer[1], signal.Signals(int(answer[1])).name)
        return int(answer[0]), ""

    def close(self):
        if self.process is None:
            return
        try:
            os.killpg(self.process.pid, signal.SIGKILL)
        except ProcessLookupError:
            pass
        try:
            self.process.stdin.close()
        except BrokenPipeError:  # input that it did not read
            pass
        self.process.stdout.close()
        self.process.wait()
        self.process = None


def make_options(assignments, bag, topics, keep):
    options = []
    for assignment in assignments:
        options += ["--set", assignment]
    for quantity in keep["measure"]:
        options += ["--measure", quantity]
    if bag:
        options += ["--bag_in", bag]
        for name, topic in topics.items():
            options += ["--topic", "%s=%s" % (name, topic)]
    if keep["statistics"]:
        options += ["--statistics", "statistics.csv"]
    if keep["wrenches"]:
        options += ["--wrenches", "wrenches.csv"]
    if keep["final"]:
        options += ["--final", "final.ply"]
    if keep["frames"]:
        options += ["--frames", "frames", "--frame_rate", repr(float(keep["frames"]))]
    if keep["bag"]:
        options += ["--bag_out", "run.bag"]
    return options + ["--threads", "1"]


def collect(folder, keep):
    """(values, files, hash of the state, missing values) of a finished run."""
    values, state, missing = {}, "", []
    for line in read_lines(os.path.join(folder, "out")):
        words = line.split()
        if words[:1] == ["measured"]:
            values[words[1]] = float(words[2])
        elif words[:2] == ["state", "hash"]:
            state = words[2]
        elif words[:2] == ["note:", "--measure:"]:
            missing.append(line[len("note: --measure: "):])
    if keep["statistics"]:
        values.update(reduce_statistics(os.path.join(folder, "statistics.csv"), keep["statistics"]))
    if keep["wrenches"]:
        values.update(reduce_wrenches(os.path.join(folder, "wrenches.csv"), keep["wrenches"]))
    files = {}
    if keep["final"]:
        files["final"] = [read_file(folder, "final.ply")]
    if keep["bag"]:
        files["bag"] = [read_file(folder, "run.bag")]
    if keep["frames"]:
        inner = os.path.join(folder, "frames")
        files["frames"] = [read_file(inner, name) for name in sorted(os.listdir(inner))]
    return values, files, state, "; ".join(missing)


def read_file(folder, name):
    with open(os.path.join(folder, name), "rb") as stream:
        data = stream.read()
    return hash_bytes(data) + os.path.splitext(name)[1], data


def read_lines(path):
    try:
        with open(path, encoding="utf-8", errors="replace") as stream:
            return [line for line in stream.read().splitlines() if line]
    except FileNotFoundError:
        return []
