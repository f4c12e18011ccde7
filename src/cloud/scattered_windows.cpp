#include "scattered_windows.h"

#include "deformable_surface/base/median.h"
#include "deformable_surface/base/parallel.h"
#include "deformable_surface/cloud/kd_tree.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

#include <algorithm>
#include <cmath>
#include <limits>

#include "noise_profile.h"

namespace deformable_surface::cloud {
namespace {

constexpr Index kBlock = 256;
constexpr Index kSampled = 2000;    // windows for the measurement of noise
constexpr Index kNoiseWindow = 32;  // points per window for a camera's noise
constexpr Index kNoiseWindows[] = {16, 32, 64, 128, 256};
// Residual variance of windows with twice the points over that of the smaller ones: equal for noise, four times as large for a
// surface that they bend over, 1.4 times for a degenerate one (a hair, a crumpled ball). It must also be small compared with the
// window's radius.
constexpr double kPlateau = 1.2, kThinnest = 0.25;
constexpr double kLayers = 2.2;                  // spread (noise_profile.h) below that of any noise
constexpr double kThickest = 0.31, kBall = 2.3;  // fraction of the radius, in windows of 64 points, and kurtosis
constexpr double kClean = 0.1;    // spacings: with less noise in the two smallest windows, larger ones are not examined
constexpr double kRegular = 1.5;  // ninth over first decile of the distances of the directions of pixels

// A plane through some points by least squares; the normal is unit.
struct Plane {
  Vec3 middle, normal;
  double sum;  // m^2, sum of the squared distances
};

Plane fitPlane(const Points& positions, const Index* begin, const Index* end) {
  Vec3 middle = Vec3::Zero();
  for (const Index* j = begin; j != end; ++j) middle += positions[*j] / static_cast<double>(end - begin);
  Mat3 spread = Mat3::Zero();
  for (const Index* j = begin; j != end; ++j) spread += (positions[*j] - middle) * (positions[*j] - middle).transpose();
  Eigen::SelfAdjointEigenSolver<Mat3> solver;
  solver.computeDirect(spread);
  return {middle, solver.eigenvectors().col(0), std::max(0.0, solver.eigenvalues()[0])};
}

// The nearest neighbours of every stride-th point, itself first.
std::vector<std::vector<Index>> sampleWindows(const Points& points, const KdTree& tree, Index count) {
  const Index n = static_cast<Index>(points.size()), stride = std::max(Index{1}, n / kSampled);
  std::vector<std::vector<Index>> windows((n + stride - 1) / stride);
  parallelFor(static_cast<Index>(windows.size()), kBlock / 8, [&](Index begin, Index end) {
    std::vector<Neighbor> near;
    for (Index w = begin; w < end; ++w) {
      tree.nearest(points[w * stride], count, near);
      for (const Neighbor& neighbor : near) windows[w].push_back(neighbor.index);
    }
  });
  return windows;
}

double findLastDistance(const Points& points, const std::vector<Index>& window) {
  return (points[window.back()] - points[window.front()]).norm();
}

// Residuals of the best quadratics over the planes of the windows: medians.
struct Level {
  double deviation = 0.0, kurtosis = 0.0, spread = 0.0, radius = 0.0;
};
Level measureLevel(const Points& positions, const KdTree& tree, Index count) {
  std::vector<double> variances, kurtoses, spreads, radii;
  for (const std::vector<Index>& window : sampleWindows(positions, tree, count)) {
    const Plane plane = fitPlane(positions, window.data(), window.data() + window.size());
    const Vec3 e1 = plane.normal.unitOrthogonal(), e2 = plane.normal.cross(e1);
    std::vector<Sample> samples;
    for (const Index j : window) {
      const Vec3 d = positions[j] - plane.middle;
      samples.push_back({Vec2(d.dot(e1), d.dot(e2)), d.dot(plane.normal)});
    }
    const Leftover leftover = measureLeftover(samples);
    if (!(leftover.variance >= 0.0)) continue;
    variances.push_back(leftover.variance);
    kurtoses.push_back(leftover.kurtosis);
    spreads.push_back(leftover.spread);
    radii.push_back(findLastDistance(positions, window));
  }
  if (variances.empty()) return {};
  return {std::sqrt(findMedian(std::move(variances))), findMedian(std::move(kurtoses)), findMedian(std::move(spreads)),
          findMedian(std::move(radii))};
}

// Whether directions are spaced as regularly as those of pixels.
bool areRegular(const Points& directions, const KdTree& tree) {
  std::vector<double> nearest;
  for (const std::vector<Index>& window : sampleWindows(directions, tree, 2))
    if (window.size() == 2) nearest.push_back(findLastDistance(directions, window));
  if (nearest.empty()) return false;
  std::sort(nearest.begin(), nearest.end());
  return nearest[nearest.size() / 10] > 0.0 && nearest[nearest.size() * 9 / 10] <= kRegular * nearest[nearest.size() / 10];
}

// Inverse distances along the directions from the eye; a plane is a linear function of the direction.
struct SeenWindows {
  const Points& directions;
  std::vector<double> values;  // 1/m
  NoiseProfile noise;

