#include "newton.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace deformable_surface::solve {
namespace {

constexpr double kArmijo = 1e-4;           // share of the predicted decrease that must be reached
constexpr int kMaxHalvings = 30;           // beyond it the direction is rounding
constexpr double kEnergyRounding = 1e-14;  // of an energy: some tens of units in the last place
constexpr int kPatience = 2;               // projected matrices in a row after which the state is taken to be near a saddle
constexpr double kFirstShift = 1e-4;       // of the highest frequency squared: small beside it, large beside buckling modes
constexpr double kRaise = 10.0;            // of a shift that was not enough
constexpr double kLower = 0.25;            // of one that was: the least one that does leads fastest out of a saddle
// Of the gradient: largest residual of a direction by products; the next iteration finds the rest.
constexpr double kLoosest = 0.05;
constexpr double kForcing = 0.9;          // times the square of the gradient's fall: residual of the next direction
constexpr double kOversolved = 0.3;       // of the residual that ends the search: more accurate directions bring nothing
constexpr double kSkew = 1e-3;            // of a direction: the error that is left where the matrix has a skew part
constexpr int kMostSkew = 50;             // iterations for it; 20 suffice where both parts are equally large
constexpr double kHardly = 1e-3;          // of a direction: what leads to no descent beyond it holds up the rest
constexpr std::size_t kMostParts = 32;    // that are then moved one by one
constexpr int kMaxShortenings = 30;       // of a direction that stops points; beyond it there is none
constexpr double kRegularization = 1e-9;  // of the largest diagonal, where neither weight nor stiffness resists a motion
// Work in evaluations of all forces, as measured on sheets and spheres of 400 and 1000 points (springs and triangles) and on bars
// of 300, 1000 and 3000. A product by the stiffness counts as one, and so does an energy.
constexpr double kAssembly = 33.0;  // of a matrix
constexpr double kRate = 1400.0;    // multiplications of a factorisation in the time of a point's forces
constexpr double kPlaces = 150.0;   // numbers of a factor that a solution reads in this time

}  // namespace

void NewtonDescent::computeRemainder(const Problem& problem, State& state, Points& remainder) {
  const Index n = state.size();
  const System& system = problem.system;
  for (Index i = 0; i < n; ++i)
    state.velocities[i] = problem.step > 0.0 ? Vec3((state.positions[i] - problem.before[i]) / problem.step) : Vec3::Zero();
  system.computeForces(problem.time, state, forces_);
  passes_ += 1.0;
  remainder.assign(n, Vec3::Zero());
  if (!system.dissipatesInForces()) return;  // all forces have a potential
  system.computeConservativeForces(problem.time, state, conservative_);
  passes_ += 1.0;
  for (Index i = 0; i < n; ++i) remainder[i] = forces_[i] - conservative_[i];
}

double NewtonDescent::evaluate(const Problem& problem, State& state) {
  const Index n = state.size();
  const System& system = problem.system;
  computeRemainder(problem, state, remainder_);
  has_remainder_ = std::any_of(remainder_.begin(), remainder_.end(), [](const Vec3& r) { return !r.isZero(0.0); });
  gradient_.resize(n);
  double residual = 0.0;
  for (Index i = 0; i < n; ++i) {
    gradient_[i].setZero();
    if (system.isHeld(i)) continue;
    gradient_[i] = problem.weight[i] * (state.positions[i] - problem.target[i]) - forces_[i];
    const double unbalanced = gradient_[i].norm();
    if (!(unbalanced <= problem.rounding[i])) residual = std::max(residual, unbalanced);
  }
  residual_ = residual;
  return residual;
}

double NewtonDescent::potential(const Problem& problem, const State& state) {
  if (is_potential_known_ && potential_at_ == state.positions) return potential_;
  potential_ = problem.system.potentialEnergy(problem.time, state);
  passes_ += 1.0;
  potential_at_ = state.positions;
  is_potential_known_ = true;
  return potential_;
}

