// Edits of single oriented particles, as data. Services fill it, the simulation carries it
// out.
#pragma once

#include "deformable_surface/base/types.h"

#include <vector>

namespace deformable_surface::simulation {

/// kCrease removes the forces that keep the surface flat there; kOrient turns particles, which ends their crease; kFix holds
/// position and orientation where they are, kFree releases both.
enum class ParticleAction { kAdd, kMove, kDelete, kCrease, kOrient, kFix, kFree };

struct ParticleEdit {
  ParticleAction action = ParticleAction::kAdd;
  std::vector<Index> ids;       // of particles, each once; none with kAdd
  Points positions{};           // m, one per particle: kAdd, kMove
  Orientations orientations{};  // unit, one per particle: kAdd, kOrient; z becomes the normal
};

}  // namespace deformable_surface::simulation
