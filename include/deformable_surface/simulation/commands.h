// What may be asked of a simulation while it runs, as values: a command can be kept, passed on and given to several copies of a
// surface. Apart from the simulation, because whoever carries commands need not know it.
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

/// What each of them does and refuses: see the function of the same name in Simulation.
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
/// Of these only the values that may change while a surface runs are taken (run_time_params.h).
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

/// What a command, or an event within a step, has changed. Dynamics::follow() draws every conclusion from the first ones.
struct Changes {
  bool loads = false;            // which loads act, or how strongly
  bool parts = false;            // whether parts of the surface may sleep
  bool material = false;         // stiffness or masses
  bool motion = false;           // positions, velocities, elastic forces or masses are not those that the last step ended with
  bool everywhere = false;       // all of the surface is disturbed
  std::vector<Index> disturbed;  // else these points

  bool done = true;          // false: there was nothing to do
  bool moved = false;        // points are elsewhere, or others
  Index points = 0;          // simulation points that it concerns
  std::vector<Index> added;  // ids of new particles
  std::string notice;
};

}  // namespace deformable_surface::simulation
