#include "peers_clouds.h"

#include "deformable_surface/cloud/kd_tree.h"
#include "deformable_surface/cloud/normals.h"
#include "measure.h"
#include "wavy_sheet.h"

#include <algorithm>
#include <cmath>

#ifdef DEFORMABLE_SURFACE_WITH_NANOFLANN
#include <nanoflann.hpp>
#endif
#ifdef DEFORMABLE_SURFACE_WITH_PCL
#include <pcl/features/normal_3d.h>
#include <pcl/search/kdtree.h>
#include <flann/flann.hpp>
#endif

namespace deformable_surface::benchmark {
namespace {

constexpr Index kListed = 32;
constexpr Index kSizes[] = {10000, 100000};

#ifdef DEFORMABLE_SURFACE_WITH_NANOFLANN
struct Adaptor {
  const Points& points;
  std::size_t kdtree_get_point_count() const { return points.size(); }
  double kdtree_get_pt(std::size_t i, std::size_t axis) const { return points[i][static_cast<Eigen::Index>(axis)]; }
  template <class Box>
  bool kdtree_get_bbox(Box&) const {
    return false;
  }
};

Lists findByNanoflann(const Points& points, Index k) {
  const Adaptor adaptor{points};
  using Tree = nanoflann::KDTreeSingleIndexAdaptor<nanoflann::L2_Simple_Adaptor<double, Adaptor>, Adaptor, 3, Index>;
  Tree tree(3, adaptor, nanoflann::KDTreeSingleIndexAdaptorParams(10));
  tree.buildIndex();
  Lists lists;
  std::vector<Index> found(k + 1);
  std::vector<double> squared(k + 1);
  for (std::size_t i = 0; i < points.size(); ++i) {
    const std::size_t count = tree.knnSearch(points[i].data(), k + 1, found.data(), squared.data());
    for (std::size_t m = 0; m < count; ++m)
      if (found[m] != static_cast<Index>(i)) lists.items.push_back(found[m]);
    lists.offsets.push_back(static_cast<Index>(lists.items.size()));
  }
  return lists;
}
#endif

#ifdef DEFORMABLE_SURFACE_WITH_PCL
// The exact search of its tree for few dimensions.
Lists findByFlann(const Points& points, Index k) {
  const std::size_t n = points.size();
  const flann::Matrix<double> data(const_cast<double*>(points.data()->data()), n, 3);
  flann::Index<flann::L2_Simple<double>> tree(data, flann::KDTreeSingleIndexParams(15));
  tree.buildIndex();
  flann::SearchParams exact(flann::FLANN_CHECKS_UNLIMITED);
  exact.cores = 1;
  std::vector<int> found(n * (k + 1));
  std::vector<double> squared(found.size());
  flann::Matrix<int> indices(found.data(), n, k + 1);
  flann::Matrix<double> distances(squared.data(), n, k + 1);
  tree.knnSearch(data, indices, distances, k + 1, exact);
  Lists lists;
  for (std::size_t i = 0; i < n; ++i) {
    for (Index m = 0; m <= k; ++m)
      if (indices[i][m] != static_cast<int>(i)) lists.items.push_back(indices[i][m]);
    lists.offsets.push_back(static_cast<Index>(lists.items.size()));
  }
  return lists;
}

// In float, as PCL has them; one thread.
Points estimateByPcl(const Points& points) {
  auto cloud = std::make_shared<pcl::PointCloud<pcl::PointXYZ>>();
  for (const Vec3& p : points) {
    const Eigen::Vector3f q = p.cast<float>();
    cloud->push_back({q.x(), q.y(), q.z()});
  }
  pcl::NormalEstimation<pcl::PointXYZ, pcl::Normal> estimation;
  estimation.setInputCloud(cloud);
  estimation.setSearchMethod(std::make_shared<pcl::search::KdTree<pcl::PointXYZ>>());
  estimation.setKSearch(kListed + 1);  // the point is one of them
  pcl::PointCloud<pcl::Normal> found;
  estimation.compute(found);
  Points normals;
  for (const pcl::Normal& n : found) normals.emplace_back(n.normal_x, n.normal_y, n.normal_z);
  return normals;
}
#endif

// Degrees to the formula's, whatever the side, root mean square.
double findAngle(const Points& positions, const Points& normals) {
  double sum = 0.0;
  for (std::size_t i = 0; i < positions.size(); ++i) {
    const double sine = std::min(1.0, normals[i].cross(findWavyNormal(positions[i])).norm());
    sum += std::asin(sine) * std::asin(sine);
  }
  return std::sqrt(sum / positions.size()) * 180.0 / M_PI;
}

}  // namespace

void compareNeighbors(const Options& options, Report& report) {
  report.begin("peers_neighbors", "14b. The " + std::to_string(kListed) + " nearest neighbours of every point, one thread",
               {"program", "points", "cpu_ms", "ns_per_point", "lists_that_differ_from_ours"});
  for (const Index n : kSizes) {
    const Points points = makeWavySheet(n, PointOrder::kScan).positions;
    Lists ours;
    const auto add = [&](const char* name, auto&& find) {
      Lists found;
      const Timing timing = measure([&] { found = find(points, kListed); }, options.budget);
      if (ours.items.empty()) ours = found;
      Index differ = 0;
      for (Index i = 0; i < ours.size(); ++i) differ += !std::equal(ours.begin(i), ours.end(i), found.begin(i), found.end(i));
      report.add({name, std::to_string(points.size()), showMilliseconds(timing.cpu), show(1e9 * timing.cpu / points.size()),
                  std::to_string(differ)});
    };
    add("deformable_surface", cloud::nearestNeighbors);
#ifdef DEFORMABLE_SURFACE_WITH_NANOFLANN
    add("nanoflann", findByNanoflann);
#else
    report.add({"nanoflann", "-", "-", "-", "not installed (libnanoflann-dev)"});
#endif
#ifdef DEFORMABLE_SURFACE_WITH_PCL
    add("FLANN", findByFlann);
#else
    report.add({"FLANN", "-", "-", "-", "not installed (libpcl-dev)"});
#endif
  }
  report.end();
}

void compareNormals(const Options& options, Report& report) {
  report.begin("peers_normals",
               "14c. Normals from the " + std::to_string(kListed) + " nearest neighbours, which are found too, one thread",
               {"program", "points", "cpu_ms", "ns_per_point", "rms_error_degrees"});
  for (const Index n : kSizes) {
    const Points points = makeWavySheet(n, PointOrder::kScan).positions;
    const auto add = [&](const char* name, auto&& estimate) {
      Points found;
      const Timing timing = measure([&] { found = estimate(points); }, options.budget);
      report.add({name, std::to_string(points.size()), showMilliseconds(timing.cpu), show(1e9 * timing.cpu / points.size()),
                  show(findAngle(points, found))});
    };
    add("deformable_surface", [](const Points& p) { return cloud::estimateNormals(p, cloud::nearestNeighbors(p, kListed)); });
#ifdef DEFORMABLE_SURFACE_WITH_PCL
    add("PCL, float", estimateByPcl);
#else
    report.add({"PCL", "-", "-", "-", "not installed (libpcl-dev)"});
#endif
  }
  report.end();
  report.note(
      "error: angle to the formula's normal, root mean square; the sheet is curved, so that it is that of the plane through so "
      "many points");
}

}  // namespace deformable_surface::benchmark
