// Held points that move along with pins and tools.
#pragma once

#include "deformable_surface/solve/system.h"

#include <vector>

namespace deformable_surface::solve {

/// The work of what carries a point: it bears the force on it.
struct CarryingWork {
  Vec3 place, force = Vec3::Zero();  // m and N, when it was last asked

  /// J, since it was last asked, by the trapezoidal rule.
  double moveTo(const Vec3& next, const Vec3& force_there) {
    const double work = -0.5 * (force + force_there).dot(next - place);
    place = next;
    force = force_there;
    return work;
  }
};

struct CarriedPoint {
  Index point;
  Vec3 velocity;            // m/s, in the whole step
  CarryingWork work, slow;  // slow: of forces that do not act in every sub-step
};

/// The points that are held and in motion when a step begins, in ascending order.
void findCarried(const System& system, const State& state, std::vector<CarriedPoint>& carried);

/// Adds the loads to the forces, which end as zero on held points. Returns the work of what carries points since the last call,
/// J.
double addLoads(const System& system, double time, const State& state, std::vector<CarriedPoint>& carried, Points& forces);
/// The end of it: forces with all loads, on held points too, which are at positions, m.
double bear(const System& system, const Points& positions, std::vector<CarriedPoint>& carried, Points& forces);

}  // namespace deformable_surface::solve
