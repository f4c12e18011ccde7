#include "cloud_filters_pcl.h"

#include <pcl/filters/radius_outlier_removal.h>
#include <pcl/filters/statistical_outlier_removal.h>
#include <pcl/point_cloud.h>
#include <pcl/point_types.h>
#include <pcl/segmentation/sac_segmentation.h>

#include <algorithm>
#include <cmath>

#include "quiet_pcl.h"

namespace deformable_surface::io {
namespace {

using Cloud = pcl::PointCloud<pcl::PointXYZ>;

// This many points give a share to half a percent, and each trial counts them all.
constexpr std::size_t kMostForPlane = 10000;
constexpr double kMissed = 1e-4;  // chance that a plane of min_share is not found
// For a larger min_share this share is used: it is large, and a refused plane is then the largest, too.
constexpr double kLargeShare = 0.3;

Vec3 findMiddle(const Points& points) {
  Vec3 sum = Vec3::Zero();
  for (const Vec3& p : points) sum += p;
  return sum / static_cast<double>(points.size());
}

/// Every step-th point, relative to the middle: PCL has 24 bits for a coordinate.
Cloud::Ptr toPcl(const Points& points, const Vec3& middle, std::size_t step) {
  Cloud::Ptr cloud(new Cloud);
  cloud->reserve(points.size() / step + 1);
  for (std::size_t i = 0; i < points.size(); i += step) {
    const Eigen::Vector3f p = (points[i] - middle).cast<float>();
    cloud->push_back(pcl::PointXYZ(p.x(), p.y(), p.z()));
  }
  return cloud;
}

}  // namespace

std::optional<Plane> findLargestPlane(const Points& points, double distance, double min_share) {
  if (points.size() < 3) return std::nullopt;
  const QuietPcl quiet;
  const Vec3 middle = findMiddle(points);
  // A trial picks three points on the plane with the probability of their share, cubed.
  const double all_on_plane = std::pow(std::min(min_share, kLargeShare), 3);
  pcl::SACSegmentation<pcl::PointXYZ> search;  // its random numbers begin alike each time
  search.setModelType(pcl::SACMODEL_PLANE);
  search.setMethodType(pcl::SAC_RANSAC);
  search.setDistanceThreshold(distance);
  search.setProbability(1.0 - kMissed);
  search.setMaxIterations(static_cast<int>(std::ceil(std::log(kMissed) / std::log1p(-all_on_plane))));
  search.setOptimizeCoefficients(true);
  search.setInputCloud(toPcl(points, middle, (points.size() - 1) / kMostForPlane + 1));
  pcl::PointIndices on_plane;
  pcl::ModelCoefficients found;
  search.segment(on_plane, found);
  if (found.values.size() != 4) return std::nullopt;
  Plane plane;
  plane.normal = Vec3(found.values[0], found.values[1], found.values[2]);
  const double length = plane.normal.norm();
  if (!(length > 0.0)) return std::nullopt;
  plane.normal /= length;
  plane.offset = found.values[3] / length - plane.normal.dot(middle);
  return plane;
}

std::vector<char> findOutliers(const Points& points, const simulation::OutlierParams& params) {
  using Method = simulation::OutlierParams::Method;
  if (params.method == Method::kNone || points.size() < 2) return std::vector<char>(points.size(), 0);
  const QuietPcl quiet;
  const Cloud::Ptr cloud = toPcl(points, findMiddle(points), 1);
  pcl::PointIndices kept;
  if (params.method == Method::kRadius) {
    pcl::RadiusOutlierRemoval<pcl::PointXYZ> filter;
    filter.setInputCloud(cloud);
    filter.setRadiusSearch(params.radius);
    filter.setMinNeighborsInRadius(params.neighbors);
    filter.filter(kept.indices);
  } else {
    pcl::StatisticalOutlierRemoval<pcl::PointXYZ> filter;
    filter.setInputCloud(cloud);
    // PCL reads as many distances as it was asked for, even if there are fewer points.
    filter.setMeanK(std::min(params.neighbors, static_cast<Index>(points.size()) - 1));
    filter.setStddevMulThresh(params.deviations);
    filter.filter(kept.indices);
  }
  std::vector<char> is_alone(points.size(), 1);
  for (const auto i : kept.indices) is_alone[i] = 0;
  return is_alone;
}

}  // namespace deformable_surface::io
