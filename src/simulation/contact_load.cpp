#include "deformable_surface/simulation/contact_load.h"

#include <algorithm>

namespace deformable_surface::simulation {
namespace {

// Calls visit(i, depth, normal) for every point inside the tool.
template <class Visit>
void forEachInside(const tool::ToolParams& tool, double time, const Points& positions, Visit&& visit) {
  const tool::Pose pose = tool::interpolate(tool.path, time);
  for (Index i = 0; i < static_cast<Index>(positions.size()); ++i) {
    const geometry::SignedDistance d = tool::findSignedDistance(tool.shape, pose, positions[i]);
    if (d.distance < 0.0) visit(i, -d.distance, d.normal);
  }
}

}  // namespace

void ContactLoad::addForces(double time, const model::State& state, Points& forces) const {
  for (const tool::ToolParams& tool : tools_)
    forEachInside(tool, time, state.positions,
                  [&](Index i, double depth, const Vec3& normal) { forces[i] += masses_[i] * rate_ * rate_ * depth * normal; });
}

double ContactLoad::potential(double time, const model::State& state) const {
  double sum = 0.0;
  for (const tool::ToolParams& tool : tools_)
    forEachInside(tool, time, state.positions,
                  [&](Index i, double depth, const Vec3&) { sum += 0.5 * masses_[i] * rate_ * rate_ * depth * depth; });
  return sum;
}

double ContactLoad::estimateWork(double from, double to, const model::State& before, const model::State& after) const {
  return std::max({0.0, potential(to, before) - potential(from, before), potential(to, after) - potential(from, after)});
}

// The curvature of the tool's surface would soften a point that slides; leaving it out keeps the matrix positive.
void ContactLoad::addStiffness(double time, const model::State& state, double, BlockSparse& stiffness) const {
  for (const tool::ToolParams& tool : tools_) {
    const tool::Pose pose = tool::interpolate(tool.path, time);
    for (Index i = 0; i < state.size(); ++i) {
      const geometry::SignedDistance d = tool::findSignedDistance(tool.shape, pose, state.positions[i]);
      // Also without contact: the pattern stays the same from step to step.
      stiffness.add(i, i, d.distance < 0.0 ? Mat3(masses_[i] * rate_ * rate_ * d.normal * d.normal.transpose()) : Mat3::Zero());
    }
  }
}

void ContactLoad::addRowBounds(double, const model::State& state, std::vector<double>& stiffness, std::vector<double>&) const {
  for (Index i = 0; i < state.size(); ++i) stiffness[i] += static_cast<double>(tools_.size()) * masses_[i] * rate_ * rate_;
}

}  // namespace deformable_surface::simulation
