#include "depth_windows.h"

#include "deformable_surface/base/median.h"
#include "deformable_surface/base/parallel.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace deformable_surface::cloud {
namespace {

constexpr Index kRowsPerTask = 8, kPlanesPerTask = 8192;
constexpr Index kNoiseRadius = 3;      // of the windows for the measurement of noise
constexpr Index kSampledRows = 120;    // largest number of rows and of columns of these windows
constexpr double kUnknowns = 3.0;      // of a plane
constexpr double kFewestPixels = 6.0;  // of a window: twice the unknowns of a plane
constexpr double kLeastFilled =
    0.3;  // fraction of a window: a little more than the quarter that is left in the corner of an image
constexpr double kLeastSpread =
    0.05;                     // fraction of the determinant of a full window's spread: collinear pixels determine no plane
constexpr Index kBeside = 2;  // largest distance in pixels of a window from a pixel that fits none
constexpr double kMostVariance = 3.0;  // factor on the variance of small windows: a larger one is due to shape

// Sums over pixels; u and v count from the middle of the image.
struct Sums {
  double n = 0.0, u = 0.0, v = 0.0, uu = 0.0, uv = 0.0, vv = 0.0, w = 0.0, uw = 0.0, vw = 0.0, ww = 0.0;

  void add(const Sums& b, double sign) {
    n += sign * b.n;
    u += sign * b.u;
    v += sign * b.v;
    uu += sign * b.uu;
    uv += sign * b.uv;
    vv += sign * b.vv;
    w += sign * b.w;
    uw += sign * b.uw;
    vw += sign * b.vw;
    ww += sign * b.ww;
  }
};

// Sums over all rectangles that begin in the first pixel; the sums over any other rectangle follow from them.
class SummedImage {
 public:
  explicit SummedImage(const DepthImage& image)
      : width_(image.width), height_(image.height), sums_(std::size_t(width_ + 1) * (height_ + 1)) {
    double total = 0.0, count = 0.0;
    for (const double w : image.inverse_depth) {
      total += w;
      count += w > 0.0;
    }
    mean_ = count > 0.0 ? total / count : 0.0;
    for (Index v = 0; v < height_; ++v) {
      Sums row;
      for (Index u = 0; u < width_; ++u) {
        const double inverse = image.inverse_depth[std::size_t(v) * width_ + u];
        if (inverse > 0.0) {
          const double x = u - middleU(), y = v - middleV(), w = inverse - mean_;
          row.add({1.0, x, y, x * x, x * y, y * y, w, x * w, y * w, w * w}, 1.0);
        }
        Sums& sum = sums_[place(u + 1, v + 1)];
        sum = sums_[place(u + 1, v)];
        sum.add(row, 1.0);
      }
    }
  }

  // Over the pixels at most radius rows and columns away.
  Sums around(Index u, Index v, Index radius) const {
    const Index left = std::max(0, u - radius), right = std::min(width_, u + radius + 1);
    const Index top = std::max(0, v - radius), bottom = std::min(height_, v + radius + 1);
    Sums sum = sums_[place(right, bottom)];
    sum.add(sums_[place(left, bottom)], -1.0);
    sum.add(sums_[place(right, top)], -1.0);
    sum.add(sums_[place(left, top)], 1.0);
    return sum;
  }
  double middleU() const { return 0.5 * width_; }
  double middleV() const { return 0.5 * height_; }
  double mean() const { return mean_; }

 private:
  std::size_t place(Index u, Index v) const { return std::size_t(v) * (width_ + 1) + u; }

  const Index width_, height_;
  double mean_ = 0.0;
  std::vector<Sums> sums_;
};

struct Plane {
  double at_zero = 0.0, along_u = 0.0, along_v = 0.0;  // of u = v = 0
  double deviation = 0.0;  // of the noise there; 0: the window has no plane, or noise does not explain it
  double variance = 0.0;   // of the residuals
  double freedom = 0.0;

