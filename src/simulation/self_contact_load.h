// Contact of the surface with itself for the solver: loads on the simulation points and a limit of their motion. The contact room
// itself does not depend on the solver.
#pragma once

#include "deformable_surface/contact/self_contact.h"
#include "deformable_surface/model/deformable_model.h"
#include "deformable_surface/simulation/rest_surface.h"
#include "deformable_surface/solve/external_load.h"
#include "deformable_surface/solve/motion_limit.h"

#include <algorithm>
#include <memory>
#include <vector>

#include "contact_skin.h"

namespace deformable_surface::simulation {

/// m: contact.thickness, or what `auto` stands for.
double findContactThickness(const SceneParams& params, const RestSurface& rest);

/// The springs that push near parts apart.
class SelfContactLoad : public solve::ExternalLoad {
 public:
  explicit SelfContactLoad(contact::SelfContact& contact) : contact_(contact) {}

  void addForces(double, const model::State& state, Points& forces) const override {
    contact_.addForces(state.positions, forces);
  }
  bool isConservative() const override { return true; }
  double potential(double, const model::State& state) const override { return contact_.potential(state.positions); }
  double storedEnergy(double, const model::State& state) const override { return contact_.potential(state.positions); }
  void addStiffness(double, const model::State& state, double step, BlockSparse& stiffness) const override {
    contact_.addStiffness(state.positions, state.velocities, step, stiffness);
  }
  void addRowBounds(double, const model::State& state, std::vector<double>& stiffness, std::vector<double>&) const override {
    contact_.addStiffnessBounds(state.positions, stiffness);
  }

 private:
  contact::SelfContact& contact_;
};

/// The damping of these springs. Its stiffness is that of SelfContactLoad, which acts whenever this one does.
class SelfContactDamping : public solve::ExternalLoad {
 public:
  explicit SelfContactDamping(contact::SelfContact& contact) : contact_(contact) {}

  void addForces(double, const model::State& state, Points& forces) const override {
    contact_.addDampingForces(state.positions, state.velocities, forces);
  }
  bool isSplitOff() const override { return true; }
  double estimateWork(double, double, const model::State&, const model::State&) const override { return 0.0; }
  void addRowBounds(double, const model::State& state, std::vector<double>&, std::vector<double>& damping) const override {
    contact_.addDampingBounds(state.positions, damping);
  }

 private:
  contact::SelfContact& contact_;
};

/// Friction between parts. Dissipative, except for the energy that its springs return. Its damping has the bounds of
/// SelfContactDamping.
class SelfFriction : public solve::ExternalLoad {
 public:
  explicit SelfFriction(contact::SelfContact& contact) : contact_(contact) {}

  void addForces(double, const model::State& state, Points& forces) const override {
    contact_.addFriction(state.positions, state.velocities, state.self_friction, forces);
  }
  bool isSplitOff() const override { return true; }
  void addForcesAtRest(double, const model::State& state, Points& forces) const override {
    contact_.addFrictionAtRest(state.positions, state.self_friction, forces);
  }
  double estimateWork(double, double, const model::State& before, const model::State& after) const override {
    return std::max(0.0, contact_.frictionEnergy(before.positions, before.self_friction) -
                             contact_.frictionEnergy(after.positions, after.self_friction));
  }
  void addStiffness(double, const model::State& state, double step, BlockSparse& stiffness) const override {
    contact_.addFrictionStiffness(state.positions, state.velocities, state.self_friction, step, stiffness);
  }
  void remember(double, double step, model::State& state) const override {
    contact_.moveAnchors(state.positions, state.velocities, step, state.self_friction);
  }

 private:
  contact::SelfContact& contact_;
};

/// How far crossed parts have been pushed apart.
struct UntanglingProgress {
  Index fewest = 0;   // crossings of an edge and a triangle, since the state was given
  double time = 0.0;  // s, since there were as few for the first time
  bool is_told = false;
};

/// The forces that push apart what crosses.
class Untangling : public solve::ExternalLoad {
 public:
  explicit Untangling(contact::SelfContact& contact) : contact_(contact) {}

