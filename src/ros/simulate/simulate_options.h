// The command line of `simulate`, as values.
#pragma once

#include "deformable_surface/base/types.h"

#include <map>
#include <set>
#include <string>
#include <vector>

namespace deformable_surface::node {

struct SimulateOptions {
  bool help = false;
  bool version = false;
  bool check = false;  // nothing is built
  bool quiet = false;
  bool strict = false;  // expectations that are not kept are an error
  std::string scene;
  std::vector<std::string> assignments;  // KEY=VALUE of --set, then of --duration and --threads
  std::string final_file, filtered_file, frames_directory, statistics_file, bag_in, bag_out, wrenches_file,
      mesh_file;                              // empty = not wanted
  Index mesh_pieces = 1;                      // of an edge of mesh_file
  std::vector<std::string> measured;          // quantities, as in expect
  double frame_rate = 0.0;                    // Hz; 0 = output.publish_rate
  std::map<std::string, std::string> topics;  // of bag_in: cloud_in, force, wrench, tools -> topic
  std::set<std::string> given_topics;         // names that --topic gave
};

/// Throws InputError with all problems at once.
SimulateOptions parseOptions(const std::vector<std::string>& arguments);

/// What --help prints.
std::string describeOptions();

}  // namespace deformable_surface::node
