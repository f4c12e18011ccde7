// An estimate of the error at each place of a surface, in place of one for the largest.
#pragma once

#include <vector>

namespace deformable_surface::simulation {

/// The error of a place is the largest value of `apart` at the simulation points that it follows, plus `everywhere`, but at most
/// `most`. See docs/accuracy_control.md.
struct LocalErrors {
  std::vector<float> apart;  // (m) m, of simulation points
  double everywhere = 0.0;   // m, of time stepping, sleep, a softer membrane and other equilibria
  double most = 0.0;         // m, estimate of the largest error; infinite: nothing can be said; NaN: there is no estimate
};

}  // namespace deformable_surface::simulation
