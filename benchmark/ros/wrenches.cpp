// Rate and regularity of contact wrenches for a haptic device.
#include "ros_parts.h"

#include "deformable_surface/ToolArray.h"

#include <geometry_msgs/WrenchStamped.h>

#include <algorithm>
#include <stdexcept>
#include <vector>

namespace deformable_surface::benchmark {

void measureWrenches(const RosOptions& options, RosTable& table) {
  Surface surface(
      "/haptic",
      "{model: mass_spring, gravity: [0, 0, 0], simplification: {target_points: 300}, material: {young_modulus: 1.0e4, "
      "damping: 1.0}, integrator: {time_step: 0.001}, pins: [{box: {min: [-0.51, -1, -1], max: [-0.49, 1, 1]}}, "
      "{box: {min: [0.49, -1, -1], max: [0.51, 1, 1]}}], output: {publish_rate: 30}}",
      makeSquare(10000));
  ros::Publisher tools = surface.handle().advertise<ToolArray>("tools", 1);
  std::vector<ros::WallTime> came;
  std::size_t frames = 0, touches = 0;
  const ros::Subscriber wrench = surface.handle().subscribe<geometry_msgs::WrenchStamped>(
      "tools/ball/wrench", 1000, [&](const geometry_msgs::WrenchStampedConstPtr& m) {
        came.push_back(ros::WallTime::now());
        touches += m->wrench.force.z != 0.0;
      });
  const ros::Subscriber deformed = surface.handle().subscribe<sensor_msgs::PointCloud2>(
      "deformed", 2, [&](const sensor_msgs::PointCloud2ConstPtr&) { ++frames; });
  waitFor("/haptic to take tools", [&] { return tools.getNumSubscribers() > 0; });
  ToolArray ball;
  ball.tools.resize(1);
  ball.tools[0].id = "ball";
  ball.tools[0].primitive.type = shape_msgs::SolidPrimitive::SPHERE;
  ball.tools[0].primitive.dimensions = {0.1};
  ball.tools[0].pose.position.z = 0.08;
  tools.publish(ball);
  waitFor("wrenches", [&] { return touches > 10; });

  came.clear();
  frames = 0;
  const ros::WallTime begin = ros::WallTime::now();
  const double steps = surface.countSteps(options.seconds);
  const double seconds = (ros::WallTime::now() - begin).toSec();
  std::vector<double> apart;
  for (std::size_t k = 1; k < came.size(); ++k) apart.push_back((came[k] - came[k - 1]).toSec());
  std::sort(apart.begin(), apart.end());
  if (apart.empty()) throw std::runtime_error("no wrenches came");
  table.add("wrenches of a ball that presses",
            show(static_cast<double>(came.size()) / seconds) + " /s at " + show(steps) + " steps/s; 99 % of them at most " +
                showMilliseconds(apart[apart.size() * 99 / 100]) + " ms apart",
            "500 /s",
            "300 simulated points, step 1 ms, a cloud of 10,000 points beside it at " +
                show(static_cast<double>(frames) / seconds) + " /s");
}

}  // namespace deformable_surface::benchmark
