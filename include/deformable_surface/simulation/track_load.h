// The pull towards an observed cloud: where the surface was seen it is drawn there, where it was not, physics decides. A load of
// its own, because it keeps what of the surface was seen where.
#pragma once

#include "deformable_surface/simulation/observed_cloud.h"
#include "deformable_surface/solve/external_load.h"

#include <vector>

namespace deformable_surface::simulation {

/// Each simulation point that was seen is drawn to the plane of the cloud at the point nearest to it:
/// F = m g n n.(p - x) - 2 m sqrt(g) n n.v, with the gain g, 1/s^2, the plane's point p and normal n (point to plane [Chen and
/// Medioni 1992], critically damped). Along the plane nothing pulls: what a cloud does not show, where on the surface a point is,
/// is left to physics.
class TrackLoad : public solve::ExternalLoad {
 public:
  /// What a snapshot must hold: the points that were seen, ascending, and the planes that they are drawn to.
  struct Seen {
    Index point;
    Vec3 place, normal;  // m; unit
  };

  TrackLoad(const std::vector<double>& masses, double gain) : masses_(masses), gain_(gain) {}

  /// From now on towards this cloud, instead of the one before. A point was seen if a point of the cloud lies within reach (m)
  /// whose plane is not turned by more than sixty degrees from the surface, and not farther aside than the cloud's points are
  /// apart: in a hole, or behind what stands before it, it was not. normals (m x 3): of the surface, unit or zero. O(m log n).
  void observe(const ObservedCloud& cloud, const model::State& state, const Points& normals, double reach);
  void restore(const std::vector<Seen>& seen) { seen_ = seen; }
  const std::vector<Seen>& seen() const { return seen_; }
  bool isEmpty() const { return seen_.empty(); }

  /// Root of the mean square distance from the planes, m; NaN if nothing was seen.
  double residual(const model::State& state) const;

  void addForces(double time, const model::State& state, Points& forces) const override;
  double storedEnergy(double time, const model::State& state) const override;
  /// The potential's loss, at least: damping only takes.
  double estimateWork(double from, double to, const model::State& before, const model::State& after) const override;
  void addStiffness(double time, const model::State& state, double step, BlockSparse& stiffness) const override;
  void addRowBounds(double time, const model::State& state, std::vector<double>& stiffness,
                    std::vector<double>& damping) const override;

 private:
  const std::vector<double>& masses_;
  double gain_;  // 1/s^2
  std::vector<Seen> seen_;
};

}  // namespace deformable_surface::simulation
