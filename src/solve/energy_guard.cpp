#include "deformable_surface/solve/energy_guard.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace deformable_surface::solve {
namespace {

// Verlet at half the stable step gains up to a quarter of the energy of its highest mode when motion turns into
// stretch: the conserved quantity is smaller than the energy by (w h / 2)^2 of the elastic part. The rest leaves room for
// crumpling, where modes stiffen; measured in docs/stability.md.
constexpr double kSwing = 0.4;
constexpr double kMemory = 1e-3;    // share by which the largest recent energy decays per step: a swing takes a few hundred
constexpr double kRounding = 16.0;  // units in the last place per point that sums of energies may be wrong by

}  // namespace

void EnergyGuard::beginStep(const System& system, double time, const State& state) {
  if (!elastic_known_) elastic_ = system.elasticEnergy(state);
  elastic_known_ = true;
  const double kinetic = system.kineticEnergy(state);
  before_ = elastic_ + kinetic + system.loadPotential(time, state);
  memory_.vibration = std::max(memory_.vibration, std::max(0.0, elastic_) + kinetic + system.storedEnergy(time, state));
  if (!memory_.kick_needed) return;
  memory_.kick_needed = false;
  memory_.kick = 0.0;
  system.computeSteadyLoads(time, state, forces_);
  for (Index i = 0; i < state.size(); ++i) memory_.kick += 0.5 * forces_[i].squaredNorm() / system.masses()[i];
}

bool EnergyGuard::accepts(const System& system, double time, const State& state, double substep, double work,
                          const Allowance& allowance) {
  next_elastic_ = system.elasticEnergy(state);
  kinetic_ = system.kineticEnergy(state);
  const double moving = next_elastic_ + kinetic_;
  // Bonds can have less energy than at rest; that is no vibration.
  const double vibration = std::max(0.0, next_elastic_) + kinetic_ + system.storedEnergy(time, state);
  after_ = moving + system.loadPotential(time, state);
  gain_ = after_ - before_ - work;
  excess_ = memory_.excess + gain_;
  next_ = memory_;
  next_.vibration = std::max(vibration, (1.0 - kMemory) * memory_.vibration);
  next_.excess = (1.0 - allowance.fade) * std::max(0.0, excess_);
  kick_ = memory_.kick * substep * substep;
  // By how much either limit is exceeded; NaN exceeds them.
  const double beyond = std::max(excess_ - kSwing * next_.vibration - kick_, gain_ - allowance.gain * next_.vibration - kick_);
  if (beyond <= 0.0) return std::isfinite(after_);
  // Rounding: positions off by a unit in the last place, times the forces there; and that of the sum itself.
  double reach = 0.0;
  for (const Vec3& x : state.positions) reach = std::max(reach, x.lpNorm<Eigen::Infinity>());
  const double terms = state.size() * reach * system.largestForce(time, state) + system.energyScale();
  const double rounding = kRounding * std::numeric_limits<double>::epsilon() * terms;
  return beyond <= rounding && std::isfinite(after_);
}

void EnergyGuard::commit() {
  memory_ = next_;
  elastic_ = next_elastic_;
}

}  // namespace deformable_surface::solve
