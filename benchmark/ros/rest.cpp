// Processor time of a node with a surface at rest, compared with a roscpp node that does nothing, in the same minute.
#include "ros_parts.h"

namespace deformable_surface::benchmark {

void measureRest(const RosOptions& options, RosTable& table) {
  const std::string scene =
      "{model: mass_spring, gravity: [0, 0, 0], simplification: {target_points: 400}, integrator: {time_step: 0.01}, "
      "pins: [{box: {min: [-0.51, -1, -1], max: [-0.49, 1, 1]}}]}";
  const node::test::NodeProcess idle("/idle", "", "benchmark_ros", {"--idle"});
  // The first has no subscribers, the second has some, such as RViz.
  ros::NodeHandle alone("/alone");
  const node::test::NodeProcess unheard("/alone", scene);
  ros::Publisher cloud = alone.advertise<sensor_msgs::PointCloud2>("cloud_in", 1);
  waitFor("/alone to listen", [&] { return cloud.getNumSubscribers() > 0; });
  cloud.publish(makeSquare(10000));
  std::size_t surfaces = 0;
  {
    const ros::Subscriber once =
        alone.subscribe<sensor_msgs::PointCloud2>("deformed", 1, [&](const sensor_msgs::PointCloud2ConstPtr&) { ++surfaces; });
    waitFor("a cloud of /alone", [&] { return surfaces > 0; });
  }
  std::size_t frames = 0;
  ros::NodeHandle heard("/heard");
  const node::test::NodeProcess shown("/heard", scene);
  const ros::Subscriber deformed =
      heard.subscribe<sensor_msgs::PointCloud2>("deformed", 2, [&](const sensor_msgs::PointCloud2ConstPtr&) { ++frames; });
  ros::Publisher other_cloud = heard.advertise<sensor_msgs::PointCloud2>("cloud_in", 1);
  waitFor("/heard to listen", [&] { return other_cloud.getNumSubscribers() > 0 && deformed.getNumPublishers() > 0; });
  other_cloud.publish(makeSquare(10000));
  waitFor("a cloud of /heard", [&] { return frames > 0; });
  letIn(5.0);

  frames = 0;
  const pid_t processes[] = {idle.id(), unheard.id(), shown.id()};
  double used[3];
  for (int k = 0; k < 3; ++k) used[k] = readProcessorSeconds(processes[k]);
  const ros::WallTime begin = ros::WallTime::now();
  letIn(options.rest_seconds);
  const double seconds = (ros::WallTime::now() - begin).toSec();
  for (int k = 0; k < 3; ++k) used[k] = (readProcessorSeconds(processes[k]) - used[k]) / seconds;
  const std::string beside =
      "an idle node of roscpp takes " + show(100.0 * used[0]) + " % of a core; over " + show(seconds) + " s";
  const auto above = [&](double share) { return show(100.0 * (share - used[0])) + " % of a core above the idle node"; };
  table.add("processor time of a surface at rest, nobody listens", above(used[1]), "0.1 % above the idle node", beside);
  table.add("the same with a subscriber of ~deformed", above(used[2]), "0.1 % above the idle node",
            beside + "; " + std::to_string(frames) + " clouds came");
}

}  // namespace deformable_surface::benchmark
