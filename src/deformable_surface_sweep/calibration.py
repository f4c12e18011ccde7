"""The calibration of the error estimate (docs/accuracy_control.md) by the engine of sweeps: each of its random scenes is a run of
`benchmark_core`, and what a run has is its rows of calibration_scenes.csv. scripts/benchmark calls it."""
import argparse
import os
import subprocess
import sys
import tempfile
import time

from .cluster import open_cluster
from .engine import Engine, Run
from .errors import SweepError
from .identity import find_program, find_version, hash_bytes
from .progress import Progress
from .simulator import Result
from .store import write_whole
from .worker import require_version

TABLE = "calibration_scenes.csv"


def run_seeds(job, runs, inputs):
    """Same as worker.run_batch(). The first assignment of a run is its seed."""
    require_version(job)
    return [run_seed(job["program"], assignments[0]) for assignments, _ in runs]


def run_seed(program, seed):
    begin = time.monotonic()
    with tempfile.TemporaryDirectory(prefix="calibration_") as folder:
        done = subprocess.run([program, "--calibration", "--scenes", seed, "1", "--output", folder], stdout=subprocess.DEVNULL,
                              stderr=subprocess.PIPE, universal_newlines=True)
        table = read_table(os.path.join(folder, TABLE))
    status = "done" if done.returncode == 0 and len(table) > 1 else "failed"
    rows = "".join(table[1:]).encode()
    return Result(status, " ".join(done.stderr.split()), {}, {"rows": [(hash_bytes(rows), "".join(table).encode())]}, "",
                  time.monotonic() - begin)


def read_table(path):
    """The lines of a table, the header first."""
    if not os.path.exists(path):
        return []
    with open(path) as stream:
        return stream.readlines()


def find_seed(line):
    """The seed of a complete row; else None."""
    seed = line.split(",", 1)[0]
    return int(seed) if seed.isdigit() and line.endswith("\n") else None


def calibrate(options):
    path = os.path.join(options.folder, TABLE)
    table = read_table(path)
    rows = {}  # seed -> lines
    for line in table:
        rows.setdefault(find_seed(line), []).append(line)
    rows.pop(None, None)
    seeds = range(options.first, options.first + options.count)
    todo = [Run("seed%d" % seed, [str(seed)], {}) for seed in seeds if seed not in rows]
    program = find_program(options.program)
    job = {"program": program, "version": find_version(program), "scene": "", "bag": ""}
    progress = Progress(options.count, options.count - len(todo))
    header = table[:1]

    def take(name, result):
        lines = result.files["rows"][0][1].decode().splitlines(keepends=True) if result.files else []
        # Rows of another version have other columns. What this one writes is known from its first result.
        if header and lines and lines[0] != header[0]:
            raise SweepError("%s: found the columns '%s'; accepted: '%s', or another folder than that of another version's scenes" %
                             (path, header[0].strip(), lines[0].strip()))
        header[:] = header or lines[:1]
        if result.status == "done":
            rows[int(name[len("seed"):])] = lines[1:]
            # In the order of the seeds, not of completion.
            write_whole(path, "".join(header + [line for seed in sorted(rows) for line in rows[seed]]).encode())
        else:
            progress.say("%s: %s" % (name, result.problem))
        progress.add(result.status)

    if todo:
        with open_cluster(options.scheduler, options.scheduler_file, None, options.workers) as (client, shares_files):
            Engine(client, job, {}, shares_files, progress.say, run_seeds).run(todo, take)
    progress.finish()


def main(arguments=None):
    parser = argparse.ArgumentParser("calibration", description=__doc__)
    parser.add_argument("program", help="benchmark_core, at the same path on every worker")
    parser.add_argument("folder", help="of " + TABLE + ", which goes on where it was stopped")
    parser.add_argument("first", type=int, help="seed")
    parser.add_argument("count", type=int)
    parser.add_argument("--workers", type=int, default=0)
    parser.add_argument("--scheduler", default="")
    parser.add_argument("--scheduler-file", default="")
    try:
        calibrate(parser.parse_args(arguments))
    except SweepError as error:
        sys.exit("calibration: %s" % error)


if __name__ == "__main__":
    main()
