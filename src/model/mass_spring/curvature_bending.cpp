#include "deformable_surface/model/mass_spring/curvature_bending.h"

#include "deformable_surface/base/parallel.h"
#include "deformable_surface/model/mass_spring/incidence.h"

#include <Eigen/QR>

#include <algorithm>
#include <cmath>

namespace deformable_surface::model {
namespace {

constexpr Index kBlock = 512;
constexpr Index kFitPoints = 16;   // neighbours in the fit: about two rings, enough for one-sided fits at edges
constexpr double kReach = 1.05;    // kernel support over the farthest neighbour's distance, so that it still counts
constexpr double kRankTolerance = 1e-3;  // smallest pivot over the largest for a fit to count as determined

// How often each of b_11, b_12, b_22 stands in the sum over a and b.
const Vec3 kMultiplicity(1.0, 2.0, 1.0);

// The nearest kFitPoints among the first, second and, if those are too few, third ring.
std::vector<Index> chooseFitPoints(Index i, const Points& rest, const Lists& ring) {
  std::vector<Index> found{i};
  std::size_t level = 0;
  for (int depth = 0; depth < 3 && (depth < 2 || static_cast<Index>(found.size()) <= kFitPoints); ++depth) {
    const std::size_t end = found.size();
    for (; level < end; ++level)
      for (const Index* j = ring.begin(found[level]); j != ring.end(found[level]); ++j)
        if (std::find(found.begin(), found.end(), *j) == found.end()) found.push_back(*j);
  }
  found.erase(found.begin());
  std::sort(found.begin(), found.end(), [&](Index a, Index b) {
    const double da = (rest[a] - rest[i]).squaredNorm(), db = (rest[b] - rest[i]).squaredNorm();
    return da != db ? da < db : a < b;
  });
  if (static_cast<Index>(found.size()) > kFitPoints) found.resize(kFitPoints);
  return found;
}

}  // namespace

CurvatureBending::CurvatureBending(const Points& rest, const Points& normals, const Lists& ring,
                                   const std::vector<double>& areas, double rigidity) {
  const Index n = static_cast<Index>(rest.size());
  neighbors_.offsets.assign(1, 0);
  rest_curvature_.assign(n, Vec3::Zero());
  weight_.assign(n, 0.0);
  moment_.resize(n);
  std::vector<std::pair<Index, Index>> uses;
  for (Index i = 0; i < n; ++i) {
    const std::vector<Index> fit = chooseFitPoints(i, rest, ring);
    const Index k = static_cast<Index>(fit.size());
    neighbors_.items.push_back(i);
    rows_.emplace_back(Row{Vec2::Zero(), Vec3::Zero()});
    if (k >= 5) {
      // The weighted quadratic in tangent coordinates scaled by the reach.
      const Vec3 e1 = normals[i].unitOrthogonal(), e2 = normals[i].cross(e1);
      const double reach = kReach * (rest[fit.back()] - rest[i]).norm();
      Eigen::Matrix<double, Eigen::Dynamic, 5> design(k, 5);
      Eigen::VectorXd root_weight(k);
      for (Index m = 0; m < k; ++m) {
        const Vec3 d = (rest[fit[m]] - rest[i]) / reach;
        const double a = d.dot(e1), b = d.dot(e2), q = 1.0 - d.squaredNorm();
        root_weight[m] = q;
        design.row(m) << a, b, 0.5 * a * a, a * b, 0.5 * b * b;
        design.row(m) *= q;
      }
      Eigen::ColPivHouseholderQR<Eigen::Matrix<double, Eigen::Dynamic, 5>> solver(design);
      const auto pivots = solver.matrixQR().diagonal().cwiseAbs();
      if (pivots.minCoeff() > kRankTolerance * pivots.maxCoeff()) {
        const Eigen::MatrixXd weights = root_weight.asDiagonal();
        const Eigen::Matrix<double, 5, Eigen::Dynamic> inverse = solver.solve(weights);
        Row own{Vec2::Zero(), Vec3::Zero()};
        for (Index m = 0; m < k; ++m) {
          const Row row{inverse.block<2, 1>(0, m) / reach, inverse.block<3, 1>(2, m) / (reach * reach)};
          own.first -= row.first;
          own.second -= row.second;
          neighbors_.items.push_back(fit[m]);
          rows_.push_back(row);
        }
        rows_[neighbors_.offsets.back()] = own;
        weight_[i] = rigidity * areas[i];
      } else {
        ++num_without_fit_;
      }
    } else {
      ++num_without_fit_;
    }
    neighbors_.offsets.push_back(static_cast<Index>(neighbors_.items.size()));
    for (Index r = neighbors_.offsets[i]; r < neighbors_.offsets[i + 1]; ++r) {
      uses.emplace_back(neighbors_.items[r], r);
      owner_.push_back(i);
    }
  }
  users_ = groupByPoint(n, uses);
  State at_rest{rest, {}};
  for (Index i = 0; i < n; ++i) rest_curvature_[i] = shapeAt(i, at_rest).change;
}

CurvatureBending::Shape CurvatureBending::shapeAt(Index i, const State& state) const {
  Vec3 t1 = Vec3::Zero(), t2 = Vec3::Zero(), b11 = Vec3::Zero(), b12 = Vec3::Zero(), b22 = Vec3::Zero();
  for (Index r = neighbors_.offsets[i]; r < neighbors_.offsets[i + 1]; ++r) {
    const Vec3& x = state.positions[neighbors_.items[r]];
    const Row& row = rows_[r];
    t1 += row.first[0] * x;
    t2 += row.first[1] * x;
    b11 += row.second[0] * x;
    b12 += row.second[1] * x;
    b22 += row.second[2] * x;
  }
  Shape s;
  const Vec3 cross = t1.cross(t2);
  const double area = cross.norm();
  if (!(area > 0.0)) {  // tangents collapsed: no normal, hence no force
    s.normal.setZero();
    s.christoffel.setZero();
    s.change = -rest_curvature_[i];
    return s;
  }
  s.normal = cross / area;
  s.change = Vec3(s.normal.dot(b11), s.normal.dot(b12), s.normal.dot(b22)) - rest_curvature_[i];
  // The dual basis: t^1 . t_1 = 1, t^1 . t_2 = 0 and so on.
  const Vec3 dual1 = t2.cross(s.normal) / area, dual2 = s.normal.cross(t1) / area;
  s.christoffel << dual1.dot(b11), dual1.dot(b12), dual1.dot(b22), dual2.dot(b11), dual2.dot(b12), dual2.dot(b22);
  return s;
}

void CurvatureBending::addForces(const State& state, Points& forces) const {
  const Index n = neighbors_.size();
  // The moment of every point.
  parallelFor(n, kBlock, [&](Index begin, Index end) {
    for (Index i = begin; i < end; ++i) {
      if (weight_[i] == 0.0) {
        moment_[i] = {Vec3::Zero(), Vec3::Zero(), Vec2::Zero()};
        continue;
      }
      const Shape s = shapeAt(i, state);
      moment_[i].normal = s.normal;
      moment_[i].second = weight_[i] * kMultiplicity.cwiseProduct(s.change);
      moment_[i].first = s.christoffel * moment_[i].second;
    }
  });
  // f_j = -sum_i n_i (M_i^ab c^ab_ij - M_i^ab Gamma^c_ab g^c_ij), gathered by the points.
  parallelFor(n, kBlock, [&](Index begin, Index end) {
    for (Index j = begin; j < end; ++j) {
      Vec3 sum = Vec3::Zero();
      for (const Index* r = users_.begin(j); r != users_.end(j); ++r) {
        const Moment& m = moment_[owner_[*r]];
        sum -= (m.second.dot(rows_[*r].second) - m.first.dot(rows_[*r].first)) * m.normal;
      }
      forces[j] += sum;
    }
  });
}

double CurvatureBending::energy(const State& state) const {
  return parallelSum(neighbors_.size(), kBlock, [&](Index begin, Index end) {
    double sum = 0.0;
    for (Index i = begin; i < end; ++i) {
      if (weight_[i] == 0.0) continue;
      const Vec3 change = shapeAt(i, state).change;
      sum += 0.5 * weight_[i] * change.dot(kMultiplicity.cwiseProduct(change));
    }
    return sum;
  });
}

void CurvatureBending::addStiffness(const State& state, BlockSparse& stiffness) const {
  std::vector<Vec3> s;
  for (Index i = 0; i < neighbors_.size(); ++i) {
    if (weight_[i] == 0.0) continue;
    const Shape shape = shapeAt(i, state);
    const Mat3 project = weight_[i] * shape.normal * shape.normal.transpose();
    // Derivative of n . b_ab by the normal motion of each neighbour.
    const Index begin = neighbors_.offsets[i], end = neighbors_.offsets[i + 1];
    s.clear();
    for (Index r = begin; r < end; ++r) s.push_back(rows_[r].second - shape.christoffel.transpose() * rows_[r].first);
    for (Index a = begin; a < end; ++a)
      for (Index b = begin; b <= a; ++b)
        stiffness.add(neighbors_.items[a], neighbors_.items[b],
                      s[a - begin].dot(kMultiplicity.cwiseProduct(s[b - begin])) * project);
  }
}

void CurvatureBending::addRowBounds(std::vector<double>& stiffness) const {
  for (Index i = 0; i < neighbors_.size(); ++i) {
    Vec3 sum = Vec3::Zero();
    for (Index r = neighbors_.offsets[i]; r < neighbors_.offsets[i + 1]; ++r) sum += rows_[r].second.cwiseAbs();
    for (Index r = neighbors_.offsets[i]; r < neighbors_.offsets[i + 1]; ++r)
      stiffness[neighbors_.items[r]] += weight_[i] * rows_[r].second.cwiseAbs().dot(kMultiplicity.cwiseProduct(sum));
  }
}

}  // namespace deformable_surface::model
