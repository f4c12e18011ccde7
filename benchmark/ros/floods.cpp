// Input that arrives faster than it can be used: the rate of steps, and memory.
#include "ros_parts.h"

#include "deformable_surface/PointForce.h"

#include <atomic>
#include <thread>

namespace deformable_surface::benchmark {
namespace {

std::string makeScene(const std::string& policy) {
  return "{model: mass_spring, simplification: {target_points: 400}, material: {young_modulus: 1.0e4}, sleep: {mode: never}, "
         "integrator: {time_step: 0.01}, pins: [{box: {min: [-0.51, -1, -1], max: [-0.49, 1, 1]}}], input: {policy: " +
         policy + "}}";
}

// Publishes from a thread of its own during its lifetime. period: s, 0 = as fast as possible.
class Flood {
 public:
  template <class Message>
  Flood(ros::Publisher publisher, const Message& message, double period) {
    thread_ = std::thread([this, publisher, message, period]() mutable {
      const ros::WallTime begin = ros::WallTime::now();
      for (std::size_t sent = 0; !is_ended_; ++sent) {
        publisher.publish(message);
        const double ahead = period * static_cast<double>(sent) - (ros::WallTime::now() - begin).toSec();
        if (ahead > 0.0) ros::WallDuration(ahead).sleep();
      }
    });
  }
  ~Flood() {
    is_ended_ = true;
    thread_.join();
  }

 private:
  std::atomic<bool> is_ended_{false};
  std::thread thread_;
};

void measure(const std::string& what, Surface& surface, double before, const RosOptions& options, const std::string& counted,
             RosTable& table) {
  const double memory_before = readMemory(surface.id());
  // Messages given to publish() may have been dropped on their way.
  const double first = surface.diagnostic(counted);
  const ros::WallTime begin = ros::WallTime::now();
  const double during = surface.countSteps(options.seconds);
  const double seconds = (ros::WallTime::now() - begin).toSec();
  const double arrived = (surface.diagnostic(counted) - first) / seconds;
  const double half = readPeakMemory(surface.id());
  surface.countSteps(options.seconds);
  table.add(what, show(during) + " steps/s of " + show(before) + "; at most " + show(readPeakMemory(surface.id())) + " MB",
            "within 20 %",
            show(arrived) + " arrived a second; memory " + show(memory_before) + " MB at its beginning, at most " + show(half) +
                " by the middle");
}

}  // namespace

void measureFloods(const RosOptions& options, RosTable& table) {
  for (const std::string policy : {"ignore", "track", "replace"}) {
    Surface surface("/flood_" + policy, makeScene(policy), makeSquare(10000));
    const double before = surface.countSteps(options.seconds);
    const Flood flood(surface.cloud(), makeSquare(1000000), 0.0);
    measure("clouds of 1,000,000 points as fast as they go, policy " + policy, surface, before, options, "clouds received",
            table);
  }
  Surface surface("/flood_forces", makeScene("ignore"), makeSquare(10000));
  ros::Publisher force = surface.handle().advertise<PointForce>("force", 1000);
  waitFor("/flood_forces to take forces", [&] { return force.getNumSubscribers() > 0; });
  const double before = surface.countSteps(options.seconds);
  PointForce push;
  push.id = "push";
  push.force.z = 0.1;
  push.radius = 0.1;
  const Flood flood(force, push, 0.001);
  measure("1000 forces a second", surface, before, options, "commands applied", table);
}

}  // namespace deformable_surface::benchmark
