// Arguments of growSurface() in the tests: orientations of normals, and the two relaxations between passes.
#pragma once

#include "deformable_surface/model/oriented_particles/grow_surface.h"
#include "deformable_surface/model/oriented_particles/relax_on_surface.h"

namespace deformable_surface::model {

inline Relaxation makeRelaxation(double spacing, Index sweeps) {
  return [=](Points& positions, Orientations& orientations, const std::vector<char>& fixed, std::vector<char>* awake) {
    relaxOnSurface(spacing, sweeps, fixed, positions, orientations, awake);
  };
}

inline void relaxNothing(Points&, Orientations&, const std::vector<char>&, std::vector<char>*) {}

/// Orientations with these normals.
inline Orientations orientTo(const Points& normals) {
  Orientations orientations;
  for (const Vec3& n : normals) orientations.push_back(Eigen::Quaterniond::FromTwoVectors(Vec3::UnitZ(), n));
  return orientations;
}

}  // namespace deformable_surface::model
