// Commands to a running simulation as values: they can be stored, passed on and given to several copies of a surface. Code that
// only passes commands on does not need the simulation.
#pragma once

#include "deformable_surface/geometry/region.h"
#include "deformable_surface/model/deformable_model.h"
#include "deformable_surface/model/oriented_particles/growth_params.h"
#include "deformable_surface/simulation/observed_cloud.h"
#include "deformable_surface/simulation/particle_edit.h"
#include "deformable_surface/simulation/run_time_params.h"
#include "deformable_surface/tool/tool.h"

#include <memory>
#include <optional>
#include <string>
#include <variant>
#include <vector>

namespace deformable_surface::simulation {

/// Meaning and refusals of each command: see the function of the same name in Simulation.
namespace command {

struct SetForce {
  ForceParams force;
};
struct RemoveForce {
  std::string id;
};
struct SetTool {
  tool::ToolParams tool;
};
struct MoveTool {
  std::string id;
  std::vector<tool::WaypointParams> path;
};
struct RemoveTool {
  std::string id;
};
struct Pin {
  geometry::Region region;
  bool orientation = false;
};
struct PinAlong {
  std::string id;
  geometry::Region region;
  std::vector<tool::WaypointParams> path;
};
struct MovePin {
  std::string id;
  std::vector<tool::WaypointParams> path;
};
struct Unpin {
  geometry::Region region;
};
struct SetGravity {
  Vec3 gravity;  // m/s^2, in the surface's frame
};
struct SetMaterial {
  std::optional<geometry::Region> region;  // none: everywhere
  MaterialChangeParams change;
};
struct SetDamping {
  double damping;  // 1/s
};
/// Only the values that may change while a surface runs are used (run_time_params.h).
struct SetParams {
  SceneParams params;
};
struct Observe {
  std::shared_ptr<const ObservedCloud> cloud;
};
struct SetState {
  model::State state;
};
struct EditParticles {
  ParticleEdit edit;
};
struct GrowSurface {
  model::GrowthParams growth;
};

}  // namespace command

using Command = std::variant<command::SetForce, command::RemoveForce, command::SetTool, command::MoveTool, command::RemoveTool,
                             command::Pin, command::PinAlong, command::MovePin, command::Unpin, command::SetGravity,
                             command::SetMaterial, command::SetDamping, command::SetParams, command::Observe, command::SetState,
                             command::EditParticles, command::GrowSurface>;

/// What a command, or an event within a step, has changed. Dynamics::follow() acts on the first group of members.
struct Changes {
  bool loads = false;            // which loads act, or how strongly
  bool parts = false;            // whether parts of the surface may sleep
  bool material = false;         // stiffness or masses
  bool motion = false;           // positions, velocities, elastic forces or masses have changed since the end of the last step
  bool everywhere = false;       // all of the surface is disturbed
  std::vector<Index> disturbed;  // else these points

  bool done = true;          // false: there was nothing to do
  bool moved = false;        // points are elsewhere, or others
  Index points = 0;          // number of simulation points concerned
  std::vector<Index> added;  // ids of new particles
  std::string notice;
};

}  // namespace deformable_surface::simulation
