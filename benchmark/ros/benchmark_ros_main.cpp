// The benchmark over ROS: nodes in processes of their own, or a nodelet, measured from another program. The options are those of
// scripts/benchmark_ros.
#include "ros_parts.h"

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <iterator>
#include <string>
#include <vector>

namespace deformable_surface::benchmark {
namespace {

struct Part {
  const char* name;
  void (*run)(const RosOptions&, RosTable&);
};
constexpr Part kParts[] = {{"latency", measureLatency},   {"clouds", measureClouds}, {"manager", measureManager},
                           {"wrenches", measureWrenches}, {"floods", measureFloods}, {"rest", measureRest}};

int fail(const std::string& problem) {
  std::fprintf(stderr, "benchmark_ros: %s\n", problem.c_str());
  return 2;
}

int run(int argc, char** argv) {
  RosOptions options;
  std::string folder = ".";
  std::vector<std::string> wanted;
  for (int i = 1; i < argc; ++i) {
    const std::string argument = argv[i];
    if (argument == "--idle") {
      ros::NodeHandle keep_alive;
      ros::spin();
      return 0;
    }
    if (argument == "--quick") {
      options = {2.0, 10.0};
    } else if ((argument == "--only" || argument == "--output") && i + 1 < argc) {
      (argument == "--only" ? wanted.emplace_back() : folder) = argv[i + 1];
      ++i;
    } else {
      return fail("found '" + argument + "'; accepted: --quick, --only PART, --output FOLDER");
    }
  }
  std::string names;
  for (const Part& part : kParts) names += (names.empty() ? "" : ", ") + std::string(part.name);
  for (const std::string& name : wanted)
    if (std::none_of(std::begin(kParts), std::end(kParts), [&](const Part& part) { return name == part.name; }))
      return fail("--only: found '" + name + "'; accepted: " + names);

  double load[3] = {0.0, 0.0, 0.0};
  getloadavg(load, 3);
  std::printf("load before: %.1f %.1f %.1f\n", load[0], load[1], load[2]);
  ros::NodeHandle keep_alive;
  Report report(folder);
  report.begin("ros", "Over ROS", {"what", "found", "target", "conditions"});
  RosTable table(report);
  for (const Part& part : kParts)
    if (wanted.empty() || std::find(wanted.begin(), wanted.end(), part.name) != wanted.end()) part.run(options, table);
  std::printf("\n");
  report.end();
  return 0;
}

}  // namespace
}  // namespace deformable_surface::benchmark

int main(int argc, char** argv) {
  ros::init(argc, argv, "benchmark_ros");
  try {
    return deformable_surface::benchmark::run(argc, argv);
  } catch (const std::exception& problem) {
    std::fprintf(stderr, "benchmark_ros: %s\n", problem.what());
    return 1;
  }
}
