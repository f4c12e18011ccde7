#include "deformable_surface/io/cloud_filters.h"

#include "cloud_filters_pcl.h"

#include "deformable_surface/base/error.h"
#include "deformable_surface/base/interrupt.h"
#include "deformable_surface/base/parallel.h"
#include "deformable_surface/cloud/flying_pixels.h"
#include "deformable_surface/cloud/kd_tree.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace deformable_surface::io {
namespace {

using cloud::PointCloud;
using simulation::InputFilterParams;
using simulation::PlaneFilterParams;

constexpr Index kBlock = 512;       // points
constexpr Index kFewestPoints = 3;  // that a surface is made of
constexpr std::array<const char*, 7> kNames{"", "crop", "range", "flying pixels", "plane", "other side of the plane", "outliers"};

std::string join(const std::vector<std::string>& parts) {
  std::string text;
  for (const std::string& part : parts) text += (text.empty() ? "" : ", ") + part;
  return text;
}

/// The remaining points of a cloud, and how the others were removed.
class Filtering {
 public:
  explicit Filtering(PointCloud& cloud) : cloud_(cloud), removed_by_(cloud.positions.size(), RemovedBy::kNone) {
    for (Index i = 0; i < cloud.size(); ++i)
      if (cloud.positions[i].allFinite()) alive_.push_back(i);
  }

  const PointCloud& cloud() const { return cloud_; }
  /// Indices of the remaining points, ascending.
  const std::vector<Index>& alive() const { return alive_; }
  Points points() const {
    Points points;
    points.reserve(alive_.size());
    for (const Index i : alive_) points.push_back(cloud_.positions[i]);
    return points;
  }
  const std::vector<RemovedBy>& removedBy() const { return removed_by_; }

  /// Removes the points for which find(k, i) is not kNone; k: among the remaining points, i: in the cloud.
  template <class Find>
  void remove(const Find& find) {
    std::size_t left = 0;
    for (std::size_t k = 0; k < alive_.size(); ++k) {
      const Index i = alive_[k];
      removed_by_[i] = find(k, i);
      if (removed_by_[i] == RemovedBy::kNone) {
        alive_[left++] = i;
      } else {
        cloud_.positions[i].setConstant(std::numeric_limits<double>::quiet_NaN());
      }
    }
    alive_.resize(left);
  }

 private:
  PointCloud& cloud_;
  std::vector<RemovedBy> removed_by_;
  std::vector<Index> alive_;
};

/// How many points there are, and where.
std::string describe(const Filtering& filtering) {
  if (filtering.alive().empty()) return "no points";
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  Vec3 low = Vec3::Constant(kInfinity), high = -low;
  double nearest = kInfinity, farthest = 0.0;
  const Vec3 eye = filtering.cloud().eye();
  for (const Index i : filtering.alive()) {
    const Vec3& p = filtering.cloud().positions[i];
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
    const double distance = (p - eye).norm();
    nearest = std::min(nearest, distance);
    farthest = std::max(farthest, distance);
  }
  const Vec3 size = high - low;
  return std::to_string(filtering.alive().size()) + " points, " + formatShort(nearest) + " to " + formatShort(farthest) +
         " m from the eye, in a box of " + formatShort(size.x()) + " x " + formatShort(size.y()) + " x " + formatShort(size.z()) +
         " m";
}

/// A regular sample of the points such that a ball of this radius around one of them holds enough for a median, and few more.
Points thin(const Points& points, double radius) {
  constexpr std::size_t kWanted = 24;  // the median of as many has a quarter of the noise of one
  constexpr std::size_t kAsked = 64;   // points that stand for all
  const cloud::KdTree tree(points);
  std::vector<cloud::Neighbor> neighbors;
  std::size_t found = 0, asked = 0;
  for (std::size_t i = 0; i < points.size(); i += points.size() / kAsked + 1, ++asked) {
    tree.withinRadius(points[i], radius, neighbors);
    found += neighbors.size();
  }
  const std::size_t step = std::max<std::size_t>(1, found / (asked * kWanted));
  Points thinned;
  for (std::size_t i = 0; i < points.size(); i += step) thinned.push_back(points[i]);
  return thinned;
}

/// The height of each point above the plane, or the median of those within the radius where this can differ: farther
/// off, all within it lie on the point's own side of the layer.
std::vector<double> findHeights(const PlaneFilterParams& params, const Plane& plane, const Points& points) {
  std::vector<double> heights;
  heights.reserve(points.size());
  for (const Vec3& p : points) heights.push_back(plane.height(p));
  if (!(params.radius > 0.0)) return heights;
  const double reach = params.distance + params.radius;
  std::vector<double> medians = heights;
  const Points thinned = thin(points, params.radius);
  const cloud::KdTree tree(thinned);
  parallelFor(static_cast<Index>(points.size()), kBlock, [&](Index begin, Index end) {
    std::vector<cloud::Neighbor> neighbors;
    std::vector<double> around;
    for (Index i = begin; i < end; ++i) {
      if (std::abs(heights[i]) > reach) continue;
      tree.withinRadius(points[i], params.radius, neighbors);
      if (neighbors.empty()) continue;
      around.clear();
      for (const cloud::Neighbor& neighbor : neighbors) around.push_back(plane.height(thinned[neighbor.index]));
      const auto middle = around.begin() + static_cast<std::ptrdiff_t>(around.size() / 2);
      std::nth_element(around.begin(), middle, around.end());
      medians[i] = *middle;
    }
  });
  return medians;
}

/// A note of what was found.
std::string removePlane(const PlaneFilterParams& params, Filtering& filtering) {
  const std::string key = "input.filter.plane: ";
  const Points points = filtering.points();
  std::optional<Plane> plane = findLargestPlane(points, params.distance, params.min_share);
  if (!plane) return key + "found no plane in " + std::to_string(points.size()) + " points; none is taken away";
  const Vec3 eye = filtering.cloud().eye();
  if (plane->height(eye) < 0.0) *plane = {-plane->normal, -plane->offset};
  const double distance_of_eye = plane->height(eye);

  Index on_plane = 0;
  for (const Vec3& p : points) on_plane += std::abs(plane->height(p)) <= params.distance;
  const double share = static_cast<double>(on_plane) / static_cast<double>(points.size());
  const std::string found = formatShort(100.0 * share) + " % of " + std::to_string(points.size()) + " points lie within " +
                            formatShort(params.distance) + " m of a plane " + formatShort(distance_of_eye) + " m from the eye";
  if (!(share >= params.min_share))
    return key + found + "; accepted: min_share, " + formatShort(100.0 * params.min_share) + " %, so that it stays";

  using Keep = PlaneFilterParams::Keep;
  if (params.keep != Keep::kBoth && !(distance_of_eye > params.distance))
    throw InputError("input.filter.plane.keep: " + found + ", which has no near and no far side from there; accepted: both");
  const std::vector<double> heights = findHeights(params, *plane, points);
  filtering.remove([&](std::size_t k, Index) {
    if (std::abs(heights[k]) <= params.distance) return RemovedBy::kPlane;
    const bool stays = params.keep == Keep::kBoth || (heights[k] > 0.0) == (params.keep == Keep::kNearSide);
    return stays ? RemovedBy::kNone : RemovedBy::kOtherSide;
  });
  return key + found;
}

std::string describeRemoved(const std::array<Index, kNames.size()>& counts) {
  std::vector<std::string> parts;
  for (std::size_t f = 1; f < counts.size(); ++f)
    if (counts[f] > 0) parts.push_back(std::string(kNames[f]) + " " + std::to_string(counts[f]));
  return parts.empty() ? "none" : join(parts);
}

}  // namespace