double NewtonDescent::merit(const Problem& problem, State& state) {
  double sum = potential(problem, state);
  for (Index i = 0; i < state.size(); ++i) {
    if (problem.system.isHeld(i)) continue;
    sum += 0.5 * problem.weight[i] * (state.positions[i] - problem.target[i]).squaredNorm();
  }
  if (!has_remainder_) return sum;
  computeRemainder(problem, state, remainder_there_);
  for (Index i = 0; i < state.size(); ++i) sum -= 0.5 * (remainder_[i] + remainder_there_[i]).dot(state.positions[i] - start_[i]);
  return sum;
}

bool NewtonDescent::factorize(const Problem& problem, const State& state, model::Hessian hessian) {
  const Index n = state.size();
  const System& system = problem.system;
  stiffness_.begin(n);
  system.addStiffness(problem.time, state, problem.step, hessian, stiffness_);
  if (stiffness_.finish(std::exchange(is_first_matrix_, false))) factor_.analyze(stiffness_.pattern());
  const Lists& pattern = stiffness_.pattern();
  double largest = 0.0;
  for (Index j = 0; j < n; ++j) {
    Mat3& diagonal = stiffness_.values()[pattern.offsets[j]];
    diagonal.diagonal().array() += problem.weight[j];
    if (!system.isHeld(j)) largest = std::max(largest, diagonal.diagonal().maxCoeff());
  }
  // Held points become identity rows.
  for (Index j = 0; j < n; ++j) {
    const Index first = pattern.offsets[j];
    for (Index k = first; k < pattern.offsets[j + 1]; ++k)
      if (system.isHeld(j) || system.isHeld(pattern.items[k])) stiffness_.values()[k].setZero();
    stiffness_.values()[first].diagonal().array() += system.isHeld(j) ? 1.0 : kRegularization * largest;
  }
  passes_ += kAssembly + factor_.factorWork() / (kRate * n);
  return factor_.factorize(stiffness_.values());
}

bool NewtonDescent::factorizeShifted(const System& system) {
  const auto diagonal = [this](Index j) { return stiffness_.values()[stiffness_.pattern().offsets[j]].diagonal().array(); };
  if (shift_ == 0.0)
    for (Index j = 0; j < system.size(); ++j)
      if (!system.isHeld(j)) shift_ = std::max(shift_, kFirstShift * diagonal(j).maxCoeff() / system.masses()[j]);
  for (Index j = 0; j < system.size(); ++j)
    if (!system.isHeld(j)) diagonal(j) += shift_ * system.masses()[j];
  passes_ += factor_.factorWork() / (kRate * system.size());
  const bool definite = factor_.factorize(stiffness_.values());
  shift_ *= definite ? kLower : kRaise;
  return definite;
}

// (K + c v v^T)^-1 by the formula of Sherman and Morrison.
void NewtonDescent::applyInverse(const System& system, const State& state, Eigen::VectorXd& vector) {
  const double passes = static_cast<double>(factor_.factorSize()) / (kPlaces * system.size());
  passes_ += passes;
  factor_.solveInPlace(vector);
  const double c = system.rankOneStiffness(state, rank_one_);
  if (!(c > 0.0)) return;
  const Eigen::Map<const Eigen::VectorXd> v(rank_one_.data()->data(), 3 * state.size());
  response_ = v;
  passes_ += passes;
  factor_.solveInPlace(response_);
  vector -= response_ * (c * v.dot(vector) / (1.0 + c * v.dot(response_)));
}

// (S + A) x = b with S symmetric, A skew [Concus and Golub 1976]. left_ = b - (S + A) x is found without products by S.
void NewtonDescent::solveWithSkew(const Problem& problem, const State& state) {
  const Eigen::Index size = direction_.size();
  found_.resize(state.size());
  product_.resize(state.size());
  Eigen::Map<Eigen::VectorXd> correction(found_.data()->data(), size);
  const Eigen::Map<const Eigen::VectorXd> product(product_.data()->data(), size);
  left_ = direction_;
  former_left_.setZero(size);
  solution_.setZero(size);
  former_solution_.setZero(size);
  double first = 0.0, before = 0.0, factor = 1.0;
  for (int k = 0; k < kMostSkew; ++k) {
    correction_ = left_;
    applyInverse(problem.system, state, correction_);
    const double squared = correction_.dot(left_);
    if (k == 0) first = squared;
    if (!(squared > kSkew * kSkew * first)) break;
    factor = k == 0 ? 1.0 : 1.0 / (1.0 + squared / (before * factor));
    before = squared;
    correction = correction_;
    problem.system.computeSkewProduct(problem.time, state, found_, product_);
    former_left_ = (1.0 - factor) * former_left_ - factor * product;
    former_left_.swap(left_);
    former_solution_ += factor * (correction_ + solution_ - former_solution_);
    former_solution_.swap(solution_);
  }
}

