#include "self_contact_load.h"

#include <set>
#include <utility>

namespace deformable_surface::simulation {
namespace {

constexpr double kAlone = 0.99;  // weight of a triangle in whose Delaunay cell there is no other

}  // namespace

// Neighbours on a surface run along their common edge in opposite directions. Triangles of which one would run along an edge that
// another has taken overlap it.
std::vector<contact::Triangle> chooseContactTriangles(const std::vector<model::WeightedTriangle>& triangles) {
  std::vector<contact::Triangle> chosen;
  std::set<std::pair<Index, Index>> taken;
  for (const bool takes_shared : {false, true}) {
    for (const model::WeightedTriangle& triangle : triangles) {
      if ((triangle.weight < kAlone) != takes_shared) continue;
      const contact::Triangle t{triangle.corner[0], triangle.corner[1], triangle.corner[2]};
      const auto overlaps = [&](int k) { return taken.count({t[k], t[(k + 1) % 3]}) > 0; };
      if (overlaps(0) || overlaps(1) || overlaps(2)) continue;
      for (int k = 0; k < 3; ++k) taken.emplace(t[k], t[(k + 1) % 3]);
      chosen.push_back(t);
    }
  }
  return chosen;
}

SelfContactLoads::SelfContactLoads(const Points& rest, const model::DeformableModel& model, double thickness)
    : contact(rest, chooseContactTriangles(model.triangles()), model.masses(), {thickness, 0.0}) {}

// Where the loads do not act the limit still does: parts that come faster than was foreseen are stopped, not bounced.
bool SelfContactLoads::beginStep(const model::State& state, double step) {
  const bool may_act = contact.mayTouch(state.positions, state.velocities, step);
  return std::exchange(may_act_, may_act) != may_act;
}

}  // namespace deformable_surface::simulation
