#include "deformable_surface/model/elastic_solid/fitted_gradients.h"

#include "deformable_surface/base/parallel.h"

#include <Eigen/Eigenvalues>

#include <algorithm>
#include <cmath>

namespace deformable_surface::model {
namespace {

constexpr Index kBlock = 256;
constexpr Index kNearest = 3;  // neighbours whose distances give the spacing: a corner of a lattice has as many
// Least spread of neighbours in a direction, squared, over that in their main one. With a spread of less than two hundredths, the
// error of the gradient along it grows more than fifty times.
constexpr double kLeastSpread = 4e-4;

struct Pair {
  Index i, j;
  double detour;
  bool operator<(const Pair& other) const { return i != other.i ? i < other.i : j < other.j; }
};

// Both directions of every listed pair, once each, ascending; for a pair listed by both ends the mean of the detours.
std::vector<Pair> listBothWays(const Lists& neighbors, const std::vector<double>& detours) {
  std::vector<Pair> both;
  both.reserve(2 * neighbors.items.size());
  for (Index i = 0; i < neighbors.size(); ++i)
    for (Index k = neighbors.offsets[i]; k < neighbors.offsets[i + 1]; ++k) {
      const double detour = detours.empty() ? 1.0 : detours[k];
      both.push_back({i, neighbors.items[k], detour});
      both.push_back({neighbors.items[k], i, detour});
    }
  std::sort(both.begin(), both.end());
  std::size_t kept = 0;
  for (std::size_t k = 0; k < both.size(); ++k) {
    const bool is_same = kept > 0 && both[kept - 1].i == both[k].i && both[kept - 1].j == both[k].j;
    if (is_same)
      both[kept - 1].detour = 0.5 * (both[kept - 1].detour + both[k].detour);
    else
      both[kept++] = both[k];
  }
  both.resize(kept);
  return both;
}

// The reach of each point: nearest distances vary from point to point, their means less.
std::vector<double> findReach(const Points& points, const Lists& neighbors, double share) {
  const Index n = neighbors.size();
  std::vector<double> nearest(n, 0.0), reach(n, 0.0);
  for (Index i = 0; i < n; ++i) {
    const Index count = std::min(kNearest, neighbors.count(i));
    for (Index k = 0; k < count; ++k) nearest[i] += (points[neighbors.begin(i)[k]] - points[i]).norm() / count;
  }
  for (Index i = 0; i < n; ++i) {
    double sum = nearest[i];
    for (const Index* j = neighbors.begin(i); j != neighbors.end(i); ++j) sum += nearest[*j];
    reach[i] = share * sum / (1 + neighbors.count(i));
  }
  return reach;
}

}  // namespace

Mat3 PairFit::inverseAt(Index i) const {
  const double* k = inverse.data() + 6 * static_cast<std::ptrdiff_t>(i);
  Mat3 matrix;
  matrix << k[0], k[1], k[2], k[1], k[3], k[4], k[2], k[4], k[5];
  return matrix;
}

PairFit fitPairs(const Points& points, const Lists& neighbors, const std::vector<double>& detours, double share) {
  const Index n = static_cast<Index>(points.size());
  const std::vector<double> reach = findReach(points, neighbors, share);
  PairFit fit;
  Index row = 0;
  for (const Pair& pair : listBothWays(neighbors, detours)) {
    while (row < pair.i) fit.pairs.offsets.push_back(static_cast<Index>(fit.pairs.items.size())), ++row;
    const double h = 0.5 * (reach[pair.i] + reach[pair.j]);
    const Vec3 X = points[pair.j] - points[pair.i];
    const double s = X.squaredNorm() / (h * h);
    if (!(s < 1.0) || !(pair.detour > 0.0)) continue;
    const double w = (1.0 - s) * (1.0 - s) * pair.detour / (h * h);
    fit.pairs.items.push_back(pair.j);
    for (int c = 0; c < 3; ++c) fit.m.push_back(w * X[c]);
    fit.m.push_back(w);
  }
  while (row < n) fit.pairs.offsets.push_back(static_cast<Index>(fit.pairs.items.size())), ++row;

  fit.inverse.assign(6 * static_cast<std::size_t>(n), 0.0);
  fit.rank.assign(n, 0);
  parallelFor(n, kBlock, [&](Index begin, Index end) {
    Eigen::SelfAdjointEigenSolver<Mat3> solver;
    for (Index i = begin; i < end; ++i) {
      Mat3 K = Mat3::Zero();
      for (Index k = fit.pairs.offsets[i]; k < fit.pairs.offsets[i + 1]; ++k) {
        const Vec3 X = points[fit.pairs.items[k]] - points[i];
        K += fit.m[4 * static_cast<std::size_t>(k) + 3] * X * X.transpose();
      }
      solver.compute(K);
      Mat3 inverse = Mat3::Zero();
      for (int c = 0; c < 3; ++c) {
        if (!(solver.eigenvalues()[c] > kLeastSpread * solver.eigenvalues()[2])) continue;
        inverse += solver.eigenvectors().col(c) * solver.eigenvectors().col(c).transpose() / solver.eigenvalues()[c];
        ++fit.rank[i];
      }
      if (fit.rank[i] == 3) inverse = K.inverse();
      double* to = fit.inverse.data() + 6 * static_cast<std::size_t>(i);
      to[0] = inverse(0, 0);
      to[1] = 0.5 * (inverse(0, 1) + inverse(1, 0));
      to[2] = 0.5 * (inverse(0, 2) + inverse(2, 0));
      to[3] = inverse(1, 1);
      to[4] = 0.5 * (inverse(1, 2) + inverse(2, 1));
      to[5] = inverse(2, 2);
    }
  });
  return fit;
}

}  // namespace deformable_surface::model
