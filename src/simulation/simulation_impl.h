// What a simulation is made of, and the order of a step. Private, and apart from the files that implement the class: its life and answers,
// the commands to it, what it hands out of itself, who sleeps, what touches.
#pragma once

#include "deformable_surface/simulation/simulation.h"

#include "deformable_surface/base/error.h"
#include "deformable_surface/base/timer.h"
#include "deformable_surface/base/value.h"
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

#include <algorithm>
#include <cmath>
#include <cstring>

#include "accuracy.h"
#include "active_part.h"
#include "activity.h"
#include "cutting.h"
#include "deformed_surface.h"
#include "error_estimator.h"
#include "nested_start.h"
#include "tool_watch.h"

namespace deformable_surface::simulation {

constexpr double kContactRate = 0.45;  // of the highest frequency at rest: its square then grows by a fifth at most

// FNV-1a over 64-bit words.
constexpr std::uint64_t kHashBegin = 14695981039346656037ull;
inline std::uint64_t hashWords(const double* words, int count, std::uint64_t h) {
  for (int k = 0; k < count; ++k) {
    std::uint64_t bits;
    std::memcpy(&bits, words + k, sizeof bits);
    h = (h ^ bits) * 1099511628211ull;
  }
  return h;
}

inline std::uint64_t hashPoints(const Points& points, std::uint64_t h = kHashBegin) {
  for (const Vec3& p : points) h = hashWords(p.data(), 3, h);
  return h;
}

inline std::uint64_t hashState(const State& state) {
  std::uint64_t h = hashPoints(state.velocities, hashPoints(state.positions));
  for (const Quaternion& q : state.orientations) h = hashWords(q.coeffs().data(), 4, h);
  return hashPoints(state.spins, h);
}

inline Index nearestPoint(const Points& points, const Vec3& to) {
  Index nearest = 0;
  for (Index i = 1; i < static_cast<Index>(points.size()); ++i)
    if ((points[i] - to).squaredNorm() < (points[nearest] - to).squaredNorm()) nearest = i;
  return nearest;
}

struct Snapshot::Contents {
  std::uint64_t scene;  // see Simulation::Impl::identify()
  State state;
  std::uint64_t steps;
  double time;  // s
  std::vector<char> pinned, pinned_turns;
  Vec3 gravity;
  std::vector<NamedForces::Named> forces;
  std::vector<tool::ToolParams> tools;
  std::vector<PointValues> values;
  RunTimePhysics physics;
  double damping;       // 1/s
  double contact_rate;  // 1/s
  std::vector<Grips::Grip> grips;
  std::vector<ContactLoad::Body> bodies;
  std::vector<model::MassSpring::Link> cuts;
  std::shared_ptr<const CutTransfer::Memory> severed;  // null: nothing
  std::vector<TrackLoad::Seen> seen;
  solve::TimeMarch::Memory march, part_march;
  bool has_part;
  Activity::Memory activity;
  std::vector<ToolWatch::Seen> watched;
  std::shared_ptr<const transfer::Resampler> resampler;  // null if points are not inserted
  std::shared_ptr<const ErrorEstimator::Memory> estimate;  // null: no estimate
  Statistics statistics;
};

struct Simulation::Impl {
  // Given.
  SceneParams params;
  const std::shared_ptr<const cloud::PointCloud> shared_input;
  const cloud::PointCloud& input = *shared_input;

  // Made once from the rest state: what forks share, and what each has for itself.
  std::unique_ptr<model::DeformableModel> model;
  model::OrientedParticles* const particles;  // the model, if it is this one
  const model::ElasticSolid* const solid;     // the same
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
  std::vector<char> pinned, pinned_turns;
  std::vector<char> held, held_turns;  // pinned, gripped or too cold
  std::unique_ptr<ParticleLife> life;  // null: no particles
  std::unique_ptr<Cutting> cutting;    // null: nothing that can be cut
  solve::System system;

