// The mechanical system: state, constraints, loads, the order of a step, and sleep. It knows nothing of clouds, error estimates
// and published data. The simulation, its coarser copies and trials each run one.
#pragma once

#include "deformable_surface/base/interrupt.h"
#include "deformable_surface/simulation/commands.h"
#include "deformable_surface/simulation/evolution.h"
#include "deformable_surface/simulation/model_kind.h"
#include "deformable_surface/simulation/rest_surface.h"
#include "deformable_surface/simulation/tool_reaction.h"

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>

#include "active_part.h"
#include "burst.h"
#include "clamp_edges.h"
#include "cloud_follower.h"
#include "dynamics_state.h"
#include "jam.h"
#include "parts.h"

namespace deformable_surface::simulation {

/// The largest distance between points of the same index, m.
double findLargestDistance(const Points& a, const Points& b);

class Dynamics {
 public:
  /// At rest, at time 0. Takes the model out of the rest surface; forks share the rest. Throws InputError if the scene's
  /// tools are not accepted on this surface.
  Dynamics(const SceneParams& params, RestSurface rest);
  Dynamics(const Dynamics&) = delete;
  Dynamics& operator=(const Dynamics&) = delete;

  /// Another one in the same state. It continues as this one would, bit for bit; it shares the rest surface and has a clone
  /// of the model. to_look: no step will be taken from it. Throws InputError if the model cannot be copied.
  std::unique_ptr<Dynamics> fork(bool to_look = false) const;
  DynamicsState save() const;
  /// saved: from a dynamics of the same surface and scene.
  void restore(const DynamicsState& saved, bool to_look = false);
  /// Back to rest at time 0. Pins, forces and tools of the scene stay; later ones are removed.
  void reset();
  /// The result of growing a surface through the particles at rest, if the scene asks for it: a sentence; else empty.
  const std::string& growthNotice() const { return growth_notice_; }
  /// Why contact.self: auto is off; empty: it is on, or not auto.
  const std::string& whyNoSelfContact() const { return why_no_self_contact_; }
  /// Of a surface or body that has no contact with itself, before any cut.
  std::shared_ptr<const ContactSkin> skinWithoutContact();
  const std::string& growthWarning() const { return growth_warning_; }

  /// Carries out a command that was checked (command_checks.h). Edits of particles throw InputError, and change nothing, if they
  /// are impossible.
  Changes apply(const Command& command);

  // A step has two halves.
  /// Finds out what wakes in this step. False: nothing does, and only passStep() has to be called.
  bool beginStep();
  struct Request {
    /// Start of the search for a first equilibrium: positions of all points, or none. It is called only where that may
    /// pay.
    std::function<Points(const SceneParams& now)> find_start;
    /// m; > 0: an equilibrium is searched for a second time, from positions disturbed by this distance.
    double second_search = 0.0;
  };
  struct Outcome {
    bool ok = true;
    std::string failure;                                 // what was wrong, as the end of "step 3 ..."
    std::string notice;                                  // for the user of a step that succeeded; else empty
    bool has_slept = false;                              // through the step
    bool has_cut = false, leaves_copies = false;         // see Evolution
    bool has_new_arrival = false;                        // see ContactLoad
    std::optional<double> second_distance;               // m, how far the end of the second search is from that of the first
    double contact_seconds = 0.0, search_seconds = 0.0;  // s of wall time
    solve::SolveReport report;
    bool is_static = false;              // the step was a search for an equilibrium
    solve::StepFailure retried;          // why the step was taken again; of no kind: it was not
    bool is_retried_implicitly = false;  // that time
  };
  /// Numbers that are not finite, and an interrupt, never throw. Everything is then as before the step, also if anything throws.
  Outcome takeStep(const Request& request);
  /// Both halves.
  Outcome step();
  /// Only time passes.
  Outcome passStep();
  /// Undoes the last step; no command may have come since.
  void undoStep();

  /// See Simulation::setInterrupt().
  void setInterrupt(const std::atomic<bool>* interrupt);
  const std::atomic<bool>* interrupt() const { return interrupt_; }
  /// Cuts are reported to this follower while they are made; null: to none.
  void setCutFollower(CutFollower* follower) { cut_follower_ = follower; }

