// Checks whether a step created energy. A blow-up that stays finite passes every other check. All integrators share
// this check.
#pragma once

#include "deformable_surface/solve/system.h"

namespace deformable_surface::solve {

/// Keeps an account of the energy E (kinetic, elastic, potential of the loads). Commands between steps do not count as a
/// gain. The work of loads without a potential is added to the account. The excess is what E has gained beyond that since
/// its lowest value. A step is sound if
///   excess <= swing * V + (kinetic energy that the loads give in a sub-step from rest)
/// V is the largest recent sum of kinetic and elastic energy, springs to fixed places included. The first term covers the
/// oscillation of a symplectic method's energy about the value that it conserves. The second covers the error of the first
/// step of a first-order method. The excess decays slowly, so that drift over very many steps is not taken for a blow-up. V
/// therefore stays below 1 / (1 - swing) of the energy that was there or was put in. This bounds every speed and every stretch:
/// no other quantity of a single point has to be watched.
class EnergyGuard {
 public:
  /// What a snapshot must hold.
  struct Memory {
    double excess = 0.0;     // J
    double vibration = 0.0;  // J, the largest recent kinetic + elastic energy
    double kick = 0.0;       // J/s^2, see loadsChanged()
    bool kick_needed = true;
  };

  /// Forgets everything. The account starts again with the next state.
  void restart() {
    Points scratch = std::move(forces_);  // so that a restart in every step allocates nothing
    *this = EnergyGuard();
    forces_ = std::move(scratch);
  }
  /// The loads have changed since the last step: the energy that they give from rest is measured again.
  void loadsChanged() { memory_.kick_needed = true; }
  /// The elastic energy has changed since the end of the last step, by plastic flow.
  void elasticityChanged() { elastic_known_ = false; }
  const Memory& memory() const { return memory_; }
  void setMemory(const Memory& memory) {
    restart();
    memory_ = memory;
  }

  /// At the start of a step, after its commands.
  void beginStep(const System& system, double time, const State& state);
  /// What an integration method may gain by its nature.
  struct Allowance {
    double gain;  // of a single step, in shares of V
    double fade;  // share of the excess that a step forgives: growth below about half of it is drift
  };
  static constexpr Allowance kSymplectic{1.0, 1e-5};
  static constexpr Allowance kDescending{1e-3, 1e-5};  // implicit and static: they never gain but by the error of the work put in
  static constexpr Allowance kPublished{1.0, 1e-3};    // explicit Euler drifts

  /// At the end of a step: false if the energy is not finite or has grown more than is allowed. substep, s: of the integrator;
  /// work, J: of loads without a potential in this step. Does not change the memory.
  bool accepts(const System& system, double time, const State& state, double substep, double work, const Allowance& allowance);
  /// Whether the excess is at most this share of the energy in motion and stretch (beside the error of a first step), as
  /// the last accepts() found it.
  bool isCalm(double share) const { return excess_ <= share * next_.vibration + kick_; }
  /// Whether the kinetic energy is at most this share of the same energy.
  bool isNearRest(double share) const { return kinetic_ <= share * next_.vibration; }
  /// The next step begins with the state that accepts() saw last.
  void commit();

  double energyBefore() const { return before_; }  // J, at beginStep()
  double energyAfter() const { return after_; }    // J, as accepts() saw it last

  /// J, gained in the step beyond the work put in, as the last accepts() found it.
  double gain() const { return gain_; }
  /// J, gained since the lowest energy, beyond the work put in.
  double excess() const { return excess_; }

 private:
  Memory memory_, next_;
  bool elastic_known_ = false;
  double elastic_ = 0.0, next_elastic_ = 0.0, before_ = 0.0, after_ = 0.0, gain_ = 0.0, excess_ = 0.0, kick_ = 0.0,
         kinetic_ = 0.0;
  Points forces_;
};

}  // namespace deformable_surface::solve
