// What a simulation is made of. Private, and apart from the files that implement it: how it is made and set
// (simulation_making.cpp), its step (simulation_step.cpp), what is measured of it (simulation_measuring.cpp), the commands to it,
// what it hands out of itself, who sleeps, what touches.
#pragma once

#include "deformable_surface/simulation/simulation.h"

#include "deformable_surface/base/interrupt.h"
#include "deformable_surface/base/timer.h"
#include "deformable_surface/model/elastic_solid/elastic_solid.h"
#include "deformable_surface/model/mass_spring/mass_spring.h"
#include "deformable_surface/simulation/contact_load.h"
#include "deformable_surface/simulation/grips.h"
#include "deformable_surface/simulation/loads.h"
#include "deformable_surface/simulation/particle_life.h"
#include "deformable_surface/simulation/rest_surface.h"
#include "deformable_surface/simulation/run_time_params.h"
#include "deformable_surface/simulation/track_load.h"
#include "deformable_surface/solve/time_march.h"

#include "accuracy.h"
#include "active_part.h"
#include "activity.h"
#include "clamp_edges.h"
#include "cutting.h"
#include "deformed_surface.h"
#include "error_estimator.h"
#include "parts.h"
#include "state_hash.h"
#include "tool_watch.h"

#include <optional>

namespace deformable_surface::simulation {

/// What a step goes on from and may change. A step that is refused gives it back, and a snapshot holds it.
struct Checkpoint {
  // What time alone and tools in motion change of a surface that sleeps.
  std::vector<NamedForces::Named> forces;
  std::vector<ToolWatch::Seen> watched;
  Activity::Memory activity;
  solve::TimeMarch::Memory march, part_march;
  bool has_part = false;

  // What changes only of one that is awake.
  State state;
  std::uint64_t steps = 0;
  std::vector<char> pinned, pinned_turns;
  std::vector<model::ClampEdge> clamp_edges;
  double membrane_share = 1.0, softening = 0.0;
  solve::IntegratorType integrator = solve::IntegratorType::kAuto;
  double contact_rate = 0.0;  // 1/s
  std::vector<Grips::Grip> grips;
  std::vector<ContactLoad::Body> bodies;
  std::vector<model::MassSpring::Link> cuts;
  std::shared_ptr<const CutTransfer::Memory> severed;  // null: nothing
  std::vector<TrackLoad::Seen> seen;
  Points followed;
};

struct Snapshot::Contents {
  std::uint64_t scene;  // see Simulation::Impl::identify()
  Checkpoint checkpoint;
  double time;  // s
  Vec3 gravity;
  std::vector<tool::ToolParams> tools;
  std::vector<PointValues> values;
  double spacing;       // m, of particles, which a fit may have found; else 0
  RunTimePhysics physics;
  double damping;       // 1/s
  std::shared_ptr<const transfer::Resampler> resampler;  // null if points are not inserted
  std::shared_ptr<const ErrorEstimator::Memory> estimate;  // null: no estimate
  Statistics statistics;
  bool is_sight, is_estimated;  // a sight holds nothing that only steps need
  std::uint64_t surface_revision;
};

struct Simulation::Impl {
  // Given.
  SceneParams params;
  const std::shared_ptr<const cloud::PointCloud> shared_input;
  const cloud::PointCloud& input = *shared_input;

  // Made once from the rest state: what forks share, and what each has for itself.
  std::unique_ptr<model::DeformableModel> model;
  model::OrientedParticles* const particles;  // the model, if it is this one
  model::ElasticSolid* const solid;           // the same
  const std::shared_ptr<const RestSurface> shared_rest;
  const RestSurface& rest = *shared_rest;
  std::vector<std::string> notes;
  GravityLoad gravity;
  PressureLoad pressure;
  DragLoad drag;
  AnchorLoad anchors;
  NamedForces forces;
  ContactLoad contact;
  FrictionLoad friction;
  TrackLoad track;
  Grips grips;
  std::vector<const solve::ExternalLoad*> loads;
  std::vector<char> pinned, pinned_turns;     // pinned: of PinMark
  std::vector<model::ClampEdge> clamp_edges;  // of the pins, ascending
  std::vector<char> held, held_turns;  // pinned, gripped or too cold
  std::unique_ptr<ParticleLife> life;  // null: no particles
  std::unique_ptr<Cutting> cutting;    // null: nothing that can be cut
  solve::System system;

  // What a snapshot holds (with the pins, forces and grips above).
  State state;
  std::vector<tool::ToolParams> tools;
  std::uint64_t steps = 0;

  std::vector<PointValues> values;  // (m) what points are made of that are not as everywhere; empty if the model is another
  std::vector<model::PointMaterial> shares;  // the same as the model has it; empty: as it was made

  double membrane_share = 1.0;         // of the stated membrane stiffness, that acts
  double chosen_membrane_share = 1.0;  // from each reset on
  double softening = 0.0;              // m, what that has changed so far, in the trial
  std::string share_notice;            // for the next step, that it has ended
  solve::IntegratorType chosen_integrator = solve::IntegratorType::kAuto;  // another: in the place of auto, from each reset on

  double contact_rate = 0.0;  // 1/s; 0: not found yet
  solve::TimeMarch march;
  Index fineness = 1;
  const std::atomic<bool>* interrupt = nullptr;  // see Simulation::setInterrupt()