  // For copies and trials.
  /// Moves every free point by up to size (m) along each axis, always in the same way: the start of a twin.
  void disturb(double size);
  /// At rest: uses only this share, in (0, 1], of the stated membrane stiffness from now on and after resets; bending
  /// and masses are as stated.
  void softenMembrane(double share);
  void stiffenMembrane() { setMembraneShare(1.0); }  // all of it acts, until the next reset
  double membraneShare() const { return now_.membrane_share; }
  /// Multiplies the number of sub-steps of every step by fineness.
  void setFineness(Index fineness);
  /// From the next step on, instead of that of the params.
  void setIntegrator(solve::IntegratorType type);
  /// The same, also after resets.
  void chooseIntegrator(solve::IntegratorType type) { params_.integrator.type = chosen_.integrator = type; }
  /// Whether the chosen integrator is in use, and is another than auto.
  bool hasChosenIntegrator() const {
    return chosen_.integrator != solve::IntegratorType::kAuto && params_.integrator.type == chosen_.integrator;
  }

  const SceneParams& params() const { return params_; }  // with the values of now where they may change
  const RestSurface& rest() const { return *rest_; }
  const model::DeformableModel& model() const { return *model_; }
  const ModelKind& kind() const { return kind_; }
  /// See ModelKind; the follower keeps this model by reference.
  std::unique_ptr<CloudFollower> makeFollower() const { return kind_.makeFollower(*rest_, params_, *model_); }
  const solve::System& system() const { return system_; }
  const LoadSet& loads() const { return loads_; }
  const Grips& grips() const { return grips_; }
  const Activity& activity() const { return activity_; }
  /// Throws InputError for tools that are not accepted on this surface.
  void requireTools(const std::vector<tool::ToolParams>& tools) const;

  double time() const { return static_cast<double>(steps_) * params_.integrator.time_step; }
  std::uint64_t stepCount() const { return steps_; }
  const model::State& state() const { return now_.points; }
  /// See Simulation.
  double energyExcess() const { return lastMarch().memory().energy.excess; }
  /// Of all bits of the state, and of cuts that it does not hold.
  std::uint64_t stateHash() const;
  const std::vector<char>& pinned() const { return now_.pinned; }
  /// Index of the first pin of the scene that holds a point at rest; the number of pins if there is none.
  std::size_t findPin(Index point) const;
  const std::vector<char>& held() const { return held_; }  // (n) pinned, gripped or held by the evolution
  const std::vector<tool::ToolParams>& tools() const { return tools_; }
  Index numOwnMaterial() const;
  /// Of the last step.
  solve::IntegratorType lastIntegrator() const { return lastMarch().lastType(); }
  Index lastSubsteps() const { return last_substeps_; }
  /// Changes whenever anything that can be asked for may have changed, except the time.
  std::uint64_t revision() const { return revision_; }
  /// See Simulation.
  bool hasSnapped() const;
  std::vector<ToolReaction> toolReactions() const;
  std::vector<Contact> contacts() const;
  std::vector<SelfTouch> selfTouches() const;
  std::vector<PinReaction> pinReactions() const;
  /// Where contact of the surface with itself stopped points in the last step, and what acts there; none: nowhere.
  std::optional<Jam> findJam() const;
  /// The largest distance, m, of a point that contact stopped in the last step from where a tool or a moving pin would hold it.
  double measureLag() const;

  /// See ContactLoad.
  void adoptArrivals(const ContactLoad& other) { loads_.contact.adoptArrivals(other); }

 private:
  struct Made {
    std::shared_ptr<const RestSurface> rest;
    std::unique_ptr<model::DeformableModel> model;
    std::shared_ptr<const ContactSkin> meeting;  // null: that of the model, which is not cut; of a fork: it has no contact
    bool is_fork = false;
    bool looks_first = false;      // of a fork: see SelfContactParams
    ContactPoints::Areas areas{};  // of a fork: see ContactPoints
  };
  static Made take(RestSurface&& rest);
  Dynamics(const SceneParams& params, Made made);

  // How it is made and set.
  void makeSelfContact(Made made);
  std::vector<AnchorLoad::Anchor> makeAnchors() const;
  void placePins();
  void placeAnchors();
  void clampHeld();
  ClampEdges findEdges(const std::vector<char>& inside, const Contains& contains) const;
  std::vector<Index> clampPin(const std::vector<char>& inside, const Contains& contains);
  std::string clampGrips(const std::vector<std::size_t>& begun);
  void endClamps();
  void setTools(std::vector<tool::ToolParams> tools);
  void giveContactTools();
  void placePointsBetween();
  void severPointsBetween();
  void followCuts();
  void findTangles();
  bool untangles() const;
  std::string describeCrossed() const;
  void placeLoadPoints();
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

  // The content of a checkpoint and of a snapshot.
  void keepWaiting(DynamicsState::Waiting& waiting) const;
  void keepHolding(DynamicsState::Holding& holding) const;
  void giveBack(const DynamicsState& saved, bool to_look);