FilterReport filterCloud(const InputFilterParams& params, PointCloud& cloud) {
  FilterReport report;
  if (!params.isOn()) return report;
  Filtering filtering(cloud);
  const std::size_t before = filtering.alive().size();
  const std::string described = describe(filtering);

  const auto isCropped = [&](const Vec3& p) {
    return std::any_of(params.crop.begin(), params.crop.end(), [&](const auto& crop) { return !crop.region.contains(p); });
  };
  const auto removeIf = [&](RemovedBy filter, const auto& goes) {
    filtering.remove([&](std::size_t k, Index i) { return goes(k, i) ? filter : RemovedBy::kNone; });
    endIfInterrupted();
  };
  // In the whole image: at an outline, the other filters may remove the background, or the surface in front.
  std::vector<char> flying;
  if (params.flying_pixels > 0.0) {
    if (cloud.width < 2 || cloud.height < 2) {
      throw InputError("input.filter.flying_pixels: found a cloud of " + std::to_string(cloud.width) + " x " +
                       std::to_string(cloud.height) + " points, where no pixel has neighbours; accepted: organised clouds, or 0");
    }
    flying = cloud::findFlyingPixels(cloud, params.flying_pixels);
    endIfInterrupted();
  }
  if (!params.crop.empty()) removeIf(RemovedBy::kCrop, [&](std::size_t, Index i) { return isCropped(cloud.positions[i]); });
  removeIf(RemovedBy::kRange, [&, eye = cloud.eye()](std::size_t, Index i) {
    const double distance = (cloud.positions[i] - eye).norm();
    return distance < params.range.min || distance > params.range.max;
  });
  if (!flying.empty()) removeIf(RemovedBy::kFlyingPixels, [&](std::size_t, Index i) { return flying[i]; });
  std::string plane_notice;
  if (params.plane.distance > 0.0) {
    plane_notice = removePlane(params.plane, filtering);
    endIfInterrupted();
  }
  if (params.outliers.method != simulation::OutlierParams::Method::kNone) {
    const std::vector<char> is_alone = findOutliers(filtering.points(), params.outliers);
    removeIf(RemovedBy::kOutliers, [&](std::size_t k, Index) { return is_alone[k]; });
  }

  report.removed_by = filtering.removedBy();
  std::array<Index, kNames.size()> counts{};
  for (const RemovedBy filter : report.removed_by) ++counts[static_cast<std::size_t>(filter)];
  const std::string removed = describeRemoved(counts);
  report.notices.push_back("input.filter: taken away: " + removed + "; before: " + described + "; after: " + describe(filtering));
  if (!plane_notice.empty()) report.notices.push_back(plane_notice);
  const std::size_t after = filtering.alive().size();
  if (after < kFewestPoints && after < before) {
    report.problem = "input.filter: found " + std::to_string(before) + " points, of which " + std::to_string(after) +
                     " stay (taken away: " + removed + "); accepted: filters that leave at least " +
                     std::to_string(kFewestPoints);
  }
  return report;
}

PointCloud withRemovedBy(const FilterReport& report, PointCloud before) {
  cloud::ExtraField field{"removed_by", cloud::ScalarType::kUint8, 1, std::vector<std::uint8_t>(before.positions.size(), 0)};
  for (std::size_t i = 0; i < report.removed_by.size(); ++i) field.bytes[i] = static_cast<std::uint8_t>(report.removed_by[i]);
  before.extra_fields.insert(before.extra_fields.begin(), std::move(field));
  return before;
}

}  // namespace deformable_surface::io
