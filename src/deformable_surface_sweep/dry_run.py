"""Estimates the cost of a plan: the number of runs, and time and bytes measured on a few of them on this machine."""
import os

from .progress import describe_bytes, describe_time
from .simulator import Simulator
from .store import Store

PROBES = 3  # first, middle and last


def describe_plan(sweep):
    runs = {run.name: run for run in sweep.runs}
    done = Store(sweep.options.out).read() if os.path.isdir(sweep.options.out) else {}
    todo = [run for name, run in runs.items() if name not in done]
    lines = ["%d runs, %d of them to be run" % (len(runs), len(todo))]
    if len(runs) < len(sweep.runs):
        lines.append("%d rows have the values of another row" % (len(sweep.runs) - len(runs)))
    if todo:
        lines += describe_probes(sweep, [todo[i] for i in sorted({0, len(todo) // 2, len(todo) - 1})][:PROBES], len(todo))
    return "\n".join(lines)


def describe_probes(sweep, probes, count):
    simulator = Simulator(sweep.program)
    try:
        results = [simulator.run(*sweep.describe_for_program(run), sweep.plan.timeout) for run in probes]
    finally:
        simulator.close()
    # The first run also loads the program.
    seconds = sum(result.seconds for result in results) / len(results)
    size = sum(len(data) for result in results for files in result.files.values() for _, data in files) / len(results)
    workers = sweep.options.workers or len(os.sched_getaffinity(0))
    lines = ["%.2f s a run, by %d of them: %s with %d workers" % (seconds, len(results), describe_time(seconds * count / workers), workers),
             "%s of files" % describe_bytes(size * count)]
    lines += ["%s: %s" % (result.status, result.problem) for result in results if result.problem]
    return lines
