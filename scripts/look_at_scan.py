#!/usr/bin/env python3
"""Examines a scan before anything is built or started: whether it is a surface, which way is up, whether a camera took it, and how the
demo puts it upright. It needs no ROS, because the demo runs it before the build. On the command line it prints the result, or in one
sentence why the scan is refused: look_at_scan.py FILE [UP [HEIGHT]]"""
import os
import re
import sys

import numpy as np

sys.path.insert(0, os.path.dirname(os.path.realpath(__file__)))
import point_files  # noqa: E402

# To z up, by a rotation each: a mirrored scan would not be the thing that was scanned.
UPRIGHT = {"x": [[0, 0, -1], [0, 1, 0], [1, 0, 0]], "-x": [[0, 0, 1], [0, 1, 0], [-1, 0, 0]],
           "y": [[1, 0, 0], [0, 0, -1], [0, 1, 0]], "-y": [[1, 0, 0], [0, 0, 1], [0, -1, 0]],
           "z": [[1, 0, 0], [0, 1, 0], [0, 0, 1]], "-z": [[1, 0, 0], [0, -1, 0], [0, 0, -1]]}

FEWEST = 20          # points: fewer span nothing worth pulling
FLAT = 0.1           # of the largest extent: what is lower along z lies down
LINE = 0.01          # of the longest axis of the spread: what is no wider is a line
ROD = 0.2            # the same: what is no wider, and shows no surface from near, is one for the simulation
NO_SURFACE = 0.3     # of the width of a neighbourhood: one so thick is no piece of a surface
NEIGHBORS = 16
SAMPLES = 100        # neighbourhoods that are looked at
CELL = 3.0           # spacings: parts that are apart by more are parts
MOST_LINES = 8192    # rows or columns of pixels
LINE_GAP = 0.25      # of their spacing if there were so many: values nearer than that are of one line
OFF_LINE = 0.1       # of the spacing: tolerance
MOST_SPARSE = 4      # pixels per point
HELD = 0.1           # of the height, from below, is what the demo holds
FEWEST_HELD = 0.1    # of the points of the part, at least


class Scan:
    """A scan and how it stands: rows (n x 3, in the file's frame, NaN where the camera saw nothing) become `scale` * rows there,
    and turned by `rotation` and moved by `offset` (m) they stand in the world with z up."""

    def __init__(self, path, up="auto", height=0.3):
        if up != "auto" and up not in UPRIGHT:
            raise ValueError("up is '%s'; accepted: auto, %s" % (up, ", ".join(sorted(UPRIGHT))))
        if not height > 0:
            raise ValueError("height is %s; accepted: a positive number of metres" % height)
        self.path = path
        self.rows, self.width, self.height = restore_grid(*read_grid(path))
        is_seen = np.isfinite(self.rows).all(axis=1)
        points = self.rows[is_seen]
        refuse_what_is_no_surface(path, points)
        self.is_camera = is_camera(self.rows, self.width, self.height)
        self.notices = [describe(path, points, self)]

        parts = find_parts(points)
        sizes = np.bincount(parts)
        largest = points[parts == sizes.argmax()]
        self.up, why = (up, "as given") if up != "auto" else choose_up(largest, self.is_camera)
        self.rotation = np.array(UPRIGHT[self.up], float)
        self.notices.append("up is %s (%s); change it with up:=AXIS" % (self.up, why))
        if len(sizes) > 1:
            self.notices.append("%d parts; the largest, of %d points, stands on the ground and is held" % (len(sizes), sizes.max()))

        upright = largest @ self.rotation.T
        low, high = upright.min(axis=0), upright.max(axis=0)
        if not high[2] - low[2] > 1e-6 * (high - low).max():
            raise ValueError("%s: all points have one %s coordinate; accepted: an axis along which the scan extends as up" %
                             (path, self.up))
        self.scale = height / (high[2] - low[2])
        # What is held reaches up to HELD of the height; where few points are so low, the scan stands that much deeper.
        cut = max(low[2] + HELD * (high[2] - low[2]), np.quantile(upright[:, 2], FEWEST_HELD))
        middle = 0.5 * (low + high)
        self.offset = np.array([0.0, 0.0, HELD * height]) - self.scale * np.array([middle[0], middle[1], cut])
        self.notices.append("scaled to a height of %.3g m (1 unit of the file is %.3g m); the lowest %.3g m are held" %
                            (height, self.scale, self.scale * (cut - low[2])))

    def place(self):
        """The rows as they stand in the world (n x 3), m."""
        return self.scale * self.rows @ self.rotation.T + self.offset