  void addForces(double, const model::State& state, Points& forces) const override {
    contact_.addPushes(state.velocities, forces);
  }
  bool isSplitOff() const override { return true; }
  double estimateWork(double, double, const model::State& before, const model::State& after) const override {
    return contact_.workOfPushes(before.positions, after.positions);
  }
  void addStiffness(double, const model::State&, double step, BlockSparse& stiffness) const override {
    contact_.addPushStiffness(step, stiffness);
  }
  void addRowBounds(double, const model::State&, std::vector<double>&, std::vector<double>& damping) const override {
    contact_.addPushRowBounds(damping);
  }

 private:
  contact::SelfContact& contact_;
};

class SelfContactLimit : public solve::MotionLimit {
 public:
  SelfContactLimit(contact::SelfContact& contact, std::vector<Index> parts) : contact_(contact), parts_(std::move(parts)) {}

  const std::vector<Index>& limit(const Points& before, Points& after, bool continues) const override {
    const std::vector<Index>& stopped = contact_.limit(before, after, continues);
    stopped_.resize(before.size(), 0);
    for (const Index i : stopped) stopped_[i] = 1;
    return stopped;
  }
  const std::vector<Index>& parts() const override { return parts_; }
  void setParts(std::vector<Index> parts) { parts_ = std::move(parts); }
  /// Number of points stopped since the last forgetStopped().
  Index numStopped() const { return std::count(stopped_.begin(), stopped_.end(), char{1}); }
  const std::vector<char>& stopped() const { return stopped_; }  // (n), or empty before the first limit()
  void forgetStopped() { std::fill(stopped_.begin(), stopped_.end(), char{0}); }

 private:
  contact::SelfContact& contact_;
  std::vector<Index> parts_;           // (n)
  mutable std::vector<char> stopped_;  // (n)
};

/// Loads and limit of one surface.
class SelfContactLoads {
 public:
  /// rest: (n) m. params: the rate is set later.
  SelfContactLoads(const Points& rest, std::shared_ptr<const ContactSkin> skin, const model::DeformableModel& model,
                   const contact::SelfContactParams& params);
  SelfContactLoads(const SelfContactLoads&) = delete;
  SelfContactLoads& operator=(const SelfContactLoads&) = delete;

  const std::shared_ptr<const ContactSkin>& skin() const { return skin_; }
  /// Leaves out what is no longer among the triangles of the model.
  void followCut(const model::DeformableModel& model);
  /// Checks whether the loads may act in a step of this length (s), and chooses how to push crossed parts apart if they are to be
  /// (`untangles`). Returns whether other loads act than before.
  bool beginStep(const model::State& state, double step, bool untangles);
  /// What crosses now has no contact, and nothing is pushed until the next step.
  void followCrossings(const Points& positions);
  /// What the next step depends on.
  struct Memory {
    bool may_act = false;  // in the last step
    std::shared_ptr<const contact::ClearMotion> proven;
  };
  Memory memory() const { return {may_act_, contact.proven()}; }
  void setMemory(const Memory& memory);
  bool mayAct() const { return may_act_; }
  bool pushes() const { return pushes_; }
  bool rubs() const { return rubs_; }
  void setMayAct(bool may_act) { may_act_ = may_act; }
  /// Number of points stopped since the step began.
  Index numStopped() const { return limit.numStopped(); }

  contact::SelfContact contact;
  const SelfContactLoad springs{contact};
  const SelfContactDamping damping{contact};
  const SelfFriction friction{contact};
  const Untangling untangling{contact};
  SelfContactLimit limit;

 private:
  const std::shared_ptr<const ContactSkin> skin_;
  std::vector<char> is_whole_;  // (triangles)
  const bool rubs_;
  bool may_act_ = false, pushes_ = false;
};

}  // namespace deformable_surface::simulation
