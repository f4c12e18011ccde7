// Two oriented particles, packed as the loops over pairs read them. The tests of pair forces and of their stiffness share them.
#pragma once

#include "deformable_surface/model/oriented_particles/lattice.h"
#include "deformable_surface/model/oriented_particles/pair_forces.h"

#include <gtest/gtest.h>

namespace deformable_surface::test {

/// places, normals: (2) each, in m and unit.
struct TwoParticles {
  Points places, normals;
  double strength = 1.0;  // of bonds, 0: melted

  model::PackedParticles pack() const {
    model::PackedParticles packed;
    for (int i = 0; i < 2; ++i) {
      packed.places.insert(packed.places.end(), {places[i].x(), places[i].y(), places[i].z(), strength});
      packed.normals.insert(packed.normals.end(), {normals[i].x(), normals[i].y(), normals[i].z(), 1.0});
    }
    return packed;
  }
  double energy(const model::PairPotentials& pair) const {
    model::NeighborList lists(pair.cutoff, 0.1 * pair.cutoff);
    EXPECT_TRUE(lists.update(places));
    return model::gatherEnergy(pair, lists, pack(), 0, 2);
  }
  TwoParticles moved(int particle, const Vec3& by) const {
    TwoParticles there = *this;
    there.places[particle] += by;
    return there;
  }
  TwoParticles turned(int particle, const Vec3& by) const {
    TwoParticles there = *this;
    there.normals[particle] = Eigen::AngleAxisd(by.norm(), by.normalized()) * normals[particle];
    return there;
  }
};

/// With all terms; anisotropic as well.
inline model::PairPotentials makePair(bool is_anisotropic) {
  model::MaterialParams material;
  material.young_modulus = 1e4;
  material.thickness = 0.01;
  model::OrientedParticlesParams params;
  params.co_circularity = 0.5;
  if (is_anisotropic) params.weighting = model::ParticleWeighting::kAnisotropic;
  return model::calibrateLattice(0.1, material, params).pair;
}

/// Near each other, neither parallel nor in one plane.
inline TwoParticles askew() {
  return {{Vec3(0.0, 0.0, 0.0), Vec3(0.09, 0.03, 0.02)}, {Vec3(0.1, -0.2, 1.0).normalized(), Vec3(-0.3, 0.1, 1.0).normalized()}};
}

}  // namespace deformable_surface::test
