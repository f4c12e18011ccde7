// Edits of single particles by a user: checks and effects. particle_life.cpp has the automatic changes.
#include "deformable_surface/base/error.h"
#include "deformable_surface/base/interrupt.h"
#include "deformable_surface/base/value.h"
#include "deformable_surface/cloud/kd_tree.h"
#include "particle_life.h"

#include <algorithm>
#include <cmath>

namespace deformable_surface::simulation {
namespace {

using model::State;

// Nearer than the growing rule ever comes to another particle, repulsion would throw both off.
constexpr double kClosest = 0.3;  // spacings
constexpr double kUnitTolerance = 1e-6;
constexpr std::size_t kLook = 1024;  // particles between two looks at an interrupt

std::string nameOf(Index id) { return "particle " + std::to_string(id); }

void requireCount(const char* what, std::size_t found, std::size_t accepted) {
  if (found != accepted)
    throw InputError(std::string(what) + ": found " + std::to_string(found) + "; accepted: " + std::to_string(accepted) +
                     ", one per particle");
}

// Indices of the particles with these ids, in their order.
std::vector<Index> findPoints(const State& state, const std::vector<Index>& ids) {
  std::vector<Index> index_of_id(state.next_id, -1), points;
  for (Index i = 0; i < state.size(); ++i) index_of_id[state.traits[i].id] = i;
  constexpr Index kTaken = -2;
  for (const Index id : ids) {
    const Index i = id >= 0 && id < state.next_id ? index_of_id[id] : -1;
    if (i == kTaken) throw InputError(nameOf(id) + ": found its id twice; accepted: each particle once");
    if (i < 0) throw InputError(nameOf(id) + ": found none of this id; accepted: particles that are there");
    points.push_back(i);
    index_of_id[id] = kTaken;
  }
  return points;
}

// Of each position the nearest particle, of equally near ones the first; -1 if there are none.
std::vector<Index> findNearest(const State& state, const Points& positions) {
  constexpr double kEqual = 1e-9;  // of the distance: the tree rounds in another way
  const cloud::KdTree tree(state.positions);
  std::vector<cloud::Neighbor> near;
  std::vector<Index> nearest(positions.size(), -1);
  for (std::size_t k = 0; k < positions.size(); ++k) {
    endIfInterrupted(k, kLook);
    tree.nearest(positions[k], 1, near);
    if (near.empty()) break;
    tree.withinRadius(positions[k], (1.0 + kEqual) * std::sqrt(near.front().squared_distance), near);
    for (cloud::Neighbor& q : near) q.squared_distance = (state.positions[q.index] - positions[k]).squaredNorm();
    nearest[k] = std::min_element(near.begin(), near.end())->index;
  }
  return nearest;
}

}  // namespace

Population ParticleLife::edit(const ParticleEdit& edit, State& state, std::vector<char>& pinned,
                              std::vector<char>& pinned_turns) {
  using Action = ParticleAction;
  const bool adds = edit.action == Action::kAdd, moves = edit.action == Action::kMove, turns = edit.action == Action::kOrient;
  if (adds && model_.hasKeptBonds())
    throw InputError(
        "action: found add with oriented_particles.bonds kept, which new particles have none of; accepted: the others");
  if (adds) requireCount("ids", edit.ids.size(), 0);
  const std::size_t count = adds ? edit.positions.size() : edit.ids.size();
  if (count == 0) throw InputError("found an edit of no particle; accepted: at least one");
  requireCount("positions", edit.positions.size(), adds || moves ? count : 0);
  requireCount("orientations", edit.orientations.size(), adds || turns ? count : 0);
  if (adds && state.positions.size() + count > static_cast<std::size_t>(model_.params().growth.max_particles))
    throw InputError("found " + std::to_string(state.positions.size() + count) +
                     " particles after the edit; accepted: up to oriented_particles.growth.max_particles, " +
                     std::to_string(model_.params().growth.max_particles));
  for (const Vec3& p : edit.positions)
    if (!(p.array().abs() <= kMaxLength).all())
      throw InputError("positions: found a coordinate that is not finite or too large; accepted: up to " +
                       formatReal(kMaxLength) + " m");
  for (const Quaternion& q : edit.orientations)
    if (!(std::abs(q.norm() - 1.0) <= kUnitTolerance))
      throw InputError("orientations: found a quaternion of length " + formatReal(q.norm()) + "; accepted: length 1");
  const std::vector<Index> points = findPoints(state, edit.ids);

  State edited = state;
  Population changes;
  const std::vector<Index> nearest = adds ? findNearest(state, edit.positions) : std::vector<Index>();
  for (std::size_t k = 0; k < count; ++k) {
    if (adds) {
      model::ParticleTraits traits;
      traits.id = edited.next_id++;
      traits.ancestor = nearest[k] < 0 ? 0 : state.traits[nearest[k]].ancestor;
      edited.positions.push_back(edit.positions[k]);
      edited.velocities.push_back(Vec3::Zero());
      edited.orientations.push_back(edit.orientations[k]);
      edited.spins.push_back(Vec3::Zero());
      edited.traits.push_back(traits);
      continue;
    }
    const Index i = points[k];
    if (moves) edited.positions[i] = edit.positions[k];
    if (turns) edited.orientations[i] = edit.orientations[k];
    if (edit.action == Action::kCrease || turns) edited.traits[i].is_smooth = turns;
    if (moves || edit.action == Action::kFix) edited.velocities[i].setZero();
    if (turns || edit.action == Action::kFix) edited.spins[i].setZero();
  }
  if (adds || moves) {
    std::vector<Index> placed = points;
    for (Index i = state.size(); i < edited.size(); ++i) placed.push_back(i);
    requireRoom(edited, placed);
  }
  if (edit.action == Action::kDelete) {
    std::vector<char> is_gone(state.positions.size(), 0);
    for (const Index i : points) is_gone[i] = 1;
    takeOut(is_gone, edited, changes);
  }

  // All checks have passed. An added particle takes part in the cuts of the one next to it.
  if (adds && !model_.cuts().isEmpty()) {
    const Index first = state.size();
    std::vector<model::ParticleCuts::Pair> parents;
    for (const Index i : nearest) parents.emplace_back(i, -1);
    model_.setCuts(model_.cuts().inherit(edited.positions, edited.traits, first, parents, model_.cutLengths()));
  }
  changes.born = adds ? static_cast<Index>(count) : 0;
  state = std::move(edited);
  if (edit.action == Action::kFix || edit.action == Action::kFree)
    for (const Index i : points) pinned[i] = pinned_turns[i] = edit.action == Action::kFix;
  return changes;
}

// Between those placed and all others.
void ParticleLife::requireRoom(const State& state, const std::vector<Index>& placed) const {
  const double closest = kClosest * model_.lattice().spacing;
  const cloud::KdTree tree(state.positions);
  std::vector<cloud::Neighbor> near;
  for (std::size_t k = 0; k < placed.size(); ++k) {
    endIfInterrupted(k, kLook);
    const Index i = placed[k];
    tree.nearest(state.positions[i], 2, near, closest);  // itself and another
    for (const cloud::Neighbor& q : near) {
      const Index j = q.index;
      const double distance = (state.positions[i] - state.positions[j]).norm();
      if (j != i && distance < closest)
        throw InputError(nameOf(state.traits[i].id) + ": found it " + formatShort(distance) + " m from " +
                         nameOf(state.traits[j].id) + "; accepted: at least " + formatShort(closest) + " m, " +
                         formatShort(kClosest) + " of the spacing");
    }
  }
}

}  // namespace deformable_surface::simulation
