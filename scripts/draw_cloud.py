#!/usr/bin/env python3
"""Draws clouds of points as shaded surfaces, side by side, into a PNG, for the demo, the documentation and users' own results. From the
command line:
  draw_cloud.py OUT.png REST.ply [DEFORMED.ply ...]     the colour is the distance from the first file's points
  draw_cloud.py OUT.png DEFORMED.ply ... --field error  the colour is a field of the files
  draw_cloud.py OUT.png FILTERED.pcd                    of `simulate --filtered`: the colour is the filter that removed a point"""
import argparse
import os
import sys

import numpy as np

sys.path.insert(0, os.path.dirname(os.path.realpath(__file__)))
import point_files  # noqa: E402

# To z up, by a rotation each.
UPRIGHT = {"x": [[0, 0, -1], [0, 1, 0], [1, 0, 0]], "-x": [[0, 0, 1], [0, 1, 0], [-1, 0, 0]],
           "y": [[1, 0, 0], [0, 0, -1], [0, 1, 0]], "-y": [[1, 0, 0], [0, 0, 1], [0, -1, 0]],
           "z": np.eye(3), "-z": [[1, 0, 0], [0, -1, 0], [0, 0, -1]]}
# What the values of the field removed_by stand for (io/cloud_filters.h), and how they are drawn.
FILTERS = [("stays", "#b9c6d2"), ("crop", "#5d6d7e"), ("range", "#8e7cc3"), ("flying pixels", "#e02020"), ("plane", "#f2c14e"),
           ("other side of the plane", "#a0662c"), ("outliers", "#c2188a")]
RIM_DEPTH = 0.35  # of the radius; small beside the relief of a surface, large enough to order neighbours


def look_along(azimuth, elevation):
    """The rows are the picture's right, up and towards-the-viewer directions, for a viewer at these angles (degrees; z is up)."""
    a, e = np.radians([azimuth, elevation])
    towards = np.array([np.cos(e) * np.cos(a), np.cos(e) * np.sin(a), np.sin(e)])
    right = np.array([-np.sin(a), np.cos(a), 0.0])
    return np.stack([right, np.cross(towards, right), towards])


def measure_spacing(points, samples=400):
    """A distance within which nearly every point has some neighbours, by brute force from a few points spread over the list."""
    finite = points[np.isfinite(points).all(axis=1)]
    chosen = finite[np.linspace(0, len(finite) - 1, min(samples, len(finite))).astype(int)]
    few = min(4, len(finite) - 1)
    return np.percentile([np.sqrt(np.partition(((finite - p) ** 2).sum(axis=1), few)[few]) for p in chosen], 90)


def blur(image, radius, rounds=2):
    """Box means, as often as rounds says, along both axes."""
    for _ in range(rounds):
        for axis in (0, 1):
            wide = np.pad(image, [(radius + 1, radius) if a == axis else (0, 0) for a in (0, 1)], mode="edge")
            total = np.cumsum(wide, axis=axis)
            first, width = np.arange(image.shape[axis]), 2 * radius + 1
            image = (np.take(total, first + width, axis) - np.take(total, first, axis)) / width
    return image


