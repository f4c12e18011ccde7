#!/usr/bin/env python3
"""Runs the scenes after the figures of the paper on meshfree elasticity with point cloud geodesics, and those of filled and plastic
solids, with `simulate`, and draws their final states side by side, coloured by displacement. Makes docs/images/solids.png.
  draw_solids.py SIMULATE OUT.png      SIMULATE: the program, e.g. .ws/devel/lib/deformable_surface/simulate"""
import os
import subprocess
import sys
import tempfile

import matplotlib
import numpy as np

matplotlib.use("Agg")
from matplotlib import pyplot  # noqa: E402

import point_files  # noqa: E402

SCENES = os.path.join(os.path.dirname(os.path.realpath(__file__)), "..", "scenes")
FIGURES = [("two_bars_solid", "Fig. 8: two bars", (0, 2)), ("trousers", "Fig. 9: trousers", (0, 1)),
           ("octopus", "Fig. 10: an octopus waves", (0, 1))]
COLUMNS = [("at rest", ["duration=0.01", "gravity=[0, 0, 0]"]), ("nearest in space (1)", ["neighbors.geodesic_exponent=1"]),
           ("as published (15)", ["neighbors.geodesic_exponent=15"]), ("auto", [])]
# Scene, title, times from rest, axes.
OTHERS = [("solid_ball", "a filled ball falls on a floor", (0.01, 0.18, 2.0), (0, 2)),
          ("solid_plastic", "pressed down, let go: it stays bent", (0.01, 0.5, 2.0), (0, 2))]


def run(simulate, scene, assignments):
    """Positions at rest and at the end, and displacements."""
    with tempfile.TemporaryDirectory() as folder:
        final = os.path.join(folder, "final.ply")
        command = [simulate, os.path.join(SCENES, scene + ".yaml"), "--final", final]
        for assignment in assignments:
            command += ["--set", assignment]
        subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
        positions, _, columns = point_files.read_rows(final)
        return positions, columns["displacement"]


def draw(axis, positions, displacements, axes, largest, title):
    order = np.argsort(displacements)
    axis.scatter(positions[order, axes[0]], positions[order, axes[1]], c=displacements[order], s=3.0, vmin=0.0, vmax=largest,
                 cmap="viridis", linewidths=0)
    axis.set_aspect("equal")
    axis.set_title(title, fontsize=8)
    axis.axis("off")


def main():
    simulate, out = sys.argv[1:]
    figure = pyplot.figure(figsize=(10, 9.5))
    grid = figure.add_gridspec(5, 12, height_ratios=[1.0, 1.9, 1.5, 1.1, 0.9])
    for row, (scene, title, axes) in enumerate(FIGURES):
        results = [run(simulate, scene, assignments) for _, assignments in COLUMNS]
        largest = max(displacements.max() for _, displacements in results)
        low = np.min([positions.min(axis=0) for positions, _ in results], axis=0)
        high = np.max([positions.max(axis=0) for positions, _ in results], axis=0)
        margin = 0.03 * (high - low).max()
        for column, (positions, displacements) in enumerate(results):
            axis = figure.add_subplot(grid[row, 3 * column:3 * column + 3])
            draw(axis, positions, displacements, axes, largest, (title + "\n" if column == 0 else "") + COLUMNS[column][0])
            axis.set_xlim(low[axes[0]] - margin, high[axes[0]] + margin)
            axis.set_ylim(low[axes[1]] - margin, high[axes[1]] + margin)
    for row, (scene, title, times, axes) in enumerate(OTHERS):
        results = [run(simulate, scene, ["duration=%g" % time]) for time in times]
        low = np.min([positions.min(axis=0) for positions, _ in results], axis=0)
        high = np.max([positions.max(axis=0) for positions, _ in results], axis=0)
        for column, (positions, displacements) in enumerate(results):
            axis = figure.add_subplot(grid[len(FIGURES) + row, 4 * column:4 * column + 4])
            draw(axis, positions, displacements, axes, max(d.max() for _, d in results),
                 (title + "\n" if column == 0 else "") + "%g s" % times[column])
            axis.set_xlim(low[axes[0]] - 0.01, high[axes[0]] + 0.01)
            axis.set_ylim(low[axes[1]] - 0.01, high[axes[1]] + 0.01)
    figure.tight_layout()
    figure.savefig(out, dpi=64)


if __name__ == "__main__":
    main()
