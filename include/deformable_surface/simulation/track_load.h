// Draws the surface towards an observed cloud where it was seen; elsewhere physics decides. The load remembers which points were
// seen where.
#pragma once

#include "deformable_surface/simulation/observed_cloud.h"
#include "deformable_surface/solve/external_load.h"

#include <vector>

namespace deformable_surface::simulation {

/// Each simulation point that was seen is drawn to the plane of the cloud at the nearest point:
/// F = m g n n.(p - x) - 2 m sqrt(g) n n.v, with the gain g, 1/s^2, the plane's point p and normal n (point to plane [Chen and
/// Medioni 1992], critically damped). There is no force along the plane: a cloud does not show where on the surface a point is,
/// and physics decides it.
class TrackLoad : public solve::ExternalLoad {
 public:
  /// What a snapshot must hold: the points that were seen, ascending, and their planes.
  struct Seen {
    Index point;
    Vec3 place, normal;  // m; unit
  };

  TrackLoad(const std::vector<double>& masses, double gain) : masses_(masses), gain_(gain) {}

  /// Tracks this cloud from now on, instead of the one before. A point was seen if a point of the cloud lies within reach (m),
  /// its plane is turned by at most sixty degrees from the surface, and the point is not farther aside than the cloud's points
  /// are apart: points in a hole or behind an obstacle were not seen. normals (m x 3): of the surface, unit or zero. O(m log n).
  void observe(const ObservedCloud& cloud, const model::State& state, const Points& normals, double reach);
  void restore(const std::vector<Seen>& seen) { seen_ = seen; }
  const std::vector<Seen>& seen() const { return seen_; }
  bool isEmpty() const { return seen_.empty(); }

  /// Root of the mean square distance from the planes, m; NaN if nothing was seen.
  double residual(const model::State& state) const;

  void addForces(double time, const model::State& state, Points& forces) const override;
  double storedEnergy(double time, const model::State& state) const override;
  /// At least the loss of the potential: damping only dissipates.
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
