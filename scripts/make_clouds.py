#!/usr/bin/env python3
"""Writes the clouds of scenes/clouds: outlines of our own, filled with points. Those without thickness and the bars are after the
figures of the paper on meshfree elasticity with point cloud geodesics. Can make them finer or with other gaps.
  make_clouds.py [FOLDER]      default: scenes/clouds beside this script. The same files every time."""
import math
import os
import sys

ROW = 0.5 * math.sqrt(3.0)  # height of a row of equilateral triangles over their side


def sample_outline(corners, spacing):
    """Points along a closed polygon: every corner, and between them as equally as the spacing allows."""
    points = []
    for (ax, ay), (bx, by) in zip(corners, corners[1:] + corners[:1]):
        count = max(1, round(math.hypot(bx - ax, by - ay) / spacing))
        points += [(ax + (bx - ax) * k / count, ay + (by - ay) * k / count) for k in range(count)]
    return points


def is_inside(x, y, corners):
    """Whether a ray from the point crosses the polygon an odd number of times."""
    inside = False
    for (ax, ay), (bx, by) in zip(corners, corners[1:] + corners[:1]):
        if (ay > y) != (by > y) and x < ax + (bx - ax) * (y - ay) / (by - ay):
            inside = not inside
    return inside


def fill(corners, spacing):
    """Points on the outline, and a hexagonal lattice inside that keeps two thirds of the spacing from it."""
    outline = sample_outline(corners, spacing)
    xs, ys = [p[0] for p in corners], [p[1] for p in corners]
    points = list(outline)
    for row in range(int((max(ys) - min(ys)) / (ROW * spacing)) + 1):
        y = min(ys) + ROW * spacing * row
        for column in range(int((max(xs) - min(xs)) / spacing) + 2):
            x = min(xs) + spacing * (column + 0.5 * (row % 2))
            if is_inside(x, y, corners) and min(math.hypot(x - p[0], y - p[1]) for p in outline) > 2.0 / 3.0 * spacing:
                points.append((x, y))
    return points


def mirror(right):
    """A closed outline from its right half, which begins and ends at x = 0 or beside it."""
    return right + [(-x, y) for x, y in reversed(right) if x > 0.0]


def make_trousers(spacing):
    """Trousers, a metre high, y upwards. The legs are 1.75 spacings apart from the crotch down."""
    slit = 0.5 * 1.75 * spacing
    return mirror([(0.0, 1.0), (0.19, 1.0), (0.2, 0.93), (0.21, 0.76), (0.2, 0.35), (0.19, 0.0), (slit, 0.0), (slit, 0.7), (0.0, 0.715)])


def distance_to(x, y, piece):
    """From a straight piece of an outline."""
    (ax, ay), (bx, by) = piece
    along = ((x - ax) * (bx - ax) + (y - ay) * (by - ay)) / ((bx - ax) ** 2 + (by - ay) ** 2)
    along = max(0.0, min(1.0, along))
    return math.hypot(x - ax - along * (bx - ax), y - ay - along * (by - ay))


def make_shirt(spacing, depth=0.05, width=0.12):
    """A shirt, 0.66 m high, y upwards. Front and back meet at the seams and are 2 depth apart from width on; open at hem, cuffs and
    neck. x, y, z."""
    right = [(0.0, 0.0), (0.25, 0.0), (0.24, 0.4), (0.37, 0.31), (0.43, 0.45), (0.22, 0.64), (0.1, 0.665), (0.05, 0.615), (0.0, 0.6)]
    pieces = list(zip(right, right[1:]))
    seams = pieces[1:3] + pieces[4:6]
    points = []
    for x, y in fill(mirror(right), spacing):
        distance = min(distance_to(abs(x), y, seam) for seam in seams)
        z = depth * math.sqrt(1.0 - (1.0 - min(distance, width) / width) ** 2)
        points += [(x, y, z), (x, y, -z)] if distance > 1e-9 else [(x, y, 0.0)]
    return points


def make_octopus(spacing):
    """A head and six arms that hang side by side, 1.75 spacings apart, y upwards: half a metre high."""
    slit, arm, longest = 1.75 * spacing, 0.04, 0.3
    right, left_edge = [], 0.5 * slit
    for k in range(3):
        length = longest - 0.02 * k
        right += [(left_edge, 0.0), (left_edge, -length), (left_edge + 0.5 * arm, -length - 0.3 * arm), (left_edge + arm, -length),
                  (left_edge + arm, 0.0)]
        left_edge += arm + slit
    width = left_edge - slit
    angles = [k * math.pi / 24 for k in range(1, 13)]
    head = [(width * math.cos(a), 0.03 + 0.2 * math.sin(a)) for a in angles]
    head[-1] = (0.0, 0.23)
    outline = right + [(width, 0.03)] + head  # from the slit in the middle to the crown
    return mirror(list(reversed(outline)))


def make_lattice_bars(spacing):
    """Two bars of five rows of a hexagonal lattice, a metre long, joined at the left; a row is missing between them. x and z."""
    bar, joint, points = 5, 0.1, []
    for row in range(-bar, bar + 1):
        is_short = row % 2
        for column in range(round(1.0 / spacing) + 1 - is_short):
            x = spacing * (column + 0.5 * is_short)
            if row != 0 or x < joint:
                points.append((x, ROW * spacing * row))
    return points


def make_block_bars(spacing):
    """The same in space, cubic: five by five points across each bar, which are 1.6 spacings apart. x, y, z."""
    side, columns, joined, points = 5, round(1.0 / spacing) + 1, 5, []
    for column in range(columns):
        for layer in range(side):
            for sign in (-1, 1):
                points += [(column * spacing, (layer - 2) * spacing, sign * (0.8 + row) * spacing) for row in range(side)]
            if column < joined:
                points.append((column * spacing, (layer - 2) * spacing, 0.0))
    return points


def write(folder, name, what, points):
    with open(os.path.join(folder, name + ".xyz"), "w") as out:
        out.write("# %s; written by scripts/make_clouds.py\n" % what)
        for p in points:
            out.write(" ".join("%.5g" % (v + 0.0) for v in p) + "\n")


def main():
    folder = sys.argv[1] if len(sys.argv) > 1 else os.path.join(os.path.dirname(os.path.realpath(__file__)), "..", "scenes", "clouds")
    os.makedirs(folder, exist_ok=True)
    write(folder, "trousers", "trousers in the plane z = 0", [p + (0.0,) for p in fill(make_trousers(0.02), 0.02)])
    write(folder, "shirt", "a shirt", make_shirt(0.02))
    write(folder, "octopus", "an octopus in the plane z = 0", [p + (0.0,) for p in fill(make_octopus(0.012), 0.012)])
    write(folder, "two_bars_lattice", "two bars in the plane y = 0", [(x, 0.0, z) for x, z in make_lattice_bars(0.02)])
    write(folder, "two_bars_block", "two bars that fill space", make_block_bars(0.025))


if __name__ == "__main__":
    main()
