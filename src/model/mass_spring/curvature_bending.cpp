#include "deformable_surface/model/mass_spring/curvature_bending.h"

#include "deformable_surface/base/parallel.h"
#include "deformable_surface/base/simd.h"
#include "deformable_surface/model/mass_spring/incidence.h"

#include <Eigen/QR>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>

namespace deformable_surface::model {
namespace {

constexpr Index kBlock = 512;
constexpr Index kFitPoints = 16;   // neighbours in the fit: about two rings, enough for one-sided fits at edges
constexpr double kReach = 1.05;    // kernel support over the farthest neighbour's distance, so that it still counts
constexpr double kRankTolerance = 1e-3;  // smallest pivot over the largest for a fit to count as determined

// How often each of b_11, b_12, b_22 stands in the sum over a and b.
const Vec3 kMultiplicity(1.0, 2.0, 1.0);

// Sums of rows times positions: t_1, t_2, b_11, b_12, b_22 of one point. rows: (5 x count) weights; positions: padded to four.
using Double4 = double __attribute__((vector_size(4 * sizeof(double))));

DEFORMABLE_SURFACE_WIDE void sumDerivatives(Index count, const Index* neighbors, const double* rows, const double* positions,
                                            CurvatureBending::Derivatives& result) {
  Double4 sum[5] = {};
  for (Index r = 0; r < count; ++r) {
    Double4 x;
    std::memcpy(&x, positions + 4 * neighbors[r], sizeof x);
    for (int k = 0; k < 5; ++k) sum[k] += rows[5 * r + k] * x;
  }
  std::memcpy(result.value, sum, sizeof sum);
}

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
  std::vector<Index> owner;  // the point whose fit each row belongs to
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
      owner.push_back(i);
    }
  }
  users_ = groupByPoint(n, uses);
  for (Index r : users_.items) {
    user_rows_.push_back(rows_[r]);
    user_owner_.push_back(owner[r]);
  }
  State at_rest{rest, {}};
  for (Index i = 0; i < n; ++i) rest_curvature_[i] = shapeAt(i, at_rest).change;
}

CurvatureBending::Shape CurvatureBending::shapeAt(Index i, const State& state) const {
  Derivatives d{};
  for (Index r = neighbors_.offsets[i]; r < neighbors_.offsets[i + 1]; ++r) {
    const Vec3& x = state.positions[neighbors_.items[r]];
    const double* weight = rows_[r].first.data();
    for (int k = 0; k < 5; ++k)
      for (int c = 0; c < 3; ++c) d.value[k][c] += weight[k] * x[c];
  }
  return shapeOf(i, d);
}

CurvatureBending::Shape CurvatureBending::shapeOf(Index i, const Derivatives& d) const {
  using Map = Eigen::Map<const Vec3>;
  const Map t1(d.value[0]), t2(d.value[1]), b11(d.value[2]), b12(d.value[3]), b22(d.value[4]);
  Shape s;
  const Vec3 cross = t1.cross(t2);
  const double area = cross.norm();
  if (!(area > 0.0)) {  // tangents collapsed: no normal, hence no force
    s = {Vec3::Zero(), -rest_curvature_[i], Vec3::Zero(), {Vec3::Zero(), Vec3::Zero()}, Eigen::Matrix<double, 2, 3>::Zero()};
    return s;
  }
  s.normal = cross / area;
  s.curvature = Vec3(s.normal.dot(b11), s.normal.dot(b12), s.normal.dot(b22));
  s.change = s.curvature - rest_curvature_[i];
  s.dual[0] = t2.cross(s.normal) / area;
  s.dual[1] = s.normal.cross(t1) / area;
  for (int c = 0; c < 2; ++c) s.christoffel.row(c) << s.dual[c].dot(b11), s.dual[c].dot(b12), s.dual[c].dot(b22);
  return s;
}

void CurvatureBending::pad(const State& state) const {
  const Index n = neighbors_.size();
  padded_.resize(4 * n);
  for (Index i = 0; i < n; ++i)
    for (int c = 0; c < 3; ++c) padded_[4 * i + c] = state.positions[i][c];
}

CurvatureBending::Shape CurvatureBending::shapeOfPadded(Index i) const {
  Derivatives derivatives;
  const Index first = neighbors_.offsets[i];
  sumDerivatives(neighbors_.count(i), &neighbors_.items[first], rows_[first].first.data(), padded_.data(), derivatives);
  return shapeOf(i, derivatives);
}

