// All loads that a surface can have, and which of them act. The dynamics and the awake part of a surface, with
// fewer points, both have one.
#pragma once

#include "deformable_surface/simulation/contact_damping.h"
#include "deformable_surface/simulation/friction_load.h"
#include "deformable_surface/simulation/guide_load.h"
#include "deformable_surface/simulation/loads.h"
#include "deformable_surface/simulation/track_load.h"

#include <memory>
#include <vector>

#include "self_contact_load.h"

namespace deformable_surface::simulation {

class LoadSet {
 public:
  /// model is kept by reference.
  LoadSet(const model::DeformableModel& model, const SceneParams& params);
  LoadSet(const LoadSet&) = delete;
  LoadSet& operator=(const LoadSet&) = delete;

  GravityLoad gravity;
  PressureLoad pressure;
  DragLoad drag;
  AnchorLoad anchors{{}};
  NamedForces forces;
  ContactLoad contact;
  ContactDamping contact_damping;
  FrictionLoad friction;
  TrackLoad track;
  GuideLoad guide;
  /// Null: the surface may pass through itself. Not for parts.
  std::unique_ptr<SelfContactLoads> self_contact;

  /// The loads that can act, which a solver evaluates, in a fixed order.
  const std::vector<const solve::ExternalLoad*>& acting() const { return acting_; }
  /// To be called after a load has become empty, or is no longer empty.
  void choose();

  /// Of the springs by which points stick to tools and to the surface itself, at a time (s), J.
  double frictionEnergy(double time, const model::State& state) const;

  /// Takes the loads of a larger surface: new_index (of its points) is the index here, or -1. Observed clouds are
  /// omitted: they keep the whole surface awake.
  void takePart(const LoadSet& whole, const std::vector<Index>& new_index);

 private:
  std::vector<const solve::ExternalLoad*> acting_;
};

}  // namespace deformable_surface::simulation
