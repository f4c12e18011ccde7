// Everything that a dynamics needs to continue from a state, bit for bit, as one value: the content of a snapshot, and what a
// refused step restores.
#pragma once

#include "deformable_surface/simulation/evolution.h"
#include "deformable_surface/simulation/grips.h"
#include "deformable_surface/simulation/region_material.h"
#include "deformable_surface/simulation/run_time_params.h"
#include "deformable_surface/solve/time_march.h"

#include "activity.h"
#include "load_set.h"
#include "tool_watch.h"

namespace deformable_surface::simulation {

struct DynamicsState {
  /// Changed by time alone and by moving tools, also of a surface that sleeps.
  struct Waiting {
    std::uint64_t steps = 0;
    std::vector<NamedForces::Named> forces;
    std::vector<ToolWatch::Seen> watched;
    Activity::Memory activity;
    solve::TimeMarch::Memory march, part_march;
    bool has_part = false;
  };
  /// Where the points are and which are held: changed by steps and commands of a surface that is awake.
  struct Motion {
    model::State points;
    std::vector<char> pinned, pinned_turns;     // (n) pinned: of PinMark
    std::vector<model::ClampEdge> clamp_edges;  // of the pins, ascending
    double membrane_share = 1.0;                // of the stated membrane stiffness, that acts
    double contact_rate = 0.0;                  // 1/s; 0: not found yet
    Points followed;                            // m, positions at the last followPartners() of the model; or empty
  };
  /// What tools and pins hold and have done, and the method that takes the steps. Changed as Motion is.
  struct Holding {
    solve::IntegratorType integrator = solve::IntegratorType::kAuto;
    std::vector<Grips::Grip> grips;
    std::vector<ContactLoad::Body> bodies;
    std::shared_ptr<const Evolution::Memory> evolution;
    std::vector<TrackLoad::Seen> tracked;
    SelfContactLoads::Memory self_contact;
    UntanglingProgress untangling;
  };
  /// Changed by commands only.
  struct Settings {
    std::vector<tool::ToolParams> tools;
    std::vector<PointValues> values;  // (n) materials of points that differ from the general one; empty for models without
    Vec3 gravity = Vec3::Zero();      // m/s^2
    double damping = 0.0;             // 1/s
    RunTimePhysics physics;           // of the scene
  };

  Waiting waiting;
  Motion motion;
  Holding holding;
  Settings settings;

  /// Memory in use, except for a few small lists.
  std::size_t bytes() const;
};

}  // namespace deformable_surface::simulation