  struct Fit {
    Vec3 gradient = Vec3::Zero();
    double deviation = 0.0;  // of the noise there; 0: noise does not explain the window
  };

  Fit fit(const Index* begin, const Index* end, Index middle) const {
    Mat3 normal = Mat3::Zero();
    Vec3 right = Vec3::Zero();
    for (const Index* j = begin; j != end; ++j) {
      normal += directions[*j] * directions[*j].transpose();
      right += values[*j] * directions[*j];
    }
    const Fit fit{normal.ldlt().solve(right), noise.at(values[middle])};
    double sum = 0.0;
    for (const Index* j = begin; j != end; ++j) sum += std::pow(values[*j] - fit.gradient.dot(directions[*j]), 2);
    const double freedom = static_cast<double>(end - begin) - 3.0;
    const double most = fit.deviation * fit.deviation * findMostVariance(freedom);
    return sum <= most * freedom ? fit : Fit();
  }
  double measureMisfit(const Fit& fit, Index i) const { return fit.gradient.dot(directions[i]) - values[i]; }
  Vec3 move(const Fit& fit, Index i, const Vec3& position) const {
    const double there = fit.gradient.dot(directions[i]);
    return there > 0.0 ? Vec3(position + directions[i] * (1.0 / there - 1.0 / values[i])) : position;
  }
};

// Planes in space, for points with uniform noise.
struct SpaceWindows {
  const Points& positions;
  double deviation;  // m

  struct Fit {
    Vec3 middle = Vec3::Zero(), normal = Vec3::Zero();
    double deviation = 0.0;  // m; 0: noise does not explain the window
  };

