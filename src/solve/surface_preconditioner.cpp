#include "surface_preconditioner.h"

#include <algorithm>

namespace deformable_surface::solve {
namespace {

constexpr double kRegularization = 1e-9;  // of the largest diagonal: for surfaces without constraints

}  // namespace

bool SurfacePreconditioner::Part::hasPairsOf(const std::vector<System::Coupling>& others) const {
  return std::equal(pairs.begin(), pairs.end(), others.begin(), others.end(),
                    [](const auto& pair, const auto& spring) { return pair.first == spring.i && pair.second == spring.j; });
}

// Held points become identity rows. Reuses known results: the factor as it is, or the analysis or the whole of the other part.
bool SurfacePreconditioner::Part::factorize(const System& system, const Part* other) {
  const Index n = system.size();
  if (!hasPairsOf(springs)) {
    pairs.clear();
    pairs.reserve(springs.size());
    for (const System::Coupling& spring : springs) pairs.emplace_back(spring.i, spring.j);
    is_positive = false;
    if (other && other->pairs == pairs) {
      factor = other->factor;
      diagonal = other->diagonal;
      values = other->values;
      is_positive = other->is_positive;
    } else {
      factor.analyze(n, pairs);
    }
  }
  diagonal.swap(diagonal_before);
  values.swap(values_before);
  diagonal.assign(n, 0.0);
  values.resize(springs.size());
  for (std::size_t k = 0; k < springs.size(); ++k) {
    const auto [i, j, stiffness] = springs[k];
    diagonal[i] += stiffness;
    diagonal[j] += stiffness;
    values[k] = system.isHeld(i) || system.isHeld(j) ? 0.0 : -stiffness;
  }
  const double regular = kRegularization * *std::max_element(diagonal.begin(), diagonal.end());
  for (Index i = 0; i < n; ++i) diagonal[i] = system.isHeld(i) ? 1.0 : diagonal[i] + regular;
  if (is_positive && diagonal == diagonal_before && values == values_before) return true;
  return is_positive = factor.factorize(diagonal, values);
}

bool SurfacePreconditioner::prepare(const System& system, const State& state, double support) {
  if (!system.findCouplings(state, support, along_.springs, across_[used_].springs)) return false;
  if (!across_[used_].hasPairsOf(across_[used_].springs) && !across_[used_].pairs.empty()) {
    across_[1 - used_].springs.swap(across_[used_].springs);
    used_ = 1 - used_;
  }
  system.computeAreaVectors(state, normals_);
  for (Vec3& normal : normals_) {
    const double length = normal.norm();
    normal = length > 0.0 ? Vec3(normal / length) : Vec3::Zero();
  }
  if (!along_.factorize(system) || !across_[used_].factorize(system, &along_)) return false;
  are_alike_ = across_[used_].pairs == along_.pairs;
  return true;
}

void SurfacePreconditioner::apply(const System& system, const Eigen::VectorXd& force, Eigen::VectorXd& answer) {
  const Index n = system.size();
  rows_.resize(4 * static_cast<std::size_t>(n));
  const auto row = [&](Index i) { return Eigen::Map<Eigen::Vector4d>(rows_.data() + 4 * static_cast<std::size_t>(i)); };
  for (Index i = 0; i < n; ++i) {
    const Vec3 f = force.segment<3>(3 * i);
    const double across = f.dot(normals_[i]);
    row(i) << f - across * normals_[i], across;
  }
  if (are_alike_) {
    along_.factor.solveWith(across_[used_].factor, rows_);
  } else {
    tangential_.resize(n);
    normal_.resize(n);
    for (Index i = 0; i < n; ++i) {
      tangential_[i] = row(i).head<3>();
      normal_[i] = row(i)[3];
    }
    along_.factor.solve(tangential_, tangential_);
    across_[used_].factor.solve(normal_, normal_);
    for (Index i = 0; i < n; ++i) row(i) << tangential_[i], normal_[i];
  }
  answer.resize(3 * n);
  for (Index i = 0; i < n; ++i) {
    const Vec3 t = row(i).head<3>();
    answer.segment<3>(3 * i) = system.isHeld(i) ? Vec3(Vec3::Zero()) : Vec3(t + (row(i)[3] - t.dot(normals_[i])) * normals_[i]);
  }
}

}  // namespace deformable_surface::solve
