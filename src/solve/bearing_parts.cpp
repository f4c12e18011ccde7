#include "bearing_parts.h"

#include <algorithm>
#include <cmath>

namespace deformable_surface::solve {
namespace {

constexpr double kMuch = 0.01;  // of what all parts have gained or lost: smaller ones are errors of the rule

}  // namespace

void BearingParts::begin(const System& system) {
  bears_.assign(system.size(), 0);
  const MotionLimit* const limit = system.motionLimit();
  parts_ = limit && !limit->parts().empty() ? &limit->parts() : &linked_;
  if (parts_ == &linked_) system.labelParts(linked_);
}

void BearingParts::addChanged(const System& system, double time, double step, const State& before, const State& after) {
  system.computeForces(time, before, forces_before_);
  system.computeForces(time + step, after, forces_after_);
  gains_.assign(after.size(), 0.0);
  for (Index i = 0; i < after.size(); ++i) {
    if (system.isHeld(i)) continue;
    const Vec3 impulse = 0.5 * step * (forces_before_[i] + forces_after_[i]),
               gained = system.masses()[i] * (after.velocities[i] - before.velocities[i]);
    gains_[(*parts_)[i]] += 0.5 * (gained - impulse).dot(before.velocities[i] + after.velocities[i]);
  }
  double all = 0.0;
  for (const double gain : gains_) all += std::abs(gain);
  for (std::size_t part = 0; part < gains_.size(); ++part)
    if (std::abs(gains_[part]) > kMuch * all) bears_[part] = 1;
}

bool BearingParts::areAnyFree(const System& system) const {
  for (Index i = 0; i < static_cast<Index>(bears_.size()); ++i)
    if (contains(system, i)) return true;
  return false;
}

double BearingParts::take(const System& system, double energy, State& state, bool keeps_momentum) const {
  Vec3 mean = Vec3::Zero();
  double mass = 0.0, moving = 0.0;
  for (Index i = 0; i < state.size(); ++i) {
    if (!contains(system, i)) continue;
    mean += system.masses()[i] * state.velocities[i];
    mass += system.masses()[i];
  }
  mean = keeps_momentum ? Vec3(mean / mass) : Vec3::Zero();
  for (Index i = 0; i < state.size(); ++i)
    if (contains(system, i)) moving += 0.5 * system.masses()[i] * (state.velocities[i] - mean).squaredNorm();
  const double scale = moving > energy ? std::sqrt(1.0 - energy / moving) : 0.0;
  for (Index i = 0; i < state.size(); ++i)
    if (contains(system, i)) state.velocities[i] = mean + scale * (state.velocities[i] - mean);
  return std::min(energy, moving);
}

}  // namespace deformable_surface::solve
