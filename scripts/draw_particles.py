#!/usr/bin/env python3
"""Runs the scenes after the figures of [Szeliski and Tonnesen 1991] with `simulate` and draws each at some times into one picture, from the
markers for RViz: axes, discs, wireframe, shaded triangles. Makes docs/images/particles.png, with --cuts docs/images/particles_scalpel.png,
with --volume docs/images/particles_volume.png.
  draw_particles.py [--cuts | --volume] SIMULATE OUT.png [SCENES]      SIMULATE: the program, e.g. .ws/devel/lib/deformable_surface/simulate"""
import io
import os
import subprocess
import sys
import tempfile

import matplotlib
import numpy as np
import rosbag

matplotlib.use("Agg")
from matplotlib import pyplot  # noqa: E402
from matplotlib.collections import LineCollection, PolyCollection  # noqa: E402
from PIL import Image  # noqa: E402

SCENES = os.path.join(os.path.dirname(os.path.realpath(__file__)), "..", "scenes")
# Scene, title, frames per second, frames drawn (from 0; -1 the last) and how, elevation and azimuth of the viewer in degrees.
PANELS = [
    ("stretch", "Figure 4: axes, discs, wireframe, triangles", 10,
     ((-1, "axes"), (-1, "discs"), (-1, "wireframe"), (-1, "surface")), 35, -70),
    ("chain", "Figure 5: two chains link", 50, ((1, "chain"), (20, "chain"), (-1, "chain")), 0, -90),
    ("weld", "Figure 6: welding", 50, ((1, "discs"), (25, "discs"), (-1, "discs")), 60, -90),
    ("cut", "Figure 7: cutting", 50, ((0, "discs"), (40, "discs"), (-1, "discs")), 60, -90),
    ("crease", "Figure 8: a crease", 10, ((0, "surface"), (5, "surface"), (-1, "surface")), 15, 20),
    ("stretch", "Figure 9: stretching, particles are born (orange)", 10, ((0, "discs"), (15, "discs"), (-1, "discs")), 20, -70),
    ("grow", "Figure 10: samples (blue), grown through, triangles", 10, ((0, "samples"), (0, "discs"), (0, "surface")), 15, -70),
    ("fill", "Figure 11: gaps are filled up to a width", 100, ((1, "discs"), (3, "discs"), (-1, "discs")), 60, -90),
    ("drape", "Figure 12a: draping", 10, ((0, "surface"), (4, "surface"), (-1, "surface")), 20, -50),
    ("plastic", "Figure 12b: drawn out, let go", 10, ((0, "discs"), (10, "discs"), (-1, "discs")), 60, -90),
    ("bend", "Figure 12b: bent, let go: it stays bent", 10, ((5, "surface"), (20, "surface"), (-1, "surface")), 15, -70),
    ("tear", "Figure 12c: tearing", 10, ((1, "surface"), (12, "surface"), (-1, "surface")), 60, -90),
    ("stem", "Figure 13: a stem", 10, ((8, "surface"), (20, "surface"), (-1, "surface")), 12, -70),
    ("handle", "Figure 13: and a handle", 10, ((25, "surface"), (55, "surface"), (-1, "surface")), 12, -70),
    ("torus", "Figure 14: a sphere becomes a torus", 10, ((0, "surface"), (14, "surface"), (-1, "surface")), 50, -60),
    ("axes", "Figure 15: x axes (red) before and after the spin torque", 10, ((0, "frames"), (-1, "frames")), 55, -60),
]
# Beyond the paper; pictures of their own.
OWN_PANELS = {
    "--cuts": [("scalpel", "Two scalpels cut for good; a hand and tweezers open both cuts", 10,
                ((4, "surface"), (10, "surface"), (-1, "surface")), 45, -75)],
    "--volume": [("volume", "A seed is blown up in a volume", 10, ((0, "surface"), (3, "surface"), (6, "surface"), (-1, "surface")),
                  25, -60)],
}
GIVEN, BORN = np.array([0.45, 0.65, 0.85]), np.array([0.95, 0.6, 0.2])
AXIS_COLOURS = ((0.8, 0.1, 0.1), (0.1, 0.6, 0.1), (0.1, 0.2, 0.8))
COLOURS = 96  # of the picture: few enough for a small file
DISC = np.radians(np.arange(0, 360, 30))
LAMP = np.array([0.3, 0.5, 0.81])  # as the viewer sees it: right, up, towards the viewer


