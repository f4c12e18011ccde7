#include "samplings.h"

#include <Eigen/Eigenvalues>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <random>
#include <sstream>
#include <stdexcept>

namespace deformable_surface::physics {
namespace {

constexpr double kJitter = 0.25;      // of the spacing, in each direction
constexpr double kScanDensity = 3.0;  // scan points along the spacing of the simulated ones: a scan simplified to a ninth

// The part of the scanned plane that is covered evenly, m: its lower left corner, from the mean of the points, and its sides.
const Vec2 kScanCorner(-0.30, -0.12);
constexpr double kScanWidth = 0.72, kScanHeight = 0.40;

class Jitter {
 public:
  double draw(double spacing) { return kJitter * spacing * (static_cast<double>(generator_()) / 2147483648.0 - 1.0); }

 private:
  std::mt19937 generator_{1};
};

// The scan's points in its plane, the lower left corner of the even part at the origin. Read once.
const std::vector<Vec2>& scanPattern() {
  static const std::vector<Vec2> pattern = [] {
    std::vector<Vec2> found;
    std::ifstream file(dataFolder() + "/pcl_scans/sac_plane_test.pcd");
    Points points;
    bool data = false;
    for (std::string line; std::getline(file, line);) {
      if (data) {
        std::istringstream numbers(line);
        double x, y, z;
        if (numbers >> x >> y >> z) points.emplace_back(x, y, z);
      }
      data = data || line.rfind("DATA", 0) == 0;
    }
    if (points.empty()) return found;
    Vec3 mean = Vec3::Zero();
    for (const Vec3& p : points) mean += p / static_cast<double>(points.size());
    Mat3 covariance = Mat3::Zero();
    for (const Vec3& p : points) covariance += (p - mean) * (p - mean).transpose();
    const Eigen::SelfAdjointEigenSolver<Mat3> axes(covariance);
    // Signs of eigenvectors are arbitrary: the largest component is taken positive.
    Vec3 u = axes.eigenvectors().col(2), v = axes.eigenvectors().col(1);
    Eigen::Index largest;
    u.cwiseAbs().maxCoeff(&largest);
    if (u[largest] < 0.0) u = -u;
    v.cwiseAbs().maxCoeff(&largest);
    if (v[largest] < 0.0) v = -v;
    for (const Vec3& p : points) {
      const Vec2 q = Vec2((p - mean).dot(u), (p - mean).dot(v)) - kScanCorner;
      if (q.x() >= 0.0 && q.x() < kScanWidth && q.y() >= 0.0 && q.y() < kScanHeight) found.push_back(q);
    }
    return found;
  }();
  return pattern;
}

// The pattern with the given mean spacing over a rectangle at the origin: repeated by reflection, so that it has no seams. Of two
// points that a reflection brings together one is left out.
std::vector<Vec2> repeatPattern(const Vec2& size, double spacing) {
  const std::vector<Vec2>& pattern = scanPattern();
  if (pattern.empty()) throw std::runtime_error("there is no scan: DEFORMABLE_SURFACE_DATA names no folder that holds it");
  const double own = std::sqrt(kScanWidth * kScanHeight / static_cast<double>(pattern.size()));
  const double scale = spacing / own;
  const Vec2 tile(scale * kScanWidth, scale * kScanHeight);
  std::vector<Vec2> points;
  const double seam = 0.25 * own;
  for (int i = 0; i * tile.x() <= size.x(); ++i)
    for (int j = 0; j * tile.y() <= size.y(); ++j)
      for (const Vec2& p : pattern) {
        const double to_side = std::min(p.x(), kScanWidth - p.x()), to_end = std::min(p.y(), kScanHeight - p.y());
        if ((i % 2 == 1 && to_side < seam) || (j % 2 == 1 && to_end < seam)) continue;
        const Vec2 q(i % 2 == 0 ? p.x() : kScanWidth - p.x(), j % 2 == 0 ? p.y() : kScanHeight - p.y());
        const Vec2 placed(i * tile.x() + scale * q.x(), j * tile.y() + scale * q.y());
        if (placed.x() <= size.x() && placed.y() <= size.y()) points.push_back(placed);
      }
  return points;
}

Index countCells(double length, double spacing) { return std::max<Index>(1, static_cast<Index>(std::lround(length / spacing))); }

}  // namespace

std::string dataFolder() {
  const char* folder = std::getenv("DEFORMABLE_SURFACE_DATA");
  return folder ? folder : "";
}

bool hasScan() { return !scanPattern().empty(); }

Mat3 someRotation() { return Eigen::AngleAxisd(1.1, Vec3(0.3, -0.5, 0.8).normalized()).toRotationMatrix(); }

Sampled sampleRectangle(const Vec2& low, const Vec2& high, double spacing, Sampling sampling) {
  Sampled sampled;
  const Vec2 size = high - low;
  const Index nx = countCells(size.x(), spacing), ny = countCells(size.y(), spacing);
  if (sampling == Sampling::kScanned) {
    // What lies within half a spacing of an edge is moved onto it: the piece is cut along straight lines.
    const double dense = spacing / kScanDensity;
    for (Vec2 p : repeatPattern(size, dense)) {
      for (int c = 0; c < 2; ++c) {
        if (p[c] < 0.5 * dense) p[c] = 0.0;
        if (p[c] > size[c] - 0.5 * dense) p[c] = size[c];
      }
      sampled.points.emplace_back(low.x() + p.x(), low.y() + p.y(), 0.0);
    }
    for (const double x : {low.x(), high.x()})
      for (const double y : {low.y(), high.y()}) sampled.points.emplace_back(x, y, 0.0);
    sampled.keep = (nx + 1) * (ny + 1);
    return sampled;
  }
  Jitter jitter;
  for (Index i = 0; i <= nx; ++i)
    for (Index j = 0; j <= ny; ++j) {
      Vec3 p(low.x() + size.x() * i / nx, low.y() + size.y() * j / ny, 0.0);
      if (sampling == Sampling::kJittered) {
        const double dx = jitter.draw(size.x() / nx), dy = jitter.draw(size.y() / ny);
        if (i > 0 && i < nx) p.x() += dx;
        if (j > 0 && j < ny) p.y() += dy;
      }
      sampled.points.push_back(p);
    }
  return sampled;
}

Sampled sampleDisc(double radius, double spacing, Sampling sampling) {
  Sampled sampled;
  const Index rings = countCells(radius, spacing);
  const auto ringPoints = [](Index r) { return r == 0 ? Index{1} : 6 * r; };
  if (sampling == Sampling::kScanned) {
    const double dense = spacing / kScanDensity;
    for (const Vec2& p : repeatPattern(Vec2(2.0 * radius, 2.0 * radius), dense)) {
      const Vec2 q = p - Vec2(radius, radius);
      const double r = q.norm();
      if (r > radius + 0.5 * dense) continue;
      const Vec2 moved = r > radius - 0.5 * dense ? Vec2(q * (radius / r)) : q;
      sampled.points.emplace_back(moved.x(), moved.y(), 0.0);
    }
    for (Index r = 0; r <= rings; ++r) sampled.keep += ringPoints(r);
    return sampled;
  }
  Jitter jitter;
  for (Index r = 0; r <= rings; ++r)
    for (Index k = 0; k < ringPoints(r); ++k) {
      double distance = radius * r / rings, angle = 2.0 * kPi * (k + 0.5 * (r % 2)) / ringPoints(r);
      if (sampling == Sampling::kJittered && r > 0) {
        const double out = jitter.draw(radius / rings), along = jitter.draw(radius / rings);
        angle += along / distance;
        if (r < rings) distance += out;
      }
      sampled.points.emplace_back(distance * std::cos(angle), distance * std::sin(angle), 0.0);
    }
  return sampled;
}

Sampled sampleSphere(double radius, double spacing, Sampling sampling) {
  Sampled sampled;
  const double area = 4.0 * kPi * radius * radius;
  Index n = countCells(area, spacing * spacing);
  if (sampling == Sampling::kScanned) {
    sampled.keep = n;
    n = static_cast<Index>(n * kScanDensity * kScanDensity);
  }
  const double golden_angle = kPi * (3.0 - std::sqrt(5.0)), step = std::sqrt(area / n);
  Jitter jitter;
  for (Index i = 0; i < n; ++i) {
    const double z = 1.0 - (2.0 * i + 1.0) / n, r = std::sqrt(1.0 - z * z), angle = golden_angle * i;
    Vec3 p = radius * Vec3(r * std::cos(angle), r * std::sin(angle), z);
    if (sampling != Sampling::kRegular) {
      const double east = jitter.draw(step), north = jitter.draw(step);
      const Vec3 eastward(-std::sin(angle), std::cos(angle), 0.0);
      p = radius * (p + east * eastward + north * p.normalized().cross(eastward)).normalized();
    }
    sampled.points.push_back(p);
  }
  return sampled;
}

}  // namespace deformable_surface::physics
