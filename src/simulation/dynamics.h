// The surface as a mechanical system: its state, what holds and loads it, the order of a step, and what of it sleeps. It knows
// nothing of clouds, of error estimates and of what is published: the simulation, its coarser copies and trials all run one.
#pragma once

#include "deformable_surface/base/interrupt.h"
#include "deformable_surface/simulation/commands.h"
#include "deformable_surface/simulation/evolution.h"
#include "deformable_surface/simulation/model_kind.h"
#include "deformable_surface/simulation/rest_surface.h"
#include "deformable_surface/simulation/tool_reaction.h"

#include <functional>
#include <memory>
#include <optional>

#include "active_part.h"
#include "clamp_edges.h"
#include "cloud_follower.h"
#include "dynamics_state.h"
#include "parts.h"

namespace deformable_surface::simulation {

/// Of points from those of the same index, m.
double findLargestDistance(const Points& a, const Points& b);

class Dynamics {
 public:
  /// At rest, at time 0. The model is taken out of the rest surface, which forks share. Throws InputError for what the scene's
  /// tools may not do here.
  Dynamics(const SceneParams& params, RestSurface rest);
  Dynamics(const Dynamics&) = delete;
  Dynamics& operator=(const Dynamics&) = delete;

  /// Another one in the state of this, which goes on as this one would, bit for bit; it shares the rest surface and has a clone
  /// of the model. to_look: no step will be taken from it. Throws InputError if the model cannot be copied.
  std::unique_ptr<Dynamics> fork(bool to_look = false) const;
  DynamicsState save() const;
  /// Of a dynamics of the same surface and scene.
  void restore(const DynamicsState& saved, bool to_look = false);
  /// Back to rest at time 0; pins, forces and tools of the scene stay, those added since go.
  void reset();
  /// How a surface was grown through the particles at rest, if the scene asks for it: a sentence; else empty.
  const std::string& growthNotice() const { return growth_notice_; }

  /// Of commands that were checked (command_checks.h). Edits of particles throw InputError, and change nothing, where they cannot
  /// be done.
  Changes apply(const Command& command);

  // A step has two halves.
  /// Looks what wakes in the step that begins now. False: nothing does, and passStep() is all that is left to do.
  bool beginStep();
  struct Request {
    /// Where the search for a first equilibrium may begin: positions of all points, or none. It is asked only where that may be
    /// worth while.
    std::function<Points(const SceneParams& now)> find_start;
    /// m; > 0: an equilibrium is searched for a second time, from positions that are disturbed by so much.
    double second_search = 0.0;
  };
  struct Outcome {
    bool ok = true;
    std::string failure;     // what was wrong, as the end of "step 3 ..."
    std::string notice;      // what a user should know though all is well; else empty
    bool has_slept = false;  // through the step
    bool has_cut = false;
    bool has_new_arrival = false;                        // see ContactLoad
    std::optional<double> second_distance;               // m, how far the end of the second search is from that of the first
    double contact_seconds = 0.0, search_seconds = 0.0;  // s of wall time
    solve::SolveReport report;
  };
  /// Numbers that went wrong, and an interrupt, never throw: everything is then as before the step; so it is if anything throws.
  Outcome takeStep(const Request& request);
  /// Both halves.
  Outcome step();
  /// Time alone passes.
  Outcome passStep();
  /// As if the last step had not been taken; no command may have come since.
  void undoStep();

  /// See Simulation::setInterrupt().
  void setInterrupt(const std::atomic<bool>* interrupt);
  const std::atomic<bool>* interrupt() const { return interrupt_; }
  /// Cuts are told to this one while they are made; null: to nobody.
  void setCutFollower(CutFollower* follower) { cut_follower_ = follower; }