  // What a snapshot holds (with the pins, forces and grips above).
  State state;
  std::vector<tool::ToolParams> tools;
  std::uint64_t steps = 0;

  std::vector<PointValues> values;           // (m) what points are made of that are not as everywhere; empty if the model is another
  std::vector<model::PointMaterial> shares;  // the same as the model has it; empty: as it was made

  double contact_rate = 0.0;  // 1/s; 0: not found yet
  solve::TimeMarch march;
  Index fineness = 1;
  const std::atomic<bool>* interrupt = nullptr;  // see Simulation::setInterrupt()

  // What is awake; see activity_steps.cpp.
  Activity activity;
  ToolWatch tool_watch;
  std::unique_ptr<ActivePart> part;     // null: to be made when it is needed
  solve::TimeMarch::Memory part_march;  // that a part which is made goes on from
  std::vector<Index> hits;              // scratch
  bool is_hot = false;                  // some particles are above the ambient temperature
  bool is_measured = false;             // the statistics are those of the state
  std::uint64_t revision = 0;           // see Simulation::revision()

  // Results and scratch.
  Statistics statistics;
  DeformedSurface surface;
  AccuracyChoice choice;
  bool is_wish_missed = false;  // said since the last reset
  std::unique_ptr<ErrorEstimator> estimator;  // null: no estimate
  mutable Points forces_on_all;               // N, scratch
  model::MaterialParams made = params.material;  // what the model was made with
  std::uint64_t scene_hash;                      // of what was given

  Impl(const SceneParams& given, std::shared_ptr<const cloud::PointCloud> cloud, std::unique_ptr<model::DeformableModel> material,
       std::shared_ptr<const RestSurface> built)
      : params(given),
        shared_input(std::move(cloud)),
        model(std::move(material)),
        particles(dynamic_cast<model::OrientedParticles*>(model.get())),
        solid(dynamic_cast<const model::ElasticSolid*>(model.get())),
        shared_rest(std::move(built)),
        notes(rest.notes),
        gravity(model->masses(), params.gravity),
        pressure(*model, params.pressure),
        drag(*model, params.viscous_drag),
        anchors(makeAnchors()),
        forces(model->masses()),
        contact(model->masses()),
        friction(contact),
        track(model->masses(), params.input.track_gain),
        system(*model, loads, held, params.material.damping, &held_turns),
        march(system, *model, params.integrator),
        activity(params.activity, rest.points, std::sqrt(rest.area / static_cast<double>(rest.points.size())),
                 params.integrator.time_step, *model, canBeInParts()),
        surface(rest, input, params, solid),
        scene_hash(identify(rest, params)) {
    if (auto* mass_spring = dynamic_cast<model::MassSpring*>(model.get()))
      cutting = std::make_unique<Cutting>(*mass_spring, params.mass_spring.tear_strain);
  }

  /// Of a surface that nobody else has.
  static std::unique_ptr<Impl> make(const SceneParams& params, cloud::PointCloud&& cloud, RestSurface built) {
    std::unique_ptr<model::DeformableModel> model = std::move(built.model);
    auto impl = std::make_unique<Impl>(params, std::make_shared<const cloud::PointCloud>(std::move(cloud)), std::move(model),
                                       std::make_shared<const RestSurface>(std::move(built)));
    impl->reset();
    return impl;
  }

  std::vector<AnchorLoad::Anchor> makeAnchors() const {
    std::vector<AnchorLoad::Anchor> list;
    for (const AnchorParams& a : params.anchors) list.push_back({nearestPoint(rest.points, a.point), a.target, a.stiffness});
    return list;
  }

  // On the points that are there.
  void placeAnchors() {
    anchors = AnchorLoad(makeAnchors());
    if (!particles) return;
    std::vector<Index> index_of_id(state.next_id, -1);
    for (Index i = 0; i < state.size(); ++i) index_of_id[state.traits[i].id] = i;
    anchors.renumber(index_of_id);
  }

