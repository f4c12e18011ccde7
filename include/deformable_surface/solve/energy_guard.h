// Whether a step made energy out of nothing: a blow-up that stays finite passes every other check. Apart from the
// integrators, which it judges all alike.
#pragma once

#include "deformable_surface/solve/system.h"

namespace deformable_surface::solve {

/// Keeps an account of the energy E (kinetic, elastic, potential of the loads). What commands between steps change is no
/// gain; the work of loads without a potential is put in. The excess is what E has gained beyond that since it was lowest. A
/// step is sound if
///   excess <= swing * V + (kinetic energy that the loads give in a sub-step from rest)
/// with V the largest kinetic and elastic energy of late, world springs included. The first term is the oscillation of a
/// symplectic method's energy about what it really conserves, the second the error of the first step of a first-order one.
/// The excess fades slowly, so that drift over very many steps is not held to be a blow-up. V therefore stays below 1 / (1 -
/// swing) of what was there or put in, which bounds every speed and every stretch: nothing else about a single point has to
/// be watched.
class EnergyGuard {
 public:
  /// What a snapshot must hold.
  struct Memory {
    double excess = 0.0;     // J
    double vibration = 0.0;  // J, the largest kinetic + elastic energy of late
    double kick = 0.0;       // J/s^2, see loadsChanged()
    bool kick_needed = true;
  };

  /// Forgets everything: the next state is where the account begins.
  void restart() {
    Points scratch = std::move(forces_);  // so that a restart in every step allocates nothing
    *this = EnergyGuard();
    forces_ = std::move(scratch);
  }
  /// The loads are not those of the last step: how hard they push from rest is to be found anew.
  void loadsChanged() { memory_.kick_needed = true; }
  /// The elastic energy of the state is not that of the end of the last step: something has flowed.
  void elasticityChanged() { elastic_known_ = false; }
  const Memory& memory() const { return memory_; }
  void setMemory(const Memory& memory) {
    restart();
    memory_ = memory;
  }

  /// At the start of a step, after its commands.
  void beginStep(const System& system, double time, const State& state);
  /// What a method may do by its nature.
  struct Allowance {
    double gain;  // of a single step, in shares of V
    double fade;  // share of the excess that a step forgives: growth below about half of it is drift
  };
  static constexpr Allowance kSymplectic{1.0, 1e-5};
  static constexpr Allowance kDescending{1e-3, 1e-5};  // implicit and static: they never gain but by the error of the work put in
  static constexpr Allowance kPublished{1.0, 1e-3};    // explicit Euler drifts

  /// At its end: false if the energy is not finite or has grown beyond what is allowed. substep, s, is that of the integrator;
  /// work, J, that of loads without a potential in this step. Changes no memory.
  bool accepts(const System& system, double time, const State& state, double substep, double work, const Allowance& allowance);
  /// Whether the excess is at most this share of the energy in motion and stretch (beside the error of a first step), as
  /// accepts() saw it last.
  bool isCalm(double share) const { return excess_ <= share * next_.vibration + kick_; }
  /// Whether the kinetic energy is at most this share of the same.
  bool isNearRest(double share) const { return kinetic_ <= share * next_.vibration; }
  /// Takes what accepts() saw last as the state that the next step begins with.
  void commit();

  double energyBefore() const { return before_; }  // J, at beginStep()
  double energyAfter() const { return after_; }    // J, as accepts() saw it last

  /// J, gained in the step beyond the work put in, as accepts() saw it last.
  double gain() const { return gain_; }
  /// J, the same since the energy was lowest.
  double excess() const { return excess_; }

 private:
  Memory memory_, next_;
  bool elastic_known_ = false;
  double elastic_ = 0.0, next_elastic_ = 0.0, before_ = 0.0, after_ = 0.0, gain_ = 0.0, excess_ = 0.0, kick_ = 0.0,
         kinetic_ = 0.0;
  Points forces_;
};

}  // namespace deformable_surface::solve