void NewtonDescent::solveFactored(const Problem& problem, const State& state) {
  if (problem.system.hasSkewStiffness()) {
    solveWithSkew(problem, state);
  } else {
    solution_ = direction_;
    applyInverse(problem.system, state, solution_);
  }
  if (solution_.allFinite()) direction_ = solution_;
}

void NewtonDescent::solveByProducts(const Problem& problem, const State& state) {
  const double fall = last_residual_ > 0.0 ? residual_ / last_residual_ : 1.0;
  const double enough = std::max(std::min(kLoosest, kForcing * fall * fall) * residual_, kOversolved * problem.enough);
  const auto solve = [&](model::Hessian hessian) {
    products_.prepare(problem.system, problem.time, state, problem.step, hessian, problem.weight);
    const bool is_positive = products_.solve(problem.system, gradient_, enough, interrupt_, found_);
    passes_ += 1.0 + products_.numProducts();
    return is_positive;
  };
  if (!is_indefinite_) is_indefinite_ = !solve(model::Hessian::kExact);
  if (is_indefinite_) solve(model::Hessian::kPositive);
  const Eigen::Map<const Eigen::VectorXd> found(found_.data()->data(), 3 * state.size());
  if (found.allFinite()) direction_ = found;
}

template <class Counts>
double NewtonDescent::findSlope(const Counts& counts) const {
  double slope = 0.0;
  for (Index i = 0; i < static_cast<Index>(gradient_.size()); ++i)
    if (counts(i)) slope += gradient_[i].dot(direction_.segment<3>(3 * i));
  return slope;
}

double NewtonDescent::residualOfOthers(const Problem& problem) const {
  double residual = 0.0;
  for (std::size_t i = 0; i < gradient_.size(); ++i)
    if (!stopped_.contains(problem.system, static_cast<Index>(i)) && !(gradient_[i].norm() <= problem.rounding[i]))
      residual = std::max(residual, gradient_[i].norm());
  return residual;
}

const std::vector<Index>& NewtonDescent::stop(const System& system, const Points& positions) {
  reached_ = positions;
  for (Index i = 0; i < system.size(); ++i)
    if (!system.isHeld(i)) reached_[i] += direction_.segment<3>(3 * i);
  const std::vector<Index>& stopped = system.motionLimit()->limit(positions, reached_, false);
  stopped_.addStopped(*system.motionLimit(), stopped);
  return stopped;
}

// Points that are stopped short keep their motion along the obstacle. If that leads uphill, the direction of their parts is
// shortened, until it stops no point.
bool NewtonDescent::shorten(const System& system, const Points& positions) {
  const Index n = static_cast<Index>(positions.size());
  stopped_.begin(system);
  const std::vector<Index>& stopped = stop(system, positions);
  if (stopped.empty()) return false;
  solution_ = direction_;
  for (const Index i : stopped) direction_.segment<3>(3 * i) = reached_[i] - positions[i];
  if (findSlope([&](Index i) { return stopped_.contains(system, i); }) < 0.0) return true;
  double share = 1.0;
  for (int halving = 0; halving <= kMaxShortenings; ++halving) {
    share = halving < kMaxShortenings ? 0.5 * share : 0.0;
    direction_ = solution_;
    for (Index i = 0; i < n; ++i)
      if (stopped_.contains(system, i)) direction_.segment<3>(3 * i) *= share;
    if (stop(system, positions).empty()) break;
  }
  return true;
}

