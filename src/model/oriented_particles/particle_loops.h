// The loops over the neighbours of a particle, and constants that the parts of the model share.
#pragma once

#include "deformable_surface/model/oriented_particles/oriented_particles.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

namespace deformable_surface::model {

namespace particles {

constexpr Index kBlock = 256;
constexpr double kSkin = 0.3;                // of the distance r0: a good trade between listing too much and listing too often
constexpr double kLinkLength = 1.3;          // of the spacing: between the first neighbours of a lattice and the second
constexpr double kTurn = 6.283185307179586;  // rad

inline Vec3 normalOf(const Quaternion& q) {
  const double x = q.x(), y = q.y(), z = q.z(), w = q.w();
  return {2.0 * (x * z + w * y), 2.0 * (y * z - w * x), 1.0 - 2.0 * (x * x + y * y)};
}

// The present bonds, with the links and triangles to show. All name particles by number, so they change together.
inline void updateBonds(const KeptBonds& kept, const std::vector<ParticleTraits>& traits, const ParticleCuts& cuts,
                        PresentBonds& present, std::vector<std::pair<Index, Index>>& links,
                        std::vector<WeightedTriangle>& triangles) {
  present.update(kept, traits, cuts);
  links.clear();
  for (const KeptBonds::Bond& bond : present.bonds()) links.emplace_back(std::min(bond.i, bond.j), std::max(bond.i, bond.j));
  triangles = present.triangles();
}

}  // namespace particles

// Calls take(j, d, c) for the particles to which i has no bond and that are nearer than c, m: than those of a lattice at rest, or
// than they were at rest if they were nearer or had one. They repel with the energy of ApartPotential.
template <class Take>
void OrientedParticles::forEachStranger(Index i, const Take& take) const {
  const Eigen::Map<const Vec3> p(packed_.place(i));
  const double most = lattice_.pair.distance;
  for (Index k = stranger_begins_[i]; k < stranger_begins_[i + 1]; ++k) {
    const Index j = strangers_[k];
    const double squared = (Eigen::Map<const Vec3>(packed_.place(j)) - p).squaredNorm();
    if (!(squared < most * most)) continue;
    const double d = std::sqrt(squared), c = std::min(most, bonds_.restDistance(i, j));
    if (d < c) take(j, d, c);
  }
}

template <class Take>
void OrientedParticles::forEachNear(Index i, double distance, const Take& take) const {
  const Eigen::Map<const Vec3> p(packed_.place(i));
  for (const Index* j = lists_.begin(i); j != lists_.end(i); ++j) {
    const double d = (Eigen::Map<const Vec3>(packed_.place(*j)) - p).norm();
    if (d < distance) take(*j, d);
  }
}

template <class Take>
void OrientedParticles::forEachParted(Index i, const Take& take) const {
  const Eigen::Map<const Vec3> p(packed_.place(i));
  for (const Index* j = lists_.beginParted(i); j != lists_.endParted(i); ++j)
    take((Eigen::Map<const Vec3>(packed_.place(*j)) - p).norm());
}

}  // namespace deformable_surface::model