  // For copies and trials.
  /// Moves every free point by up to size (m) along each axis, always in the same way: what a twin starts from.
  void disturb(double size);
  /// Only this share, in (0, 1], of the stated membrane stiffness acts from now on and after resets, which is at rest; bending
  /// and masses are as stated.
  void softenMembrane(double share);
  void stiffenMembrane() { setMembraneShare(1.0); }  // all of it acts, until the next reset
  double membraneShare() const { return now_.membrane_share; }
  /// A step is taken in fineness times as many sub-steps.
  void setFineness(Index fineness);
  /// From the next step on, in place of that of the params.
  void setIntegrator(solve::IntegratorType type);
  /// The same from now on and after resets.
  void chooseIntegrator(solve::IntegratorType type) { params_.integrator.type = chosen_.integrator = type; }
  /// Whether that is the one that acts, and another than auto.
  bool hasChosenIntegrator() const {
    return chosen_.integrator != solve::IntegratorType::kAuto && params_.integrator.type == chosen_.integrator;
  }

  const SceneParams& params() const { return params_; }  // with the values of now where they may change
  const RestSurface& rest() const { return *rest_; }
  const model::DeformableModel& model() const { return *model_; }
  const ModelKind& kind() const { return kind_; }
  /// See ModelKind; of this model, which it keeps by reference.
  std::unique_ptr<CloudFollower> makeFollower() const { return kind_.makeFollower(*rest_, params_, *model_); }
  const solve::System& system() const { return system_; }
  const LoadSet& loads() const { return loads_; }
  const Grips& grips() const { return grips_; }
  const Activity& activity() const { return activity_; }
  /// Throws InputError for what tools may not do to this surface.
  void requireTools(const std::vector<tool::ToolParams>& tools) const;

  double time() const { return static_cast<double>(steps_) * params_.integrator.time_step; }
  std::uint64_t stepCount() const { return steps_; }
  const model::State& state() const { return now_.points; }
  const std::vector<char>& pinned() const { return now_.pinned; }
  const std::vector<char>& held() const { return held_; }  // (n) pinned, gripped or held by the evolution
  const std::vector<tool::ToolParams>& tools() const { return tools_; }
  Index numOwnMaterial() const;
  /// Of the last step.
  solve::IntegratorType lastIntegrator() const { return lastMarch().lastType(); }
  Index lastSubsteps() const { return last_substeps_; }
  /// Another number whenever anything that can be asked for may be another, but the time.
  std::uint64_t revision() const { return revision_; }
  /// See Simulation.
  bool hasSnapped() const;
  std::vector<ToolReaction> toolReactions() const;
  std::vector<Contact> contacts() const;
  std::vector<SelfTouch> selfTouches() const;
  std::vector<PinReaction> pinReactions() const;

  /// See ContactLoad.
  void adoptArrivals(const ContactLoad& other) { loads_.contact.adoptArrivals(other); }

 private:
  struct Made {
    std::shared_ptr<const RestSurface> rest;
    std::unique_ptr<model::DeformableModel> model;
  };
  static Made take(RestSurface&& rest);
  Dynamics(const SceneParams& params, Made made);

  // How it is made and set.
  std::vector<AnchorLoad::Anchor> makeAnchors() const;
  void placePins();
  void placeAnchors();
  void clampHeld();
  std::vector<Index> findClamps(const std::vector<char>& inside, const Contains& contains);
  void endClamps();
  std::size_t findPin(Index point) const;
  void setTools(std::vector<tool::ToolParams> tools);
  void giveContactTools();
  bool applyMaterial();
  void followMaterial();
  void setMembraneShare(double share);
  bool hasContact(const std::vector<tool::ToolParams>& tools) const;
  void setContactRate(double rate);
  void findContactRate();
  void findContactRateAgain();

  // Commands.
  Changes perform(const command::SetForce& c);
  Changes perform(const command::RemoveForce& c);
  Changes perform(const command::SetTool& c);
  Changes perform(const command::MoveTool& c);
  Changes perform(const command::RemoveTool& c);
  Changes perform(const command::Pin& c);
  Changes perform(const command::PinAlong& c);
  Changes perform(const command::MovePin& c);
  Changes perform(const command::Unpin& c);
  Changes perform(const command::SetGravity& c);
  Changes perform(const command::SetMaterial& c);
  Changes perform(const command::SetDamping& c);
  Changes perform(const command::SetParams& c);
  Changes perform(const command::Observe& c);
  Changes perform(const command::SetState& c);
  Changes perform(const command::EditParticles& c);
  Changes perform(const command::GrowSurface& c);
  Changes replaceTools(std::vector<tool::ToolParams> tools);
  std::vector<Index> pinInside(const geometry::Region& region, std::vector<char>& inside);
  Changes changeForce(const std::string& id);
  void follow(const Changes& changes);

