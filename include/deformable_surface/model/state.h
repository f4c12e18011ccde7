// The state of the simulation points: positions, velocities, and further quantities of some models.
#pragma once

#include "deformable_surface/base/types.h"
#include "deformable_surface/contact/friction_anchors.h"

#include <algorithm>
#include <utility>
#include <vector>

namespace deformable_surface::model {

constexpr Index kNoParent = -1;

/// Further quantities of an oriented particle.
struct ParticleTraits {
  double temperature = 0.0;                   // K above ambient; weakens its bonds
  Index id = 0;                               // never used again: the initial particles are numbered by rank, later ones by birth
  Index ancestor = 0;                         // id of the initial particle that it descends from; its own if it is one
  Index parents[2] = {kNoParent, kNoParent};  // ids of the two between which it was added
  double turn = 0.0;                   // rad, about its normal, of its x axis from that of its orientation; no force reads it
  Vec3 rest_curvature = Vec3::Zero();  // 1/m: xx, yy, xy in the orientation's frame, to which it is bent at rest
  bool is_smooth = true;               // false: no force that keeps the surface flat acts on or from it (a crease)
};

/// Everything that a snapshot must hold of the simulation points. World frame.
struct State {
  Points positions;                                  // (n x 3) m
  Points velocities;                                 // (n x 3) m/s
  std::vector<contact::BodyAnchor> friction{};       // ascending by body, then point
  std::vector<contact::PairAnchor> self_friction{};  // ascending
  /// Within a step: tools (their numbers in ContactLoad) and points that came out from behind them, ascending.
  std::vector<std::pair<Index, Index>> escaped{};
  // For models whose points have orientations, else empty:
  Orientations orientations{};           // (n) unit, from the point's frame to the world: its z axis is the normal
  Points spins{};                        // (n x 3) angular velocity, rad/s
  std::vector<ParticleTraits> traits{};  // (n)
  Index next_id = 0;                     // of the particle that is born next
  // For solids that flow, else empty:
  std::vector<Mat3> plastic{};  // (n) F_p^-1, from where the surroundings of a point are at rest now to where they were at first
  double dissipated = 0.0;      // J, by plastic flow

  bool hasEscaped(Index tool, Index point) const {
    return std::binary_search(escaped.begin(), escaped.end(), std::pair(tool, point));
  }
  Index size() const { return static_cast<Index>(positions.size()); }
  /// The orientation of an oriented particle with its turn about the normal: the frame that shows the principal directions.
  Quaternion frame(Index i) const { return orientations[i] * Quaternion(Eigen::AngleAxisd(traits[i].turn, Vec3::UnitZ())); }
};

}  // namespace deformable_surface::model