void CurvatureBending::addForces(const State& state, Points& forces) const {
  const Index n = neighbors_.size();
  pad(state);
  // The moment of every point.
  parallelFor(n, kBlock, [&](Index begin, Index end) {
    for (Index i = begin; i < end; ++i) {
      if (weight_[i] == 0.0) {
        moment_[i] = Moment{};
        continue;
      }
      const Shape s = shapeOfPadded(i);
      Eigen::Map<Vec3>(moment_[i].normal) = s.normal;
      const Vec3 second = weight_[i] * kMultiplicity.cwiseProduct(s.change);
      Eigen::Map<Vec3>(moment_[i].second) = second;
      Eigen::Map<Vec2>(moment_[i].first) = s.christoffel * second;
    }
  });
  // f_j = -sum_i n_i (M_i^ab c^ab_ij - M_i^ab Gamma^c_ab g^c_ij), gathered by the points.
  parallelFor(n, kBlock, [&](Index begin, Index end) {
    for (Index j = begin; j < end; ++j) {
      Vec3 sum = Vec3::Zero();
      for (Index u = users_.offsets[j]; u < users_.offsets[j + 1]; ++u) {
        const Moment& m = moment_[user_owner_[u]];
        const Row& row = user_rows_[u];
        const double along = m.second[0] * row.second[0] + m.second[1] * row.second[1] + m.second[2] * row.second[2] -
                             m.first[0] * row.first[0] - m.first[1] * row.first[1];
        for (int c = 0; c < 3; ++c) sum[c] -= along * m.normal[c];
      }
      forces[j] += sum;
    }
  });
}

double CurvatureBending::energy(const State& state) const {
  pad(state);
  return parallelSum(neighbors_.size(), kBlock, [&](Index begin, Index end) {
    double sum = 0.0;
    for (Index i = begin; i < end; ++i) {
      if (weight_[i] == 0.0) continue;
      const Vec3 change = shapeOfPadded(i).change;
      sum += 0.5 * weight_[i] * change.dot(kMultiplicity.cwiseProduct(change));
    }
    return sum;
  });
}

// With k_ab = n . b_ab - II0_ab and M = D A k (each component as often as it stands in the sum), the Hessian is the sum of
//   D A dk_ab dk_ab,           dk_ab = n . (db_ab - Gamma^c_ab dt_c)                    (Gauss-Newton), and
//   M_ab d2(n . b_ab) = -2 (n . dt_c) (t^c . dp) - M_ab (n . b_ab) (t^c . t^d) (n . dt_c) (n . dt_d),  dp = M_ab (db_ab - Gamma^d_ab dt_d).
void CurvatureBending::addStiffness(const State& state, Hessian hessian, BlockSparse& stiffness) const {
  std::array<Vec3, kFitPoints + 1> change;   // of k_ab by the normal motion of each neighbour
  std::array<double, kFitPoints + 1> along;  // dp by the motion of each neighbour
  for (Index i = 0; i < neighbors_.size(); ++i) {
    if (weight_[i] == 0.0) continue;
    const Shape shape = shapeAt(i, state);
    const Vec3& n = shape.normal;
    const Mat3 project = n * n.transpose();
    const Vec3 moment = weight_[i] * kMultiplicity.cwiseProduct(shape.change);
    const double pull = moment.dot(shape.curvature);
    Mat2 metric;
    metric << shape.dual[0].squaredNorm(), shape.dual[0].dot(shape.dual[1]), shape.dual[0].dot(shape.dual[1]), shape.dual[1].squaredNorm();
    const Index begin = neighbors_.offsets[i], end = neighbors_.offsets[i + 1];
    for (Index r = begin; r < end; ++r) {
      change[r - begin] = rows_[r].second - shape.christoffel.transpose() * rows_[r].first;
      along[r - begin] = moment.dot(change[r - begin]);
    }
    for (Index j = begin; j < end; ++j)
      for (Index k = begin; k <= j; ++k) {
        double normal = weight_[i] * change[j - begin].dot(kMultiplicity.cwiseProduct(change[k - begin]));
        Mat3 block = Mat3::Zero();
        if (hessian == Hessian::kExact) {
          const Vec2 gj = rows_[j].first, gk = rows_[k].first;
          normal -= pull * gj.dot(metric * gk);
          const Vec3 tj = along[k - begin] * (gj[0] * shape.dual[0] + gj[1] * shape.dual[1]);
          const Vec3 tk = along[j - begin] * (gk[0] * shape.dual[0] + gk[1] * shape.dual[1]);
          block = -n * tj.transpose() - tk * n.transpose();
        }
        block += normal * project;
        stiffness.add(neighbors_.items[j], neighbors_.items[k], block);
      }
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
