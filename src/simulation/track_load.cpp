#include "deformable_surface/simulation/track_load.h"

#include "deformable_surface/base/error.h"
#include "deformable_surface/cloud/clean.h"
#include "deformable_surface/cloud/normals.h"

#include <cmath>
#include <limits>
#include <utility>

namespace deformable_surface::simulation {
namespace {

constexpr Index kNeighbors = 10;      // that show a plane in the noise of a depth camera
constexpr double kAside = 1.0;        // of the distance to the farthest of these neighbours: beyond it a point was not seen
constexpr double kLeastCosine = 0.5;  // sixty degrees: a wall that the cloud shows beside the surface is not it

Points findDistinct(const cloud::PointCloud& cloud) {
  cloud::CleanCloud clean = cloud::clean(cloud);
  if (clean.positions.size() < 3)
    throw InputError("cloud: found " + std::to_string(clean.positions.size()) + " finite distinct points among " +
                     std::to_string(cloud.positions.size()) + "; accepted: at least 3");
  return std::move(clean.positions);
}

}  // namespace

ObservedCloud::ObservedCloud(const cloud::PointCloud& cloud) : points_(findDistinct(cloud)), tree_(points_) {}

void TrackLoad::observe(const ObservedCloud& cloud, const model::State& state, const Points& normals, double reach) {
  const cloud::KdTree& tree = cloud.tree();
  seen_.clear();
  std::vector<cloud::Neighbor> near;
  Points around;
  for (Index i = 0; i < state.size(); ++i) {
    tree.nearest(state.positions[i], kNeighbors, near);
    const Vec3 place = cloud.points()[near[0].index];
    if (!((place - state.positions[i]).norm() <= reach)) continue;
    // The plane from the neighbours of the nearest point.
    tree.nearest(place, kNeighbors, near);
    around.clear();
    Lists others;
    others.offsets = {0};
    for (const cloud::Neighbor& neighbor : near) {
      if (!around.empty()) others.items.push_back(static_cast<Index>(around.size()));
      around.push_back(cloud.points()[neighbor.index]);
    }
    others.offsets.resize(around.size() + 1, static_cast<Index>(others.items.size()));
    const Vec3 normal = cloud::estimateNormals(around, others)[0];
    const double spread = (around.back() - place).norm();
    const Vec3 to_place = place - state.positions[i];
    if (!((to_place - normal * normal.dot(to_place)).norm() <= kAside * spread)) continue;
    if (!(std::abs(normal.dot(normals[i])) >= kLeastCosine)) continue;
    seen_.push_back({i, place, normal});
  }
}

double TrackLoad::residual(const model::State& state) const {
  double sum = 0.0;
  for (const Seen& s : seen_) sum += std::pow(s.normal.dot(s.place - state.positions[s.point]), 2);
  return seen_.empty() ? std::numeric_limits<double>::quiet_NaN() : std::sqrt(sum / static_cast<double>(seen_.size()));
}

void TrackLoad::addForces(double, const model::State& state, Points& forces) const {
  const double damping = 2.0 * std::sqrt(gain_);
  for (const Seen& s : seen_) {
    const double pull =
        gain_ * s.normal.dot(s.place - state.positions[s.point]) - damping * s.normal.dot(state.velocities[s.point]);
    forces[s.point] += masses_[s.point] * pull * s.normal;
  }
}

double TrackLoad::storedEnergy(double, const model::State& state) const {
  double sum = 0.0;
  for (const Seen& s : seen_)
    sum += 0.5 * masses_[s.point] * gain_ * std::pow(s.normal.dot(s.place - state.positions[s.point]), 2);
  return sum;
}

double TrackLoad::estimateWork(double from, double to, const model::State& before, const model::State& after) const {
  return storedEnergy(from, before) - storedEnergy(to, after);
}

void TrackLoad::addStiffness(double, const model::State&, double step, BlockSparse& stiffness) const {
  const double rate = gain_ + (step > 0.0 ? 2.0 * std::sqrt(gain_) / step : 0.0);
  for (const Seen& s : seen_) stiffness.add(s.point, s.point, masses_[s.point] * rate * s.normal * s.normal.transpose());
}

void TrackLoad::addRowBounds(double, const model::State&, std::vector<double>& stiffness, std::vector<double>& damping) const {
  for (const Seen& s : seen_) {
    stiffness[s.point] += masses_[s.point] * gain_;
    damping[s.point] += 2.0 * masses_[s.point] * std::sqrt(gain_);
  }
}

}  // namespace deformable_surface::simulation
