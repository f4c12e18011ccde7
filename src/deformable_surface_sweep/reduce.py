"""Reduces the rows of a run, one per step, to the numbers to keep."""
import csv
import math

from .errors import SweepError

REDUCTIONS = ("last", "max", "mean", "min")


def name_reduction(name, way):
    """The name of a column of the table. A reduction that is not a word is a time in s."""
    return "%s.%s" % (name, way if way in REDUCTIONS else "at_%g" % way)


def reduce_column(times, values, way):
    """values at the times of the steps; NaN where a run has none. A time selects the first step that is not before it."""
    if not values:
        return math.nan
    if way == "last":
        return values[-1]
    if way == "mean":
        return math.fsum(values) / len(values)
    if way in ("max", "min"):
        # NaN is kept: comparisons with it are false.
        return math.nan if any(math.isnan(value) for value in values) else max(values) if way == "max" else min(values)
    tolerance = 1e-9 * max(1.0, way)  # of times in decimal fractions
    return next((value for time, value in zip(times, values) if time >= way - tolerance), math.nan)


def reduce_rows(rows, ways):
    times = [float(row["simulation_time"]) for row in rows]
    result = {}
    for name, all_of in ways.items():
        values = [float(row[name]) for row in rows]
        for way in all_of:
            result[name_reduction(name, way)] = reduce_column(times, values, way)
    return result


def reduce_statistics(path, ways):
    with open(path, newline="") as stream:
        reader = csv.DictReader(stream)
        check_names("keep: statistics", ways, reader.fieldnames)
        return reduce_rows(list(reader), ways)


def reduce_wrenches(path, ways):
    with open(path, newline="") as stream:
        rows = list(csv.DictReader(stream))
    result = {}
    for name, all_of in ways.items():
        of, _, component = name.rpartition(".")
        check_names("keep: wrenches", [of], sorted({row["id"] for row in rows}))
        reduced = reduce_rows([row for row in rows if row["id"] == of], {component: all_of})
        result.update({name + key[len(component):]: value for key, value in reduced.items()})
    return result


def check_names(where, names, known):
    for name in names:
        if name not in known:
            raise SweepError("%s: found '%s'; accepted: %s" % (where, name, ", ".join(known) or "none, the scene has no tool and no pin"))