  // Only the loads that can act are evaluated.
  void chooseLoads() {
    loads = {&gravity, &forces};
    if (params.pressure != 0.0) loads.push_back(&pressure);
    if (params.viscous_drag > 0.0) loads.push_back(&drag);
    if (!params.anchors.empty()) loads.push_back(&anchors);
    if (!contact.isEmpty()) loads.push_back(&contact);
    if (!friction.isEmpty()) loads.push_back(&friction);
    if (!track.isEmpty()) loads.push_back(&track);
  }

  void setTools(std::vector<tool::ToolParams> given) {
    for (const tool::ToolParams& tool : given)
      if (tool.shape.kind == geometry::Solid::Kind::kMesh && !tool.shape.mesh)
        throw InputError("tool " + quote(tool.id) + " shape.mesh.file: found one that has not been read; accepted: vertices and triangles");
    for (const tool::ToolParams& tool : given)
      if (cutting && tool.mode == tool::Mode::kCut && (params.output.resample || params.mass_spring.volume_stiffness > 0.0))
        throw InputError("tool " + quote(tool.id) + " mode: found cut on a surface that " +
                         (params.output.resample ? "inserts points, which would not know their side" : "keeps its volume") +
                         "; accepted: cut without output.resample and mass_spring.volume_stiffness");
    if (!given.empty() && !(contact_rate > 0.0)) findContactRate();
    tools = std::move(given);
    giveContactTools();
    grips.setTools(tools);
    chooseLoads();
    loadsChanged();
    setParts();
  }

  // Knives cut springs without resistance; particles they push, too.
  void giveContactTools() {
    std::vector<tool::ToolParams> pushing = tools;
    const auto isKnife = [](const tool::ToolParams& tool) { return tool.mode == tool::Mode::kCut; };
    if (cutting) pushing.erase(std::remove_if(pushing.begin(), pushing.end(), isKnife), pushing.end());
    contact.setTools(pushing);
  }

  double time() const { return static_cast<double>(steps) * params.integrator.time_step; }

  void reset() {
    if (cutting) cutting->setCuts({});
    state.positions = rest.points;
    state.velocities.assign(rest.points.size(), Vec3::Zero());
    model->beginAtRest(state);
    steps = 0;
    pinned = rest.pinned;
    pinned_turns = rest.pinned_turns;
    placeAnchors();
    if (particles) {
      life = std::make_unique<ParticleLife>(*particles);
      for (Index i = 0; i < state.size(); ++i) state.traits[i].is_smooth = !rest.creased[i];
      if (params.oriented_particles.fit) {
        const std::string news = fit(params.oriented_particles.growth).notice;
        if (std::find(notes.begin(), notes.end(), news) == notes.end()) notes.push_back(news);
      }
    }
    clampHeld();
    track.restore({});
    values = rest.values;
    applyMaterial();
    setDamping(params.material.damping);
    gravity.gravity = params.gravity;
    forces.clear();
    for (const ForceParams& force : params.forces) forces.set(force);
    grips.reset();
    contact.reset();
    part.reset();
    part_march = {};
    contact_rate = 0.0;
    setTools(params.tools);
    activity.reset();
    tool_watch.reset();
    march.restart();
    if (estimator) estimator->reset();
    is_wish_missed = false;
    surface.reset();
    statistics = Statistics{};
    changed();
    measure();
  }

  // What a simulation hands out of itself: simulation_memory.cpp.
  static std::uint64_t identify(const RestSurface& rest, const SceneParams& params);
  std::shared_ptr<const Snapshot::Contents> save() const;
  void restore(const Snapshot::Contents& saved);
  std::unique_ptr<Impl> fork() const;

  // Tells the model what its points are made of. What follows from the stiffness is found anew.
  void applyMaterial() {
    if (values.empty()) return;
    std::vector<model::PointMaterial> now = findShares(made, params.material, values);
    if (shares.empty()) shares = findShares(made, made, rest.values);
    if (now == shares) return;
    model->setMaterial(now);
    shares = std::move(now);
    const std::vector<ContactLoad::Body> bodies = contact.all();  // what they hold up stays up
    contact.setTools({});
    chooseLoads();
    contact_rate = 0.0;
    if (!tools.empty()) findContactRate();
    contact.restore(bodies);
    chooseLoads();
    wakeAll();
    march.restart();
  }

