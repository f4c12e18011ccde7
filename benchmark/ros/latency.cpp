// Time from a command to the first cloud that shows it: a force on a surface at rest, repeated, sent at varying times between
// steps.
#include "ros_parts.h"

#include "deformable_surface/PointForce.h"

#include <std_srvs/Trigger.h>

#include <algorithm>
#include <cstring>
#include <stdexcept>
#include <utility>
#include <vector>

namespace deformable_surface::benchmark {
namespace {

constexpr int kRepetitions = 100;
constexpr double kStep = 0.01;  // s
// The points under the force move far more in one step, and rounding far less.
constexpr float kMoved = 1e-6f;  // m

float findLargestDisplacement(const sensor_msgs::PointCloud2& cloud) {
  for (const sensor_msgs::PointField& field : cloud.fields) {
    if (field.name != "displacement") continue;
    float largest = 0.0f;
    for (std::size_t at = field.offset; at + sizeof largest <= cloud.data.size(); at += cloud.point_step) {
      float value;
      std::memcpy(&value, cloud.data.data() + at, sizeof value);
      largest = std::max(largest, value);
    }
    return largest;
  }
  throw std::runtime_error("~deformed has no field displacement");
}

}  // namespace

void measureLatency(const RosOptions&, RosTable& table) {
  Surface surface("/latency",
                  "{model: mass_spring, gravity: [0, 0, 0], simplification: {target_points: 400}, integrator: {time_step: 0.01}, "
                  "pins: [{box: {min: [-0.51, -1, -1], max: [-0.49, 1, 1]}}], output: {publish_rate: 100}}",
                  makeSquare(10000));
  ros::WallTime shown;
  bool is_moved = false;
  const ros::Subscriber deformed =
      surface.handle().subscribe<sensor_msgs::PointCloud2>("deformed", 1, [&](const sensor_msgs::PointCloud2ConstPtr& m) {
        const ros::WallTime now = ros::WallTime::now();
        const bool was_moved = std::exchange(is_moved, findLargestDisplacement(*m) > kMoved);
        if (is_moved && !was_moved) shown = now;
      });
  ros::Publisher force = surface.handle().advertise<PointForce>("force", 1);
  waitFor("the connections of /latency", [&] { return deformed.getNumPublishers() > 0 && force.getNumSubscribers() > 0; });

  PointForce push;
  push.id = "push";
  push.point.x = 0.5;
  push.force.z = 0.1;
  push.radius = 0.05;
  std::vector<double> seconds;
  for (int k = 0; k < kRepetitions; ++k) {
    letIn(0.05 + kStep * k / kRepetitions);
    const ros::WallTime sent = ros::WallTime::now();
    force.publish(push);
    waitFor("a cloud that shows the force", [&] { return is_moved; });
    seconds.push_back((shown - sent).toSec());
    std_srvs::Trigger reset;
    if (!ros::service::call("/latency/reset", reset)) throw std::runtime_error("~reset cannot be called");
    waitFor("a cloud at rest", [&] { return !is_moved; });
  }
  std::sort(seconds.begin(), seconds.end());
  table.add("command to the first ~deformed that shows it",
            showMilliseconds(seconds[seconds.size() / 2]) + " ms; 95 % below " +
                showMilliseconds(seconds[seconds.size() * 95 / 100]) + ", all below " + showMilliseconds(seconds.back()),
            "below " + showMilliseconds(kStep + 0.005) + " ms",
            "10000 points, 400 simulated, step 10 ms, a frame per step, " + std::to_string(kRepetitions) + " forces");
}

}  // namespace deformable_surface::benchmark
