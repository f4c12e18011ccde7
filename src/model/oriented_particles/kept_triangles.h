// The strains of four triangles of kept bonds at once, and their slopes. Forces and the bounds of their stiffness share it.
#pragma once

#include "deformable_surface/base/simd.h"
#include "deformable_surface/model/oriented_particles/kept_bonds.h"

namespace deformable_surface::model {

/// Four triangles in a state; a: the edge from corner a to corner a + 1, or corner a. In the notation of KeptBonds, with l e and
/// l^2 c, in m, for e and c: no length divides anything.
struct DeformedTriangles {
  Double4 normal[3][3];
  Double4 r[3][3], u_first[3], u_last[3], inverse[3];  // r, n.r for the normals at both ends, 1 / |r| or 0
  Double4 e[3], c[3], s[3];
  Double4 held, smooth, shearing[3];  // factors of M and B; S
  Double4 by_e[3], by_c[3], by_s[3];  // slopes of the energy
};

DEFORMABLE_SURFACE_INLINE void takeLess(const Double4& a, Double4& b) { b = a < b ? a : b; }

DEFORMABLE_SURFACE_INLINE void loadCorner(const double* rows, const Index* corner, Double4& a, Double4& b, Double4& c,
                                          Double4& d) {
  load(rows + 4 * static_cast<std::ptrdiff_t>(corner[0]), a);
  load(rows + 4 * static_cast<std::ptrdiff_t>(corner[1]), b);
  load(rows + 4 * static_cast<std::ptrdiff_t>(corner[2]), c);
  load(rows + 4 * static_cast<std::ptrdiff_t>(corner[3]), d);
  transpose(a, b, c, d);
}

// factor K v of a symmetric matrix, stored as in FourTriangles.
DEFORMABLE_SURFACE_INLINE void multiply(const double (&k)[6][4], const Double4& factor, const Double4* v, Double4* product) {
  Double4 m[6];
  for (int a = 0; a < 6; ++a) load(k[a], m[a]);
  product[0] = factor * (m[0] * v[0] + m[5] * v[1] + m[4] * v[2]);
  product[1] = factor * (m[5] * v[0] + m[1] * v[1] + m[3] * v[2]);
  product[2] = factor * (m[4] * v[0] + m[3] * v[1] + m[2] * v[2]);
}

DEFORMABLE_SURFACE_INLINE void deform(const PackedParticles& particles, const PresentBonds::FourTriangles& t,
                                      DeformedTriangles& d) {
  Double4 place[3][3], strength[3], smooth[3];
  for (int a = 0; a < 3; ++a) {
    loadCorner(particles.places.data(), t.corner[a], place[a][0], place[a][1], place[a][2], strength[a]);
    loadCorner(particles.normals.data(), t.corner[a], d.normal[a][0], d.normal[a][1], d.normal[a][2], smooth[a]);
  }
  const Double4 zero = place[0][0] - place[0][0], one = zero + 1.0;
  d.held = strength[0];
  takeLess(strength[1], d.held);
  takeLess(strength[2], d.held);
  d.smooth = d.held * smooth[0] * smooth[1] * smooth[2];
  for (int a = 0; a < 3; ++a) {
    const int b = (a + 1) % 3;
    Double4 length, curve, height, squared = zero;
    load(t.length[a], length);
    load(t.curve[a], curve);
    load(t.height[a], height);
    load(t.shearing[a], d.shearing[a]);
    d.u_first[a] = d.u_last[a] = zero;
    for (int x = 0; x < 3; ++x) {
      d.r[a][x] = place[b][x] - place[a][x];
      squared += d.r[a][x] * d.r[a][x];
      d.u_first[a] += d.normal[a][x] * d.r[a][x];
      d.u_last[a] += d.normal[b][x] * d.r[a][x];
    }
    Double4 distance = squared;
    takeRoots(distance);
    d.inverse[a] = (distance > zero ? one : zero) / (distance > zero ? distance : one);
    d.e[a] = distance - length;
    d.c[a] = d.u_last[a] - d.u_first[a] - curve;
    d.s[a] = 0.5 * (d.u_first[a] + d.u_last[a]) - height;
    Double4 weaker = strength[a];
    takeLess(strength[b], weaker);
    d.shearing[a] *= weaker * smooth[a] * smooth[b];
    d.by_s[a] = d.shearing[a] * d.s[a];
  }
  multiply(t.stretching, d.held, d.e, d.by_e);
  multiply(t.bending, d.smooth, d.c, d.by_c);
}

}  // namespace deformable_surface::model
