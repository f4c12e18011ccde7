#!/usr/bin/env python3
"""Runs scenes/particles_torus.yaml with other numbers of particles, balls and jitters, and counts what comes out by an alpha
complex, which shares no code with the triangles and the growth of the particles, of balls of 1 to 1.2 spacings. Prints a table;
status 1 if any run does not end as one torus.
  check_topology.py SIMULATE [--points N ...] [--balls R ...] [--jitters J ...] [--seeds S ...] [--rigidity D]
                    [--set KEY=VALUE ...] [--keep FOLDER]
Balls: radii in radii of the sphere. SIMULATE: the program, e.g. .ws/devel/lib/deformable_surface/simulate"""
import argparse
import itertools
import math
import os
import re
import resource
import subprocess
import sys
import tempfile

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components
from scipy.spatial import Delaunay

SCENE = os.path.join(os.path.dirname(os.path.realpath(__file__)), "..", "scenes", "particles_torus.yaml")
SPHERE = 0.5  # m, its radius in the scene
START_GAP = 0.05  # m, between ball and sphere at the start
STIFFNESS = 100.0  # N/m, E h in the scene
PUSH = 2.0  # s, from the start until the balls touch, as in the scene
# In spacings: balls of this radius around the particles cover the place of a missing one (1, and 1.2 where the surface is drawn
# out), which is no change of topology. The hole for a tool must be wider, which is little wider behind narrow tools.
ALPHAS = (1.0, 1.1, 1.2)
TORUS = (1, 2, 1)
LONGEST = 60  # s of processor time for a run: a surface that flies apart grows without end


def squared_radii(points, simplices):
    """Centres and squared radii of the smallest spheres through the corners of simplices (m x k)."""
    first = points[simplices[:, 0]]
    sides = points[simplices[:, 1:]] - first[:, None]
    gram = np.einsum("mia,mja->mij", sides, sides)
    # Of flat simplices the radius is infinite in any case.
    gram += 1e-13 * np.trace(gram, axis1=1, axis2=2)[:, None, None] * np.eye(gram.shape[1])
    weights = np.linalg.solve(gram, 0.5 * np.einsum("mii->mi", gram)[:, :, None])[:, :, 0]
    offset = np.einsum("mi,mia->ma", weights, sides)
    return first + offset, np.einsum("ma,ma->m", offset, offset)


def betti_numbers(points, radius):
    """Pieces, tunnels and voids of the union of balls around points (n x 3): the homology of its alpha complex."""
    cells = np.sort(Delaunay(points).simplices, axis=1)
    kinds = {4: cells}
    values = {4: squared_radii(points, cells)[1]}
    for corners in (3, 2):
        # The faces of the simplices above, each once, and the least value that these pass on.
        above, above_value = kinds[corners + 1], values[corners + 1]
        faces, opposite = [], []
        for left_out in range(corners + 1):
            faces.append(np.delete(above, left_out, axis=1))
            opposite.append(above[:, left_out])
        faces, opposite = np.concatenate(faces), np.concatenate(opposite)
        unique, inverse = np.unique(faces, axis=0, return_inverse=True)
        inverse = inverse.ravel()
        centre, own = squared_radii(points, unique)
        inside = np.sum((points[opposite] - centre[inverse]) ** 2, axis=1) < own[inverse] * (1 - 1e-12)
        passed_on = np.full(len(unique), np.inf)
        np.minimum.at(passed_on, inverse, np.tile(above_value, corners + 1))
        has_inside = np.zeros(len(unique), bool)
        np.logical_or.at(has_inside, inverse, inside)
        kinds[corners], values[corners] = unique, np.where(has_inside, passed_on, np.minimum(own, passed_on))
        if corners == 3:
            face_of_cell = inverse
    limit = radius * radius
    is_in = {k: values[k] <= limit for k in values}
    chi = len(points) - is_in[2].sum() + is_in[3].sum() - is_in[4].sum()
    edges = kinds[2][is_in[2]]
    pieces = connected_components(coo_matrix((np.ones(len(edges)), (edges[:, 0], edges[:, 1])), (len(points),) * 2), False)[0]
    # Voids: what is left of space, cells joined across faces that are left; the outside is one more cell.
    m = len(cells)
    cell = np.tile(np.arange(m), 4)
    order = np.argsort(face_of_cell, kind="stable")
    face, cell = face_of_cell[order], cell[order]
    is_pair = np.flatnonzero(face[1:] == face[:-1])
    links = [(cell[k], cell[k + 1]) for k in is_pair if not is_in[3][face[k]]]
    is_alone = np.ones(len(face), bool)
    is_alone[is_pair] = is_alone[is_pair + 1] = False
    links += [(cell[k], m) for k in np.flatnonzero(is_alone) if not is_in[3][face[k]]]
    left = np.append(~is_in[4], True)
    links = np.array([link for link in links if left[link[0]] and left[link[1]]]).reshape(-1, 2)
    graph = coo_matrix((np.ones(len(links)), (links[:, 0], links[:, 1])), (m + 1, m + 1))
    labels = connected_components(graph, False)[1]
    voids = len(np.unique(labels[left])) - 1
    return int(pieces), int(pieces + voids - chi), int(voids)


