#!/usr/bin/env python3
"""Draws the errors of the physics suite over the spacing, from the table that `scripts/benchmark --physics` writes: the picture in
docs/accuracy.md.
  draw_accuracy.py PHYSICS.csv OUT.png"""
import csv
import sys

import matplotlib

matplotlib.use("Agg")
from matplotlib import pyplot  # noqa: E402

STYLES = {"regular": "o-", "jittered": "s--", "scanned": "^:"}


def read_series(path):
    """Errors over spacings by (case, membrane, sampling), spatial cases only; rows without a value are left out."""
    series = {}
    with open(path, newline="") as file:
        for row in csv.DictReader(file):
            refined_in_time = row["case"].startswith("free fall") or row["case"].endswith("tumbling sheet")
            measured = row["source"].startswith(("measured", "neo-Hookean"))
            if row["failure"] or refined_in_time or measured:
                continue
            key = (row["case"], row["membrane"], row["sampling"])
            series.setdefault(key, []).append((float(row["spacing_m_or_step_s"]), 100.0 * float(row["error"])))
    return series


def main():
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    series = read_series(sys.argv[1])
    figure, axes = pyplot.subplots(1, 2, figsize=(14, 6), sharey=True)
    cases = list(dict.fromkeys(case for case, _, _ in series))
    colours = {case: pyplot.get_cmap("tab20")(i % 20) for i, case in enumerate(cases)}
    for axis, membrane in zip(axes, ("triangles", "springs")):
        for (case, of, sampling), points in series.items():
            if of != membrane:
                continue
            # Over the coarsest spacing of the case: the cases have lengths from decimetres to ten metres.
            coarsest = max(size for size, _ in points)
            axis.plot([size / coarsest for size, _ in points], [error for _, error in points], STYLES[sampling],
                      color=colours[case], label=case if sampling == "jittered" else None, markersize=4, linewidth=1.2)
        x = [0.25, 1.0]
        axis.plot(x, [2.0 * v for v in x], color="black", linewidth=0.8)
        axis.plot(x, [2.0 * v * v for v in x], color="black", linewidth=0.8)
        axis.text(0.25, 0.5, "order 1", ha="right", va="center")
        axis.text(0.25, 0.125, "order 2", ha="right", va="center")
        axis.set(xscale="log", yscale="log", title=membrane, xlabel="spacing over the coarsest of the case", xlim=(0.17, 1.1),
                 ylim=(1e-3, 1e2))
        axis.set_xticks([0.25, 0.5, 1.0], labels=["1/4", "1/2", "1"], minor=False)
        axis.minorticks_off()
        axis.grid(alpha=0.3)
    axes[0].set_ylabel("error, %  (full: grid, dashed: jittered, dotted: scanned)")
    lines = dict(zip(*axes[0].get_legend_handles_labels()[::-1]))
    figure.legend(lines.values(), lines.keys(), loc="center right", fontsize=8)
    figure.tight_layout(rect=(0.0, 0.0, 0.78, 1.0))
    figure.savefig(sys.argv[2], dpi=90)


if __name__ == "__main__":
    main()
