#include "carried_points.h"

namespace deformable_surface::solve {

void findCarried(const System& system, const State& state, std::vector<CarriedPoint>& carried) {
  carried.clear();
  for (Index i = 0; i < state.size(); ++i)
    if (system.isHeld(i) && !state.velocities[i].isZero(0.0))
      carried.push_back({i, state.velocities[i], {state.positions[i]}, {state.positions[i]}});
}

double addLoads(const System& system, double time, const State& state, std::vector<CarriedPoint>& carried, Points& forces) {
  if (carried.empty()) {
    system.addLoads(time, state, forces);
    return 0.0;
  }
  system.addLoadsOnAll(time, state, forces);
  return bear(system, state.positions, carried, forces);
}

double bear(const System& system, const Points& positions, std::vector<CarriedPoint>& carried, Points& forces) {
  double work = 0.0;
  for (CarriedPoint& c : carried) work += c.work.moveTo(positions[c.point], forces[c.point]);
  for (Index i = 0; i < system.size(); ++i)
    if (system.isHeld(i)) forces[i].setZero();
  return work;
}

}  // namespace deformable_surface::solve