  Fit fit(const Index* begin, const Index* end, Index) const {
    const Plane plane = fitPlane(positions, begin, end);
    const double freedom = static_cast<double>(end - begin) - 3.0;
    const double most = deviation * deviation * findMostVariance(freedom);
    return plane.sum <= most * freedom ? Fit{plane.middle, plane.normal, deviation} : Fit();
  }
  double measureMisfit(const Fit& fit, Index i) const { return (fit.middle - positions[i]).dot(fit.normal); }
  Vec3 move(const Fit& fit, Index i, const Vec3& position) const { return position + measureMisfit(fit, i) * fit.normal; }
};

// places: where the points of the windows are neighbours of each other.
template <class Windows>
void fitAll(const Windows& windows, const Points& places, Index count, FittedPoints& fitted) {
  const Index n = static_cast<Index>(places.size());
  const Lists neighbors = nearestNeighbors(places, std::min(count, n) - 1);
  std::vector<typename Windows::Fit> fits(n);
  parallelFor(n, kBlock, [&](Index begin, Index end) {
    std::vector<Index> members;
    for (Index j = begin; j < end; ++j) {
      members.assign(neighbors.begin(j), neighbors.end(j));
      members.push_back(j);
      fits[j] = windows.fit(members.data(), members.data() + members.size(), j);
    }
  });
  const double unexplained = parallelSum(n, kBlock, [&](Index begin, Index end) {
    double missing = 0.0;
    for (Index i = begin; i < end; ++i) {
      double best = std::numeric_limits<double>::infinity(), nearest = best;
      Index chosen = -1, least = -1;
      const auto offer = [&](Index j, double offset) {
        if (!(fits[j].deviation > 0.0)) return;
        const double misfit = windows.measureMisfit(fits[j], i) / fits[j].deviation;
        const double cost = offset + 0.25 * misfit * misfit;
        if (std::abs(misfit) < nearest) {
          nearest = std::abs(misfit);
          least = j;
        }
        if (!(std::abs(misfit) < kOutlier && cost < best)) return;
        best = cost;
        chosen = j;
      };
      offer(i, 0.0);
      for (const Index* j = neighbors.begin(i); j != neighbors.end(i); ++j) {
        const double squared_radius = (places[neighbors.end(*j)[-1]] - places[*j]).squaredNorm();
        const double offset = (places[*j] - places[i]).squaredNorm() / squared_radius;
        if (offset <= 1.0) offer(*j, offset);
      }
      missing += chosen < 0;
      if (chosen < 0) chosen = least;  // a flying point goes to the nearer surface
      if (chosen >= 0) fitted.positions[i] = windows.move(fits[chosen], i, fitted.positions[i]);
    }
    return missing;
  });
  fitted.unexplained = static_cast<Index>(unexplained);
}

NoiseProfile measureSeenNoise(const Points& directions, const KdTree& tree, const std::vector<double>& values) {
  std::vector<std::vector<Sample>> windows;
  for (const std::vector<Index>& window : sampleWindows(directions, tree, kNoiseWindow)) {
    const Vec3& axis = directions[window.front()];
    const Vec3 e1 = axis.unitOrthogonal(), e2 = axis.cross(e1);
    windows.emplace_back();
    for (const Index j : window) windows.back().push_back({Vec2(directions[j].dot(e1), directions[j].dot(e2)), values[j]});
  }
  return NoiseProfile(windows);
}

}  // namespace

ScatteredNoise measureNoise(const Points& positions, const KdTree& tree) {
  ScatteredNoise noise;
  Level before;
  // In the smallest windows. Larger ones then hold more than one layer; a volume sampled in slices counts as layers, too.
  bool is_clean = false;
  for (const Index count : kNoiseWindows) {
    const Level level = measureLevel(positions, tree, count);
    const double spacing = level.radius * std::sqrt(kPi / count);  // of a lattice with this many points per disk
    if (!(level.radius > 0.0) || count > static_cast<Index>(positions.size())) break;
    if (count == kNoiseWindows[0]) is_clean = level.deviation <= kClean * spacing;
    if (count == 64) noise.is_thick = !is_clean && level.deviation >= kThickest * level.radius && level.kurtosis >= kBall;
    noise.spacing = spacing;
    const bool is_plateau = before.radius > 0.0 && level.deviation <= kPlateau * before.deviation;
    if (is_plateau && level.deviation <= kThinnest * level.radius && level.spread >= kLayers) {
      noise.deviation = level.deviation;
      noise.is_thick = false;
      break;
    }
    if (before.radius > 0.0 && level.deviation <= kClean * spacing) break;
    before = level;
  }
  return noise;
}

FittedPoints fitWindows(const Points& positions, const Vec3& eye, double deviation, double measured, Index count) {
  FittedPoints fitted{positions, 0, false};
  Points directions;
  std::vector<double> inverse;
  for (const Vec3& p : positions) {
    inverse.push_back(1.0 / (p - eye).norm());
    directions.push_back((p - eye) * inverse.back());
  }
  if (std::all_of(inverse.begin(), inverse.end(), [](double w) { return std::isfinite(w); })) {
    const KdTree tree(directions);
    fitted.is_seen = areRegular(directions, tree);
    if (fitted.is_seen) {
      SeenWindows windows{directions, std::move(inverse), {}};
      windows.noise = measureSeenNoise(directions, tree, windows.values);
      if (!(measured > 0.0) || windows.noise.isEmpty()) {
        windows.noise = NoiseProfile(deviation * std::pow(findMedian(windows.values), 2));
      } else {
        windows.noise.scale(deviation / measured);
      }
      fitAll(windows, directions, count, fitted);
      return fitted;
    }
  }
  fitAll(SpaceWindows{positions, deviation}, positions, count, fitted);
  return fitted;
}

}  // namespace deformable_surface::cloud
