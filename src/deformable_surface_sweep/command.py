"""The command `sweep`: reads a plan, runs the missing runs, writes the table."""
import argparse
import json
import os
import signal
import sys
import time

from .cluster import find_versions, open_cluster
from .documents import merge, find_files, set_by_path, to_text
from .dry_run import describe_plan
from .engine import Engine, Run
from .errors import SweepError
from .identity import Files, find_program, find_version, hash_run, resolve
from .names import check_plan, find_reactions
from .plan import Plan
from .progress import Progress, describe_time
from .store import Store, write_whole
from .table import write_table

RETRIED = ("failed", "timed out")
DESCRIPTION = """Runs a scene with many values of its parameters and writes one table of the results. The same command goes on with a
sweep that was stopped. Exit status: 0 all runs are done; 1 some were refused, failed or timed out; 2 the plan, the
command line or the cluster is wrong; 130 interrupted. The plan and examples: docs/sweeps.md."""


class Parser(argparse.ArgumentParser):
    def error(self, message):
        """Omits the usage, which --help prints."""
        raise SweepError(message)


def read_count(text):
    if not (text.isdigit() and int(text) > 0):
        raise argparse.ArgumentTypeError("found '%s'; accepted: a number above 0" % text)
    return int(text)


def parse_arguments(arguments):
    parser = Parser("sweep", description=DESCRIPTION, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("plan", metavar="PLAN.yaml")
    parser.add_argument("--out", metavar="DIR", help="results (else the plan's name without .yaml, in this folder)")
    parser.add_argument("--workers", metavar="N", type=read_count, default=0, help="runs at once on this machine (else its cores), or jobs of Slurm")
    where = parser.add_mutually_exclusive_group()
    where.add_argument("--scheduler", metavar="ADDRESS", default="", help="a dask-scheduler that runs, as in tcp://HOST:8786")
    where.add_argument("--scheduler-file", metavar="FILE", default="", help="the file that dask-scheduler --scheduler-file wrote")
    where.add_argument("--slurm", metavar="OPTIONS", help="start the workers with Slurm; options of sbatch, as in --slurm='--partition=cpu --time=60'")
    parser.add_argument("--dry_run", action="store_true", help="only say how many runs, how long and how many bytes")
    parser.add_argument("--retry", action="store_true", help="run again what failed or timed out before")
    parser.add_argument("--simulate", metavar="PROGRAM", default="", help="the program (else that of the workspace), at the same path "
                        "on every worker")
    parser.add_argument("--quiet", action="store_true", help="errors only")
    parsed = parser.parse_args(arguments)
    if parsed.workers and (parsed.scheduler or parsed.scheduler_file):
        parser.error("--workers: found with a scheduler, which has its workers; accepted: for this machine or --slurm")
    if parsed.slurm is not None and not parsed.workers:
        parser.error("--slurm: found without --workers; accepted: together with --workers N, the jobs to start")
    parsed.out = parsed.out or os.path.splitext(os.path.basename(parsed.plan))[0]
    return parsed


class Sweep:
    """A plan with the names of its runs and their inputs."""

    def __init__(self, options):
        self.options = options
        self.plan = Plan(options.plan)
        self.program = find_program(options.simulate)
        self.version = find_version(self.program)
        self.files = Files()
        self.inputs = {}  # name -> path
        self.scene = self.add_input(self.plan.scene_file)
        self.bag = self.add_input(self.plan.bag) if self.plan.bag else ""
        self.reactions = set()  # ids of tools and pins in any run
        self.runs = [self.describe_run(run) for run in self.plan.runs]

    def add_input(self, path):
        """The name of an input: the hash of its content, with the extension by which `simulate` determines its kind."""
        name = self.files.hash(path) + os.path.splitext(path)[1]
        self.inputs[name] = os.path.abspath(path)
        return name

    def describe_run(self, run):
        document = merge(self.plan.scene, run)
        self.reactions.update(find_reactions(document))
        files = {key: self.add_input(resolve(name)) for key, name in find_files(document)}
        for key, name in files.items():
            set_by_path(document, key, name)
        name = hash_run(document, self.bag, self.plan.topics, self.plan.keep.describe(), self.version)
        return Run(name, ["%s=%s" % (key, to_text(value)) for key, value in run.items() if key not in files], files)

    def describe_for_program(self, run):
        """(scene, assignments, bag, topics, keep) of a run on this machine, for Simulator."""
        assignments = run.assignments + ["%s=%s" % (key, self.inputs[name]) for key, name in run.files.items()]
        job = self.job()
        return self.inputs[self.scene], assignments, self.inputs.get(self.bag, ""), job["topics"], job["keep"]

    def job(self):
        """The values shared by all runs."""
        return {"program": self.options.simulate and self.program, "version": self.version, "scene": self.scene, "bag": self.bag,
                "topics": self.plan.topics, "keep": self.plan.keep.describe(), "timeout": self.plan.timeout}


def run_sweep(options):
    sweep = Sweep(options)
    check_plan(sweep)
    if options.dry_run:
        print(describe_plan(sweep))
        return 0
    store = Store(options.out)
    records = store.read()
    names = [run.name for run in sweep.runs]
    todo = {run.name: run for run in sweep.runs
            if run.name not in records or options.retry and records[run.name]["status"] in RETRIED}
    for name in todo:
        records.pop(name, None)
    keep_plan(sweep, options.out)
    progress = Progress(len(set(names)), len(set(names)) - len(todo), quiet=options.quiet)
    if progress.done:
        progress.say("%d of %d runs are there from before" % (progress.done, progress.total))

    def take(name, result):
        # A run whose workers died may succeed another time: it gets a row, but is not stored as a result.
        records[name] = store.add(name, result) if result.status != "lost" else {
            "status": "lost", "problem": result.problem, "values": {}, "files": {}, "hash": ""}
        progress.add(result.status)

    begun = time.monotonic()
    try:
        if todo:
            with open_cluster(options.scheduler, options.scheduler_file, options.slurm, options.workers) as (client, shares_files):
                Engine(client, sweep.job(), sweep.inputs, shares_files, progress.say).run(todo.values(), take)
    finally:
        progress.finish()
        store.close()
        if any(name not in records for name in names):
            # An interrupt may have come after a result was stored and before it was recorded here.
            records = {**store.read(), **records}
        written = write_table(sweep.plan, names, records, options.out)
    problems = [records[name]["problem"] for name in dict.fromkeys(names) if records[name]["status"] != "done"]
    progress.say("%s; %d runs in %s; %s" % (progress.describe_end(problems), len(todo), describe_time(time.monotonic() - begun),
                                            ", ".join(written)))
    return 1 if problems else 0


def keep_plan(sweep, out):
    """The plan, its scene and the versions, beside the results."""
    versions = dict(find_versions(), simulate=sweep.version, program=sweep.program, scene=sweep.plan.scene_file, plan=sweep.plan.path,
                    time=time.strftime("%Y-%m-%dT%H:%M:%SZ", time.gmtime()))
    for source, name in ((sweep.plan.path, "plan.yaml"), (sweep.plan.scene_file, "scene.yaml")):
        with open(source, "rb") as stream:
            write_whole(os.path.join(out, name), stream.read())
    write_whole(os.path.join(out, "versions.json"), (json.dumps(versions, indent=2) + "\n").encode())


def main(arguments=None):
    # A termination signal is treated as an interrupt: finished runs get their table.
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    try:
        return run_sweep(parse_arguments(arguments))
    except SweepError as error:
        for problem in error.problems:
            print("sweep: %s" % problem, file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        print("sweep: interrupted; finished runs are kept, and the same command goes on with the others", file=sys.stderr)
        return 130