  void setDamping(double damping) {
    system.setDamping(damping);
    if (estimator) estimator->setDamping(damping);
    wakeAll();
  }

  // Of params, to those who keep a copy of them.
  void takePhysics() {
    pressure.setPressure(params.pressure);
    drag.setDrag(params.viscous_drag);
    applyMaterial();
    chooseLoads();
    wakeAll();
    setParts();
  }

  // Contact as stiff as the surface's own stiffest motion at rest bears: the stable step stays nearly what it is without. Once, before
  // the first tool.
  void findContactRate() {
    State at_rest;
    at_rest.positions = rest.points;
    at_rest.velocities.assign(rest.points.size(), Vec3::Zero());
    model->beginAtRest(at_rest);
    const double stable = march.findStableStep(0.0, at_rest);
    model->adopt(state);
    contact_rate = kContactRate * 2.0 / (std::isfinite(stable) ? stable : params.integrator.time_step);
    contact.setRate(contact_rate);
  }

  // Tells the model what is held; what was measured and kept of it with other clamps is then worth nothing.
  void clampHeld() {
    held = pinned;
    held_turns = pinned_turns;
    if (model->setHeld(pinned)) march.restart();
    const double cold = params.oriented_particles.hold_below;
    if (!life || !(cold > 0.0)) return;
    for (Index i = 0; i < state.size(); ++i) {
      if (state.traits[i].temperature >= cold) continue;
      held[i] = held_turns[i] = 1;
      state.velocities[i].setZero();
      state.spins[i].setZero();
    }
  }

  // A first equilibrium is looked for from that of fewer points. Returns whether the state was changed.
  bool beginNested() {
    if (params.integrator.type != solve::IntegratorType::kStatic || system.isOriented() || steps > 0) return false;
    if (pinned != rest.pinned || state.positions != rest.points) return false;
    SceneParams scene = params;
    scene.gravity = gravity.gravity;
    scene.forces.clear();
    for (const NamedForces::Named& force : forces.all()) scene.forces.push_back(force.params);
    Points start = findNestedStart(scene, rest);
    if (start.empty()) return false;
    state.positions = std::move(start);
    return true;
  }