def render(points, values, low, high, view, center, extent, size, spacing, colors):
    """One surface, seen without perspective, as an image (size x size x 3). Each point is a small ball; the nearest one wins a
    pixel; the light falls on the smoothed depth picture, so that no normals are needed."""
    pixel = extent / size
    seen = (points - center) @ view.T
    keep = np.isfinite(seen).all(axis=1)
    seen, values = seen[keep], values[keep]
    column = np.floor(seen[:, 0] / pixel + size / 2).astype(int)
    row = np.floor(size / 2 - seen[:, 1] / pixel).astype(int)

    # The points that are the nearest in their own pixel, one for each pixel; the later index wins a tie.
    order = np.lexsort((seen[:, 2], column, row))
    first_of_next = np.flatnonzero((np.diff(row[order]) != 0) | (np.diff(column[order]) != 0))
    front = order[np.append(first_of_next, len(order) - 1)]

    depth, owner = np.full(size * size, -np.inf), np.full(size * size, -1)
    ball = min(max(1.5, spacing / pixel), size / 16)  # a few points far apart are still points
    reach = int(ball)
    for dy in range(-reach, reach + 1):
        for dx in range(-reach, reach + 1):
            if dx * dx + dy * dy > ball * ball:
                continue
            c, r = column[front] + dx, row[front] + dy
            inside = (c >= 0) & (c < size) & (r >= 0) & (r < size)
            target, index = (r * size + c)[inside], front[inside]
            # The rim of a ball lies behind its middle, so that a pixel goes to the point that is nearest to it in the picture.
            height = seen[index, 2] - RIM_DEPTH * pixel * (dx * dx + dy * dy) / ball
            nearer = height > depth[target]
            depth[target[nearer]] = height[nearer]
            owner[target[nearer]] = index[nearer]
    covered = owner >= 0
    image = np.ones((size * size, 3))
    if not covered.any():
        return image.reshape(size, size, 3)

    # Means over the covered pixels alone, so that the background does not bend the surface at the silhouette.
    surface = np.where(covered, depth, 0.0).reshape(size, size)
    weight = covered.reshape(size, size).astype(float)
    radius = max(1, int(round(0.6 * ball)))
    smooth = blur(surface, radius) / np.maximum(blur(weight, radius), 1e-9)
    slope_y, slope_x = np.gradient(np.where(weight > 0, smooth, np.nan), pixel)
    normal = np.stack([-np.nan_to_num(slope_x), np.nan_to_num(slope_y), np.ones_like(slope_x)], axis=-1)
    normal /= np.linalg.norm(normal, axis=-1, keepdims=True)
    key, fill = np.array([-0.45, 0.65, 0.62]), np.array([0.8, 0.1, 0.6])
    light = 0.30  # ambient
    for strength, lamp in ((0.62, key), (0.18, fill)):
        light = light + strength * np.clip(normal @ (lamp / np.linalg.norm(lamp)), 0, 1)
    # Hollows are darker than what stands out: the depth against its own surroundings.
    around = blur(surface, 4 * radius) / np.maximum(blur(weight, 4 * radius), 1e-9)
    light *= np.clip(1.0 + 6.0 * (smooth - around) / extent, 0.7, 1.15)

    share = np.clip((values[owner[covered]] - low) / max(high - low, 1e-12), 0, 1)
    image[covered] = np.clip(colors(share)[:, :3] * light.reshape(-1)[covered, None], 0, 1)
    return image.reshape(size, size, 3)


def frame_all(points, azimuth, elevation):
    """For render(): the view from these angles, its middle and how much it shows, so that all points are in the picture."""
    view = look_along(azimuth, elevation)
    seen = points[np.isfinite(points).all(axis=1)] @ view.T
    low, high = seen.min(axis=0), seen.max(axis=0)
    return view, view.T @ (0.5 * (low + high)), 1.08 * max(high[:2] - low[:2])


def show_image(axis, image, title):
    size = len(image) // 2
    axis.imshow(image.reshape(size, 2, size, 2, 3).mean(axis=(1, 3)), interpolation="lanczos")  # 2 x 2 samples smooth the edges
    axis.set_title(title, fontsize=15)
    axis.axis("off")


def save(figure, path):
    from matplotlib import pyplot
    temporary = path + ".part.png"
    figure.savefig(temporary, dpi=100)
    pyplot.close(figure)
    os.replace(temporary, path)


def draw_filtered(path, points, removed_by, title, azimuth=-60.0, elevation=15.0, size=700):
    """Writes a picture of what filters have taken of points (n x 3): all of them in the colour of their filter, removed_by (n), and
    beside them those that stay."""
    import matplotlib
    matplotlib.use("Agg")
    from matplotlib import pyplot
    from matplotlib.colors import ListedColormap, to_rgb
    from matplotlib.patches import Patch

    colors = np.array([to_rgb(color) for _, color in FILTERS])
    finite = np.isfinite(points).all(axis=1)
    view, center, extent = frame_all(points, azimuth, elevation)
    spacing = measure_spacing(points)
    figure, axes = pyplot.subplots(1, 2, figsize=(11.2, 6.3))
    for axis, shown, name in ((axes[0], finite, title), (axes[1], finite & (removed_by == 0), "what stays")):
        image = np.ones((2 * size, 2 * size, 3))
        if shown.any():
            image = render(points[shown], removed_by[shown].astype(float), 0.0, len(FILTERS) - 1.0, view, center, extent, 2 * size,
                           spacing, ListedColormap(colors, N=len(colors)))
        show_image(axis, image, name)
    figure.subplots_adjust(left=0.01, right=0.99, top=0.93, bottom=0.12, wspace=0.02)
    counts = [np.count_nonzero(finite & (removed_by == value)) for value in range(len(FILTERS))]
    figure.legend(handles=[Patch(color=color, label="%s: %d" % (name, count)) for (name, color), count in zip(FILTERS, counts)
                           if count > 0 or name == "stays"], loc="lower center", ncol=4, fontsize=12, frameon=False)
    save(figure, path)


