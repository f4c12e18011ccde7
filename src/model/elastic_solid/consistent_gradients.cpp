// The correction of fitted gradients: Lagrange's multipliers l (n x 3) of Gauss's theorem make it
//   d_ij = w_ij / V_i (l_j - l_i - grad l_i (X_j - X_i)),
// grad l_i by the same fit, so that linear motions stay exact; the theorem is then S l = r, S symmetric, at least zero, and
// zero for linear l alone.
#include "deformable_surface/base/parallel.h"
#include "deformable_surface/model/elastic_solid/fitted_gradients.h"

#include <Eigen/Eigenvalues>

#include <algorithm>
#include <cmath>

namespace deformable_surface::model {
namespace {

constexpr Index kBlock = 256;
constexpr int kMostIterations = 400;  // the remaining error is then smooth and small
constexpr double kEnough = 1e-11;     // of the first residual: rounding
// Of the least squared residual: if there is a solution, residuals vary by less from one iteration to the next.
constexpr double kAstray = 1e6;

using Map3 = Eigen::Map<const Vec3>;

const double* pairAt(const PairFit& fit, Index k) { return fit.m.data() + 4 * static_cast<std::size_t>(k); }

// grad l of every point.
void fitAll(const PairFit& fit, const Points& l, std::vector<Mat3>& gradient) {
  parallelFor(fit.size(), kBlock, [&](Index begin, Index end) {
    for (Index i = begin; i < end; ++i) {
      Mat3 A = Mat3::Zero();
      for (Index k = fit.pairs.offsets[i]; k < fit.pairs.offsets[i + 1]; ++k)
        A += (l[fit.pairs.items[k]] - l[i]) * Map3(pairAt(fit, k)).transpose();
      gradient[i] = A * fit.inverseAt(i);
    }
  });
}

// S l: each pair contributes its residuals at both ends.
void applyResiduals(const PairFit& fit, const Points& l, std::vector<Mat3>& gradient, Points& product) {
  fitAll(fit, l, gradient);
  parallelFor(fit.size(), kBlock, [&](Index begin, Index end) {
    for (Index i = begin; i < end; ++i) {
      Vec3 sum = Vec3::Zero();
      for (Index k = fit.pairs.offsets[i]; k < fit.pairs.offsets[i + 1]; ++k) {
        const Index j = fit.pairs.items[k];
        const double* m = pairAt(fit, k);
        sum -= 2.0 * m[3] * (l[j] - l[i]) - (gradient[i] + gradient[j]) * Map3(m);
      }
      product[i] = sum;
    }
  });
}

double dot(const Points& a, const Points& b) {
  return parallelSum(static_cast<Index>(a.size()), kBlock, [&](Index begin, Index end) {
    double sum = 0.0;
    for (Index i = begin; i < end; ++i) sum += a[i].dot(b[i]);
    return sum;
  });
}

double largestOf(const Points& vectors) {
  double largest = 0.0;
  for (const Vec3& v : vectors) largest = std::max(largest, v.norm());
  return largest;
}

// The points of each body, connected by pairs.
std::vector<std::vector<Index>> findBodies(const Lists& pairs) {
  std::vector<std::vector<Index>> bodies;
  std::vector<char> is_found(pairs.size(), 0);
  for (Index first = 0; first < pairs.size(); ++first) {
    if (is_found[first]) continue;
    is_found[first] = 1;
    std::vector<Index> body{first};
    for (std::size_t k = 0; k < body.size(); ++k)
      for (const Index* j = pairs.begin(body[k]); j != pairs.end(body[k]); ++j)
        if (!is_found[*j]) {
          is_found[*j] = 1;
          body.push_back(*j);
        }
    bodies.push_back(std::move(body));
  }
  return bodies;
}

// Changes r on the boundary of a body, in proportion to the area there and linearly in space, until sum and moment vanish.
void balance(const Points& points, const Points& outside, const std::vector<Index>& body, Points& r) {
  Vec3 middle = Vec3::Zero();
  double total = 0.0;
  for (const Index j : body) {
    total += outside[j].norm();
    middle += outside[j].norm() * points[j];
  }
  if (!(total > 0.0)) return;
  middle /= total;
  Eigen::Matrix4d moments = Eigen::Matrix4d::Zero();
  Eigen::Matrix<double, 4, 3> wanted = Eigen::Matrix<double, 4, 3>::Zero();
  const auto linear = [&](Index j) {
    Vec4 values;
    values << 1.0, points[j] - middle;
    return values;
  };
  for (const Index j : body) {
    moments += outside[j].norm() * linear(j) * linear(j).transpose();
    wanted -= linear(j) * r[j].transpose();
  }
  const Eigen::Matrix<double, 4, 3> change = moments.completeOrthogonalDecomposition().solve(wanted);
  for (const Index j : body) r[j] += outside[j].norm() * change.transpose() * linear(j);
}

}  // namespace

ConsistentGradients makeConsistent(const Points& points, const PairFit& fit, const PointCells& cells) {
  const Index n = fit.size();
  ConsistentGradients result;
  result.row.assign(3 * fit.pairs.items.size(), 0.0);
  result.own.assign(n, Vec3::Zero());
  const auto fittedAt = [&](Index i, Index k) { return Vec3(fit.inverseAt(i) * Map3(pairAt(fit, k))); };

  // The residual of the theorem: a_j - sum_i V_i g_i(j). In the fit of j, i is found by the opposite pair.
  Points r = cells.outside;
  for (Index i = 0; i < n; ++i)
    for (Index k = fit.pairs.offsets[i]; k < fit.pairs.offsets[i + 1]; ++k) {
      const Vec3 g = cells.volume[i] * fittedAt(i, k);
      r[fit.pairs.items[k]] -= g;
      r[i] += g;
    }
  for (const std::vector<Index>& body : findBodies(fit.pairs)) balance(points, cells.outside, body, r);

  // Conjugate gradients. If points have too few neighbours the theorem cannot hold and the iteration diverges: the best iterate
  // is kept.
  Points l(n, Vec3::Zero()), best = l, p = r, product(n);
  std::vector<Mat3> gradient(n);
  const double first = dot(r, r), first_largest = largestOf(r);
  double squared = first, least = first, least_largest = first_largest;
  for (int iteration = 0; iteration < kMostIterations && squared > kEnough * kEnough * first && squared < kAstray * least;
       ++iteration) {
    applyResiduals(fit, p, gradient, product);
    const double curvature = dot(p, product);
    if (!(curvature > 0.0)) break;
    const double step = squared / curvature;
    for (Index i = 0; i < n; ++i) {
      l[i] += step * p[i];
      r[i] -= step * product[i];
    }
    const double next = dot(r, r);
    for (Index i = 0; i < n; ++i) p[i] = r[i] + next / squared * p[i];
    squared = next;
    if (squared < least) {
      least = squared;
      least_largest = largestOf(r);
      best = l;
    }
  }
  l = best;
  result.residual = first_largest > 0.0 ? least_largest / first_largest : 0.0;

  fitAll(fit, l, gradient);
  for (Index i = 0; i < n; ++i) {
    const Mat3 inverse = fit.inverseAt(i);
    // If neighbours span no volume the correction stays in the space that they span.
    const Mat3 span =
        fit.rank[i] == 3 ? Mat3(Mat3::Identity()) : Mat3(inverse * inverse.completeOrthogonalDecomposition().pseudoInverse());
    for (Index k = fit.pairs.offsets[i]; k < fit.pairs.offsets[i + 1]; ++k) {
      const Index j = fit.pairs.items[k];
      const double* m = pairAt(fit, k);
      const Vec3 rest = m[3] * (l[j] - l[i]) - gradient[i] * Map3(m);
      const Vec3 g = inverse * Map3(m) + span * rest / cells.volume[i];
      Eigen::Map<Vec3>(result.row.data() + 3 * static_cast<std::size_t>(k)) = g;
      result.own[i] += g;
    }
  }
  return result;
}

}  // namespace deformable_surface::model