  // One step, in this order: commands -> sub-steps (forces, integration) -> checks. What follows from the new state (transfer,
  // normals, markers) is made when somebody asks for it.
  StepOutcome step() {
    const Timer timer;
    const double dt = params.integrator.time_step;
    const double now = time();
    StepOutcome outcome;

    // Commands. What is held can have changed, and with it the clamps. Rounding of the time must not lose a step to the one before.
    std::string news;
    const bool has_lived = life && !activity.isAsleep();
    if (has_lived) news = live(now, dt);
    NamedForces::Update update = forces.update(now + 1e-6 * dt, state, pinned);
    wakeForStep(update);
    if (activity.isAsleep()) return passStep(timer);
    if (life && !has_lived) news = live(now, dt);
    clampHeld();
    Grips::Update grip;
    if (!grips.isEmpty()) grip = updateGrips(now, dt);
    if (update.changed || grip.changed) loadsChanged();
    beginAsleep(now);
    if (activity.isAsleep()) return passStep(timer);

    if (!contact.isEmpty() && contact.beginStep(now, dt, state, held)) loadsChanged();

    const bool may_be_cut = cutting && cutting->beginStep(tools, now, state.positions);

    const bool is_nested = beginNested();
    solve::TimeMarch::Outcome taken = advance(now);
    if (is_nested && !taken.ok) {
      state.positions = rest.points;
      march.restart();
      taken = march.step(now, state);
    }
    const solve::SolveReport& report = taken.report;
    outcome.notice = std::move(update.notice);
    for (const std::string& more : {news, grip.notice, taken.notice})
      if (!more.empty()) outcome.notice += (outcome.notice.empty() ? "" : "; ") + more;
    if (!taken.ok) {
      outcome.ok = false;
      outcome.problem = "step " + std::to_string(steps + 1) + " at " + formatReal(now) + " s " + taken.failure +
                        "; the state before it is kept";
      return outcome;
    }
    if (!contact.isEmpty()) {
      const std::string passed = contact.endStep(now, dt, state, held, model->triangles());
      if (!passed.empty()) outcome.notice += (outcome.notice.empty() ? "" : "; ") + passed;
    }
    if (may_be_cut && cutting->endStep(tools, now, dt, state.positions, surface)) {
      wakeAll();
      setParts();
      march.restart();
      if (estimator && std::isfinite(estimator->total()))
        outcome.notice += (outcome.notice.empty() ? "" : "; ") +
                          std::string("the surface is cut, which its coarser copies do not follow: there is no error estimate until "
                                      "the next reset");
      if (estimator) estimator->lose();
    }
    ++steps;
    surface.invalidate();
    surface.resample(state);
    if (estimator) estimate(report, outcome);
    considerSleep(report);
    changed();

    // What it was.
    statistics.substeps = static_cast<std::uint32_t>(report.substeps);
    statistics.solver_iterations = static_cast<std::uint32_t>(report.iterations);
    statistics.solver_residual = report.residual;
    statistics.time_forces = report.time_forces;
    statistics.time_total = timer.seconds();
    statistics.time_solve = statistics.time_total - report.time_forces - statistics.time_estimate;
    statistics.real_time_factor = dt / statistics.time_total;
    statistics.time_transfer = statistics.time_normals = 0.0;
    return outcome;
  }

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
  void makePart();
  void wakeAll();
  void wakeForStep(const NamedForces::Update& update);
  void beginAsleep(double now);
  void wakeForce(const std::string& id);
  void loadsChanged();
  solve::TimeMarch::Outcome advance(double now);
  solve::TimeMarch::Outcome advanceWhole(double now);
  void considerSleep(const solve::SolveReport& report);
  StepOutcome passStep(const Timer& timer);

  Grips::Update updateGrips(double now, double dt) {
    if (grips.readForces()) system.computeForcesOnAll(now, state, forces_on_all);
    const Grips::Update update = grips.update(now, 1e-6 * dt, state, pinned, forces_on_all);
    grips.carry(now, dt, state, held);
    return update;
  }

  // Particles cool, go and are born; those that are too cold are held.
  std::string live(double now, double dt) {
    const double interval = params.oriented_particles.growth_interval;
    const bool looks = std::floor((now + 1e-6 * dt) / interval) > std::floor((now - (1.0 - 1e-6) * dt) / interval);
    const ParticleLife::Changes changes = life->update(now, dt, looks, tools, state);
    // Heat changes the energy of bonds, and so does flow.
    is_hot = changes.are_hot || changes.has_flowed;
    if (is_hot) march.restart();
    follow(changes);
    return changes.notice;
  }

  ParticleLife::Changes fit(const model::GrowthParams& growth) {
    const ParticleLife::Changes changes = life->fit(growth, pinned, state);
    follow(changes);
    return changes;
  }

  void requireParticles() const {
    if (!life) throw InputError("model: found one that has no particles to edit or to grow; accepted: oriented_particles");
  }

  // Everything that is by point follows a change of the population.
  void follow(const ParticleLife::Changes& changes) {
    if (!changes.new_index.empty()) {
      forces.renumber(changes.new_index);
      anchors.renumber(changes.new_index);
      grips.renumber(changes.new_index);
      contact.renumber(changes.new_index);
      keepThose(changes.new_index, pinned);
      keepThose(changes.new_index, pinned_turns);
    }
    if (changes.new_index.empty() && changes.born == 0) return;
    pinned.resize(state.positions.size(), 0);
    pinned_turns.resize(state.positions.size(), 0);
    model->adopt(state);
    track.restore({});
    chooseLoads();
    march.restart();
    wakeAll();
    surface.invalidate();
  }