def draw(path, surfaces, titles, caption="", azimuth=-60.0, elevation=15.0, size=700, what="displacement from rest"):
    """Writes the picture. `surfaces` is a list of pairs (points (n x 3) in m, values (n) in m, such as the displacement), all in one
    scale and seen from the same side; the colour bar runs from zero to the largest finite value of all."""
    import matplotlib
    matplotlib.use("Agg")
    from matplotlib import pyplot
    from matplotlib.colors import LinearSegmentedColormap

    colors = LinearSegmentedColormap.from_list("displacement", ["#c9d1da", "#f2c14e", "#e4572e", "#8f1d4f"])
    view, center, extent = frame_all(np.concatenate([points for points, _ in surfaces]), azimuth, elevation)
    spacing = measure_spacing(surfaces[0][0])
    extent += 2 * spacing  # points are balls
    largest = max(np.max(values, where=np.isfinite(values), initial=0.0) for _, values in surfaces)

    figure, axes = pyplot.subplots(1, len(surfaces), figsize=(5.6 * len(surfaces), 6.3), squeeze=False)
    for axis, (points, values), title in zip(axes[0], surfaces, titles):
        image = render(points, values, 0.0, largest, view, center, extent, 2 * size, spacing, colors)
        show_image(axis, image, title)
    figure.subplots_adjust(left=0.01, right=0.99, top=0.93, bottom=0.17, wspace=0.02)
    if largest > 0:
        bar = figure.add_axes([0.25, 0.11, 0.5, 0.022])
        scale = pyplot.cm.ScalarMappable(pyplot.Normalize(0, 1000 * largest), colors)
        figure.colorbar(scale, cax=bar, orientation="horizontal").set_label(what + " (mm)")
    figure.text(0.5, 0.005, caption, ha="center", fontsize=11)
    save(figure, path)


def read_field(path, name):
    """A column of a file, for its finite points."""
    points, _, columns = point_files.read_rows(path)
    if name not in columns:
        sys.exit("draw_cloud.py: %s has no field %s; accepted: %s" % (path, name, ", ".join(sorted(columns))))
    return columns[name].astype(float)[np.isfinite(points).all(axis=1)]


def main():
    parser = argparse.ArgumentParser(description="Draw clouds of points as shaded surfaces, side by side.")
    parser.add_argument("picture", help="the PNG to write")
    parser.add_argument("clouds", nargs="+", help=".ply, .pcd, .obj, .off or .xyz, the rest shape first; or one of simulate --filtered")
    parser.add_argument("--up", choices=sorted(UPRIGHT), default="z", help="the axis that points up; of a camera's clouds: -y")
    parser.add_argument("--azimuth", type=float, default=-60.0, help="where the viewer stands, degrees about z from x")
    parser.add_argument("--elevation", type=float, default=15.0, help="how high the viewer stands, degrees")
    parser.add_argument("--field", help="the colour: a field of every file, in m, such as error; else the distance from the first file")
    arguments = parser.parse_args()
    try:
        first, _, columns = point_files.read_rows(arguments.clouds[0])
        clouds = [point_files.read_points(path) for path in arguments.clouds]
    except (OSError, ValueError) as error:
        sys.exit("draw_cloud.py: %s" % error)
    upright = np.array(UPRIGHT[arguments.up], float).T
    if len(clouds) == 1 and "removed_by" in columns:
        removed_by = columns["removed_by"].astype(int)
        if not (removed_by < len(FILTERS)).all():
            sys.exit("draw_cloud.py: %s: removed_by %d; accepted: 0 to %d" % (arguments.clouds[0], removed_by.max(), len(FILTERS) - 1))
        draw_filtered(arguments.picture, first @ upright, removed_by, os.path.basename(arguments.clouds[0]),
                      arguments.azimuth, arguments.elevation)
        return
    clouds = [cloud @ upright for cloud in clouds]
    for path, cloud in zip(arguments.clouds, clouds):
        if len(cloud) != len(clouds[0]):
            sys.exit("draw_cloud.py: %s has %d finite points, the first file has %d" % (path, len(cloud), len(clouds[0])))
    if arguments.field:
        values = [read_field(path, arguments.field) for path in arguments.clouds]
    else:
        values = [np.linalg.norm(cloud - clouds[0], axis=1) for cloud in clouds]
    draw(arguments.picture, list(zip(clouds, values)), [os.path.basename(path) for path in arguments.clouds],
         azimuth=arguments.azimuth, elevation=arguments.elevation, what=arguments.field or "displacement from rest")


if __name__ == "__main__":
    main()
