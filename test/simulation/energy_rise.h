// How far the sum of all energies rises in a run that nothing drives.
#pragma once

#include "deformable_surface/simulation/simulation.h"

#include <algorithm>

namespace deformable_surface::test {

/// From its first state on.
class EnergyRise {
 public:
  explicit EnergyRise(const simulation::Simulation& s) : lowest_(sum(s.statistics())) {}

  void look(const simulation::Simulation& s) {
    const simulation::Statistics now = s.statistics();
    const double energy = sum(now);
    lowest_ = std::min(lowest_, energy);
    rise_ = std::max(rise_, energy - lowest_);
    fastest_ = std::max(fastest_, now.kinetic_energy);
  }
  double rise() const { return rise_; }        // J, above the lowest sum so far
  double fastest() const { return fastest_; }  // J, the largest kinetic energy

 private:
  static double sum(const simulation::Statistics& now) { return now.kinetic_energy + now.elastic_energy + now.potential_energy; }
  double lowest_, rise_ = 0.0, fastest_ = 0.0;
};

}  // namespace deformable_surface::test