def read_points(path):
    """Positions of the particles, the corners of a .obj. Points of a jittered cloud are no particles: they follow several."""
    with open(path) as file:
        return np.array([[float(number) for number in line.split()[1:4]] for line in file if line.startswith("v ")])


def run(simulate, points, ball, jitter, seed, rigidity, more, final):
    radius = ball * SPHERE
    far, near = SPHERE + START_GAP + radius, radius
    squared_spacing = 2 / math.sqrt(3) * 4 * math.pi * SPHERE ** 2 / points
    settings = ["cloud.points=%d" % points, "cloud.jitter=%g" % jitter, "cloud.seed=%d" % seed,
                "material.bending_rigidity=%g" % (rigidity * STIFFNESS * squared_spacing)] + more
    for tool, sign in ((0, 1), (1, -1)):
        path = ", ".join("{time: %g, position: [0, 0, %g]}" % (time, sign * at) for time, at in ((0, far), (PUSH, near)))
        settings += ["tools.%d.shape.sphere.radius=%g" % (tool, radius), "tools.%d.path=[%s]" % (tool, path)]
    command = [simulate, SCENE, "--mesh", final, "--threads", "1"]
    for setting in settings:
        command += ["--set", setting]
    for quantity in ("components", "boundary_loops", "euler_characteristic", "isolated"):
        command += ["--measure", quantity]
    done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, universal_newlines=True, check=False,
                          preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_CPU, (LONGEST, LONGEST)))
    return done.returncode, done.stdout


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("simulate")
    parser.add_argument("--points", type=int, nargs="+", default=[200, 300, 500, 800, 1200, 2000, 3000])
    parser.add_argument("--balls", type=float, nargs="+", default=[0.1, 0.2, 0.3, 0.4, 0.6])
    parser.add_argument("--jitters", type=float, nargs="+", default=[0.0, 0.3])
    parser.add_argument("--seeds", type=int, nargs="+", default=[1])
    parser.add_argument("--rigidity", type=float, default=0.06, help="of bending, in E h a^2, a: the spacing (the scene: 0.14)")
    parser.add_argument("--set", action="append", default=[])
    parser.add_argument("--keep", help="folder for the final particles, .obj")
    options = parser.parse_args()
    temporary = tempfile.TemporaryDirectory()  # removed at the end
    folder = options.keep or temporary.name
    os.makedirs(folder, exist_ok=True)
    print("points  ball jitter seed | %-28s | the package's own count" % "pieces, tunnels, voids")
    wrong = total = 0
    for n, ball, jitter, seed in itertools.product(options.points, options.balls, options.jitters, options.seeds):
        final = os.path.join(folder, "%d_%g_%g_%d.obj" % (n, ball, jitter, seed))
        code, text = run(options.simulate, n, ball, jitter, seed, options.rigidity, options.set, final)
        total += 1
        found = None
        if code == 0:
            points = read_points(final)
            spacing = float(re.search(r"oriented particles ([-\d.e]+) m apart", text).group(1))
            counted = [betti_numbers(points, alpha * spacing) for alpha in ALPHAS]
            found = TORUS if TORUS in counted else counted[-1]
        is_right = found == TORUS
        wrong += not is_right
        own = ", ".join("%s %s" % pair for pair in re.findall(
            r"^measured (components|boundary_loops|euler_characteristic|isolated)\s*(-?[\d.e+]+)", text, re.M))
        result = found if code == 0 else "status %d" % code
        print("%6d %5.2f %6.2f %4d | %-20s %-7s | %s" % (n, ball, jitter, seed, result, "torus" if is_right else "-",
                                                        own if code == 0 else text.strip()[-300:]), flush=True)
    print("%d of %d are one torus" % (total - wrong, total))
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