  // The copies take the same step.
  void estimate(const solve::SolveReport& report, StepOutcome& outcome) {
    const Timer timer;
    const std::string news = estimator->follow(state.positions, lastMarch().lastType(), report.substeps);
    if (!news.empty()) outcome.notice += (outcome.notice.empty() ? "" : "; ") + news;
    // Asked for, kept in the trial, but not kept now; said once.
    const double wish = params.accuracy.position_error, error = estimator->total();
    if (wish > 0.0 && choice.is_met && error > wish && std::isfinite(error) && !is_wish_missed) {
      outcome.notice += (outcome.notice.empty() ? "" : "; ") + std::string("the estimated error, ") + formatReal(error) +
                        " m, has grown beyond accuracy.position_error, " + formatReal(wish) + " m";
      is_wish_missed = true;
    }
    statistics.time_estimate = timer.seconds();
  }

  // The quantities of the state, computed when asked for.
  void measure() {
    statistics.simulation_time = time();
    statistics.step = steps;
    if (!is_measured) measureState();
    is_measured = true;
    listSkipped();
  }

  void measureState() {
    statistics.points = static_cast<std::uint32_t>(input.positions.size());
    statistics.simulation_points = static_cast<std::uint32_t>(state.size());
    statistics.springs = static_cast<std::uint32_t>(model->stretchLinks().size() + model->bendLinks().size());
    statistics.awake = 0;
    for (Index i = 0; i < state.size(); ++i) statistics.awake += !held[i] && activity.isMoving(i);
    statistics.kinetic_energy = system.kineticEnergy(state);
    statistics.elastic_energy = model->elasticEnergy(state);
    statistics.potential_energy = system.loadPotential(time(), state);
    statistics.max_stretch = model->maxStretch(state);
    double squared_speed = 0.0;
    for (const Vec3& v : state.velocities) squared_speed = std::max(squared_speed, v.squaredNorm());
    statistics.max_speed = std::sqrt(squared_speed);
    statistics.track_residual = track.residual(state);
    statistics.track_points = static_cast<std::uint32_t>(track.seen().size());
    statistics.state_hash = hash();
    if (estimator) {
      statistics.error_time = estimator->time() + activity.lost();
      statistics.error_space = estimator->space();
      statistics.error_transfer = estimator->transfer();
      statistics.error_estimate = estimator->total() + activity.lost();
    }
  }

  void listSkipped() {
    statistics.skipped.clear();
    if (activity.isAsleep()) statistics.skipped.push_back("step");
    if (!activity.isAsleep() && !activity.isWhole()) statistics.skipped.push_back("sleeping");
    if (!estimator) statistics.skipped.push_back("error_estimate");
    if (!surface.isMade()) statistics.skipped.push_back("transfer");
    if (!surface.hasNormals()) statistics.skipped.push_back("normals");
    if (params.pressure == 0.0) statistics.skipped.push_back("pressure");
    if (!(params.viscous_drag > 0.0)) statistics.skipped.push_back("drag");
    if (params.anchors.empty()) statistics.skipped.push_back("anchors");
    if (tools.empty()) statistics.skipped.push_back("contact");
  }

  std::uint64_t hash() const { return hashState(state); }

  const Surface& makeSurface(bool with_normals) {
    const bool wants_normals = with_normals && params.output.normals;
    if (surface.isMade() && (surface.hasNormals() || !wants_normals)) return surface.make(state, with_normals);
    const Timer timer;
    const Surface& made = surface.make(state, with_normals);
    // The operator makes both in one pass; the time counts as that of what was asked for.
    (wants_normals ? statistics.time_normals : statistics.time_transfer) = timer.seconds();
    return made;
  }

  // To the copies that estimate the error.
  template <class Command>
  void forward(const Command& command) {
    if (estimator) estimator->forward(command);
  }
};

}  // namespace deformable_surface::simulation
