#include "product_solver.h"

#include <algorithm>
#include <cmath>

namespace deformable_surface::solve {
namespace {

constexpr int kMostProducts = 1000;  // far more than any matrix needs that the preconditioner knows anything of
constexpr double kLeast = 1e-8;      // of the first residual: about rounding; the next direction corrects the rest
// Of the largest stiffness of a point: for motions that neither weight nor stiffness resists.
constexpr double kRegularization = 1e-9;

Eigen::Map<Eigen::VectorXd> flatten(Points& points) {
  return {points.data()->data(), 3 * static_cast<Eigen::Index>(points.size())};
}

double findLargest(const Points& vectors) {
  double squared = 0.0;
  for (const Vec3& v : vectors) squared = std::max(squared, v.squaredNorm());
  return std::sqrt(squared);
}

}  // namespace

void ProductSolver::prepare(const System& system, double time, const State& state, double step, model::Hessian hessian,
                            const std::vector<double>& weight) {
  const Index n = system.size();
  system.prepareStiffness(state, hessian);
  loads_.begin(n);
  system.addStiffness(time, state, step, hessian, loads_);
  loads_.finish();
  has_load_stiffness_ =
      std::any_of(loads_.values().begin(), loads_.values().end(), [](const Mat3& block) { return !block.isZero(0.0); });
  if (known_weight_.empty()) {
    std::vector<std::pair<Index, Index>> pairs;
    for (const auto& coupling : system.couplings()) pairs.emplace_back(coupling.i, coupling.j);
    springs_.analyze(n, pairs);
    diagonal_.resize(n);
    off_diagonal_.resize(pairs.size());
    known_held_.resize(n);
  }
  diagonal_.assign(n, 0.0);
  for (const auto& coupling : system.couplings()) {
    diagonal_[coupling.i] += coupling.stiffness;
    diagonal_[coupling.j] += coupling.stiffness;
  }
  const double regular = kRegularization * *std::max_element(diagonal_.begin(), diagonal_.end());
  weight_.resize(n);
  for (Index i = 0; i < n; ++i) weight_[i] = weight[i] + regular;
  setSprings(system);
}

// Held points become identity rows. The springs stay if nothing has changed.
void ProductSolver::setSprings(const System& system) {
  const Index n = system.size();
  bool is_same = known_weight_ == weight_;
  for (Index i = 0; i < n && is_same; ++i) is_same = system.isHeld(i) == (known_held_[i] != 0);
  if (is_same) return;
  known_weight_ = weight_;
  for (Index i = 0; i < n; ++i) {
    known_held_[i] = system.isHeld(i);
    diagonal_[i] = system.isHeld(i) ? 1.0 : diagonal_[i] + weight_[i];
  }
  std::size_t k = 0;
  for (const auto& coupling : system.couplings())
    off_diagonal_[k++] = system.isHeld(coupling.i) || system.isHeld(coupling.j) ? 0.0 : -coupling.stiffness;
  springs_.setValues(diagonal_, off_diagonal_);
}

void ProductSolver::multiply(const System& system, const Points& v, Points& product) {
  const Index n = system.size();
  system.computeStiffnessProduct(v, product);
  if (has_load_stiffness_) {
    load_vector_ = Eigen::Map<const Eigen::VectorXd>(v.data()->data(), 3 * n);
    loads_.multiply(load_vector_, load_product_);
    for (Index i = 0; i < n; ++i)
      if (!system.isHeld(i)) product[i] += load_product_.segment<3>(3 * i);
    system.confine(product);
  }
  for (Index i = 0; i < n; ++i)
    if (!system.isHeld(i)) product[i] += weight_[i] * v[i];
}

bool ProductSolver::solve(const System& system, const Points& gradient, double enough, const std::atomic<bool>* interrupt,
                          Points& direction) {
  const Index n = system.size();
  residual_.resize(n);
  direction.assign(n, Vec3::Zero());
  for (Index i = 0; i < n; ++i) residual_[i] = system.isHeld(i) ? Vec3::Zero().eval() : (-gradient[i]).eval();
  springs_.apply(residual_, preconditioned_);
  along_ = preconditioned_;
  double size = flatten(residual_).dot(flatten(preconditioned_));
  const double least = kLeast * kLeast * size;
  num_products_ = 0;
  for (int k = 0; k < kMostProducts && size > least && findLargest(residual_) > enough && !(interrupt && *interrupt); ++k) {
    multiply(system, along_, product_);
    ++num_products_;
    const double resistance = flatten(along_).dot(flatten(product_));
    if (!(resistance > 0.0)) {
      if (k == 0) direction = along_;
      return false;
    }
    const double step = size / resistance;
    flatten(direction) += step * flatten(along_);
    flatten(residual_) -= step * flatten(product_);
    springs_.apply(residual_, preconditioned_);
    const double next = flatten(residual_).dot(flatten(preconditioned_));
    flatten(along_) = flatten(preconditioned_) + next / size * flatten(along_);
    size = next;
  }
  return true;
}

}  // namespace deformable_surface::solve
