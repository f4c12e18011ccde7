#!/usr/bin/env python3
"""Draws one column of a sweep's table over each parameter that was swept, with the mean in bins and the first-order sensitivity: the
share of the variance that this parameter explains alone [Saltelli 2008, sec. 1.2.5], by the variance of the means.
  draw_sweep.py TABLE.csv COLUMN OUT.png"""
import csv
import sys

import matplotlib
import numpy as np

matplotlib.use("Agg")
from matplotlib import pyplot  # noqa: E402
from matplotlib.ticker import MaxNLocator  # noqa: E402

SMALLEST = 0.05  # what is less may be chance with some hundred runs


def read_numbers(path, column):
    """{parameter: values} and the values of the column, of the runs that are done."""
    with open(path, newline="") as stream:
        reader = csv.DictReader(stream)
        names = reader.fieldnames
        rows = [row for row in reader if row["status"] == "done"]
    if column not in names:
        sys.exit("draw_sweep.py: found the column '%s'; accepted: %s" % (column, ", ".join(names)))
    swept = {}
    for name in names[1:names.index("status")]:
        try:
            swept[name] = np.array([float(row[name]) for row in rows])
        except ValueError:  # a cloud or a list has no axis
            continue
    values = np.array([float(row[column] or "nan") for row in rows])
    finite = np.isfinite(values)
    if np.count_nonzero(finite) < 2:
        sys.exit("draw_sweep.py: found %d numbers in '%s'; accepted: at least 2" % (np.count_nonzero(finite), column))
    return {name: of[finite] for name, of in swept.items() if len(set(of)) > 1}, values[finite]


def find_sensitivity(parameter, values):
    """(first-order index, centres, means): by as many bins as leave each the root of the number of runs. The means of bins vary by
    chance as well: what that adds is subtracted."""
    bins = max(2, int(np.sqrt(len(values))))
    parts = [part for part in np.array_split(np.argsort(parameter, kind="stable"), bins) if len(part) > 1]
    means = np.array([values[part].mean() for part in parts])
    chance = np.mean([values[part].var(ddof=1) / len(part) for part in parts])
    index = (np.var(means) - chance * (len(parts) - 1) / len(parts)) / np.var(values)
    return index, [np.median(parameter[part]) for part in parts], means


def is_logarithmic(parameter):
    """Whether the logarithms of the values are spread more evenly than the values."""
    low, middle, high = parameter.min(), np.median(parameter), parameter.max()
    if low <= 0:
        return False
    return abs(np.log(middle * middle / (low * high))) / np.log(high / low) < abs(2 * middle - low - high) / (high - low)


def main():
    if len(sys.argv) != 4:
        sys.exit(__doc__)
    path, column, picture = sys.argv[1:]
    swept, values = read_numbers(path, column)
    figure, axes = pyplot.subplots(1, max(1, len(swept)), figsize=(4.5 * max(1, len(swept)), 4), sharey=True, squeeze=False)
    for axis, (name, parameter) in zip(axes[0], swept.items()):
        index, centres, means = find_sensitivity(parameter, values)
        axis.plot(parameter, values, ".", color="tab:blue", alpha=0.35, markersize=4)
        axis.plot(centres, means, "-", color="black", linewidth=2)
        if is_logarithmic(parameter):
            axis.set_xscale("log")
        else:
            axis.xaxis.set_major_locator(MaxNLocator(5))
        axis.set(xlabel=name, title="first-order sensitivity %s" % ("%.2f" % index if index >= SMALLEST else "below %g" % SMALLEST))
        axis.grid(alpha=0.3)
    axes[0][0].set_ylabel(column)
    figure.suptitle("%d runs" % len(values))
    figure.tight_layout()
    figure.savefig(picture, dpi=90)


if __name__ == "__main__":
    main()