def to_quaternion(rotation):
    """x, y, z, w of a rotation matrix: the eigenvector of a symmetric matrix, whatever the angle."""
    r = rotation
    k = np.array([[r[0, 0] - r[1, 1] - r[2, 2], r[0, 1] + r[1, 0], r[0, 2] + r[2, 0], r[2, 1] - r[1, 2]],
                  [r[0, 1] + r[1, 0], r[1, 1] - r[0, 0] - r[2, 2], r[1, 2] + r[2, 1], r[0, 2] - r[2, 0]],
                  [r[0, 2] + r[2, 0], r[1, 2] + r[2, 1], r[2, 2] - r[0, 0] - r[1, 1], r[1, 0] - r[0, 1]],
                  [r[2, 1] - r[1, 2], r[0, 2] - r[2, 0], r[1, 0] - r[0, 1], r[0, 0] + r[1, 1] + r[2, 2]]])
    return np.linalg.eigh(k)[1][:, -1]


def read_grid(path):
    """The coordinates of all points (n x 3), and the grid's width and height; of a file without a grid n and 1. What filters have
    taken (`simulate --filtered` marks it) is NaN."""
    rows, _, columns = point_files.read_rows(path)
    if "removed_by" in columns:
        rows[columns["removed_by"] != 0] = np.nan
    if path.lower().endswith(".pcd"):
        with open(path, "rb") as stream:
            head = stream.read().split(b"DATA", 1)[0].decode("ascii", "replace")
        size = {name: int(value) for name, value in re.findall(r"(?m)^(WIDTH|HEIGHT)\s+(\d+)", head)}
        if size.get("WIDTH", 0) * size.get("HEIGHT", 0) == len(rows):
            return rows, size["WIDTH"], size["HEIGHT"]
    return rows, len(rows), 1


def find_lines(values):
    """The line (an integer from 0 on) that each value (n) is on, where all values lie on evenly spaced lines; else nothing."""
    ordered = np.sort(values)
    breaks = np.flatnonzero(np.diff(ordered) > LINE_GAP * (ordered[-1] - ordered[0]) / MOST_LINES)
    if not 2 <= len(breaks) < MOST_LINES:
        return None
    middles = 0.5 * (ordered[np.append(0, breaks + 1)] + ordered[np.append(breaks, len(ordered) - 1)])
    steps = np.diff(middles)
    last = np.round(steps / np.median(steps)).sum()  # from line to line, so that an error of the median does not add up
    if not 2 <= last < MOST_LINES:
        return None
    lines = (values - middles[0]) / ((middles[-1] - middles[0]) / last)
    return np.round(lines).astype(int) if (np.abs(lines - np.round(lines)) <= OFF_LINE).all() else None


def restore_grid(rows, width, height):
    """Of a list of points in a camera's frame: its pixels (n x 3, row after row, NaN where none is), width and height. Drivers and
    filters that drop missing pixels leave such lists; x / z has one value per column and y / z one per row. Else what came."""
    seen = rows[np.isfinite(rows).all(axis=1)]
    if height > 1 or len(seen) < FEWEST or not (seen[:, 2] > 0).all():
        return rows, width, height
    lines = [find_lines(seen[:, axis] / seen[:, 2]) for axis in (0, 1)]
    if any(line is None for line in lines):
        return rows, width, height
    size = [line.max() + 1 for line in lines]
    pixels = lines[1] * size[0] + lines[0]
    if size[0] * size[1] > MOST_SPARSE * len(seen) or len(np.unique(pixels)) < len(np.unique(seen, axis=0)):
        return rows, width, height
    grid = np.full((size[0] * size[1], 3), np.nan)
    grid[pixels] = seen
    return grid, size[0], size[1]


def refuse_what_is_no_surface(path, points):
    """Raises ValueError with a sentence."""
    distinct = np.unique(points, axis=0)
    if len(distinct) < FEWEST:
        raise ValueError("%s: found %d finite distinct points; accepted: at least %d" % (path, len(distinct), FEWEST))
    centred = distinct - distinct.mean(axis=0)
    spread = np.sqrt(np.maximum(np.linalg.eigvalsh(centred.T @ centred), 0.0))[::-1]
    width = spread[1] / spread[0]
    if width < LINE or (width < ROD and measure_thickness(distinct) > NO_SURFACE):
        raise ValueError("%s: found points along a line (their spread across it is %.2g of that along it), which show no surface; "
                         "accepted: points on a surface" % (path, width))


