#!/usr/bin/env python3
"""Writes a volume to guide particles to (docs/oriented_particles.md): the signed distance from a shape, negative inside, on a regular
grid around it, as a MetaImage file (.mha).
Usage: make_volume.py SHAPE OUT.mha [--samples N] [--noise METRES] [--type float|uchar] [--seed N]
       [--center X Y Z]
uchar: a picture as scanners give it, 128 on the surface, 255 inside and 0 outside within three samples."""
import argparse

import numpy as np

HALF = 0.6  # m: half of the edge of the grid


def sphere(x, y, z):
    return np.sqrt(x * x + y * y + z * z) - 0.4


def ellipsoid(x, y, z):
    """A third longer along x, a third shorter along z. To the first order a distance, as of no field with a formula."""
    a, b, c = 0.5, 0.375, 0.25
    k = np.sqrt((x / a)**2 + (y / b)**2 + (z / c)**2)
    slope = np.sqrt((x / a**2)**2 + (y / b**2)**2 + (z / c**2)**2)
    return np.where(slope > 0, k * (k - 1) / np.maximum(slope, 1e-12), -c)


def torus(x, y, z):
    return np.hypot(np.hypot(x, y) - 0.33, z) - 0.17


def two_balls(x, y, z):
    """Balls of unequal size that a neck connects."""
    one, other, k = np.sqrt((x + 0.22)**2 + y * y + z * z) - 0.28, np.sqrt((x - 0.3)**2 + y * y + z * z) - 0.2, 0.15
    h = np.clip(0.5 + 0.5 * (other - one) / k, 0, 1)
    return other * (1 - h) + one * h - k * h * (1 - h)


def cube(x, y, z):
    d = np.stack([np.abs(x), np.abs(y), np.abs(z)]) - 0.35
    return np.sqrt((np.maximum(d, 0)**2).sum(axis=0)) + np.minimum(d.max(axis=0), 0)


def arms(x, y, z):
    """A ball with six arms along the axes."""
    def rod(a, b, c):
        return np.sqrt(b * b + c * c + np.maximum(np.abs(a) - 0.42, 0)**2) - 0.11
    d = [np.sqrt(x * x + y * y + z * z) - 0.22, rod(x, y, z), rod(y, z, x), rod(z, x, y)]
    k = 25.0
    return -np.log(sum(np.exp(-k * e) for e in d)) / k


SHAPES = {f.__name__: f for f in (sphere, ellipsoid, torus, two_balls, cube, arms)}


def write(path, values, spacing, origin):
    """values (x, y, z); origin: place of the first, m."""
    name = {"float32": "MET_FLOAT", "uint8": "MET_UCHAR", "int16": "MET_SHORT"}[values.dtype.name]
    with open(path, "wb") as out:
        out.write(("ObjectType = Image\nNDims = 3\nBinaryData = True\nBinaryDataByteOrderMSB = False\nCompressedData = False\n"
                   "Offset = {} {} {}\nElementSpacing = {} {} {}\nDimSize = {} {} {}\nElementType = {}\n"
                   "ElementDataFile = LOCAL\n").format(*origin, *[spacing] * 3, *values.shape, name).encode())
        out.write(values.tobytes(order="F"))


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("shape", choices=sorted(SHAPES))
    parser.add_argument("out")
    parser.add_argument("--samples", type=int, default=48, help="along each axis")
    parser.add_argument("--noise", type=float, default=0.0, help="standard deviation, m")
    parser.add_argument("--type", choices=["float", "uchar"], default="float")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--center", type=float, nargs=3, default=[0.0, 0.0, 0.0], help="of the shape and its grid, m")
    given = parser.parse_args()
    spacing = 2 * HALF / (given.samples - 1)
    x = -HALF + spacing * np.arange(given.samples)
    values = SHAPES[given.shape](*np.meshgrid(x, x, x, indexing="ij"))
    values = values + given.noise * np.random.default_rng(given.seed).standard_normal(values.shape)
    if given.type == "uchar":
        values = np.clip(np.round(127.5 * (1 - values / (3 * spacing)) + 0.5), 0, 255).astype(np.uint8)
    write(given.out, values.astype(np.float32) if given.type == "float" else values, spacing,
          [c - HALF for c in given.center])


if __name__ == "__main__":
    main()
