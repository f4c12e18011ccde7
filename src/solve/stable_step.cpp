#include "deformable_surface/solve/stable_step.h"

#include <Eigen/Eigenvalues>

#include <algorithm>
#include <cmath>
#include <limits>

namespace deformable_surface::solve {
namespace {

constexpr int kLanczosSteps = 30;  // the largest eigenvalue of meshes is then known to about a percent, and bounded by the residual

// Largest eigenvalue of D K D (D = 1 / sqrt(mass), zero on held points), plus the residual that bounds its error.
double largestEigenvalue(const Eigen::SparseMatrix<double>& lower, const Eigen::VectorXd& scale) {
  const Eigen::Index n = scale.size();
  Eigen::VectorXd v(n), w(n), previous = Eigen::VectorXd::Zero(n);
  // A start that has a part of every mode and is always the same.
  std::uint32_t seed = 12345u;
  for (Eigen::Index i = 0; i < n; ++i) {
    seed = seed * 1664525u + 1013904223u;
    v[i] = scale[i] > 0.0 ? 0.5 + static_cast<double>(seed >> 8) / (1u << 24) : 0.0;
    if ((seed >> 5) & 1u) v[i] = -v[i];
  }
  const double norm = v.norm();
  if (!(norm > 0.0)) return 0.0;
  v /= norm;
  std::vector<double> alpha, beta;
  for (int k = 0; k < kLanczosSteps; ++k) {
    w = scale.cwiseProduct(lower.selfadjointView<Eigen::Lower>() * scale.cwiseProduct(v));
    if (k > 0) w -= beta.back() * previous;
    alpha.push_back(w.dot(v));
    w -= alpha.back() * v;
    beta.push_back(w.norm());
    if (!(beta.back() > 1e-12 * std::abs(alpha.front()))) break;
    previous = v;
    v = w / beta.back();
  }
  const int m = static_cast<int>(alpha.size());
  Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver;
  solver.computeFromTridiagonal(Eigen::Map<Eigen::VectorXd>(alpha.data(), m), Eigen::Map<Eigen::VectorXd>(beta.data(), std::max(0, m - 1)));
  return solver.eigenvalues()[m - 1] + beta.back() * std::abs(solver.eigenvectors()(m - 1, m - 1));
}

}  // namespace

double StableStep::estimate(double time, const State& state, const System& system) {
  const System::Bounds bounds = system.bounds(time, state);
  const Index n = system.size();
  stiffness_.begin(n);
  system.addStiffness(time, state, 0.0, model::Hessian::kPositive, stiffness_);
  Eigen::VectorXd scale(3 * n);
  for (Index i = 0; i < n; ++i)
    scale.segment<3>(3 * i).setConstant(system.isHeld(i) ? 0.0 : 1.0 / std::sqrt(system.masses()[i]));
  // What the matrix leaves out (loads and parts without one) only enters Gershgorin's bound; where the matrix is empty it decides alone.
  const double measured = std::sqrt(std::max(0.0, largestEigenvalue(stiffness_.finish(), scale)));
  const double w = measured > 0.0 ? std::min(measured, bounds.frequency) : bounds.frequency;
  if (!(w > 0.0)) return bounds.damping_rate > 0.0 ? 2.0 / bounds.damping_rate : std::numeric_limits<double>::infinity();
  const double z = 0.5 * bounds.damping_rate / w;
  return 2.0 / w * (std::sqrt(1.0 + z * z) - z);
}

}  // namespace deformable_surface::solve