  // A step and its parts.
  void carryOut(const Request& request, std::optional<InterruptScope>& scope, Outcome& outcome);
  std::string describeCompliance();
  void beginSelfContact(double dt, std::string& notice);
  void beginToolContact(double now, double dt, Outcome& outcome);
  solve::TimeMarch::Outcome findMotion(double now, const Request& request);
  solve::TimeMarch::Outcome advanceFromStart(double now, bool is_elsewhere);
  void settleContact(double now, solve::TimeMarch::Outcome& taken);
  bool hasKnife(double now) const;
  Index countSinglePoints();
  std::string describeGrazing(double now);
  std::string describeCostlySteps(const solve::SolveReport& report);
  std::string describeCostlyContact(const solve::SolveReport& report);
  const std::vector<model::WeightedTriangle>& outside();
  std::string endUntangling(double dt);
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

  // Made once from the rest state: shared by forks, or one for each.
  const std::shared_ptr<const RestSurface> rest_;
  const std::unique_ptr<model::DeformableModel> model_;
  const ModelKind& kind_;
  const std::unique_ptr<Evolution> evolution_;

  // What a DynamicsState holds: directly, or as the memory of these objects.
  DynamicsState::Motion now_;
  std::uint64_t steps_ = 0;
  std::vector<tool::ToolParams> tools_;
  std::vector<PointValues> values_;
  LoadSet loads_;
  Burst burst_;
  Grips grips_;
  std::vector<char> held_, held_turns_;  // pinned, gripped or held by the evolution
  solve::System system_;
  solve::TimeMarch march_;
  Activity activity_;
  ToolWatch tool_watch_;
  std::unique_ptr<ActivePart> part_;     // null: to be made when it is needed
  solve::TimeMarch::Memory part_march_;  // that a part which is made goes on from

  // Not changed by resets and snapshots.
  struct Chosen {
    double membrane_share = 1.0;                                      // from each reset on
    solve::IntegratorType integrator = solve::IntegratorType::kAuto;  // another: replaces auto, from each reset on
    // What it was made with.
    model::MaterialParams made;
    solve::IntegratorType made_for = solve::IntegratorType::kAuto;
  } chosen_;
  std::optional<std::vector<model::WeightedTriangle>> skin_;  // of a body: see outside()
  bool has_between_ = false;                                  // the contact's points between simulation points were asked for
  bool has_load_points_ = false;                              // those that carry forces with a radius were asked for
  Index num_links_ = 0;                                       // as the model was made
  std::vector<model::PointMaterial> shares_;                  // values_ as given to the model; empty: as it was made
  Index fineness_ = 1;
  const std::atomic<bool>* interrupt_ = nullptr;
  CutFollower* cut_follower_ = nullptr;

  std::uint64_t revision_ = 0;
  std::string growth_notice_, growth_warning_;
  Index last_substeps_ = 0;
  LooseParts loose_;  // of static steps
  std::string why_no_self_contact_;
  std::shared_ptr<const ContactSkin> skin_without_contact_;  // null: not made
  UntanglingProgress untangling_;
  // What was told since the last reset, and the work that is counted for it.
  struct Told {
    bool grazing = false, compliance = false, dicing = false;
    Index loose = 0;  // points of loose parts, as told last
    struct ImplicitWork {
      Index steps = 0, iterations = 0;  // of implicit steps, since the last look
      bool is_told = false;
    } implicit_work;
    struct ContactWork {
      std::size_t near = 0;  // pairs, in all sub-steps until the end of the last step
      double pairs = 0.0;    // a point and sub-step, in all steps since the last look
      Index steps = 0;       // these
      bool is_told = false;
    } contact_work;
  } told_;
  DynamicsState before_;       // the step that is taken, or was taken last; without settings, and if it slept, without motion
  bool has_slept_ = false;     // through that step
  NamedForces::Update woken_;  // by the step that is taken
  bool has_woken_ = false;     // in its first half
  // Scratch.
  std::vector<char> linked_;   // (n)
  std::vector<char> patches_;  // (n) see model::Clamping
  std::vector<model::ClampEdge> patch_edges_;
  std::vector<Index> hits_, moving_;  // moving: points on pins that move in the step
  State before_search_;               // of an equilibrium, where it may have to begin again with contact
  std::vector<ContactLoad::Body> tools_before_search_;
  std::vector<double> load_stiffness_, load_damping_;  // N/m, N s/m
  mutable Points forces_on_all_;                       // N
};

}  // namespace deformable_surface::simulation
