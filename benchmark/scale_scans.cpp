#include "scale_scans.h"

#include "deformable_surface/base/error.h"
#include "deformable_surface/base/timer.h"
#include "deformable_surface/cloud/kd_tree.h"
#include "deformable_surface/simulation/simulation.h"
#include "heap_counter.h"
#include "measure.h"
#include "physics/samplings.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <memory>
#include <optional>

#ifdef DEFORMABLE_SURFACE_WITH_PCL
#include <pcl/io/pcd_io.h>
#endif

namespace deformable_surface::benchmark {
namespace {

constexpr Index kSimulationPoints = 2000;
constexpr const char* kScans[] = {"open3d_bunny/bunnyData.pcd", "pcl_scans/rops_cloud.pcd",   "ros_package_scans/plane_noisy.pcd",
                                  "pcl_scans/cturtle.pcd",      "pcl_data_kinect/person.pcd", "pcl_scans/five_people.pcd"};

// Standard deviation of the nearest distance over its mean.
double findSpacingVariation(const Points& points) {
  const Lists nearest = cloud::nearestNeighbors(points, 1);
  double sum = 0.0, squares = 0.0;
  for (Index i = 0; i < nearest.size(); ++i) {
    const double distance = (points[*nearest.begin(i)] - points[i]).norm();
    sum += distance;
    squares += distance * distance;
  }
  const double mean = sum / nearest.size();
  return std::sqrt(std::max(0.0, squares / nearest.size() - mean * mean)) / mean;
}

// The largest error of points that move with the simulation, in its extents.
double findRotationError(simulation::Simulation& built) {
  const Mat3 rotation = Eigen::AngleAxisd(1.1, Vec3(0.3, -0.5, 0.8).normalized()).toRotationMatrix();
  model::State turned = built.state();
  Eigen::AlignedBox3d box;
  for (Vec3& p : turned.positions) {
    box.extend(p);
    p = rotation * p;
  }
  built.setState(turned);
  const Points& positions = built.surface(true).positions;
  double error = 0.0;
  for (std::size_t i = 0; i < positions.size(); ++i)
    if (positions[i].allFinite()) error = std::max(error, (positions[i] - rotation * built.input().positions[i]).norm());
  return error / box.sizes().maxCoeff();
}

void addScan(const std::string& name, const cloud::PointCloud& scan, Report& report) {
  simulation::SceneParams scene;
  scene.simplification.target_points = kSimulationPoints;
  const auto num_finite =
      std::count_if(scan.positions.begin(), scan.positions.end(), [](const Vec3& p) { return p.allFinite(); });
  try {
    const double cpu_before = processorSeconds();
    const Timer timer;
    HeapCounter heap;
    simulation::Simulation built(scene, scan);
    heap.stop();
    const double wall = timer.seconds(), cpu = processorSeconds() - cpu_before, points = static_cast<double>(num_finite);
    report.add({name, std::to_string(scan.size()), std::to_string(num_finite), std::to_string(built.state().size()), show(wall),
                show(cpu), show(1e9 * cpu / points), show(static_cast<double>(heap.liveBytes()) / points),
                show(static_cast<double>(heap.peakBytes()) / points), show(findSpacingVariation(built.state().positions)),
                show(findRotationError(built))});
  } catch (const InputError& problem) {
    report.add(
        {name, std::to_string(scan.size()), std::to_string(num_finite), "-", "-", "-", "-", "-", "-", "-", problem.what()});
  }
}

}  // namespace

std::optional<cloud::PointCloud> readScan(const std::string& name) {
#ifdef DEFORMABLE_SURFACE_WITH_PCL
  const std::string path = physics::dataFolder() + "/" + name;
  pcl::PointCloud<pcl::PointXYZ> read;
  if (!std::ifstream(path) || pcl::io::loadPCDFile(path, read) != 0) return std::nullopt;
  cloud::PointCloud scan;
  for (const pcl::PointXYZ& p : read) scan.positions.emplace_back(p.x, p.y, p.z);
  scan.width = read.width;
  scan.height = read.height;
  return scan;
#else
  static_cast<void>(name);
  return std::nullopt;
#endif
}

void measureScans(const Options&, Report& report) {
  report.begin("scale_scans", "13g. Set-up of real scans for " + std::to_string(kSimulationPoints) + " simulation points",
               {"scan", "points", "finite", "simulation_points", "wall_s", "cpu_s", "cpu_ns_per_point", "kept_bytes_per_point",
                "peak_bytes_per_point", "spacing_varies_by", "rotation_error_in_extents"});
  Index num_absent = 0;
  for (const char* name : kScans) {
    const std::optional<cloud::PointCloud> scan = readScan(name);
    if (scan) {
      addScan(name, *scan, report);
    } else {
      ++num_absent;
    }
  }
  report.end();
  if (num_absent > 0) report.note(std::to_string(num_absent) + " are not there; " + kScansAreRead);
  report.note("bytes: of the heap per finite point, after set-up and at its peak, the input apart");
}

}  // namespace deformable_surface::benchmark
