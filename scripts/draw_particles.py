#!/usr/bin/env python3
"""Runs the scenes after the figures of [Szeliski and Tonnesen 1991] with `simulate` and draws each at three times, with every particle as
a disc across its normal, into one picture. It is a file of its own so that docs/images/particles.png can be made again.
  draw_particles.py SIMULATE OUT.png      SIMULATE: the program, e.g. .ws/devel/lib/deformable_surface/simulate"""
import os
import re
import subprocess
import sys
import tempfile

import matplotlib
import numpy as np

matplotlib.use("Agg")
from matplotlib import pyplot  # noqa: E402
from matplotlib.collections import LineCollection, PolyCollection  # noqa: E402

sys.path.insert(0, os.path.dirname(os.path.realpath(__file__)))
import point_files  # noqa: E402

SCENES = os.path.join(os.path.dirname(os.path.realpath(__file__)), "..", "scenes")
# Scene, title, frames per second, frames drawn (from 0; -1 the last), elevation and azimuth of the viewer in degrees.
PANELS = [
    ("chain", "5: two chains link", 50, (1, 20, -1), 0, -90),
    ("weld", "6: welding", 50, (1, 25, -1), 60, -90),
    ("cut", "7: cutting", 50, (0, 40, -1), 60, -90),
    ("crease", "8: a crease", 10, (0, 5, -1), 12, 12),
    ("stretch", "9: stretching", 10, (0, 15, -1), 20, -70),
    ("grow", "10: growing through samples", 10, (0, -1), 15, -70),
    ("fill", "11: small gaps are filled", 100, (1, 3, -1), 60, -90),
    ("drape", "12a: draping", 10, (0, 4, -1), 20, -50),
    ("plastic", "12b: drawn out, let go", 10, (0, 10, -1), 60, -90),
    ("bend", "12b: bent, let go: it stays bent", 10, (5, 20, -1), 15, -70),
    ("tear", "12c: tearing", 10, (1, 12, -1), 60, -90),
    ("stem", "13: a stem", 10, (8, 20, -1), 12, -70),
    ("handle", "13: and a handle", 10, (25, 55, -1), 12, -70),
    ("torus", "14: a sphere becomes a torus", 10, (0, 14, -1), 50, -60),
]
GIVEN, BORN = np.array([0.45, 0.65, 0.85]), np.array([0.95, 0.6, 0.2])
DISC = np.radians(np.arange(0, 360, 30))


def read_vertices(path):
    """Positions, normals and displacements of a PLY file as `simulate` writes it: one element, all properties plain numbers."""
    with open(path, "rb") as stream:
        data = stream.read()
    end = re.search(rb"^end_header\r?\n", data, re.MULTILINE).end()
    header = [line.split() for line in data[:end].decode("ascii").splitlines()]
    form = next(word[1] for word in header if word[0] == "format")
    fields = [(word[2], point_files.PLY_FORMATS[form] + point_files.PLY_TYPES[word[1]]) for word in header if word[0] == "property"]
    count = next(int(word[2]) for word in header if word[:2] == ["element", "vertex"])
    table = np.frombuffer(data, np.dtype(fields), count, end)
    columns = [np.stack([table[n] for n in names], axis=1).astype(float) for names in (("x", "y", "z"), fields_of_normals(table))]
    is_there = np.isfinite(columns[0]).all(axis=1)
    return columns[0][is_there], columns[1][is_there], table["displacement"][is_there]


def fields_of_normals(table):
    return ("nx", "ny", "nz") if "nx" in table.dtype.names else ("normal_x", "normal_y", "normal_z")


def look_along(elevation, azimuth):
    """The rows are the picture's right, up and towards-the-viewer directions; z is up."""
    e, a = np.radians([elevation, azimuth])
    towards = np.array([np.cos(e) * np.cos(a), np.cos(e) * np.sin(a), np.sin(e)])
    right = np.array([-np.sin(a), np.cos(a), 0.0])
    return np.stack([right, np.cross(towards, right), towards])


def measure_spacing(points):
    distances = np.linalg.norm(points[:, None] - points[None], axis=2)
    return np.median(np.partition(distances, 1, axis=1)[:, 1])


def draw_discs(axis, path, view):
    points, normals, displacements = read_vertices(path)
    radius = 0.5 * measure_spacing(points)
    # Two directions across each normal.
    helper = np.where(np.abs(normals[:, :1]) < 0.9, [[1.0, 0.0, 0.0]], [[0.0, 1.0, 0.0]])
    u = np.cross(normals, helper)
    u /= np.linalg.norm(u, axis=1, keepdims=True)
    v = np.cross(normals, u)
    rims = points[:, None] + radius * (np.cos(DISC)[None, :, None] * u[:, None] + np.sin(DISC)[None, :, None] * v[:, None])
    light = view.T @ np.array([0.3, 0.5, 0.81])
    shade = 0.35 + 0.65 * np.abs(normals @ light)
    # The back of a disc is darker: holes and the inside of closed surfaces are then seen.
    shade *= np.where(normals @ view[2] > 0.0, 1.0, 0.6)
    colours = np.where(np.isnan(displacements)[:, None], BORN, GIVEN) * shade[:, None]
    order = np.argsort(points @ view[2])
    axis.add_collection(PolyCollection((rims @ view[:2].T)[order], facecolors=np.clip(colours[order], 0, 1), edgecolors="0.25",
                                       linewidths=0.15))
    return points @ view[:2].T


def draw_chain(axis, path, view):
    points = read_vertices(path)[0]
    longest = 1.6 * measure_spacing(points)
    flat = points @ view[:2].T
    pairs = [(i, j) for i in range(len(flat)) for j in range(i) if np.linalg.norm(points[i] - points[j]) < longest]
    axis.add_collection(LineCollection([(flat[i], flat[j]) for i, j in pairs], colors="0.5", linewidths=0.8))
    axis.plot(flat[:, 0], flat[:, 1], ".", color=GIVEN * 0.8, markersize=3)
    return flat


def main():
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    columns = 2
    rows = (len(PANELS) + columns - 1) // columns
    figure = pyplot.figure(figsize=(13, 2.6 * rows))
    for k, (name, title, rate, chosen, elevation, azimuth) in enumerate(PANELS):
        view = look_along(elevation, azimuth)
        with tempfile.TemporaryDirectory() as folder:
            subprocess.run([sys.argv[1], os.path.join(SCENES, "particles_%s.yaml" % name), "--frames", folder, "--frame_rate",
                            str(rate)], check=True, stdout=subprocess.DEVNULL)
            frames = sorted(os.listdir(folder))
            axes, drawn = [], []
            for c, frame in enumerate(chosen):
                left = (k % columns + (c + 0.02) / 3.0) / columns
                axis = figure.add_axes([left, 1.0 - (k // columns + 0.98) / rows, 0.96 / (3 * columns), 0.86 / rows])
                draw = draw_chain if name == "chain" else draw_discs
                drawn.append(draw(axis, os.path.join(folder, frames[frame]), view))
                axes.append(axis)
        # All times of a scene on one scale.
        everything = np.concatenate(drawn)
        middle, half = (everything.min(0) + everything.max(0)) / 2.0, 0.55 * (everything.max(0) - everything.min(0)).max()
        for axis in axes:
            axis.set(xlim=(middle[0] - half, middle[0] + half), ylim=(middle[1] - half, middle[1] + half), aspect="equal")
            axis.axis("off")
        figure.text((k % columns + 0.02) / columns, 1.0 - (k // columns + 0.09) / rows, title, fontsize=11)
    figure.savefig(sys.argv[2], dpi=70)


if __name__ == "__main__":
    main()
