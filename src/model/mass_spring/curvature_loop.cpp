#include "deformable_surface/model/mass_spring/curvature_loop.h"

#include "deformable_surface/base/parallel.h"
#include "deformable_surface/base/simd.h"

#include <atomic>

namespace deformable_surface::model {
namespace {

constexpr Index kBlock = 256;  // points per parallel block: distribution costs little beside it
constexpr Index kBatch = 4;    // groups of four points: their rows stay in the first-level cache between the two passes
constexpr Index kSlots = CurvatureLoop::kSlots;
constexpr double kCrushed = CurvatureLoop::kCrushed;

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

}  // namespace

CurvatureLoop::CurvatureLoop(const Lists& points, const std::vector<CurvatureRow>& rows, const std::vector<double>& weights,
                             const std::vector<Vec3>& rest, double poisson_ratio)
    : poisson_ratio_(poisson_ratio) {
  const Index n = points.size(), padded = (n + 3) / 4 * 4;
  neighbors_.assign(kSlots * padded, 0);
  rows_.assign(5 * kSlots * padded, 0.0);
  constants_.assign(4 * padded, 0.0);
  along_.resize(kSlots * padded);
  normals_.resize(4 * padded);
  for (Index i = 0; i < n; ++i) {
    const Index group = i / 4, lane = i % 4;
    const double constants[4] = {weights[i], rest[i][0], rest[i][1], rest[i][2]};
    for (int k = 0; k < 4; ++k) constants_[16 * group + 4 * k + lane] = constants[k];
    if (weights[i] == 0.0) continue;
    for (Index slot = 0; slot < points.count(i); ++slot) {
      const Index r = points.offsets[i] + slot, place = 4 * (kSlots * group + slot) + lane;
      const double row[5] = {rows[r].first[0], rows[r].first[1], rows[r].second[0], rows[r].second[1], rows[r].second[2]};
      for (int k = 0; k < 5; ++k) rows_[5 * (place - lane) + 4 * k + lane] = row[k];
      neighbors_[place] = 4 * points.items[r];
    }
  }
  // The forces of the fits, grouped by points: counted first, then placed.
  users_.offsets.assign(n + 1, 0);
  const auto forEachUse = [&](const auto& visit) {
    for (Index i = 0; i < n; ++i)
      for (Index slot = 0; weights[i] != 0.0 && slot < points.count(i); ++slot)
        visit(points.begin(i)[slot], 4 * (kSlots * (i / 4) + slot) + i % 4, 4 * i);
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

bool CurvatureLoop::computeMoments(const PaddedPoints& positions) const {
  std::atomic<bool> any_crushed{false};
  parallelFor(numGroups(), kBlock / 4, [&](Index begin, Index end) {
    if (model::computeMoments(begin, end, neighbors_.data(), rows_.data(), constants_.data(), poisson_ratio_, positions.data(),
                              along_.data(), normals_.data()))
      any_crushed.store(true, std::memory_order_relaxed);
  });
  return any_crushed;
}

void CurvatureLoop::addForces(Index num_points, Points& forces) const {
  parallelFor(num_points, kBlock, [&](Index begin, Index end) {
    gatherForces(begin, end, users_.offsets.data(), users_.items.data(), along_.data(), normals_.data(), forces.data()->data());
  });
}

Vec3 CurvatureLoop::findForce(Index point) const {
  Vec3 force = Vec3::Zero();
  gatherForces(0, 1, &users_.offsets[point], users_.items.data(), along_.data(), normals_.data(), force.data());
  return force;
}

double CurvatureLoop::energy(const PaddedPoints& positions) const {
  return parallelSum(numGroups(), kBlock / 4, [&](Index begin, Index end) {
    return sumEnergies(begin, end, neighbors_.data(), rows_.data(), constants_.data(), poisson_ratio_, positions.data());
  });
}

}  // namespace deformable_surface::model
