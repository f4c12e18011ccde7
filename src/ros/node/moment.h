// A moment of the surface, handed from the stepping thread to the one that shows it.
#pragma once

#include "deformable_surface/ros/convert/surface_output.h"
#include "deformable_surface/simulation/simulation.h"

#include <cstdint>
#include <memory>
#include <optional>
#include <string>

namespace deformable_surface::node {

struct Moment {
  simulation::Snapshot sight;
  std::int64_t stamp = 0;  // ns
  CloudId cloud;
  double time_input = 0.0;                           // s spent on commands in the last step, for the statistics
  std::uint64_t revision = 0, surface_revision = 0;  // of the simulation
  bool is_kept = false;                              // it is shown, also where a newer one comes
  bool all = false;                                  // of one that is kept: clouds and markers too that have not changed
  bool is_result = false;                            // of a call: the cloud is made for later subscribers, too
  // For the first moment of a new surface, at rest; else null and empty:
  std::unique_ptr<simulation::Simulation> viewer;
  std::string frame;
  // If output.normals may have changed.
  std::optional<simulation::SceneParams> params;
};

}  // namespace deformable_surface::node