  // What a checkpoint and a snapshot hold.
  void keepWaiting(DynamicsState::Waiting& waiting) const;
  void keepHolding(DynamicsState::Holding& holding) const;
  void giveBack(const DynamicsState& saved, bool to_look);

  // A step and its parts.
  void carryOut(const Request& request, std::optional<InterruptScope>& scope, Outcome& outcome);
  static void refuse(const std::string& why, Outcome& outcome);
  bool beginElsewhere(const Request& request);
  bool isHeldAround() const;
  void findLoose(double time);
  std::string holdLoose();
  std::optional<double> searchAgain(double now, double disturbance, model::State& start) const;
  void disturb(double size, Points& positions) const;
  Grips::Update updateGrips(double now, double dt);
  std::string live(double now, double dt);
  void followPopulation(const Population& population);

  // What is awake.
  bool canBeInParts() const;
  bool maySleep() const;
  solve::TimeMarch& lastMarch() { return part_ ? part_->march() : march_; }
  const solve::TimeMarch& lastMarch() const { return part_ ? part_->march() : march_; }
  void setParts();
  void followPartners(const Points& positions);
  void makePart();
  void wakeAll();
  void followLoads();
  NamedForces::Update wakeForStep(double now, double dt);
  void beginAsleep(double now);
  solve::TimeMarch::Outcome advance(double now);
  solve::TimeMarch::Outcome advanceWhole(double now);
  void considerSleep(const solve::SolveReport& report);

  SceneParams params_;  // with the integrator and the physics of now

  // Made once from the rest state: what forks share, and what each has for itself.
  const std::shared_ptr<const RestSurface> rest_;
  const std::unique_ptr<model::DeformableModel> model_;
  const ModelKind& kind_;
  const std::unique_ptr<Evolution> evolution_;

  // What a DynamicsState holds: as it is, or as the memories of those that it acts by.
  DynamicsState::Motion now_;
  std::uint64_t steps_ = 0;
  std::vector<tool::ToolParams> tools_;
  std::vector<PointValues> values_;
  LoadSet loads_;
  Grips grips_;
  std::vector<char> held_, held_turns_;  // pinned, gripped or held by the evolution
  solve::System system_;
  solve::TimeMarch march_;
  Activity activity_;
  ToolWatch tool_watch_;
  std::unique_ptr<ActivePart> part_;     // null: to be made when it is needed
  solve::TimeMarch::Memory part_march_;  // that a part which is made goes on from

  // What resets and snapshots leave as it is.
  struct Chosen {
    double membrane_share = 1.0;                                      // from each reset on
    solve::IntegratorType integrator = solve::IntegratorType::kAuto;  // another: in the place of auto, from each reset on
    model::MaterialParams made;                                       // what the model was made with
  } chosen_;
  std::vector<model::PointMaterial> shares_;  // values_ as the model has them; empty: as it was made
  Index fineness_ = 1;
  const std::atomic<bool>* interrupt_ = nullptr;
  CutFollower* cut_follower_ = nullptr;

  std::uint64_t revision_ = 0;
  std::string growth_notice_;
  Index last_substeps_ = 0;
  LooseParts loose_;               // of static steps
  bool has_said_stopped_ = false;  // since the last reset
  Index loose_said_ = 0;           // points of loose parts, as said last since the last reset
  DynamicsState before_;           // the step that is taken, or was taken last; without settings, and if it slept, without motion
  bool has_slept_ = false;         // through that step
  NamedForces::Update woken_;      // by the step that is taken
  bool has_woken_ = false;         // in its first half
  // Scratch.
  std::vector<Index> hits_, moving_;                   // moving: points on pins that move in the step
  std::vector<double> load_stiffness_, load_damping_;  // N/m, N s/m
  mutable Points forces_on_all_;                       // N
};

}  // namespace deformable_surface::simulation
