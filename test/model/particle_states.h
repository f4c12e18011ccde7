// States of oriented particles that the tests of the model share: random and flat.
#pragma once

#include "deformable_surface/model/oriented_particles/oriented_particles.h"
#include "model_checks.h"

namespace deformable_surface::test {

using model::MaterialParams;
using model::OrientedParticles;
using model::OrientedParticlesParams;
using model::PairPotentials;
using model::ParticleMode;
using model::ParticleWeighting;

constexpr double kSpacing = 0.05;

inline MaterialParams thickSheet() {
  MaterialParams m;
  m.thickness = 0.04;  // so that bending and stretching stiffness are similar
  return m;
}

inline OrientedParticlesParams allTerms(ParticleWeighting weighting = ParticleWeighting::kIsotropic) {
  OrientedParticlesParams p;
  p.co_circularity = 0.7;
  p.weighting = weighting;
  return p;
}

inline OrientedParticles makeModel(Index n, const OrientedParticlesParams& params,
                                   const MaterialParams& material = thickSheet()) {
  return OrientedParticles(Points(n, Vec3::Zero()), Points(n, Vec3::UnitZ()), kSpacing, material, params);
}

inline Quaternion randomTurn(std::mt19937& generator) {
  return Quaternion(uniform(generator), uniform(generator), uniform(generator), uniform(generator)).normalized();
}

inline Quaternion turnBy(const Vec3& angle, const Quaternion& q) {
  const double size = angle.norm();
  return size > 0.0 ? Quaternion(Eigen::AngleAxisd(size, angle / size) * q) : q;
}

inline State emptyState(Index n) {
  State s;
  s.positions.assign(n, Vec3::Zero());
  s.velocities = s.spins = s.positions;
  s.orientations.assign(n, Quaternion::Identity());
  s.traits.resize(n);
  for (Index i = 0; i < n; ++i) s.traits[i].id = i;
  return s;
}

/// Particles in a box of two spacings, no two nearer than 0.7 spacings, with any orientations.
inline State randomState(Index n, unsigned seed, bool in_plane = false) {
  std::mt19937 generator(seed);
  State s = emptyState(n);
  for (Index i = 0; i < n; ++i) {
    bool is_free = false;
    while (!is_free) {
      s.positions[i] = 1.2 * kSpacing * randomVector(generator) * (in_plane ? 2.0 : 1.0);
      if (in_plane) s.positions[i].y() = 0.0;
      is_free = true;
      for (Index j = 0; j < i; ++j) is_free = is_free && (s.positions[i] - s.positions[j]).norm() > 0.7 * kSpacing;
    }
    s.orientations[i] = in_plane ? Quaternion(Eigen::AngleAxisd(3.0 * uniform(generator), Vec3::UnitY())) : randomTurn(generator);
  }
  return s;
}

/// A hexagonal patch of rows x columns particles in z = 0, spacing as given.
inline State hexagonalPatch(Index rows, Index columns, double spacing = kSpacing) {
  State s = emptyState(rows * columns);
  for (Index i = 0; i < rows; ++i)
    for (Index j = 0; j < columns; ++j)
      s.positions[i * columns + j] = spacing * Vec3(j + 0.5 * (i % 2), 0.5 * std::sqrt(3.0) * i, 0.0);
  return s;
}

/// On a cylinder of the curvature (1/m) about the y axis turned by angle about z, arc lengths kept.
inline void rollUp(double curvature, double angle, Vec3& p, Quaternion& q) {
  const Quaternion turn(Eigen::AngleAxisd(angle, Vec3::UnitZ()));
  const Vec3 flat = turn.conjugate() * p;
  const double a = curvature * flat.x();
  const double x = a == 0.0 ? flat.x() : std::sin(a) / curvature, z = a == 0.0 ? 0.0 : (std::cos(a) - 1.0) / curvature;
  p = turn * Vec3(x, flat.y(), z);
  q = turn * Quaternion(Eigen::AngleAxisd(a, Vec3::UnitY())) * turn.conjugate();
}

inline void evaluate(const OrientedParticles& model, const State& state, Points& forces, Points& torques) {
  forces.assign(state.size(), Vec3::Zero());
  torques.assign(state.size(), Vec3::Zero());
  model.addForcesAndTorques(state, forces, torques);
}

}  // namespace deformable_surface::test