class Frame:
    """What a bag says of one time: positions (n x 3), axes (n x 3 x 3, one a row), who was born, edges and triangles as points."""

    def __init__(self, markers, cloud, first):
        lists = {marker.ns: np.array([(p.x, p.y, p.z) for p in marker.points]).reshape(-1, 3) for marker in markers.markers}
        lines = lists["axes"].reshape(-1, 3, 2, 3)
        self.positions = lines[:, 0, 0]
        self.axes = lines[:, :, 1] - lines[:, :, 0]
        self.edges = lists["wireframe"].reshape(-1, 2, 3)
        self.links = lists["stretch_springs"].reshape(-1, 2, 3)
        self.triangles = lists["surface"].reshape(-1, 3, 3)
        field = next(f for f in cloud.fields if f.name == "id")
        rows = np.frombuffer(cloud.data, np.uint8).reshape(-1, cloud.point_step)
        ids = rows[:, field.offset:field.offset + 4].copy().view(np.uint32)[:, 0]
        self.is_born = ids >= (len(ids) if first is None else first)


def run_scene(simulate, name, rate, folder, given):
    bag = os.path.join(folder, "out.bag")
    subprocess.run([simulate, os.path.join(SCENES, "particles_%s.yaml" % name), "--bag_out", bag, "--set",
                    "output.publish_rate=%d" % rate], check=True, stdout=subprocess.DEVNULL)
    markers, clouds = [], []
    with rosbag.Bag(bag) as messages:
        for topic, message, _ in messages.read_messages():
            if topic.endswith("/markers"):
                markers.append(message)
            if topic.endswith("/simulation_points"):
                clouds.append(message)
    first = given.get(name, clouds[0].width * clouds[0].height)
    return [Frame(m, c, first) for m, c in zip(markers, clouds)]


def look_along(elevation, azimuth):
    """The rows are the picture's right, up and towards-the-viewer directions; z is up."""
    e, a = np.radians([elevation, azimuth])
    towards = np.array([np.cos(e) * np.cos(a), np.cos(e) * np.sin(a), np.sin(e)])
    right = np.array([-np.sin(a), np.cos(a), 0.0])
    return np.stack([right, np.cross(towards, right), towards])


def measure_spacing(points):
    distances = np.linalg.norm(points[:, None] - points[None], axis=2)
    return np.median(np.partition(distances, 1, axis=1)[:, 1])


def add_lines(axis, lines, view, colour, width):
    axis.add_collection(LineCollection(lines @ view[:2].T, colors=[colour], linewidths=width))


def add_faces(axis, faces, normals, base, view, edge, width):
    """Faces (n x k x 3), the farthest first; the back is darker, so that holes and the inside of closed surfaces are seen."""
    light = view.T @ LAMP
    shade = (0.35 + 0.65 * np.abs(normals @ light)) * np.where(normals @ view[2] > 0.0, 1.0, 0.6)
    order = np.argsort(faces.mean(1) @ view[2])
    colours = np.clip(np.broadcast_to(base, normals.shape) * shade[:, None], 0, 1)
    axis.add_collection(PolyCollection((faces @ view[:2].T)[order], facecolors=colours[order], edgecolors=edge, linewidths=width))


def draw_discs(axis, frame, view, which):
    points, axes = frame.positions[which], frame.axes[which]
    radius = 0.5 * measure_spacing(frame.positions)
    units = axes / np.linalg.norm(axes, axis=2, keepdims=True)
    rims = points[:, None] + radius * (np.cos(DISC)[None, :, None] * units[:, None, 0] + np.sin(DISC)[None, :, None] * units[:, None, 1])
    add_faces(axis, rims, units[:, 2], np.where(frame.is_born[which][:, None], BORN, GIVEN), view, "0.25", 0.15)


