// Shared functions of the parts (ros_parts.h).
#include "ros_parts.h"

#include <diagnostic_msgs/DiagnosticArray.h>

#include <cmath>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <stdexcept>

namespace deformable_surface::benchmark {
namespace {

double readStatus(pid_t process, const std::string& key) {
  std::ifstream file("/proc/" + std::to_string(process) + "/status");
  for (std::string line; std::getline(file, line);)
    if (line.rfind(key + ":", 0) == 0) return std::stod(line.substr(key.size() + 1)) / 1024.0;
  throw std::runtime_error("no " + key + " of process " + std::to_string(process));
}

}  // namespace

sensor_msgs::PointCloud2 makeSquare(Index points) {
  const auto side = static_cast<std::uint32_t>(std::lround(std::sqrt(static_cast<double>(points))));
  sensor_msgs::PointCloud2 cloud;
  cloud.header.frame_id = "world";
  cloud.header.stamp = ros::Time::now();
  cloud.width = cloud.height = side;
  cloud.point_step = 12;
  cloud.row_step = cloud.point_step * side;
  cloud.is_dense = true;
  for (const char* name : {"x", "y", "z"}) {
    sensor_msgs::PointField field;
    field.name = name;
    field.offset = static_cast<std::uint32_t>(4 * cloud.fields.size());
    field.datatype = sensor_msgs::PointField::FLOAT32;
    field.count = 1;
    cloud.fields.push_back(field);
  }
  cloud.data.resize(std::size_t{cloud.row_step} * side);
  for (std::uint32_t row = 0; row < side; ++row) {
    for (std::uint32_t column = 0; column < side; ++column) {
      const float point[] = {static_cast<float>(column) / static_cast<float>(side - 1) - 0.5f,
                             static_cast<float>(row) / static_cast<float>(side - 1) - 0.5f, 0.0f};
      std::memcpy(cloud.data.data() + std::size_t{cloud.row_step} * row + std::size_t{cloud.point_step} * column, point,
                  sizeof point);
    }
  }
  return cloud;
}

// The scheduler's own account, in nanoseconds: ticks are too coarse for a node that rests.
double readProcessorSeconds(pid_t process) {
  double seconds = 0.0;
  for (const auto& thread : std::filesystem::directory_iterator("/proc/" + std::to_string(process) + "/task")) {
    double nanoseconds = 0.0;
    if (std::ifstream(thread.path() / "schedstat") >> nanoseconds) seconds += 1e-9 * nanoseconds;
  }
  if (!(seconds > 0.0)) throw std::runtime_error("no processor time of process " + std::to_string(process));
  return seconds;
}

double readMemory(pid_t process) { return readStatus(process, "VmRSS"); }
double readPeakMemory(pid_t process) { return readStatus(process, "VmHWM"); }

void letIn(double seconds) {
  node::test::waitUntil([] { return false; }, seconds);
}

void waitFor(const std::string& what, const std::function<bool()>& condition, double seconds) {
  if (!node::test::waitUntil(condition, seconds)) throw std::runtime_error("waited in vain for " + what);
}

Surface::Surface(const std::string& name, const std::string& scene, const sensor_msgs::PointCloud2& cloud)
    : process_(name, scene), handle_(name) {
  cloud_ = handle_.advertise<sensor_msgs::PointCloud2>("cloud_in", 1);
  // A surface that replaces another begins at step 0.
  statistics_subscriber_ = handle_.subscribe<Statistics>("statistics", 1000, [this](const StatisticsConstPtr& m) {
    steps_ += m->step >= statistics_.step ? m->step - statistics_.step : m->step;
    statistics_ = *m;
  });
  const std::string prefix = name.substr(1) + ": ";
  diagnostics_subscriber_ = handle_.subscribe<diagnostic_msgs::DiagnosticArray>(
      "/diagnostics", 100, [this, prefix](const diagnostic_msgs::DiagnosticArrayConstPtr& m) {
        for (const auto& status : m->status)
          if (status.name.rfind(prefix, 0) == 0)
            for (const auto& value : status.values) diagnostics_[value.key] = value.value;
      });
  waitFor(name + " to listen",
          [this] { return cloud_.getNumSubscribers() > 0 && statistics_subscriber_.getNumPublishers() > 0; });
  cloud_.publish(cloud);
  waitFor("the surface of " + name, [this] { return statistics_.step > 0; });
}

double Surface::diagnostic(const std::string& key) const {
  const auto found = diagnostics_.find(key);
  return found == diagnostics_.end() ? 0.0 : std::atof(found->second.c_str());
}

double Surface::countSteps(double seconds) {
  letIn(0.5);
  const std::uint64_t first = steps_;
  const ros::WallTime begin = ros::WallTime::now();
  letIn(seconds);
  return static_cast<double>(steps_ - first) / (ros::WallTime::now() - begin).toSec();
}

}  // namespace deformable_surface::benchmark
