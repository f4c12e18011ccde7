#include "deformable_surface/model/mass_spring/curvature_bending.h"

#include "deformable_surface/base/parallel.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "balanced_plate.h"

namespace deformable_surface::model {
namespace {

constexpr double kCrushed = CurvatureLoop::kCrushed;
constexpr Index kBlock = 64;    // fits per task: tens of microseconds of work
constexpr Index kChunk = 4096;  // whose rates fit the stack and the nearest cache

}  // namespace

CurvatureBending::CurvatureBending(const PlateRest& plate, const std::vector<char>& held, const std::vector<ClampEdge>& edges)
    : CurvatureBending(balancePlate(clampPlate(plate, held, edges))) {}

CurvatureBending::CurvatureBending(const BalancedPlate& whole, const PlateRest& cut, const std::vector<char>& held,
                                   const std::vector<ClampEdge>& edges)
    : CurvatureBending(balanceNearCuts(whole, clampPlate(cut, held, edges))) {}

CurvatureBending::CurvatureBending(BalancedPlate&& balanced) : poisson_ratio_(balanced.clamped.plate.poisson_ratio) {
  const PlateRest& plate = balanced.clamped.plate;
  const Index size = static_cast<Index>(plate.points.size());
  weight_.assign(size, 0.0);
  for (Index i = 0; i < size; ++i) {
    if (balanced.fits.has(i))
      weight_[i] = plate.rigidity * balanced.areas[i] * (plate.shares.empty() ? 1.0 : plate.shares[i]);
    else if (!balanced.clamped.isClamped(i))
      ++num_without_fit_;
  }
  neighbors_ = std::move(balanced.fits.points);
  rows_ = std::move(balanced.rows);
  edge_points_ = std::move(balanced.clamped.edge_points);
  num_hinged_ = balanced.clamped.num_hinged;
  rest_curvature_.assign(size, Vec3::Zero());
  for (Index i = 0; i < size; ++i)
    if (weight_[i] != 0.0) rest_curvature_[i] = shapeAt(i, sumDerivatives(wholeFit(i), plate.points.data()->data(), 3)).change;
  prepareForceLoop();
}

void CurvatureBending::prepareForceLoop() {
  riders_.clear();
  for (std::size_t e = 0; e < edge_points_.size(); ++e)
    for (const Index point : edge_points_[e].points) riders_.emplace_back(point, numPoints() + static_cast<Index>(e));
  std::sort(riders_.begin(), riders_.end());
  loop_ = CurvatureLoop(neighbors_, rows_, weight_, rest_curvature_, poisson_ratio_);
}

CurvatureBending::WholeFit CurvatureBending::wholeFit(Index i) const {
  WholeFit fit;
  const auto add = [&](Index point, double share, const Row& row) {
    Index at = 0;
    while (at < fit.size && fit.points[at] != point) ++at;
    if (at == fit.size) {
      fit.points[fit.size] = point;
      fit.rows[fit.size++] = {Vec2::Zero(), Vec3::Zero()};
    }
    fit.rows[at].first += share * row.first;
    fit.rows[at].second += share * row.second;
  };
  const Index num_points = numPoints();
  for (Index r = neighbors_.offsets[i]; r < neighbors_.offsets[i + 1]; ++r) {
    const Index j = neighbors_.items[r];
    if (j < num_points)
      add(j, 1.0, rows_[r]);
    else
      for (int c = 0; c < 3; ++c) add(edge_points_[j - num_points].points[c], edge_points_[j - num_points].weights[c], rows_[r]);
  }
  return fit;
}

CurvatureBending::Derivatives CurvatureBending::sumDerivatives(const WholeFit& fit, const double* positions, Index stride) {
  Derivatives d{{Vec3::Zero(), Vec3::Zero()}, Mat3::Zero()};
  for (Index r = 0; r < fit.size; ++r) {
    const Eigen::Map<const Vec3> x(positions + stride * fit.points[r]);
    for (int c = 0; c < 2; ++c) d.t[c] += fit.rows[r].first[c] * x;
    for (int k = 0; k < 3; ++k) d.b.col(k) += fit.rows[r].second[k] * x;
  }
  return d;
}

CurvatureBending::Shape CurvatureBending::shapeAt(Index i, const Derivatives& d) const {
  Shape s;
  const Vec3 cross = d.t[0].cross(d.t[1]);
  const double area = cross.norm();
  s.normal = cross / area;
  s.curvature = d.b.transpose() * s.normal;
  s.change = s.curvature - rest_curvature_[i];
  s.dual[0] = d.t[1].cross(s.normal) / area;
  s.dual[1] = s.normal.cross(d.t[0]) / area;
  for (int c = 0; c < 2; ++c) s.christoffel.row(c) = s.dual[c].transpose() * d.b;
  return s;
}

Mat3 CurvatureBending::momentMatrix() const {
  Mat3 matrix;
  for (int k = 0; k < 3; ++k) matrix.col(k) = momentOf(Vec3::Unit(k));
  return matrix;
}

Mat3 CurvatureBending::momentRoot() const {
  const double even = std::sqrt(1.0 + poisson_ratio_), odd = std::sqrt(1.0 - poisson_ratio_);
  Mat3 root = Mat3::Zero();
  root(0, 0) = root(2, 2) = 0.5 * (even + odd);
  root(0, 2) = root(2, 0) = 0.5 * (even - odd);
  root(1, 1) = std::sqrt(2.0) * odd;
  return root;
}

bool CurvatureBending::isCrushed(const Derivatives& d) { return d.t[0].cross(d.t[1]).norm() < kCrushed; }

// With c = t_1 x t_2 and the softened length s = (|c|^2 + e^2) / (2 e): n = c / s and
//   dn = P dc, P = (1 - 2 c c / (|c|^2 + e^2)) / s.
CurvatureBending::CrushedShape CurvatureBending::crushedShapeAt(Index i, const Derivatives& d) const {
  const Vec3 cross = d.t[0].cross(d.t[1]);
  const double squares = cross.squaredNorm() + kCrushed * kCrushed, softened = 0.5 * squares / kCrushed;
  CrushedShape s;
  s.normal = cross / softened;
  s.change = d.b.transpose() * s.normal - rest_curvature_[i];
  for (int k = 0; k < 3; ++k) {
    const Vec3 b = d.b.col(k), turned = (b - 2.0 * cross.dot(b) / squares * cross) / softened;
    s.by_first[0].col(k) = d.t[1].cross(turned);
    s.by_first[1].col(k) = turned.cross(d.t[0]);
  }
  return s;
}

Mat3 CurvatureBending::CrushedShape::changeBy(const Row& row) const {
  return normal * row.second.transpose() + row.first[0] * by_first[0] + row.first[1] * by_first[1];
}

void CurvatureBending::appendEdge(PaddedPoints& positions) const {
  for (const EdgePoint& edge : edge_points_) {
    Vec3 place = Vec3::Zero();
    for (int c = 0; c < 3; ++c) place += edge.weights[c] * Eigen::Map<const Vec3>(positions.data() + 4 * edge.points[c]);
    positions.append(place);
  }
}

// By the fits and their points, then from the points on edges to the points that they follow.
void CurvatureBending::addForces(PaddedPoints& positions, Points& forces) const {
  const Index num_points = numPoints();
  appendEdge(positions);
  const bool any_crushed = loop_.computeMoments(positions);
  loop_.addForces(num_points, forces);
  for (std::size_t e = 0; e < edge_points_.size(); ++e) {
    const Vec3 force = loop_.findForce(num_points + static_cast<Index>(e));
    for (int c = 0; c < 3; ++c) forces[edge_points_[e].points[c]] += edge_points_[e].weights[c] * force;
  }
  positions.shorten(num_points);
  if (any_crushed) addCrushedForces(positions.data(), forces);
}

// The few crushed points, which got no force with the others, one by one.
void CurvatureBending::addCrushedForces(const double* positions, Points& forces) const {
  for (Index i = 0; i < neighbors_.size(); ++i) {
    if (weight_[i] == 0.0 || loop_.hasNormal(i)) continue;
    const WholeFit fit = wholeFit(i);
    const CrushedShape s = crushedShapeAt(i, sumDerivatives(fit, positions, 4));
    const Vec3 moment = weight_[i] * momentOf(s.change);
    for (Index r = 0; r < fit.size; ++r) forces[fit.points[r]] -= s.changeBy(fit.rows[r]) * moment;
  }
}

double CurvatureBending::energy(PaddedPoints& positions) const {
  appendEdge(positions);
  const double sum = loop_.energy(positions);
  positions.shorten(numPoints());
  return sum;
}

// With k_ab = n . b_ab - II0_ab and its moments M (each component as often as it stands in the sum), the Hessian is the sum of
//   dM_ab dk_ab,               dk_ab = n . (db_ab - Gamma^c_ab dt_c)                    (Gauss-Newton), and
//   M_ab d2(n . b_ab) = -2 (n . dt_c) (t^c . dp) - M_ab (n . b_ab) (t^c . t^d) (n . dt_c) (n . dt_d),
//   dp = M_ab (db_ab - Gamma^d_ab dt_d).
// For crushed points only the former part.
void CurvatureBending::addStiffness(const State& state, Hessian hessian, BlockSparse& stiffness) const {
  std::array<Vec3, 3 * (kFitPoints + 1)> change;   // of k_ab by the normal motion of each neighbour
  std::array<double, 3 * (kFitPoints + 1)> along;  // dp by the motion of each neighbour
  for (Index i = 0; i < neighbors_.size(); ++i) {
    if (weight_[i] == 0.0) continue;
    const WholeFit fit = wholeFit(i);
    const Derivatives d = sumDerivatives(fit, state.positions.data()->data(), 3);
    if (isCrushed(d)) {
      addCrushedStiffness(fit, weight_[i], crushedShapeAt(i, d), stiffness);
      continue;
    }
    const Shape shape = shapeAt(i, d);
    const Vec3& n = shape.normal;
    const Mat3 project = n * n.transpose();
    const Vec3 moment = weight_[i] * momentOf(shape.change);
    const double pull = moment.dot(shape.curvature);
    Mat2 metric;
    metric << shape.dual[0].squaredNorm(), shape.dual[0].dot(shape.dual[1]), shape.dual[0].dot(shape.dual[1]),
        shape.dual[1].squaredNorm();
    for (Index r = 0; r < fit.size; ++r) {
      change[r] = fit.rows[r].second - shape.christoffel.transpose() * fit.rows[r].first;
      along[r] = moment.dot(change[r]);
    }
    for (Index j = 0; j < fit.size; ++j)
      for (Index k = 0; k <= j; ++k) {
        double normal = weight_[i] * change[j].dot(momentOf(change[k]));
        Mat3 block = Mat3::Zero();
        if (hessian == Hessian::kExact) {
          const Vec2 gj = fit.rows[j].first, gk = fit.rows[k].first;
          normal -= pull * gj.dot(metric * gk);
          const Vec3 tj = along[k] * (gj[0] * shape.dual[0] + gj[1] * shape.dual[1]);
          const Vec3 tk = along[j] * (gk[0] * shape.dual[0] + gk[1] * shape.dual[1]);
          block = -n * tj.transpose() - tk * n.transpose();
        }
        block += normal * project;
        stiffness.add(fit.points[j], fit.points[k], block);
      }
  }
}

void CurvatureBending::addCrushedStiffness(const WholeFit& fit, double weight, const CrushedShape& shape,
                                           BlockSparse& stiffness) const {
  std::array<Mat3, 3 * (kFitPoints + 1)> change;
  for (Index r = 0; r < fit.size; ++r) change[r] = shape.changeBy(fit.rows[r]);
  const Mat3 moments = weight * momentMatrix();
  for (Index j = 0; j < fit.size; ++j)
    for (Index k = 0; k <= j; ++k) stiffness.add(fit.points[j], fit.points[k], change[j] * moments * change[k].transpose());
}

// x . K x is the sum of that of the fits, each at most its largest eigenvalue times x . M x over its own points. So no eigenvalue
// of the sum exceeds the maximum over points of the summed eigenvalues of the fits that use the point. The eigenvalue of a fit is
// that of the 3 x 3 matrix D A sum_j r(j) r(j)^T / m_j, which its Frobenius norm bounds; r = R dk with R^T R the matrix of the
// moments.
// Rates are found by all threads, a chunk of fits at a time, then added in the order of the fits.
double CurvatureBending::boundRate(const State& state, const std::vector<double>& masses) const {
  const Mat3 root = momentRoot();
  // By one fit: the norm of its stiffness over the masses.
  const auto findRate = [&](Index i) {
    const WholeFit fit = wholeFit(i);
    const Derivatives d = sumDerivatives(fit, state.positions.data()->data(), 3);
    Mat3 matrix = Mat3::Zero();
    if (isCrushed(d)) {
      const CrushedShape shape = crushedShapeAt(i, d);
      for (Index r = 0; r < fit.size; ++r) {
        const Mat3 change = shape.changeBy(fit.rows[r]) * root;
        matrix += change.transpose() * change / masses[fit.points[r]];
      }
    } else {
      const Shape shape = shapeAt(i, d);
      for (Index r = 0; r < fit.size; ++r) {
        const Vec3 change = root * (fit.rows[r].second - shape.christoffel.transpose() * fit.rows[r].first);
        matrix += change * change.transpose() / masses[fit.points[r]];
      }
    }
    return weight_[i] * matrix.norm();
  };
  const auto addRate = [&](Index i, double rate) {
    const Index num_points = numPoints();
    const bool has_edge = std::any_of(neighbors_.begin(i), neighbors_.end(i), [&](Index j) { return j >= num_points; });
    if (!has_edge) {
      for (const Index* j = neighbors_.begin(i); j != neighbors_.end(i); ++j) rate_[*j] += rate;
      return;
    }
    const WholeFit fit = wholeFit(i);
    for (Index r = 0; r < fit.size; ++r) rate_[fit.points[r]] += rate;
  };
  rate_.assign(masses.size(), 0.0);
  std::array<double, kChunk> rates;
  for (Index first = 0; first < neighbors_.size(); first += kChunk) {
    const Index size = std::min(kChunk, neighbors_.size() - first);
    parallelFor(size, kBlock, [&](Index begin, Index end) {
      for (Index k = begin; k < end; ++k) rates[k] = weight_[first + k] != 0.0 ? findRate(first + k) : 0.0;
    });
    for (Index k = 0; k < size; ++k)
      if (weight_[first + k] != 0.0) addRate(first + k, rates[k]);
  }
  return *std::max_element(rate_.begin(), rate_.end());
}

void CurvatureBending::addRowBounds(std::vector<double>& stiffness) const {
  const Mat3 moments = momentMatrix().cwiseAbs();
  for (Index i = 0; i < neighbors_.size(); ++i) {
    if (weight_[i] == 0.0) continue;
    const WholeFit fit = wholeFit(i);
    Vec3 sum = Vec3::Zero();
    for (Index r = 0; r < fit.size; ++r) sum += fit.rows[r].second.cwiseAbs();
    for (Index r = 0; r < fit.size; ++r)
      stiffness[fit.points[r]] += weight_[i] * fit.rows[r].second.cwiseAbs().dot(moments * sum);
  }
}

// Every spring is on the diagonal twice.
double CurvatureBending::sumSprings() const {
  double trace = 0.0;
  for (Index i = 0; i < neighbors_.size(); ++i)
    for (Index r = neighbors_.offsets[i]; r < neighbors_.offsets[i + 1]; ++r)
      trace += weight_[i] * rows_[r].second.dot(momentOf(rows_[r].second));
  return 0.5 * trace;
}

}  // namespace deformable_surface::model
