#!/usr/bin/env python3
"""Grows surfaces of oriented particles through samples of scans with `simulate`. Draws the samples, the surface with samples held, and
the released surface, coloured by distance: docs/images/fits.png. The scans are not shipped.
  draw_fits.py SIMULATE OUT.png [--sphere FILE] [--head FILE] [--cat FILE] [--view FILE --whole FILE]
Files: .xyz, .ply or .pcd, with normals, except the whole. In docs: sphere_1k.xyz, oni.ply and kitten.xyz of CGAL's data, bun0.pcd of
PCL's tests, and the bunny of Open3D."""
import argparse
import io
import os
import subprocess
import tempfile

import matplotlib
import numpy as np
import rosbag

matplotlib.use("Agg")
from matplotlib import pyplot  # noqa: E402
from matplotlib.cm import ScalarMappable  # noqa: E402
from matplotlib.colors import Normalize  # noqa: E402
from PIL import Image  # noqa: E402
from scipy.spatial import cKDTree  # noqa: E402

import draw_particles  # noqa: E402
import point_files  # noqa: E402

# Of the rows: how far apart samples are chosen, spacing, max_gap, sample_gap, bending rigidity in E h a^2, noise; the viewer's
# elevation and azimuth in degrees and which axis of the file is up.
ROWS = [("sphere", 0.3, 0.15, 5.0, 0.0, 1.0, 0.11, 20, -60, "z"),
        ("head", 0.04, 0.04, 5.0, 1.7, 0.3, 0.0, 10, -75, "y"),
        ("cat", 0.06, 0.0285, 5.0, 1.7, 0.3, 0.0, 15, -60, "y"),
        ("view", 0.005, 0.005, 2.5, 0.0, 0.3, 0.0, 5, -80, "y")]
TITLES = {"sphere": "a noisy sphere", "head": "an uneven head", "cat": "a cat", "view": "a range view of the bunny"}
UPRIGHT = {"z": np.eye(3), "y": np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])}
NOISE, SEED = 0.2, 3  # of the sphere's samples: spacings at most, either way; as in the tests
STIFFNESS = 1e5 * 0.001  # N/m, of the scene below
FAR = 0.4  # spacings: what is coloured most
NEIGHBOURS = 12  # that span the tangent plane of a point without normal
COLOURS = 128
SCENE = """
model: oriented_particles
cloud: {{file: {file}}}
material: {{young_modulus: 1.0e5, thickness: 0.001, bending_rigidity: {rigidity}}}
simplification: {{method: none}}
oriented_particles:
  spacing: {spacing}
  grow_surface: true
  growth: {{min_gap: 1.6, max_gap: {max_gap}, clearance: 0.65, sample_gap: {sample_gap}, max_passes: 60, {release}}}
gravity: [0, 0, 0]
duration: 0.01
"""


def choose_apart(points, apart):
    """The first ones that are as far as that from all others before them."""
    chosen = []
    for i, p in enumerate(points):
        if not chosen or np.linalg.norm(points[chosen] - p, axis=1).min() >= apart:
            chosen.append(i)
    return chosen


def find_normals(points):
    near = points[cKDTree(points).query(points, NEIGHBOURS)[1]]
    off = near - near.mean(1, keepdims=True)
    return np.linalg.eigh(np.einsum("nki,nkj->nij", off, off))[1][:, :, 0]


def make_samples(name, points, normals, apart, spacing):
    chosen = choose_apart(points, apart)
    points, normals = points[chosen], normals[chosen]
    if name == "sphere":
        normals = points / np.linalg.norm(points, axis=1, keepdims=True)
        drawn = np.random.RandomState(SEED).randint(0, 2**32, len(points), np.uint32) / 4294967295.0
        points = normals * (1.0 + NOISE * spacing * (2.0 * drawn - 1.0))[:, None]
    return points, normals


def fit(simulate, samples, normals, values, releases):
    """The first frame of the scene: the surface as the fit leaves it."""
    spacing, max_gap, sample_gap, rigidity, noise = values
    with tempfile.TemporaryDirectory() as folder:
        cloud, scene, bag = (os.path.join(folder, name) for name in ("samples.xyz", "scene.yaml", "out.bag"))
        np.savetxt(cloud, np.hstack([samples, normals]), "%.17g")
        with open(scene, "w") as stream:
            release = "noise: %r" % noise if releases else "release_samples: false"
            stream.write(SCENE.format(file=cloud, rigidity=rigidity * STIFFNESS * spacing**2, spacing=spacing, max_gap=max_gap,
                                      sample_gap=sample_gap, release=release))
        subprocess.run([simulate, scene, "--bag_out", bag], check=True, stdout=subprocess.DEVNULL)
        found = {}
        with rosbag.Bag(bag) as messages:
            for topic, message, _ in messages.read_messages():
                found.setdefault(topic.rsplit("/", 1)[-1], message)
    return draw_particles.Frame(found["markers"], found["simulation_points"], len(samples))