  double at(Index u, Index v) const { return at_zero + along_u * u + along_v * v; }
  // The plane at a pixel, given in columns and rows from the middle of the window. Combines the deviations of a mean and of two
  // slopes.
  PixelPlane takeOff(Index u, Index v, Index radius) const {
    const double share = (1.0 + 3.0 * (u * u + v * v) / (radius * (radius + 1.0))) / (freedom + kUnknowns);
    return {along_u, along_v, deviation * std::sqrt(share)};
  }
};

Plane fitPlane(const SummedImage& image, const NoiseProfile& noise, Index u, Index v, Index radius) {
  const Sums s = image.around(u, v, radius);
  if (s.n < std::max(kFewestPixels, kLeastFilled * (2.0 * radius + 1.0) * (2.0 * radius + 1.0))) return {};
  const double mean_u = s.u / s.n, mean_v = s.v / s.n, mean_w = s.w / s.n;
  const double uu = s.uu / s.n - mean_u * mean_u, uv = s.uv / s.n - mean_u * mean_v, vv = s.vv / s.n - mean_v * mean_v;
  const double uw = s.uw / s.n - mean_u * mean_w, vw = s.vw / s.n - mean_v * mean_w, ww = s.ww / s.n - mean_w * mean_w;
  const double full = radius * (radius + 1.0) / 3.0, determinant = uu * vv - uv * uv;
  if (!(determinant > kLeastSpread * full * full)) return {};
  const double a = (vv * uw - uv * vw) / determinant, b = (uu * vw - uv * uw) / determinant;
  Plane plane;
  plane.at_zero = image.mean() + mean_w - a * (mean_u + image.middleU()) - b * (mean_v + image.middleV());
  plane.along_u = a;
  plane.along_v = b;
  plane.deviation = noise.at(image.mean() + mean_w);
  plane.freedom = s.n - kUnknowns;
  plane.variance = std::max(0.0, ww - a * uw - b * vw) * s.n / plane.freedom;
  return plane;
}

// Sets the deviation of planes that noise does not explain to zero. Returns the factor of the deviations.
double markExplained(std::vector<Plane>& planes) {
  std::vector<double> shares;
  for (const Plane& plane : planes)
    if (plane.deviation > 0.0) shares.push_back(plane.variance / (plane.deviation * plane.deviation));
  if (shares.empty()) return 1.0;
  const double factor = std::sqrt(std::clamp(findMedian(std::move(shares)), 1.0, kMostVariance));
  parallelFor(static_cast<Index>(planes.size()), kPlanesPerTask, [&](Index begin, Index end) {
    for (Index p = begin; p < end; ++p) {
      Plane& plane = planes[p];
      plane.deviation *= factor;
      const double most = findMostVariance(plane.freedom);
      if (!(plane.variance <= most * plane.deviation * plane.deviation)) plane.deviation = 0.0;
    }
  });
  return factor;
}

// Centres of the windows that contain a pixel, the nearest first.
struct Offset {
  double cost;
  Index u, v;
};
std::vector<Offset> listOffsets(Index radius) {
  std::vector<Offset> offsets;
  for (Index v = -radius; v <= radius; ++v)
    for (Index u = -radius; u <= radius; ++u) offsets.push_back({static_cast<double>(u * u + v * v) / (radius * radius), u, v});
  std::stable_sort(offsets.begin(), offsets.end(), [](const Offset& a, const Offset& b) { return a.cost < b.cost; });
  return offsets;
}

}  // namespace

