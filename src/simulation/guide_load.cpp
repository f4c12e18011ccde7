#include "deformable_surface/simulation/guide_load.h"

#include "deformable_surface/base/parallel.h"

#include <algorithm>
#include <cmath>

namespace deformable_surface::simulation {
namespace {

constexpr Index kBlock = 64;  // points per task: some microseconds of work

// Distances by Newton's method change faster than places where the gradient grows away from the iso-surface.
constexpr double kSteepest = 2.0;

// Distance between the points of a hexagonal lattice with this area each.
double findSpacing(double area) { return std::sqrt(2.0 / std::sqrt(3.0) * area); }

}  // namespace

void GuideLoad::addForces(double, const model::State& state, Points& forces) const {
  computeAreaVectors(model_, state, area_);
  parallelFor(static_cast<Index>(forces.size()), kBlock, [&](Index begin, Index end) {
    for (Index i = begin; i < end; ++i) {
      const double reach = params_.reach * findSpacing(area_[i].norm());
      if (!(reach > 0.0)) continue;
      forces[i] += params_.pressure * std::clamp(params_.distance(state.positions[i]) / reach, -1.0, 1.0) * area_[i];
    }
  });
}

void GuideLoad::addRowBounds(double, const model::State& state, std::vector<double>& stiffness, std::vector<double>&) const {
  computeAreaVectors(model_, state, area_);
  for (Index i = 0; i < state.size(); ++i) {
    const double area = area_[i].norm();
    if (area > 0.0) stiffness[i] += kSteepest * params_.pressure * area / (params_.reach * findSpacing(area));
  }
}

}  // namespace deformable_surface::simulation