def draw_surface(axis, frame, view):
    corners = frame.triangles
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-300)
    add_faces(axis, corners, normals, GIVEN, view, "0.3", 0.1)


def draw_axes(axis, frame, view):
    for k in range(3):
        add_lines(axis, np.stack([frame.positions, frame.positions + frame.axes[:, k]], axis=1), view, AXIS_COLOURS[k], 0.6)


def draw_directions(axis, frame, view):
    """The x axes both ways, so that those of neighbours nearly touch."""
    half = 1.1 * frame.axes[:, 0]
    add_lines(axis, np.stack([frame.positions - half, frame.positions + half], axis=1), view, AXIS_COLOURS[0], 0.6)


def draw(axis, frame, how, view):
    everyone = np.ones(len(frame.positions), bool)
    if how == "discs":
        draw_discs(axis, frame, view, everyone)
    elif how == "samples":
        draw_discs(axis, frame, view, ~frame.is_born)
    elif how == "surface":
        draw_surface(axis, frame, view)
    elif how == "axes":
        draw_axes(axis, frame, view)
    elif how == "frames":
        draw_surface(axis, frame, view)
        draw_directions(axis, frame, view)
    elif how == "wireframe":
        add_lines(axis, frame.edges, view, "0.2", 0.3)
    else:
        add_lines(axis, frame.links, view, "0.5", 0.8)
        flat = frame.positions @ view[:2].T
        axis.plot(flat[:, 0], flat[:, 1], ".", color=GIVEN * 0.8, markersize=3)
    return frame.positions @ view[:2].T


def main():
    global SCENES
    own = next((option for option in OWN_PANELS if option in sys.argv), None)
    if own:
        sys.argv.remove(own)
    panels = OWN_PANELS[own] if own else PANELS
    if len(sys.argv) not in (3, 4):
        sys.exit(__doc__)
    SCENES = sys.argv[3] if len(sys.argv) == 4 else SCENES
    columns = 1 if own else 2
    rows = (len(panels) + columns - 1) // columns
    figure = pyplot.figure(figsize=(13, (4.0 if own else 2.5) * rows))
    # Of a scene that begins grown, the samples that it was given.
    given = {"grow": 80}
    for k, (name, title, rate, chosen, elevation, azimuth) in enumerate(panels):
        view = look_along(elevation, azimuth)
        with tempfile.TemporaryDirectory() as folder:
            frames = run_scene(sys.argv[1], name, rate, folder, given)
        axes, drawn = [], []
        for c, (frame, how) in enumerate(chosen):
            left = (k % columns + (c + 0.02) / len(chosen)) / columns
            axis = figure.add_axes([left, 1.0 - (k // columns + 0.98) / rows, 0.96 / (len(chosen) * columns), 0.86 / rows])
            drawn.append(draw(axis, frames[frame], how, view))
            axes.append(axis)
        # All times of a scene on one scale, as large as its own room lets it be.
        everything = np.concatenate(drawn)
        low, high = everything.min(0), everything.max(0)
        middle, half = (low + high) / 2.0, 0.52 * (high - low)
        box = axes[0].get_position()
        shape = box.width * figure.get_figwidth() / (box.height * figure.get_figheight())
        half = max(half[0], half[1] * shape)
        for axis in axes:
            axis.set(xlim=(middle[0] - half, middle[0] + half), ylim=(middle[1] - half / shape, middle[1] + half / shape), aspect="equal")
            axis.axis("off")
        figure.text((k % columns + 0.02) / columns, 1.0 - (k // columns + 0.09) / rows, title, fontsize=11)
    drawn = io.BytesIO()
    figure.savefig(drawn, dpi=70)
    Image.open(drawn).convert("RGB").quantize(COLOURS, dither=Image.NONE).save(sys.argv[2], optimize=True)


if __name__ == "__main__":
    main()