NoiseProfile measureNoise(const DepthImage& image) {
  const Index r = kNoiseRadius;
  const Index every_v = std::max(Index{1}, image.height / kSampledRows), every_u = std::max(Index{1}, image.width / kSampledRows);
  std::vector<std::vector<Sample>> windows;
  const auto add = [&](Index u, Index v, std::vector<Sample>& window) {
    const double w = image.inverse_depth[std::size_t(v) * image.width + u];
    if (w > 0.0) window.push_back({Vec2(u, v), w});
  };
  for (Index v = r; v + r < image.height; v += every_v) {
    for (Index u = r; u + r < image.width; u += every_u) {
      std::vector<Sample> window;
      add(u, v, window);
      if (window.empty()) continue;
      for (Index y = v - r; y <= v + r; ++y)
        for (Index x = u - r; x <= u + r; ++x)
          if (x != u || y != v) add(x, y, window);
      for (Sample& sample : window) sample.place -= Vec2(u, v);
      if (2 * window.size() > std::size_t(2 * r + 1) * (2 * r + 1)) windows.push_back(std::move(window));
    }
  }
  return NoiseProfile(windows);
}

FittedDepths fitWindows(const DepthImage& image, const NoiseProfile& noise, Index radius) {
  const Index width = image.width, height = image.height;
  const SummedImage summed(image);
  std::vector<Plane> planes(std::size_t(width) * height);
  parallelFor(height, kRowsPerTask, [&](Index begin, Index end) {
    for (Index v = begin; v < end; ++v)
      for (Index u = 0; u < width; ++u) planes[std::size_t(v) * width + u] = fitPlane(summed, noise, u, v, radius);
  });

  FittedDepths fitted;
  fitted.inverse_depth = image.inverse_depth;
  fitted.planes.resize(planes.size());
  fitted.factor = markExplained(planes);
  const std::vector<Offset> offsets = listOffsets(radius);
  // A pixel between two surfaces goes to the nearer one, so that it does not join them. Windows that contain it hold other such
  // pixels, so the windows beside them are tried as well.
  const Index wide = radius + kBeside;
  const auto takeNearest = [&](Index u, Index v, double& value, PixelPlane& taken) {
    const double own = value;
    double least = std::numeric_limits<double>::infinity();
    for (Index y = std::max(0, v - wide); y <= std::min(height - 1, v + wide); ++y) {
      for (Index x = std::max(0, u - wide); x <= std::min(width - 1, u + wide); ++x) {
        const Plane& plane = planes[std::size_t(y) * width + x];
        if (!(plane.deviation > 0.0)) continue;
        const double there = plane.at(u, v), misfit = std::abs(there - own) / plane.deviation;
        if (!(there > 0.0 && misfit < least)) continue;
        least = misfit;
        value = there;
        taken = plane.takeOff(x - u, y - v, radius);
      }
    }
  };
  const double unexplained = parallelSum(height, kRowsPerTask, [&](Index begin, Index end) {
    double count = 0.0;
    for (Index v = begin; v < end; ++v) {
      for (Index u = 0; u < width; ++u) {
        double& value = fitted.inverse_depth[std::size_t(v) * width + u];
        if (!(value > 0.0)) continue;
        PixelPlane& taken = fitted.planes[std::size_t(v) * width + u];
        const double own = value;
        double best = std::numeric_limits<double>::infinity();
        for (const Offset& offset : offsets) {
          if (!(offset.cost < best)) break;
          const Index x = u + offset.u, y = v + offset.v;
          if (x < 0 || x >= width || y < 0 || y >= height) continue;
          const Plane& plane = planes[std::size_t(y) * width + x];
          if (!(plane.deviation > 0.0)) continue;
          const double there = plane.at(u, v), misfit = (there - own) / plane.deviation;
          const double cost = offset.cost + 0.25 * misfit * misfit;
          if (!(std::abs(misfit) < kOutlier && cost < best && there > 0.0)) continue;
          best = cost;
          value = there;
          taken = plane.takeOff(offset.u, offset.v, radius);
        }
        if (best < std::numeric_limits<double>::infinity()) continue;
        count += 1.0;
        taken.deviation = fitted.factor * noise.at(own);
        takeNearest(u, v, value, taken);
      }
    }
    return count;
  });
  fitted.unexplained = static_cast<Index>(unexplained);
  return fitted;
}

}  // namespace deformable_surface::cloud
