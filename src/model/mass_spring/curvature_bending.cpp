#include "deformable_surface/model/mass_spring/curvature_bending.h"

#include "deformable_surface/base/parallel.h"
#include "deformable_surface/base/simd.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>

#include "moment_balance.h"

namespace deformable_surface::model {
namespace {

constexpr Index kBlock = 2048;  // points per parallel block: distribution costs little beside it
constexpr Index kBatch = 4;     // groups of four points: their rows stay in the first-level cache between the two passes
constexpr Index kSlots = CurvatureBending::kFitPoints + 1;  // with the point itself

// |t_1 x t_2|, the present area of a unit area at rest, below which a point counts as crushed, see the header.
constexpr double kCrushed = 0.1;

// Four points at a time, one coordinate in one vector.
struct Moments {
  Double4 t1[3], t2[3], b11[3], b12[3], b22[3];  // first the derivatives of the positions,
  Double4 change[3];                             // then n . b_ab - II0_ab,
  Double4 second[3], first[2];                   // then the weights of the second and first derivative rows in the force
};

// t_a and b_ab: the sums of rows times positions.
DEFORMABLE_SURFACE_INLINE void sumDerivatives(const Index* neighbors, const double* rows, const double* positions, Moments& m) {
  Double4 x[kSlots][4];
  for (Index r = 0; r < kSlots; ++r) {
    for (int lane = 0; lane < 4; ++lane) load(positions + neighbors[4 * r + lane], x[r][lane]);
    transpose(x[r][0], x[r][1], x[r][2], x[r][3]);
  }
  // Two loops, so that the sums fit the registers.
  Double4 t1[3]{}, t2[3]{};
  for (Index r = 0; r < kSlots; ++r) {
    Double4 g1, g2;
    load(rows + 20 * r, g1);
    load(rows + 20 * r + 4, g2);
    for (int c = 0; c < 3; ++c) {
      t1[c] += g1 * x[r][c];
      t2[c] += g2 * x[r][c];
    }
  }
  Double4 b11[3]{}, b12[3]{}, b22[3]{};
  for (Index r = 0; r < kSlots; ++r) {
    Double4 c11, c12, c22;
    load(rows + 20 * r + 8, c11);
    load(rows + 20 * r + 12, c12);
    load(rows + 20 * r + 16, c22);
    for (int c = 0; c < 3; ++c) {
      b11[c] += c11 * x[r][c];
      b12[c] += c12 * x[r][c];
      b22[c] += c22 * x[r][c];
    }
  }
  for (int c = 0; c < 3; ++c) {
    m.t1[c] = t1[c];
    m.t2[c] = t2[c];
    m.b11[c] = b11[c];
    m.b12[c] = b12[c];
    m.b22[c] = b22[c];
  }
}

DEFORMABLE_SURFACE_INLINE void multiply(const Double4* a, const Double4* b, Double4& dot) {
  dot = a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

DEFORMABLE_SURFACE_INLINE void multiplyCross(const Double4* a, const Double4* b, Double4* cross) {
  cross[0] = a[1] * b[2] - a[2] * b[1];
  cross[1] = a[2] * b[0] - a[0] * b[2];
  cross[2] = a[0] * b[1] - a[1] * b[0];
}

using Mask4 = decltype(Double4{} < Double4{});

// Moments and normals of four points, of crushed ones as in the header.
DEFORMABLE_SURFACE_INLINE void findMoments(const double* constants, double poisson_ratio, Moments& m, Double4* n,
                                           Mask4& is_crushed) {
  Double4 area, weight, rest11, rest12, rest22;
  multiplyCross(m.t1, m.t2, n);
  multiply(n, n, area);
  const Double4 softened = (area + kCrushed * kCrushed) * (0.5 / kCrushed);
  takeRoots(area);
  is_crushed = area < kCrushed;
  const Double4 inverse = 1.0 / (is_crushed ? softened : area);
  for (int c = 0; c < 3; ++c) n[c] *= inverse;
  n[3] = Double4{};
  load(constants, weight);
  load(constants + 4, rest11);
  load(constants + 8, rest12);
  load(constants + 12, rest22);
  multiply(n, m.b11, m.change[0]);
  multiply(n, m.b12, m.change[1]);
  multiply(n, m.b22, m.change[2]);
  m.change[0] -= rest11;
  m.change[1] -= rest12;
  m.change[2] -= rest22;
  m.second[0] = weight * (m.change[0] + poisson_ratio * m.change[2]);
  m.second[1] = 2.0 * (1.0 - poisson_ratio) * weight * m.change[1];  // 12 and 21
  m.second[2] = weight * (m.change[2] + poisson_ratio * m.change[0]);
  // M^ab Gamma^c_ab = t^c . (M^ab b_ab) with the dual basis t^1 = t_2 x n / |t_1 x t_2|, t^2 = n x t_1 / |t_1 x t_2|.
  Double4 p[3], turned[3];
  for (int c = 0; c < 3; ++c) p[c] = inverse * (m.second[0] * m.b11[c] + m.second[1] * m.b12[c] + m.second[2] * m.b22[c]);
  multiplyCross(m.t2, n, turned);
  multiply(turned, p, m.first[0]);
  multiplyCross(n, m.t1, turned);
  multiply(turned, p, m.first[1]);
}

// The contribution -M^ab c^ab + M^ab Gamma^c_ab g^c for each neighbour.
DEFORMABLE_SURFACE_INLINE void spreadMoments(const double* rows, const Moments& m, double* along) {
  for (Index r = 0; r < kSlots; ++r) {
    Double4 g1, g2, c11, c12, c22;
    load(rows + 20 * r, g1);
    load(rows + 20 * r + 4, g2);
    load(rows + 20 * r + 8, c11);
    load(rows + 20 * r + 12, c12);
    load(rows + 20 * r + 16, c22);
    store(m.first[0] * g1 + m.first[1] * g2 - m.second[0] * c11 - m.second[1] * c12 - m.second[2] * c22, along + 4 * r);
  }
}

// The groups from begin to end. Crushed points get no normal, hence no force here. Returns whether there are any.
DEFORMABLE_SURFACE_WIDE bool computeMoments(Index begin, Index end, const Index* neighbors, const double* rows,
                                            const double* constants, double poisson_ratio, const double* positions, double* along,
                                            double* normals) {
  Moments moments[kBatch];
  bool any_crushed = false;
  for (Index batch = begin; batch < end; batch += kBatch) {
    const Index batch_end = batch + kBatch < end ? batch + kBatch : end;
    for (Index g = batch; g < batch_end; ++g)
      sumDerivatives(neighbors + 4 * kSlots * g, rows + 20 * kSlots * g, positions, moments[g - batch]);
    for (Index g = batch; g < batch_end; ++g) {
      Double4 n[4], weight;
      Mask4 is_crushed;
      findMoments(constants + 16 * g, poisson_ratio, moments[g - batch], n, is_crushed);
      for (int c = 0; c < 3; ++c) n[c] = is_crushed ? Double4{} : n[c];
      load(constants + 16 * g, weight);
      is_crushed &= weight > 0.0;  // false without a fit
      any_crushed |= is_crushed[0] || is_crushed[1] || is_crushed[2] || is_crushed[3];
      transpose(n[0], n[1], n[2], n[3]);
      for (int lane = 0; lane < 4; ++lane) store(n[lane], normals + 16 * g + 4 * lane);
    }
    for (Index g = batch; g < batch_end; ++g) spreadMoments(rows + 20 * kSlots * g, moments[g - batch], along + 4 * kSlots * g);
  }
  return any_crushed;
}

// The energy of the groups from begin to end, J.
DEFORMABLE_SURFACE_WIDE double sumEnergies(Index begin, Index end, const Index* neighbors, const double* rows,
                                           const double* constants, double poisson_ratio, const double* positions) {
  Double4 sum{};
  for (Index g = begin; g < end; ++g) {
    Moments m;
    Double4 normals[4];
    Mask4 is_crushed;
    sumDerivatives(neighbors + 4 * kSlots * g, rows + 20 * kSlots * g, positions, m);
    findMoments(constants + 16 * g, poisson_ratio, m, normals, is_crushed);
    for (int k = 0; k < 3; ++k) sum += 0.5 * m.second[k] * m.change[k];
  }
  return (sum[0] + sum[1]) + (sum[2] + sum[3]);
}

// Adds to each point the forces of the fits that use it. users: two items per fit; forces: (n x 3).
DEFORMABLE_SURFACE_WIDE void gatherForces(Index begin, Index end, const Index* offsets, const Index* users, const double* along,
                                          const double* normals, double* forces) {
  for (Index j = begin; j < end; ++j) {
    Double4 sum{};
    for (Index u = offsets[j]; u < offsets[j + 1]; u += 2) {
      Double4 normal;
      load(normals + users[u + 1], normal);
      sum += along[users[u]] * normal;
    }
    for (int c = 0; c < 3; ++c) forces[3 * j + c] += sum[c];
  }
}

// Thirds of the triangles, m^2.
std::vector<double> findAreas(const PlateRest& plate, const CurvatureFits& fits) {
  std::vector<double> areas(plate.points.size(), 0.0);
  for (const WeightedTriangle& t : plate.triangles) {
    const auto& [a, b, c] = t.corner;
    if (!fits.has(a) || !fits.has(b) || !fits.has(c)) continue;
    const double area = 0.5 * (plate.points[b] - plate.points[a]).cross(plate.points[c] - plate.points[a]).norm();
    for (const Index corner : t.corner) areas[corner] += t.weight * area / 3.0;
  }
  return areas;
}

}  // namespace

CurvatureBending::CurvatureBending(const PlateRest& plate, const std::vector<char>& held, const std::vector<ClampEdge>& edges)
    : poisson_ratio_(plate.poisson_ratio) {
  ClampedPlate clamped = clampPlate(plate, held, edges);
  CurvatureFits fits = fitCurvatures(clamped);
  const std::vector<double> areas = findAreas(clamped.plate, fits);
  const Index size = static_cast<Index>(areas.size());
  weight_.assign(size, 0.0);
  for (Index i = 0; i < size; ++i) {
    if (fits.has(i))
      weight_[i] = plate.rigidity * areas[i] * (plate.shares.empty() ? 1.0 : clamped.plate.shares[i]);
    else if (!clamped.isClamped(i))
      ++num_without_fit_;
  }
  balanceMoments(clamped, areas, fits);
  neighbors_ = std::move(fits.points);
  rows_ = std::move(fits.rows);
  edge_points_ = std::move(clamped.edge_points);
  num_hinged_ = clamped.num_hinged;
  rest_curvature_.assign(size, Vec3::Zero());
  for (Index i = 0; i < size; ++i)
    if (weight_[i] != 0.0) rest_curvature_[i] = shapeAt(i, sumDerivatives(wholeFit(i), plate.points.data()->data(), 3)).change;
  prepareForceLoop();
}

void CurvatureBending::prepareForceLoop() {
  const Index n = neighbors_.size(), padded = (n + 3) / 4 * 4;
  group_neighbors_.assign(kSlots * padded, 0);
  group_rows_.assign(5 * kSlots * padded, 0.0);
  group_constants_.assign(4 * padded, 0.0);
  along_.resize(kSlots * padded);
  normals_.resize(4 * padded);
  for (Index i = 0; i < n; ++i) {
    const Index group = i / 4, lane = i % 4;
    const double constants[4] = {weight_[i], rest_curvature_[i][0], rest_curvature_[i][1], rest_curvature_[i][2]};
    for (int k = 0; k < 4; ++k) group_constants_[16 * group + 4 * k + lane] = constants[k];
    if (weight_[i] == 0.0) continue;
    for (Index slot = 0; slot < neighbors_.count(i); ++slot) {
      const Index r = neighbors_.offsets[i] + slot, place = 4 * (kSlots * group + slot) + lane;
      const double row[5] = {rows_[r].first[0], rows_[r].first[1], rows_[r].second[0], rows_[r].second[1], rows_[r].second[2]};
      for (int k = 0; k < 5; ++k) group_rows_[5 * (place - lane) + 4 * k + lane] = row[k];
      group_neighbors_[place] = 4 * neighbors_.items[r];
    }
  }
  riders_.clear();
  for (std::size_t e = 0; e < edge_points_.size(); ++e)
    for (const Index point : edge_points_[e].points) riders_.emplace_back(point, numPoints() + static_cast<Index>(e));
  std::sort(riders_.begin(), riders_.end());
  // The forces of the fits, grouped by points: counted first, then placed.
  users_.offsets.assign(n + 1, 0);
  const auto forEachUse = [&](const auto& visit) {
    for (Index i = 0; i < n; ++i)
      for (Index slot = 0; weight_[i] != 0.0 && slot < neighbors_.count(i); ++slot)
        visit(neighbors_.begin(i)[slot], 4 * (kSlots * (i / 4) + slot) + i % 4, 4 * i);
  };
  forEachUse([&](Index user, Index, Index) { users_.offsets[user + 1] += 2; });
  for (Index i = 0; i < n; ++i) users_.offsets[i + 1] += users_.offsets[i];
  users_.items.resize(users_.offsets.back());
  std::vector<Index> next(users_.offsets.begin(), users_.offsets.end() - 1);
  forEachUse([&](Index user, Index along, Index normal) {
    users_.items[next[user]++] = along;
    users_.items[next[user]++] = normal;
  });
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

// f_j = -sum_i n_i (M_i^ab c^ab_ij - M_i^ab Gamma^c_ab g^c_ij), M = D A [(1 - nu) k + nu tr(k) I], k = n . b - II0: by the fits,
// then gathered by the points, and from those on edges by what they ride on.
void CurvatureBending::addForces(PaddedPoints& positions, Points& forces) const {
  appendEdge(positions);
  std::atomic<bool> any_crushed{false};
  parallelFor(static_cast<Index>(group_constants_.size() / 16), kBlock / 4, [&](Index begin, Index end) {
    if (computeMoments(begin, end, group_neighbors_.data(), group_rows_.data(), group_constants_.data(), poisson_ratio_,
                       positions.data(), along_.data(), normals_.data()))
      any_crushed.store(true, std::memory_order_relaxed);
  });
  parallelFor(numPoints(), kBlock, [&](Index begin, Index end) {
    gatherForces(begin, end, users_.offsets.data(), users_.items.data(), along_.data(), normals_.data(), forces.data()->data());
  });
  const Index num_points = numPoints();
  for (Index e = 0; e < static_cast<Index>(edge_points_.size()); ++e) {
    Vec3 force = Vec3::Zero();
    gatherForces(0, 1, &users_.offsets[num_points + e], users_.items.data(), along_.data(), normals_.data(), force.data());
    for (int c = 0; c < 3; ++c) forces[edge_points_[e].points[c]] += edge_points_[e].weights[c] * force;
  }
  positions.shorten(num_points);
  if (any_crushed) addCrushedForces(positions.data(), forces);
}

// The few crushed points, which got no force with the others, one by one.
void CurvatureBending::addCrushedForces(const double* positions, Points& forces) const {
  for (Index i = 0; i < neighbors_.size(); ++i) {
    const double* normal = &normals_[4 * i];
    if (weight_[i] == 0.0 || normal[0] != 0.0 || normal[1] != 0.0 || normal[2] != 0.0) continue;
    const WholeFit fit = wholeFit(i);
    const CrushedShape s = crushedShapeAt(i, sumDerivatives(fit, positions, 4));
    const Vec3 moment = weight_[i] * momentOf(s.change);
    for (Index r = 0; r < fit.size; ++r) forces[fit.points[r]] -= s.changeBy(fit.rows[r]) * moment;
  }
}

double CurvatureBending::energy(PaddedPoints& positions) const {
  appendEdge(positions);
  const double sum = parallelSum(static_cast<Index>(group_constants_.size() / 16), kBlock / 4, [&](Index begin, Index end) {
    return sumEnergies(begin, end, group_neighbors_.data(), group_rows_.data(), group_constants_.data(), poisson_ratio_,
                       positions.data());
  });
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
double CurvatureBending::boundRate(const State& state, const std::vector<double>& masses) const {
  rate_.assign(masses.size(), 0.0);
  const Mat3 root = momentRoot();
  for (Index i = 0; i < neighbors_.size(); ++i) {
    if (weight_[i] == 0.0) continue;
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
    const double largest = weight_[i] * matrix.norm();
    for (Index r = 0; r < fit.size; ++r) rate_[fit.points[r]] += largest;
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