  // What is awake; see activity_steps.cpp.
  Activity activity;
  ToolWatch tool_watch;
  std::unique_ptr<ActivePart> part;     // null: to be made when it is needed
  solve::TimeMarch::Memory part_march;  // that a part which is made goes on from
  Points followed;  // m, where all were when the model was told by which elements it is taken in parts; or empty
  std::vector<Index> hits, moving;      // scratch; moving: points on pins that move in the step
  bool is_hot = false;                  // some particles are above the ambient temperature
  bool is_measured = false;             // the statistics are those of the state
  std::uint64_t revision = 0;           // see Simulation::revision()

  // Results and scratch.
  Checkpoint before;           // the step that is taken, or was taken last; if it slept through that, without what is awake
  bool has_slept = false;  // through that step
  Statistics statistics;
  DeformedSurface surface;
  AccuracyChoice choice;
  bool is_wish_missed = false;  // said since the last reset
  LooseParts loose;             // of static steps
  std::vector<double> load_stiffness, load_damping;  // N/m, N s/m, scratch
  Index loose_said = 0;         // points of loose parts, as said last since the last reset
  std::unique_ptr<ErrorEstimator> estimator;  // null: no estimate
  bool is_viewer = false, is_estimated_elsewhere = false;  // it takes no steps; what it shows has an estimate
  std::optional<std::uint64_t> seen_revision;              // of the surface, in the sight that a viewer was given last
  mutable Points forces_on_all;               // N, scratch
  model::MaterialParams made = params.material;  // what the model was made with
  std::uint64_t scene_hash;                      // of what was given

  // How it is made and set: simulation_making.cpp.
  Impl(const SceneParams& given, std::shared_ptr<const cloud::PointCloud> cloud, std::unique_ptr<model::DeformableModel> material,
       std::shared_ptr<const RestSurface> built);
  static std::unique_ptr<Impl> make(const SceneParams& params, cloud::PointCloud&& cloud,
                                    RestSurface built);  // which nobody else has
  std::vector<AnchorLoad::Anchor> makeAnchors() const;
  void placePins();
  void placeAnchors();
  void chooseLoads();
  void setTools(std::vector<tool::ToolParams> given);
  void giveContactTools();
  void reset();
  void applyMaterial();
  void stiffenMembrane(const std::string& why);
  void leaveIntegrator(const std::string& why);
  bool isAsTried() const {
    return membrane_share < 1.0 ||
           (chosen_integrator != solve::IntegratorType::kAuto && params.integrator.type == chosen_integrator);
  }
  void leaveTrial(const char* how);
  void setDamping(double damping);
  void takePhysics();
  void findContactRate();
  void clampHeld();
  std::vector<Index> findClamps(const std::vector<char>& inside, const Contains& contains);
  void endClamps();
  std::size_t findPin(Index point) const;

  // What a simulation hands out of itself: simulation_memory.cpp.
  static std::uint64_t identify(const RestSurface& rest, const SceneParams& params);
  void keepAsleep(Checkpoint& checkpoint) const;
  void keepAwake(Checkpoint& checkpoint) const;
  void giveBack(const Checkpoint& checkpoint);
  std::shared_ptr<const Snapshot::Contents> save(bool is_sight) const;
  void restore(const Snapshot::Contents& saved);
  std::unique_ptr<Impl> fork(bool to_view) const;

  // A step and its parts: simulation_step.cpp.
  StepOutcome step();
  void takeStep(const Timer& timer, bool have_loads_changed, std::optional<InterruptScope>& scope, StepOutcome& outcome);
  void refuse(const std::string& why, StepOutcome& outcome) const;
  void undoStep();
  bool beginNested();
  bool isHeldAround() const;
  void findLoose(double time);
  std::string holdLoose();
  std::optional<double> searchAgain(double now, model::State& start) const;
  void disturb(double size, Points& positions) const;
  Grips::Update updateGrips(double now, double dt);
  void endCuts();
  void loseEstimate(StepOutcome& outcome);
  std::string live(double now, double dt);
  ParticleLife::Changes fit(const model::GrowthParams& growth);
  void requireParticles() const;
  void follow(const ParticleLife::Changes& changes);
  void estimate(const solve::SolveReport& report, StepOutcome& outcome);
  double time() const { return static_cast<double>(steps) * params.integrator.time_step; }
  void changed() {
    is_measured = false;
    ++revision;
  }

  // What is awake; in activity_steps.cpp.
  bool canBeInParts() const;
  bool maySleep() const;
  ActivePart::Loads partLoads() const { return {gravity, anchors, forces, contact, contact_rate, system.damping()}; }
  solve::TimeMarch& lastMarch() { return part ? part->march() : march; }
  void setParts();
  void followPartners(const Points& positions);
  void makePart();
  void wakeAll();
  NamedForces::Update wakeForStep(double now, double dt);
  void beginAsleep(double now);
  void wakeForce(const std::string& id);
  void loadsChanged();
  solve::TimeMarch::Outcome advance(double now);
  solve::TimeMarch::Outcome advanceWhole(double now);
  void considerSleep(const solve::SolveReport& report);
  StepOutcome passStep(const Timer& timer, const std::string& notice);

  // What is measured of its state: simulation_measuring.cpp.
  void measure();
  void measureState();
  bool hasSnapped() const;
  void readEstimate(Statistics& into) const;
  void listSkipped();
  const Surface& makeSurface(bool with_normals);
  std::uint64_t hash() const { return hashState(state); }

  // To the copies that estimate the error.
  template <class Command>
  void forward(const Command& command) {
    leaveTrial("a command came");
    if (estimator) estimator->forward(command);
  }
};

}  // namespace deformable_surface::simulation