def measure_distances(frame, name, points, normals, spacing):
    """Of every particle, in spacings, positive where it faces: to the unit sphere, else to the nearest point's tangent plane."""
    if name == "sphere":
        return (np.linalg.norm(frame.positions, axis=1) - 1.0) / spacing
    nearest = cKDTree(points).query(frame.positions)[1]
    planes = normals[nearest]
    side = np.sign(np.einsum("ni,ni->n", planes, frame.axes[:, 2]))
    return side * np.einsum("ni,ni->n", planes, frame.positions - points[nearest]) / spacing


def draw_coloured(axis, frame, distances, view, colours):
    by_place = {tuple(p): d for p, d in zip(frame.positions, distances)}
    corners = frame.triangles
    means = np.array([np.mean([by_place[tuple(p)] for p in triangle]) for triangle in corners])
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    draw_particles.add_faces(axis, corners, normals, colours.to_rgba(means)[:, :3], view, "0.4", 0.1)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("simulate")
    parser.add_argument("out")
    for name in ("sphere", "head", "cat", "view", "whole"):
        parser.add_argument("--" + name)
    given = vars(parser.parse_args())
    rows = [row for row in ROWS if given[row[0]]]
    if not rows or (given["view"] and not given["whole"]):
        parser.error("found no scan, or a view without the whole that it is compared with")
    figure = pyplot.figure(figsize=(10.5, 3.3 * len(rows)))
    colours = ScalarMappable(Normalize(-FAR, FAR), "RdBu_r")
    for k, (name, apart, spacing, max_gap, sample_gap, rigidity, noise, elevation, azimuth, up) in enumerate(rows):
        points, normals, _ = point_files.read_rows(given[name])
        view = draw_particles.look_along(elevation, azimuth) @ UPRIGHT[up]
        if name == "view" and (normals @ view[2]).mean() < 0.0:  # it is looked at from where it was seen
            normals = -normals
        samples, sample_normals = make_samples(name, points, normals, apart, spacing)
        if name == "view":
            points = point_files.read_points(given["whole"])
            normals = find_normals(points)
        values = (spacing, max_gap, sample_gap, rigidity, noise)
        frames = [fit(given["simulate"], samples, sample_normals, values, releases) for releases in (False, True)]
        flat = frames[0].positions @ view[:2].T
        low, high = flat.min(0), flat.max(0)
        middle, half = (low + high) / 2.0, 0.54 * (high - low).max()
        for c in range(3):
            axis = figure.add_axes([c / 3.0, 1.0 - (k + 1.0) / len(rows) + 0.01, 0.31, 0.86 / len(rows)])
            if c == 0:
                draw_particles.draw_discs(axis, frames[0], view, ~frames[0].is_born)
                title = "%s: %d samples" % (TITLES[name], len(samples))
            else:
                distances = measure_distances(frames[c - 1], name, points, normals, spacing)
                draw_coloured(axis, frames[c - 1], distances, view, colours)
                title = "%s: %.3f (rms), %.2f (largest)" % (("%d born, samples held" % frames[0].is_born.sum(), "let go")[c - 1],
                                                             np.sqrt(np.mean(distances**2)), np.abs(distances).max())
                print(name, title)
            axis.set(xlim=(middle[0] - half, middle[0] + half), ylim=(middle[1] - half, middle[1] + half), aspect="equal")
            axis.axis("off")
            figure.text(c / 3.0 + 0.01, 1.0 - (k + 0.07) / len(rows), title, fontsize=9)
    bar = figure.colorbar(colours, cax=figure.add_axes([0.96, 0.35 / len(rows), 0.008, 0.4 / len(rows)]))
    bar.set_label("distance, spacings", fontsize=8)
    bar.ax.tick_params(labelsize=7)
    drawn = io.BytesIO()
    figure.savefig(drawn, dpi=80)
    Image.open(drawn).convert("RGB").quantize(COLOURS, dither=Image.NONE).save(given["out"], optimize=True)


if __name__ == "__main__":
    main()
