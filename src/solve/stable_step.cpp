#include "deformable_surface/solve/stable_step.h"

#include <Eigen/Eigenvalues>

#include <algorithm>
#include <cmath>
#include <limits>

namespace deformable_surface::solve {
namespace {

constexpr int kLanczosSteps = 30;  // the largest eigenvalue of meshes is then known to about a percent, and bounded by the residual

// The stable step of a frequency w with a damping rate, both in 1/s; see the header.
double limit(double w, double rate) {
  if (!(w > 0.0)) return rate > 0.0 ? 2.0 / rate : std::numeric_limits<double>::infinity();
  const double z = 0.5 * rate / w;
  return 2.0 / w * (std::sqrt(1.0 + z * z) - z);
}

}  // namespace

// Largest eigenvalue of D K D (D = 1 / sqrt(mass), zero on held points), plus the residual that bounds its error.
double StableStep::largestEigenvalue() {
  const Eigen::Index n = scale_.size();
  // A start that has a part of every mode and is always the same.
  std::uint32_t seed = 12345u;
  v_.resize(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    seed = seed * 1664525u + 1013904223u;
    v_[i] = scale_[i] > 0.0 ? 0.5 + static_cast<double>(seed >> 8) / (1u << 24) : 0.0;
    if ((seed >> 5) & 1u) v_[i] = -v_[i];
  }
  const double norm = v_.norm();
  if (!(norm > 0.0)) return 0.0;
  v_ /= norm;
  // The tridiagonal matrix, on the stack.
  using Small = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::ColMajor, kLanczosSteps, kLanczosSteps>;
  Small tridiagonal = Small::Zero(kLanczosSteps, kLanczosSteps);
  double beta = 0.0;
  int m = 0;
  while (m < kLanczosSteps) {
    product_ = scale_.cwiseProduct(v_);
    stiffness_.multiply(product_, w_);
    w_ = scale_.cwiseProduct(w_);
    if (m > 0) {
      w_ -= beta * previous_;
      tridiagonal(m - 1, m) = tridiagonal(m, m - 1) = beta;
    }
    const double alpha = w_.dot(v_);
    tridiagonal(m, m) = alpha;
    ++m;
    w_ -= alpha * v_;
    beta = w_.norm();
    if (!(beta > 1e-12 * std::abs(tridiagonal(0, 0)))) break;
    previous_ = v_;
    v_ = w_ / beta;
  }
  const Eigen::SelfAdjointEigenSolver<Small> solver(tridiagonal.topLeftCorner(m, m));
  return solver.eigenvalues()[m - 1] + beta * std::abs(solver.eigenvectors()(m - 1, m - 1));
}

double StableStep::estimate(double time, const State& state, const System& system) {
  const double known = system.findStableStep(state);
  if (known > 0.0) return limit(std::sqrt(4.0 / (known * known) + system.loadStiffness(time, state)), system.dampingRate(time, state));
  const Index n = system.size();
  stiffness_.begin(n);
  system.addStiffness(time, state, 0.0, model::Hessian::kPositive, stiffness_);
  scale_.resize(3 * n);
  for (Index i = 0; i < n; ++i)
    scale_.segment<3>(3 * i).setConstant(system.isHeld(i) ? 0.0 : 1.0 / std::sqrt(system.masses()[i]));
  stiffness_.finish();
  double eigenvalue = std::max(0.0, largestEigenvalue());
  const double coefficient = system.rankOneStiffness(state, rank_one_);
  if (coefficient > 0.0)
    for (Index i = 0; i < n; ++i) eigenvalue += coefficient * rank_one_[i].squaredNorm() / system.masses()[i];
  return limit(std::sqrt(eigenvalue), system.dampingRate(time, state));
}

}  // namespace deformable_surface::solve
