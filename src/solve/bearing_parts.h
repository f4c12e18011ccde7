// The parts of the points that bear it where a step has made energy that nothing put in.
#pragma once

#include "deformable_surface/solve/motion_limit.h"
#include "deformable_surface/solve/system.h"

#include <vector>

namespace deformable_surface::solve {

/// Parts are those of the system's MotionLimit; where it tells none, those that links connect.
class BearingParts {
 public:
  /// None. Labels the parts where no MotionLimit tells them.
  void begin(const System& system);
  /// (n) of each point: the number of its part, below n.
  const std::vector<Index>& parts() const { return *parts_; }
  /// stopped: points, as MotionLimit::limit() returns them.
  void addStopped(const MotionLimit& limit, const std::vector<Index>& stopped) {
    for (const Index i : stopped) bears_[limit.parts()[i]] = 1;
  }
  void addPart(Index part) { bears_[part] = 1; }
  /// The parts whose kinetic energy has changed by another amount than the power of the forces, as the mean of beginning and end
  /// of a step, explains: parts that meet others. time: s, at its beginning.
  void addChanged(const System& system, double time, double step, const State& before, const State& after);
  /// Whether a point is free and belongs to them.
  bool contains(const System& system, Index i) const { return bears_[(*parts_)[i]] != 0 && !system.isHeld(i); }
  /// Whether any free point belongs to them.
  bool areAnyFree(const System& system) const;
  /// Takes energy, J, from the motion of their free points, relative to the mean of these if momentum is kept. Places stay.
  /// Returns what was taken, J: less than asked for only if there was no more.
  double take(const System& system, double energy, State& state, bool keeps_momentum = true) const;

 private:
  const std::vector<Index>* parts_ = nullptr;
  std::vector<Index> linked_;            // (n) these, where links tell them
  std::vector<char> bears_;              // (n) by number of the part
  std::vector<double> gains_;            // (n) J, the same
  Points forces_before_, forces_after_;  // N
};

}  // namespace deformable_surface::solve