def measure_thickness(points):
    """How thick neighbourhoods are for their length, in the median: 0 on a surface, up to 1 in a cloud of dust."""
    thickness = []
    few = min(NEIGHBORS, len(points) - 1)
    for point in points[np.linspace(0, len(points) - 1, min(SAMPLES, len(points))).astype(int)]:
        near = points[np.argpartition(((points - point) ** 2).sum(axis=1), few)[:few + 1]]
        axes = np.linalg.svd(near - near.mean(axis=0), compute_uv=False)
        thickness.append(axes[2] / axes[0])
    return np.median(thickness)


def is_camera(rows, width, height):
    """Whether a camera at the origin that looks along z took them: pixels to the right lie to the right, those below lie below."""
    if width < 2 or height < 2:
        return False
    seen = np.flatnonzero(np.isfinite(rows).all(axis=1))
    if not (rows[seen, 2] > 0).all():
        return False
    rays = rows[seen, :2] / rows[seen, 2:]
    if not (rays.std(axis=0) > 0).all():
        return False
    pixels = np.stack([seen % width, seen // width], axis=1)
    return all(np.corrcoef(rays[:, k], pixels[:, k])[0, 1] > 0.9 for k in (0, 1))


def describe(path, points, scan):
    size = " of %d x %d pixels, %s" % (scan.width, scan.height, "a camera's frame" if scan.is_camera else "a grid that no camera "
                                       "at the origin took") if scan.height > 1 else ""
    return "%s: %d finite points%s" % (os.path.basename(path), len(points), size)


def choose_up(points, is_camera_frame):
    """An axis and why it is taken."""
    if is_camera_frame:
        return "-y", "a camera's y points down"
    extent = np.ptp(points, axis=0)
    if extent[2] >= FLAT * extent.max():
        return "z", "the usual axis"
    longest = "xyz"[extent.argmax()]
    return longest, "its longest axis: it lies flat along z"


def find_parts(points):
    """The number of the part (n) that each point is in: cells of a few spacings that touch are one part."""
    cells = np.floor((points - points.min(axis=0)) / (CELL * measure_spacing(points))).astype(np.int64) + 1
    span = cells.max(axis=0) + 2
    keys, cell_of = np.unique((cells[:, 0] * span[1] + cells[:, 1]) * span[2] + cells[:, 2], return_inverse=True)
    links = []
    for step in range(1, 14):  # half of the 26 cells around one
        move = np.array(np.unravel_index(13 + step, (3, 3, 3))) - 1
        wanted = keys + (move[0] * span[1] + move[1]) * span[2] + move[2]
        at = np.minimum(np.searchsorted(keys, wanted), len(keys) - 1)
        found = np.flatnonzero(keys[at] == wanted)
        links.append(np.stack([found, at[found]]))
    one, other = np.concatenate(links, axis=1)
    label = np.arange(len(keys))
    while True:  # each cell takes the least label around it, and then the label of that label
        before = label.copy()
        np.minimum.at(label, one, before[other])
        np.minimum.at(label, other, before[one])
        label = label[label]
        if (label == before).all():
            break
    return np.unique(label, return_inverse=True)[1][cell_of]


def measure_spacing(points):
    """A distance within which nearly every point has some neighbours, by brute force from a few points spread over the list."""
    chosen = points[np.linspace(0, len(points) - 1, min(SAMPLES, len(points))).astype(int)]
    few = min(4, len(points) - 1)
    spacing = np.percentile([np.sqrt(np.partition(((points - p) ** 2).sum(axis=1), few)[few]) for p in chosen], 90)
    # Coordinates of an int64 key: no more cells along an axis than that holds.
    return max(spacing, np.ptp(points, axis=0).max() / 1e5)


def main():
    if not 2 <= len(sys.argv) <= 4:
        sys.exit("usage: look_at_scan.py FILE [UP [HEIGHT]]")
    try:
        for sentence in Scan(sys.argv[1], *sys.argv[2:3], *(float(height) for height in sys.argv[3:])).notices:
            print("scan: %s" % sentence)
    except (OSError, ValueError) as error:
        sys.exit("scan refused: %s" % error)


if __name__ == "__main__":
    main()
