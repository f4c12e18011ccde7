// Patches of uneven triangles with kept bonds, which their tests share.
#pragma once

#include "particle_states.h"

namespace deformable_surface::test {

using model::WeightedTriangle;

inline MaterialParams thinSheet() {
  MaterialParams m;
  m.thickness = 0.1 * kSpacing;
  m.poisson_ratio = 0.2;
  return m;
}

/// A patch of uneven triangles; bend gives it a curvature, 1/m.
inline State unevenPatch(double bend = 0.0) {
  State s = hexagonalPatch(6, 7);
  std::mt19937 generator(4);
  for (Index i = 0; i < s.size(); ++i) {
    Vec3& p = s.positions[i];
    p += 0.2 * kSpacing * Vec3(uniform(generator), uniform(generator), 0.0);
    if (!(bend > 0.0)) continue;
    const double angle = bend * p.x();
    p.x() = std::sin(angle) / bend;
    p.z() = (std::cos(angle) - 1.0) / bend;
    s.orientations[i] = Quaternion(Eigen::AngleAxisd(angle, Vec3::UnitY()));
  }
  return s;
}

inline std::vector<WeightedTriangle> trianglesOfPatch() {
  std::vector<WeightedTriangle> all;
  for (Index i = 0; i < 5; ++i)
    for (Index j = 0; j < 6; ++j) {
      const Index a = 7 * i + j, b = a + 1, c = a + 7, d = c + 1;
      if (i % 2 == 0) {
        all.push_back({{a, b, c}, 1.0});
        all.push_back({{b, d, c}, 1.0});
      } else {
        all.push_back({{a, b, d}, 1.0});
        all.push_back({{a, d, c}, 1.0});
      }
    }
  return all;
}

inline double areaOf(const State& s) {
  double area = 0.0;
  for (const WeightedTriangle& t : trianglesOfPatch())
    area +=
        0.5 *
        (s.positions[t.corner[1]] - s.positions[t.corner[0]]).cross(s.positions[t.corner[2]] - s.positions[t.corner[0]]).norm();
  return area;
}

inline OrientedParticles makeKept(const State& rest, const MaterialParams& material = thinSheet()) {
  OrientedParticlesParams p;
  p.bonds = model::ParticleBonds::kKept;
  OrientedParticles particles = makeModel(rest.size(), p, material);
  particles.keepBonds(rest, trianglesOfPatch(), std::vector<double>(rest.size(), areaOf(rest) / rest.size()));
  return particles;
}

inline State shaken(State s, double amount, unsigned seed = 11) {
  std::mt19937 generator(seed);
  for (Index i = 0; i < s.size(); ++i) {
    s.positions[i] += amount * kSpacing * randomVector(generator);
    s.orientations[i] = turnBy(amount * randomVector(generator), s.orientations[i]);
  }
  return s;
}

}  // namespace deformable_surface::test
