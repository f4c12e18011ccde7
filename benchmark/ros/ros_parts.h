// The parts of the benchmark over ROS and their shared functions: clouds as from a camera, and a node with its own statistics.
// Every part starts its own nodes, subscribes to them as any other program would, and adds rows to one table.
#pragma once

#include "report.h"
#include "ros/node_process.h"

#include "deformable_surface/Statistics.h"

#include <ros/ros.h>
#include <sensor_msgs/PointCloud2.h>

#include <cstdint>
#include <cstdio>
#include <functional>
#include <map>
#include <string>

#include <sys/types.h>

namespace deformable_surface::benchmark {

struct RosOptions {
  double seconds = 10.0;       // of wall time that rates are counted over
  double rest_seconds = 60.0;  // that the processor time of a resting node is counted over
};

/// The table: what was measured, found, its target, and under which conditions.
class RosTable {
 public:
  explicit RosTable(Report& report) : report_(report) {}
  void add(const std::string& what, const std::string& found, const std::string& target, const std::string& conditions) {
    report_.add({what, found, target, conditions});
    std::printf("  %s: %s (%s)\n", what.c_str(), found.c_str(), conditions.c_str());
    std::fflush(stdout);
  }

 private:
  Report& report_;
};

void measureLatency(const RosOptions& options, RosTable& table);
void measureClouds(const RosOptions& options, RosTable& table);
void measureManager(const RosOptions& options, RosTable& table);
void measureWrenches(const RosOptions& options, RosTable& table);
void measureFloods(const RosOptions& options, RosTable& table);
void measureRest(const RosOptions& options, RosTable& table);

/// A square metre in z = 0 about the origin, x y z as float32, stamped now.
sensor_msgs::PointCloud2 makeSquare(Index points);

/// s of processor time of all threads that a process has so far.
double readProcessorSeconds(pid_t process);
/// MB that a process holds now, and the most that it ever held.
double readMemory(pid_t process);
double readPeakMemory(pid_t process);

/// Processes messages for that long.
void letIn(double seconds);
/// Processes messages until the condition holds. Throws std::runtime_error with the given text if it does not in time.
void waitFor(const std::string& what, const std::function<bool()>& condition, double seconds = 120.0);

/// A node with a surface, and the last of its ~statistics.
class Surface {
 public:
  /// Starts the node with a scene in YAML, gives it the cloud and waits until the surface is there.
  Surface(const std::string& name, const std::string& scene, const sensor_msgs::PointCloud2& cloud);

  pid_t id() const { return process_.id(); }
  ros::NodeHandle& handle() { return handle_; }
  const Statistics& statistics() const { return statistics_; }
  /// A count of its diagnostics; 0 before the first.
  double diagnostic(const std::string& key) const;
  ros::Publisher& cloud() { return cloud_; }
  /// Steps per second of wall time while messages are processed for that long.
  double countSteps(double seconds);

 private:
  node::test::NodeProcess process_;
  ros::NodeHandle handle_;
  ros::Publisher cloud_;
  ros::Subscriber statistics_subscriber_, diagnostics_subscriber_;
  Statistics statistics_;
  std::uint64_t steps_ = 0;
  std::map<std::string, std::string> diagnostics_;
};

}  // namespace deformable_surface::benchmark
