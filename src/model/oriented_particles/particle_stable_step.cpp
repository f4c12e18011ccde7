// Bounds of the stiffness of all pairs, and the stable step.
#include "deformable_surface/base/parallel.h"
#include "particle_loops.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace deformable_surface::model {
namespace {

using particles::kBlock;

}  // namespace

// Calls add(i, k) with the bounds k of the stiffness of every pair of each particle i of begin .. end - 1, in ascending order of
// its neighbours. The bounds are the same from both sides: pairs within that range are evaluated once.
template <class Add>
void OrientedParticles::addStiffness(Index begin, Index end, const Add& add) const {
  for (Index i = begin; i < end; ++i)
    for (const Index* j = lists_.begin(i); j != lists_.end(i) && *j < begin; ++j)
      add(i, boundStiffness(lattice_.pair, packed_, i, *j));
  for (Index i = begin; i < end; ++i)
    for (const Index* j = std::upper_bound(lists_.begin(i), lists_.end(i), i); j != lists_.end(i); ++j) {
      const PairStiffness k = boundStiffness(lattice_.pair, packed_, i, *j);
      add(i, k);
      if (*j < end) add(*j, k);
    }
}

double OrientedParticles::findStableStep(const State& state) const {
  if (!prepare(state)) return std::numeric_limits<double>::infinity();  // the first sub-step reports the problem
  const double mass = mass_, inertia = lattice_.inertia_by_mass * mass_, both = std::sqrt(mass * inertia);
  const Index n = state.size(), num_blocks = (n + kBlock - 1) / kBlock;
  const ApartPotential apart = apartPotential();
  if (kept_) {
    row_bounds_.assign(n, 0.0);
    addKeptBounds(kept_->inertia_by_mass, row_bounds_);
    const double most = parallelMax(n, kBlock, [&](Index begin, Index end) {
      double largest = 0.0;
      for (Index i = begin; i < end; ++i) largest = std::max(largest, row_bounds_[i] / masses_[i]);
      return largest;
    });
    return most > 0.0 ? 2.0 / std::sqrt(most) : std::numeric_limits<double>::infinity();
  }
  row_maxima_.assign(num_blocks, 0.0);
  parallelFor(n, kBlock, [&](Index begin, Index end) {
    double largest = 0.0, moves[kBlock] = {}, turns[kBlock] = {};
    addStiffness(begin, end, [&](Index i, const PairStiffness& k) {
      moves[i - begin] += 2.0 * (k.x / mass + k.y / both);
      turns[i - begin] += 2.0 * k.y / both + k.z / inertia;
    });
    for (Index i = begin; i < end; ++i) {
      double move = moves[i - begin];
      forEachParted(i, [&](double d) { move += 2.0 * boundContactStiffness(lattice_.pair, d) / mass; });
      move += countApart(apart, lists_, packed_, i) * 4.0 * apart.stiffness / mass;
      largest = std::max({largest, move, turns[i - begin]});
    }
    row_maxima_[begin / kBlock] = largest;
  });
  double largest = 0.0;
  for (double row : row_maxima_) largest = std::max(largest, row);
  return largest > 0.0 ? 2.0 / std::sqrt(largest) : std::numeric_limits<double>::infinity();
}

void OrientedParticles::addRowBounds(const State& state, std::vector<double>& stiffness, std::vector<double>&) const {
  if (!prepare(state)) return;
  // Normals that do not turn have an infinite inertia.
  if (kept_) return addKeptBounds(std::numeric_limits<double>::infinity(), stiffness);
  parallelFor(state.size(), kBlock, [&](Index begin, Index end) {
    addStiffness(begin, end, [&](Index i, const PairStiffness& k) { stiffness[i] += 2.0 * k.x; });
    for (Index i = begin; i < end; ++i)
      forEachParted(i, [&](double d) { stiffness[i] += 2.0 * boundContactStiffness(lattice_.pair, d); });
    if (!lists_.hasApart()) return;
    const ApartPotential apart = apartPotential();
    for (Index i = begin; i < end; ++i) stiffness[i] += 4.0 * apart.stiffness * countApart(apart, lists_, packed_, i);
  });
}

// Of kept bonds and of the repulsion of strangers; as PresentBonds::addRowBounds().
void OrientedParticles::addKeptBounds(double inertia_by_mass, std::vector<double>& bounds) const {
  bonds_.addRowBounds(packed_, inertia_by_mass, bounds);
  const ApartPotential apart = apartPotential();
  parallelFor(static_cast<Index>(bounds.size()), kBlock, [&](Index begin, Index end) {
    for (Index i = begin; i < end; ++i) {
      forEachStranger(i, [&](Index, double, double) { bounds[i] += 4.0 * apart.stiffness; });
      if (lists_.hasApart()) bounds[i] += 4.0 * apart.stiffness * countApart(apart, lists_, packed_, i);
    }
  });
}

}  // namespace deformable_surface::model
