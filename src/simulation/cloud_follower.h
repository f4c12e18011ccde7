// How the points of the cloud follow the simulation points, for models whose rest surface has no transfer for that.
#pragma once

#include "deformable_surface/model/deformable_model.h"
#include "deformable_surface/simulation/simulation.h"

#include <vector>

namespace deformable_surface::simulation {

class CloudFollower {
 public:
  virtual ~CloudFollower() = default;
  /// The surface is at rest again.
  virtual void reset() {}
  /// The dense points at a state, m, and, if given, their normals: both overwritten.
  virtual void follow(const model::State& state, Points& dense, std::vector<Eigen::Vector3f>* normals) = 0;
  /// Whether normals may be found by covariance analysis of the dense points.
  virtual bool isSurface() const { return false; }
  /// For the last state that was followed: where the initial simulation points are.
  virtual const Points& firstPositions(const model::State& state) const { return state.positions; }
  /// (dense) 1: the point is removed; empty: none is.
  virtual const std::vector<char>& gone() const {
    static const std::vector<char> none;
    return none;
  }
  /// Appends rows for simulation points that were added since. first_input: (dense) the first input point of each.
  virtual void append(const model::State& /*state*/, const std::vector<Index>& /*first_input*/, bool /*with_normals*/,
                      Surface& /*surface*/) const {}
};

}  // namespace deformable_surface::simulation
