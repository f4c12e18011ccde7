#include "newton.h"

#include <algorithm>
#include <cmath>

namespace deformable_surface::solve {
namespace {

constexpr double kArmijo = 1e-4;       // share of the predicted decrease that must be reached
constexpr int kMaxHalvings = 30;       // beyond it the direction is rounding
constexpr double kRegularization = 1e-9;  // of the largest diagonal, where neither weight nor stiffness resists a motion

}  // namespace

double NewtonDescent::evaluate(const Problem& problem, State& state) {
  const Index n = state.size();
  const System& system = problem.system;
  for (Index i = 0; i < n; ++i)
    state.velocities[i] = problem.step > 0.0 ? Vec3((state.positions[i] - problem.before[i]) / problem.step) : Vec3::Zero();
  system.computeForces(problem.time, state, forces_);
  system.computeConservativeForces(problem.time, state, conservative_);
  gradient_.resize(n);
  remainder_.resize(n);
  double residual = 0.0;
  for (Index i = 0; i < n; ++i) {
    remainder_[i] = forces_[i] - conservative_[i];
    gradient_[i].setZero();
    if (system.isHeld(i)) continue;
    gradient_[i] = problem.weight[i] * (state.positions[i] - problem.target[i]) - forces_[i];
    residual = std::max(residual, gradient_[i].norm());
  }
  return residual;
}

double NewtonDescent::merit(const Problem& problem, const State& state) const {
  double sum = problem.system.potentialEnergy(problem.time, state);
  for (Index i = 0; i < state.size(); ++i) {
    if (problem.system.isHeld(i)) continue;
    sum += 0.5 * problem.weight[i] * (state.positions[i] - problem.target[i]).squaredNorm();
    sum -= remainder_[i].dot(state.positions[i] - start_[i]);
  }
  return sum;
}

bool NewtonDescent::factorize(const Problem& problem, const State& state, model::Hessian hessian) {
  const Index n = state.size();
  const System& system = problem.system;
  stiffness_.begin(n);
  system.addStiffness(problem.time, state, problem.step, hessian, stiffness_);
  for (Index i = 0; i < n; ++i) stiffness_.add(i, i, problem.weight[i] * Mat3::Identity());
  matrix_ = stiffness_.finish();
  // Held points become identity rows.
  double largest = 0.0;
  for (Eigen::Index c = 0; c < matrix_.cols(); ++c)
    for (Eigen::SparseMatrix<double>::InnerIterator it(matrix_, c); it; ++it) {
      const bool held = system.isHeld(static_cast<Index>(it.row() / 3)) || system.isHeld(static_cast<Index>(it.col() / 3));
      if (held) it.valueRef() = it.row() == it.col() ? 1.0 : 0.0;
      else if (it.row() == it.col()) largest = std::max(largest, it.value());
    }
  for (Eigen::Index c = 0; c < matrix_.cols(); ++c) matrix_.coeffRef(c, c) += kRegularization * largest;
  if (stiffness_.patternChanged()) solver_.analyzePattern(matrix_);
  solver_.factorize(matrix_);
  return solver_.info() == Eigen::Success && solver_.vectorD().minCoeff() > 0.0;
}

double NewtonDescent::descend(const Problem& problem, State& state) {
  const Index n = state.size();
  const System& system = problem.system;

  // The direction.
  direction_.resize(3 * n);
  for (Index i = 0; i < n; ++i) direction_.segment<3>(3 * i) = -gradient_[i];
  if (factorize(problem, state, model::Hessian::kExact) || factorize(problem, state, model::Hessian::kPositive)) {
    Eigen::VectorXd solution = solver_.solve(direction_);
    // (K + c v v^T)^-1 by the formula of Sherman and Morrison.
    const double c = system.rankOneStiffness(state, rank_one_);
    if (c > 0.0) {
      const Eigen::Map<const Eigen::VectorXd> v(rank_one_.data()->data(), 3 * n);
      const Eigen::VectorXd response = solver_.solve(v);
      solution -= response * (c * v.dot(solution) / (1.0 + c * v.dot(response)));
    }
    if (solution.allFinite()) direction_ = solution;
  }
  double slope = 0.0;
  for (Index i = 0; i < n; ++i) slope += gradient_[i].dot(direction_.segment<3>(3 * i));
  if (!(slope < 0.0)) return 0.0;

  // The line search. Rounding of the energy must not hide the last decrease: within it the step counts as descending.
  start_ = state.positions;
  const double before = merit(problem, state);
  const double rounding = 1e-14 * std::abs(before);
  double fraction = 1.0;
  for (int halving = 0; halving < kMaxHalvings; ++halving, fraction *= 0.5) {
    for (Index i = 0; i < n; ++i)
      if (!system.isHeld(i)) state.positions[i] = start_[i] + fraction * direction_.segment<3>(3 * i);
    const double after = merit(problem, state);
    if (after <= before + kArmijo * fraction * slope + rounding) return fraction;
  }
  state.positions = start_;
  return 0.0;
}

double NewtonDescent::remainderWork(const Points& before, const State& state) const {
  double work = 0.0;
  for (Index i = 0; i < state.size(); ++i) work += remainder_[i].dot(state.positions[i] - before[i]);
  return work;
}

}  // namespace deformable_surface::solve
