// Clouds received per second: in another process over a socket, and in the same nodelet manager without a copy.
#include "ros_parts.h"

#include <nodelet/loader.h>

#include <stdexcept>

namespace deformable_surface::benchmark {
namespace {

// A sheet that swings for ever.
std::string makeScene(int target_points, double publish_rate) {
  return "{model: mass_spring, simplification: {target_points: " + std::to_string(target_points) +
         "}, material: {young_modulus: 1.0e4}, integrator: {time_step: 0.01}, sleep: {mode: never}, "
         "pins: [{box: {min: [-0.51, -1, -1], max: [-0.49, 1, 1]}}], output: {publish_rate: " +
         std::to_string(publish_rate) + "}}";
}

struct Count {
  double frames = 0.0, steps = 0.0;  // per second
};

std::string show(const Count& count) {
  return benchmark::show(count.frames) + " clouds/s at " + benchmark::show(count.steps) + " steps/s";
}

}  // namespace

void measureClouds(const RosOptions& options, RosTable& table) {
  Surface surface("/clouds", makeScene(700, 30.0), makeSquare(100000));
  std::size_t frames = 0;
  const ros::Subscriber deformed = surface.handle().subscribe<sensor_msgs::PointCloud2>(
      "deformed", 2, [&](const sensor_msgs::PointCloud2ConstPtr&) { ++frames; });
  waitFor("clouds of /clouds", [&] { return frames > 3; });
  const double used = readProcessorSeconds(surface.id());
  const ros::WallTime begin = ros::WallTime::now();
  frames = 0;
  Count count;
  count.steps = surface.countSteps(options.seconds);
  const double seconds = (ros::WallTime::now() - begin).toSec();
  count.frames = static_cast<double>(frames) / seconds;
  table.add("clouds of 100,000 points with normals, to one subscriber", show(count), "30 clouds/s at 100 steps/s",
            "700 simulated, publish_rate 30, node takes " +
                benchmark::show((readProcessorSeconds(surface.id()) - used) / seconds) + " of two cores; last step " +
                showMilliseconds(surface.statistics().time_total) + " ms, frame " +
                showMilliseconds(surface.statistics().time_publish) + " ms");
}

void measureManager(const RosOptions& options, RosTable& table) {
  const std::string name = "/million";
  ros::param::set(name, node::test::toXmlRpc(io::parseYaml(makeScene(2000, 30.0), name)));
  nodelet::Loader manager(false);
  if (!manager.load(name, "deformable_surface/DeformableSurfaceNodelet", {}, {}))
    throw std::runtime_error("the nodelet cannot be loaded");
  ros::NodeHandle handle(name);
  ros::Publisher cloud = handle.advertise<sensor_msgs::PointCloud2>("cloud_in", 1);
  std::size_t frames = 0;
  Statistics statistics;
  const ros::Subscriber deformed =
      handle.subscribe<sensor_msgs::PointCloud2>("deformed", 2, [&](const sensor_msgs::PointCloud2ConstPtr&) { ++frames; });
  const ros::Subscriber news =
      handle.subscribe<Statistics>("statistics", 100, [&](const StatisticsConstPtr& m) { statistics = *m; });
  waitFor("the nodelet to listen", [&] { return cloud.getNumSubscribers() > 0; });
  cloud.publish(makeSquare(1000000));
  waitFor(
      "clouds of a million points", [&] { return frames > 3; }, 600.0);
  frames = 0;
  const std::uint64_t first = statistics.step;
  const ros::WallTime begin = ros::WallTime::now();
  letIn(options.seconds);
  const double seconds = (ros::WallTime::now() - begin).toSec();
  table.add("clouds of 1,000,000 points with normals, in a nodelet manager",
            show(Count{static_cast<double>(frames) / seconds, static_cast<double>(statistics.step - first) / seconds}),
            "10 clouds/s",
            "2000 simulated, publish_rate 30, step 10 ms; last step " + showMilliseconds(statistics.time_total) + " ms, frame " +
                showMilliseconds(statistics.time_publish) + " ms");
  manager.unload(name);
}

}  // namespace deformable_surface::benchmark