NewtonDescent::Step NewtonDescent::descend(const Problem& problem, State& state, bool tentative) {
  const Index n = state.size();
  const System& system = problem.system;

  // The direction.
  direction_.resize(3 * n);
  for (Index i = 0; i < n; ++i) direction_.segment<3>(3 * i) = -gradient_[i];
  if (system.hasStiffnessProducts()) {
    solveByProducts(problem, state);
  } else if (is_factor_good_ && residual_ * residual_ < problem.enough * last_residual_) {
    solveFactored(problem, state);  // leaves about as much of the gradient as it left before: so it is the last one
  } else {
    const bool exact = is_factor_good_ = factorize(problem, state, model::Hessian::kExact);
    projected_in_a_row_ = exact || !tentative ? 0 : projected_in_a_row_ + 1;
    if (exact || (projected_in_a_row_ > kPatience && factorizeShifted(system)) ||
        factorize(problem, state, model::Hessian::kPositive))
      solveFactored(problem, state);
  }
  last_residual_ = residual_;
  const auto all = [](Index) { return true; };
  double slope = findSlope(all);
  const bool is_shortened = system.motionLimit() && slope < 0.0 && shorten(system, state.positions);
  if (is_shortened) {
    is_factor_good_ = false;
    slope = findSlope(all);
  }
  Step taken = slope < 0.0 ? search(problem, slope, tentative, state) : Step{0.0, false};
  taken.is_shortened = is_shortened;
  if (system.motionLimit() && taken.fraction < kHardly) moveByParts(problem, state, taken);
  return taken;
}

// Parts that lead to no descent must not hold up the others: each moves by itself.
void NewtonDescent::moveByParts(const Problem& problem, State& state, Step& taken) {
  const System& system = problem.system;
  if (!taken.is_shortened) stopped_.begin(system);
  const std::vector<Index>& parts = stopped_.parts();
  taken.is_shortened = true;
  listed_parts_.clear();
  for (Index i = 0; i < state.size(); ++i)
    if (!system.isHeld(i) && !stopped_.contains(system, i)) listed_parts_.push_back(parts[i]);
  std::sort(listed_parts_.begin(), listed_parts_.end());
  listed_parts_.erase(std::unique(listed_parts_.begin(), listed_parts_.end()), listed_parts_.end());
  if (listed_parts_.size() > kMostParts) return;
  solution_ = direction_;
  for (const Index part : listed_parts_) {
    direction_ = solution_;
    for (Index i = 0; i < state.size(); ++i)
      if (parts[i] != part) direction_.segment<3>(3 * i).setZero();
    const double slope = findSlope([&](Index i) { return parts[i] == part; });
    if (!(slope < 0.0) || !stop(system, state.positions).empty()) continue;
    const Step step = search(problem, slope, false, state);
    if (step.fraction < kHardly) stopped_.addPart(part);
    taken.fraction = std::max(taken.fraction, step.fraction);
    taken.drop += step.drop;
  }
}

// The line search. Rounding of the energy must not hide the last decrease: a change within rounding counts as descending.
NewtonDescent::Step NewtonDescent::search(const Problem& problem, double slope, bool tentative, State& state) {
  start_ = state.positions;
  const double before = merit(problem, state);
  const double rounding = kEnergyRounding * std::abs(before);
  double fraction = 1.0;
  for (int halving = 0; halving < kMaxHalvings; ++halving, fraction *= 0.5) {
    for (Index i = 0; i < state.size(); ++i)
      if (!problem.system.isHeld(i)) state.positions[i] = start_[i] + fraction * direction_.segment<3>(3 * i);
    const double after = merit(problem, state);
    is_factor_good_ = is_factor_good_ && halving == 0 && after <= before + rounding;
    if (after <= before + kArmijo * fraction * slope + rounding) return {fraction, false, false, before - after};
    if (tentative && halving == 0 && std::isfinite(after)) return {fraction, true, false, before - after};
  }
  state.positions = start_;
  return {0.0, false};
}

double NewtonDescent::remainderWork(const Points& before, const State& state) const {
  double work = 0.0;
  for (Index i = 0; i < state.size(); ++i) work += remainder_[i].dot(state.positions[i] - before[i]);
  return work;
}

double NewtonDescent::unbalancedWork(const Points& before, const State& state, double enough) const {
  double work = 0.0;
  for (Index i = 0; i < state.size(); ++i)
    if (gradient_[i].norm() <= enough) work += gradient_[i].dot(state.positions[i] - before[i]);
  return work;
}

}  // namespace deformable_surface::solve
