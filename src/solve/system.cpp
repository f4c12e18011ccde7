#include "deformable_surface/solve/system.h"

#include "deformable_surface/base/disjoint_sets.h"
#include "deformable_surface/base/interrupt.h"
#include "deformable_surface/base/parallel.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

namespace deformable_surface::solve {
namespace {

constexpr Index kBlock = 1024;  // points per task: about a microsecond of work

// Plain numbers are cleared several times as fast as points.
void clear(Index n, Points& values) {
  values.resize(n);
  if (n > 0) std::fill_n(values[0].data(), 3 * n, 0.0);
}

void setZeroWhere(const std::vector<char>& marks, Points& values) {
  parallelFor(static_cast<Index>(values.size()), kBlock, [&](Index begin, Index end) {
    for (Index i = begin; i < end; ++i)
      if (marks[i]) values[i].setZero();
  });
}

}  // namespace

// Each evaluation begins with a check of the thread's interrupt: the work of a solver between two of them is short.
System::System(const model::DeformableModel& model, const std::vector<const ExternalLoad*>& loads, const std::vector<char>& held,
               double damping, const std::vector<char>* held_turns)
    : model_(model), loads_(loads), held_(held), held_turns_(held_turns), damping_(damping) {}

bool System::dissipatesInForces() const {
  return model_.forcesReadVelocities() ||
         std::any_of(loads_.begin(), loads_.end(), [](const ExternalLoad* load) { return !load->isConservative(); });
}

bool System::mayDissipateInForces(double time, double within, const State& state) const {
  return model_.forcesReadVelocities() || std::any_of(loads_.begin(), loads_.end(), [&](const ExternalLoad* load) {
           return load->mayDissipate(time, within, state);
         });
}

void System::computeForces(double time, const State& state, Points& forces) const {
  endIfInterrupted();
  clear(state.size(), forces);
  model_.addForces(state, forces);
  addLoads(time, state, forces);
}

void System::computeForcesOnAll(double time, const State& state, Points& forces) const {
  endIfInterrupted();
  clear(state.size(), forces);
  model_.addForces(state, forces);
  addLoadsOnAll(time, state, forces);
}

void System::computeElasticForcesAndTorques(const State& state, Points& forces, Points& torques) const {
  endIfInterrupted();
  clear(state.size(), forces);
  clear(state.size(), torques);
  model_.orientedPoints()->addForcesAndTorques(state, forces, torques);
}

void System::holdTurns(Points& torques) const {
  if (held_turns_) setZeroWhere(*held_turns_, torques);
}

void System::computeForcesAndTorques(double time, const State& state, Points& forces, Points& torques) const {
  computeElasticForcesAndTorques(state, forces, torques);
  addLoads(time, state, forces);
  holdTurns(torques);
}

void System::computeForcesAndTorquesOnAll(double time, const State& state, Points& forces, Points& torques) const {
  computeElasticForcesAndTorques(state, forces, torques);
  addLoadsOnAll(time, state, forces);
}

void System::computeFastForces(const State& state, Points& forces) const {
  endIfInterrupted();
  clear(state.size(), forces);
  if (const model::SplitForces* split = model_.splitForces())
    split->addFastForces(state, forces);
  else
    model_.addForces(state, forces);
}

void System::computeSlowForces(const State& state, Points& forces) const {
  endIfInterrupted();
  clear(state.size(), forces);
  model_.splitForces()->addSlowForces(state, forces);
}

void System::addLoadsOnAll(double time, const State& state, Points& forces) const {
  addLoadsOnAll(time, state, Loads::kAll, forces);
}

void System::addLoadsOnAll(double time, const State& state, Loads which, Points& forces) const {
  for (const ExternalLoad* load : loads_)
    if (isAmong(*load, which)) load->addForces(time, state, forces);
  confine(forces);
}

bool System::hasSplitLoads() const {
  return std::any_of(loads_.begin(), loads_.end(), [](const ExternalLoad* load) { return load->isSplitOff(); });
}

void System::addSplitLoadsAtRest(double time, const State& state, Points& forces) const {
  for (const ExternalLoad* load : loads_)
    if (load->isSplitOff()) load->addForcesAtRest(time, state, forces);
  confine(forces);
}

void System::addLoads(double time, const State& state, Points& forces) const {
  addLoadsOnAll(time, state, forces);
  setZeroWhere(held_, forces);
}

void System::computeConservativeForces(double time, const State& state, Points& forces) const {
  endIfInterrupted();
  at_rest_ = state;
  at_rest_.velocities.assign(state.positions.size(), Vec3::Zero());
  clear(state.size(), forces);
  model_.addForces(at_rest_, forces);
  for (const ExternalLoad* load : loads_)
    if (load->isConservative()) load->addForces(time, at_rest_, forces);
  confine(forces);
  setZeroWhere(held_, forces);
}

double System::loadPotential(double time, const State& state) const {
  double energy = 0.0;
  for (const ExternalLoad* load : loads_)
    if (load->isConservative()) energy += load->potential(time, state);
  return energy;
}

System::DrivingPower System::drivingPower(double time, double step, const State& state) const {
  DrivingPower power{0.0, 0.0};
  for (const ExternalLoad* load : loads_)
    (load->isConservative() ? power.of_potentials : power.of_others) += load->drivingPower(time, step, state);
  return power;
}

double System::loadWork(double from, double to, const State& before, const State& after) const {
  double work = 0.0;
  for (const ExternalLoad* load : loads_) work += load->estimateWork(from, to, before, after);
  return work;
}

double System::estimateWork(double from, double to, const State& before, const State& after) const {
  return carryingWork(from, to, before, after) + loadWork(from, to, before, after);
}

double System::estimateStaticWork(double from, double to, const State& before, const State& after) const {
  double work = loadWork(from, to, before, after);
  if (!hasCarried(before.positions, after.positions)) return work;
  placed_ = before;
  for (Index i = 0; i < after.size(); ++i)
    if (held_[i]) placed_.positions[i] = after.positions[i];
  work += potentialEnergy(to, placed_) - potentialEnergy(to, before);
  return work;
}

double System::findCarriedStrain(const Points& before, const Points& after) const {
  double largest = 0.0;  // squared
  for (const auto& [i, j] : stretchLinksOf(model_)) {
    if (held_[i] == held_[j]) continue;
    const double squared = (before[i] - before[j]).squaredNorm();
    if (squared > 0.0) largest = std::max(largest, ((after[i] - before[i]) - (after[j] - before[j])).squaredNorm() / squared);
  }
  return std::sqrt(largest);
}

void System::labelParts(std::vector<Index>& parts) const {
  const auto& links = stretchLinksOf(model_);
  parts.assign(size(), 0);
  if (links.empty()) return;
  makeSingleSets(size(), parts);
  for (const auto& [i, j] : links) joinSets(parts, i, j);
  for (Index i = 0; i < size(); ++i) parts[i] = findRoot(parts, i);
}

bool System::hasCarried(const Points& before, const Points& after) const {
  for (std::size_t i = 0; i < after.size(); ++i)
    if (held_[i] && before[i] != after[i]) return true;
  return false;
}

double System::workAgainst(double time, const State& state, const Points& before, const Points& after) const {
  if (!hasCarried(before, after)) return 0.0;
  computeForcesOnAll(time, state, forces_on_all_);
  double work = 0.0;
  for (Index i = 0; i < state.size(); ++i)
    if (held_[i]) work -= forces_on_all_[i].dot(after[i] - before[i]);
  return work;
}

double System::carryingWork(double from, double to, const State& before, const State& after) const {
  return 0.5 * (workAgainst(from, before, before.positions, after.positions) +
                workAgainst(to, after, before.positions, after.positions));
}

double System::storedEnergy(double time, const State& state) const {
  double energy = 0.0;
  for (const ExternalLoad* load : loads_) energy += load->storedEnergy(time, state);
  return energy;
}

void System::computeSteadyLoads(double time, const State& state, Points& forces) const {
  clear(state.size(), forces);
  row_stiffness_.assign(size(), 0.0);
  row_damping_.assign(size(), 0.0);
  for (const ExternalLoad* load : loads_) {
    load->addForces(time, state, forces);
    load->addRowBounds(time, state, row_stiffness_, row_damping_);
  }
  confine(forces);
  for (std::size_t i = 0; i < forces.size(); ++i)
    if (held_[i] || row_stiffness_[i] > 0.0) forces[i].setZero();
}

double System::potentialEnergy(double time, const State& state) const {
  endIfInterrupted();
  return model_.elasticEnergy(state) + loadPotential(time, state);
}

double System::kineticEnergy(const State& state) const {
  return parallelSum(size(), kBlock, [&](Index begin, Index end) {
    double energy = 0.0;
    for (Index i = begin; i < end; ++i) energy += 0.5 * masses()[i] * state.velocities[i].squaredNorm();
    if (!state.spins.empty())
      for (Index i = begin; i < end; ++i) energy += 0.5 * inertias()[i] * state.spins[i].squaredNorm();
    return energy;
  });
}

void System::addStiffness(double time, const State& state, double step, model::Hessian hessian, BlockSparse& stiffness) const {
  endIfInterrupted();
  if (const model::StiffnessMatrix* matrix = model_.stiffnessMatrix()) matrix->addStiffness(state, step, hessian, stiffness);
  for (const ExternalLoad* load : loads_) load->addStiffness(time, state, step, stiffness);
  if (hessian == model::Hessian::kPositive) return;
  for (const ExternalLoad* load : loads_) load->addIndefiniteStiffness(time, state, stiffness);
}

bool System::hasSkewStiffness() const {
  return std::any_of(loads_.begin(), loads_.end(), [](const ExternalLoad* load) { return load->hasSkewStiffness(); });
}

void System::computeSkewProduct(double time, const State& state, const Points& v, Points& product) const {
  clear(state.size(), product);
  for (const ExternalLoad* load : loads_) load->addSkewProduct(time, state, v, product);
  confine(product);
  setZeroWhere(held_, product);
}

void System::addFastStiffness(const State& state, BlockSparse& stiffness) const {
  endIfInterrupted();
  model_.splitForces()->addFastStiffness(state, 0.0, model::Hessian::kPositive, stiffness);
}

void System::computeStiffnessProduct(const Points& v, Points& product) const {
  endIfInterrupted();
  product.assign(v.size(), Vec3::Zero());
  model_.stiffnessProducts()->addStiffnessProduct(v, product);
  confine(product);
  setZeroWhere(held_, product);
}

double System::rankOneStiffness(const State& state, Points& v) const {
  const model::StiffnessMatrix* matrix = model_.stiffnessMatrix();
  const double coefficient = matrix ? matrix->rankOneStiffness(state, v) : 0.0;
  if (coefficient > 0.0) setZeroWhere(held_, v);
  return coefficient;
}

double System::largestForce(double time, const State& state) const { return computeForcesAndLargest(time, state, forces_); }

double System::computeForcesAndLargest(double time, const State& state, Points& forces) const {
  endIfInterrupted();
  clear(state.size(), forces);
  model_.addForces(state, forces);
  double squared = 0.0;
  for (const Vec3& force : forces) squared = std::max(squared, force.squaredNorm());
  for (const ExternalLoad* load : loads_) {  // each by itself: contact bears weight
    clear(state.size(), loads_alone_);
    load->addForces(time, state, loads_alone_);
    for (std::size_t i = 0; i < forces.size(); ++i) {
      squared = std::max(squared, loads_alone_[i].squaredNorm());
      forces[i] += loads_alone_[i];
    }
  }
  confine(forces);
  setZeroWhere(held_, forces);
  return std::sqrt(squared);
}

void System::computeRowBounds(double time, const State& state, Loads which) const {
  endIfInterrupted();
  row_stiffness_.assign(size(), 0.0);
  row_damping_.assign(size(), 0.0);
  model_.addRowBounds(state, row_stiffness_, row_damping_);
  addLoadBounds(time, state, which);
}

// A point near the origin is linked to others that are farther from it.
void System::computeRounding(double time, const State& state, std::vector<double>& rounding) const {
  computeRowBounds(time, state);
  double farthest = 0.0;
  for (const Vec3& p : state.positions) farthest = std::max(farthest, p.lpNorm<Eigen::Infinity>());
  rounding.resize(size());
  for (Index i = 0; i < size(); ++i) rounding[i] = std::numeric_limits<double>::epsilon() * row_stiffness_[i] * farthest;
}

double System::roundingForce(double time, const State& state) const {
  computeRowBounds(time, state);
  double largest = 0.0;
  for (Index i = 0; i < size(); ++i)
    largest = std::max(largest, row_stiffness_[i] * state.positions[i].lpNorm<Eigen::Infinity>());
  return std::numeric_limits<double>::epsilon() * largest;
}

double System::largestRow(const std::vector<double>& bounds) const {
  const std::vector<double>& mass = masses();
  double largest = 0.0;
  for (Index i = 0; i < size(); ++i)
    if (!held_[i] && bounds[i] > 0.0) largest = std::max(largest, bounds[i] / mass[i]);
  return largest;
}

double System::dampingRate(double time, const State& state, Loads which) const {
  // Without forces that read velocities only loads damp, and the bounds of the model's stiffness are not asked for.
  if (model_.forcesReadVelocities())
    computeRowBounds(time, state, which);
  else
    computeLoadBounds(time, state, which);
  return largestRow(row_damping_);
}

void System::computeLoadBounds(double time, const State& state, Loads which) const {
  row_stiffness_.assign(size(), 0.0);
  row_damping_.assign(size(), 0.0);
  addLoadBounds(time, state, which);
}

void System::addLoadBounds(double time, const State& state, Loads which) const {
  for (const ExternalLoad* load : loads_)
    if (isAmong(*load, which)) load->addRowBounds(time, state, row_stiffness_, row_damping_);
}

double System::loadStiffness(double time, const State& state) const {
  computeLoadBounds(time, state, Loads::kOthers);
  return largestRow(row_stiffness_);
}

System::SplitBounds System::boundSplitLoads(double time, const State& state) const {
  computeLoadBounds(time, state, Loads::kSplitOff);
  return {largestRow(row_damping_), largestRow(row_stiffness_)};
}

double System::boundStiffness(double time, const State& state) const {
  computeRowBounds(time, state, Loads::kOthers);
  return largestRow(row_stiffness_);
}

bool System::hasElasticityAlone(double time, const State& state) const {
  const model::StiffnessMatrix* matrix = model_.stiffnessMatrix();
  return matrix && matrix->knowsCouplings() && !motion_limit_ && !dissipatesInForces() && !hasStiffnessProducts() &&
         !(loadStiffness(time, state) > 0.0);
}

}  // namespace deformable_surface::solve
