#include "deformable_surface/simulation/contact_points.h"

#include "deformable_surface/linear/lanczos.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace deformable_surface::simulation {
namespace {

constexpr double kDamped = 0.5;  // fraction of the mass of a cell, for all of its points between together
// Factor on ownMassOf(). Even clouds and scans need up to 1.7 (all shipped scenes), uneven meshes up to 500 (a skirt of 4004
// points, of which 1000 are simulated): Verlet then took 22 times the sub-steps.
constexpr double kHeaviest = 2.0;

}  // namespace

void ContactPoints::setBetween(std::shared_ptr<const transfer::SampledPoints> between) {
  between_ = std::move(between);
  is_severed_.clear();
  sharing_.clear();
  if (between_)
    for (const Index in_cell : countInCells()) sharing_.push_back(1 + in_cell);
  followMasses();
}

// Those that are not spare.
std::vector<Index> ContactPoints::countInCells() const {
  std::vector<Index> count(masses_.size(), 0);
  for (Index s = 0; s < between_->size(); ++s) count[between_->cellOf(s)] += !between_->isSpare(s);
  return count;
}

void ContactPoints::followMasses() {
  mass_share_.clear();
  damped_mass_.clear();
  damped_share_ = 0.0;
  if (!between_) return;
  const std::vector<Index> count = countInCells();
  for (Index s = 0; s < between_->size(); ++s) {
    const Index cell = between_->cellOf(s);
    mass_share_.push_back(std::min(1.0, kHeaviest * ownMassOf(numSimulated() + s) / masses_[cell]));
    const double mass = massOf(numSimulated() + s);
    damped_mass_.push_back(between_->isSpare(s) ? 0.0 : kDamped * mass / static_cast<double>(count[cell]));
  }
}

double ContactPoints::dampedShare() const {
  if (damped_share_ == 0.0) damped_share_ = between_ ? findDampedShare() : 1.0;
  return damped_share_;
}

// The largest eigenvalue of 1 + sum_s d_s u_s u_s^T, with d_s the mass of a point between for damping and u_s its weights over
// the roots of the masses. Sums of rows are larger by a quarter to three quarters, and sub-steps would be as much shorter.
double ContactPoints::findDampedShare() const {
  Eigen::VectorXd scale(numSimulated());
  for (Index i = 0; i < numSimulated(); ++i) scale[i] = 1.0 / std::sqrt(masses_[i]);
  Lanczos lanczos;
  return lanczos.boundLargest(scale, [&](const Eigen::VectorXd& v, Eigen::VectorXd& product) {
    product = v;
    for (Index s = 0; s < between_->size(); ++s) {
      if (damped_mass_[s] == 0.0) continue;
      double along = 0.0;
      between_->visitWeights(s, [&](Index i, double w) { along += w * scale[i] * v[i]; });
      between_->visitWeights(s, [&](Index i, double w) { product[i] += damped_mass_[s] * along * w * scale[i]; });
    }
  });
}

void ContactPoints::takePart(const ContactPoints& whole, const std::vector<Index>& new_index) {
  if (number_in_part_.empty() || taken_from_ != whole.between_) numberPart(whole, new_index);
  areas_.per_mass = whole.areas_.per_mass;
  areas_.of_points.clear();
  for (Index i = 0; !whole.areas_.of_points.empty() && i < numSimulated(); ++i)
    areas_.of_points.push_back(whole.areas_.of_points[number_in_whole_[i]]);
  is_severed_.clear();
  if (whole.is_severed_.empty()) return;
  for (Index p = numSimulated(); p < size(); ++p) is_severed_.push_back(whole.isSevered(number_in_whole_[p]));
}

// Parts are taken again whenever loads have changed. Unchanged data is kept.
void ContactPoints::numberPart(const ContactPoints& whole, const std::vector<Index>& new_index) {
  const Index n = whole.numSimulated();
  taken_from_ = whole.between_;
  number_in_part_ = new_index;
  number_in_whole_.assign(numSimulated(), -1);
  for (Index i = 0; i < n; ++i)
    if (new_index[i] >= 0) number_in_whole_[new_index[i]] = i;
  if (!whole.between_) return setBetween(nullptr);
  std::vector<Index> old;
  setBetween(std::make_shared<transfer::SampledPoints>(whole.between_->takePart(new_index, numSimulated(), old)));
  damped_share_ = whole.dampedShare();
  number_in_part_.resize(whole.size(), -1);
  for (Index i = 0; i < numSimulated(); ++i) sharing_[i] = whole.sharing_[number_in_whole_[i]];
  for (std::size_t s = 0; s < old.size(); ++s) {
    number_in_part_[n + old[s]] = numSimulated() + static_cast<Index>(s);
    number_in_whole_.push_back(n + old[s]);
    damped_mass_[s] = whole.dampedMassOf(n + old[s]);  // divided by the number in the whole cell, also if the part has fewer
  }
}

double ContactPoints::ownMassOf(Index p) const {
  if (!isBetween(p)) return masses_[p];
  double sum = 0.0;
  between_->visitWeights(p - numSimulated(), [&](Index j, double w) { sum += w * w / masses_[j]; });
  return 1.0 / sum;
}

double ContactPoints::areaOf(Index p, bool is_shared) const {
  const Index i = simulationPointOf(p);
  const double area = areas_.of_points.empty() ? areas_.per_mass * masses_[i] : areas_.of_points[i];
  return is_shared ? area / static_cast<double>(sharing_[i]) : area;
}

double ContactPoints::totalMass() const { return std::accumulate(masses_.begin(), masses_.end(), 0.0); }

bool ContactPoints::isHeld(Index p, const std::vector<char>& held) const {
  if (!isBetween(p)) return held[p];
  bool is_held = true;
  between_->visitWeights(p - numSimulated(), [&](Index j, double) { is_held = is_held && held[j]; });
  return is_held;
}

void ContactPoints::placeAll(const Points& positions, Points& all) const {
  all = positions;
  for (Index s = 0; between_ && s < between_->size(); ++s) all.push_back(between_->place(s, positions));
}

double ContactPoints::sumOfWeights(Index s) const {
  double sum = 0.0;
  between_->visitWeights(s, [&](Index, double w) { sum += std::abs(w); });
  return sum;
}

void ContactPoints::addStiffness(Index p, const Mat3& block, BlockSparse& stiffness) const {
  if (!isBetween(p)) return stiffness.add(p, p, block);
  const Index s = p - numSimulated();
  between_->visitWeights(s, [&](Index i, double w_i) {
    between_->visitWeights(s, [&](Index j, double w_j) {
      if (j <= i) stiffness.add(i, j, w_i * w_j * block);
    });
  });
}

// Row sums of |w_i w_j|.
void ContactPoints::addRowBound(Index p, double value, std::vector<double>& bound) const {
  if (!isBetween(p)) {
    bound[p] += value;
    return;
  }
  const Index s = p - numSimulated();
  const double sum = sumOfWeights(s);
  between_->visitWeights(s, [&](Index i, double w) { bound[i] += value * std::abs(w) * sum; });
}

}  // namespace deformable_surface::simulation
