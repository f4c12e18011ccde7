// Bounds of the stiffness of all pairs, and the stable step.
#include "deformable_surface/base/parallel.h"
#include "particle_loops.h"

#include <Eigen/Eigenvalues>

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
    const double most = boundKeptFrequency();
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

// 1/s^2, a bound of the largest square of a frequency with kept bonds. Strangers touch few particles, and those often in
// different directions and with unequal masses. With d the bounds of bonds and of the sums of their repulsion, and b those
// between two particles, both over masses, the largest eigenvalue is at most max (d_i x_i + sum b_ij x_j) / x_i for any x > 0
// [Collatz 1942].
double OrientedParticles::boundKeptFrequency() const {
  constexpr int kProducts = 6;  // with the matrix, from x = 1 on; other numbers were not tried
  const Index n = static_cast<Index>(masses_.size());
  const double stiffness = 2.0 * apartPotential().stiffness;
  row_bounds_.assign(n, 0.0);
  bonds_.addRowBounds(packed_, kept_->inertia_by_mass, row_bounds_);
  touch_numbers_.assign(n, -1);
  const double untouched = parallelMax(n, kBlock, [&](Index begin, Index end) {
    double largest = 0.0;
    for (Index i = begin; i < end; ++i) {
      if (lists_.hasApart()) row_bounds_[i] += 2.0 * stiffness * countApart(apartPotential(), lists_, packed_, i);
      row_bounds_[i] /= masses_[i];
      forEachStranger(i, [&](Index, double, double) { touch_numbers_[i] = 0; });
      if (touch_numbers_[i] < 0) largest = std::max(largest, row_bounds_[i]);
    }
    return largest;
  });
  touching_.clear();
  for (Index i = 0; i < n; ++i) {
    if (touch_numbers_[i] < 0) continue;
    touch_numbers_[i] = static_cast<Index>(touching_.size());
    touching_.push_back(i);
  }
  if (touching_.empty()) return untouched;
  const Index count = static_cast<Index>(touching_.size());
  touches_.clear();
  touch_begins_.assign(1, 0);
  for (Index i : touching_) {
    Mat3 push = Mat3::Zero();
    const Eigen::Map<const Vec3> place(packed_.place(i));
    forEachStranger(i, [&](Index j, double d, double) {
      const Vec3 r = Eigen::Map<const Vec3>(packed_.place(j)) - place;
      push += d > 0.0 ? Mat3(r * r.transpose() / (d * d)) : Mat3(Mat3::Identity());
      touches_.emplace_back(touch_numbers_[j], stiffness / std::sqrt(masses_[i] * masses_[j]));
    });
    touch_begins_.push_back(static_cast<Index>(touches_.size()));
    const Eigen::SelfAdjointEigenSolver<Mat3> solver(push, Eigen::EigenvaluesOnly);
    row_bounds_[i] += stiffness * solver.eigenvalues()[2] / masses_[i];
  }
  double least = std::numeric_limits<double>::infinity(), bound = least;
  for (Index i : touching_) least = std::min(least, row_bounds_[i]);
  weights_.assign(count, 1.0);
  products_.resize(count);
  for (int product = 0; product < kProducts && bound > untouched; ++product) {
    double largest = 0.0;
    for (Index k = 0; k < count; ++k) {
      double sum = row_bounds_[touching_[k]] * weights_[k];
      for (Index t = touch_begins_[k]; t < touch_begins_[k + 1]; ++t) sum += touches_[t].second * weights_[touches_[t].first];
      products_[k] = sum;
      largest = std::max(largest, sum / weights_[k]);
    }
    bound = std::min(bound, largest);
    if (!(largest > least)) break;
    // What all have in common changes no eigenvector.
    for (Index k = 0; k < count; ++k) weights_[k] = (products_[k] - least * weights_[k]) / (largest - least);
  }
  return std::max(untouched, bound);
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
