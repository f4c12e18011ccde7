// What a simulation is made of, and the order of a step. Private, and apart from the two files that implement the class: one has its life
// and its answers, the other the commands to it.
#pragma once

#include "deformable_surface/simulation/simulation.h"

#include "deformable_surface/base/error.h"
#include "deformable_surface/base/timer.h"
#include "deformable_surface/base/value.h"
#include "deformable_surface/simulation/contact_load.h"
#include "deformable_surface/simulation/grips.h"
#include "deformable_surface/simulation/loads.h"
#include "deformable_surface/simulation/particle_life.h"
#include "deformable_surface/simulation/rest_surface.h"
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
  std::vector<char> pinned, pinned_turns;
  Vec3 gravity;
  std::vector<NamedForces::Named> forces;
  std::vector<tool::ToolParams> tools;
  std::vector<Grips::Grip> grips;
  std::vector<ContactLoad::Body> bodies;
  std::vector<model::MassSpring::Link> cuts;
  std::shared_ptr<const CutTransfer::Memory> severed;  // null: nothing
  solve::TimeMarch::Memory march, part_march;
  bool has_part;
  Activity::Memory activity;
  std::shared_ptr<const transfer::Resampler> resampler;  // null if points are not inserted
  std::shared_ptr<const ErrorEstimator::Memory> estimate;  // null: no estimate
  Statistics statistics;
};

struct Simulation::Impl {
  // Given.
  SceneParams params;
  cloud::PointCloud input;

  // Made once from the rest state.
  RestSurface rest;
  GravityLoad gravity;
  PressureLoad pressure;
  DragLoad drag;
  AnchorLoad anchors;
  NamedForces forces;
  ContactLoad contact;
  FrictionLoad friction;
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

  double contact_rate = 0.0;  // 1/s; 0: not found yet
  solve::TimeMarch march;
  Index fineness = 1;

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

  Impl(const SceneParams& given, cloud::PointCloud&& cloud, RestSurface built)
      : params(given),
        input(std::move(cloud)),
        rest(std::move(built)),
        gravity(rest.model->masses(), params.gravity),
        pressure(*rest.model, params.pressure),
        drag(*rest.model, params.viscous_drag),
        anchors(makeAnchors()),
        forces(rest.model->masses()),
        contact(rest.model->masses()),
        friction(contact),
        system(*rest.model, loads, held, params.material.damping, &held_turns),
        march(system, *rest.model, params.integrator),
        activity(params.activity, rest.points, std::sqrt(rest.area / static_cast<double>(rest.points.size())),
                 params.integrator.time_step, *rest.model, canBeInParts()),
        surface(rest, input, params) {
    if (rest.mass_spring) cutting = std::make_unique<Cutting>(*rest.mass_spring, params.mass_spring.tear_strain);
    reset();
  }

  std::vector<AnchorLoad::Anchor> makeAnchors() const {
    std::vector<AnchorLoad::Anchor> list;
    for (const AnchorParams& a : params.anchors) list.push_back({nearestPoint(rest.points, a.point), a.target, a.stiffness});
    return list;
  }

  // On the points that are there.
  void placeAnchors() {
    anchors = AnchorLoad(makeAnchors());
    if (!rest.particles) return;
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
    // Knives cut springs without resistance; particles they push, too.
    std::vector<tool::ToolParams> pushing = tools;
    const auto isKnife = [](const tool::ToolParams& tool) { return tool.mode == tool::Mode::kCut; };
    if (cutting) pushing.erase(std::remove_if(pushing.begin(), pushing.end(), isKnife), pushing.end());
    contact.setTools(pushing);
    grips.setTools(tools);
    chooseLoads();
    loadsChanged();
    setParts();
  }

  double time() const { return static_cast<double>(steps) * params.integrator.time_step; }

  void reset() {
    if (cutting) cutting->setCuts({});
    state.positions = rest.points;
    state.velocities.assign(rest.points.size(), Vec3::Zero());
    rest.model->beginAtRest(state);
    steps = 0;
    pinned = rest.pinned;
    pinned_turns = rest.pinned_turns;
    placeAnchors();
    if (rest.particles) {
      life = std::make_unique<ParticleLife>(*rest.particles);
      for (Index i = 0; i < state.size(); ++i) state.traits[i].is_smooth = !rest.creased[i];
      if (params.oriented_particles.fit) {
        const std::string news = fit(params.oriented_particles.growth).notice;
        if (std::find(rest.notes.begin(), rest.notes.end(), news) == rest.notes.end()) rest.notes.push_back(news);
      }
    }
    clampHeld();
    gravity.gravity = params.gravity;
    forces.clear();
    for (const ForceParams& force : params.forces) forces.set(force);
    grips.reset();
    contact.reset();
    part.reset();
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

  // Of what stays the same from step to step: the points at rest, and the scene but for what no step reads. FNV-1a.
  std::uint64_t identify() const {
    SceneParams scene = params;
    scene.cloud = CloudParams();
    scene.duration = SceneParams().duration;
    scene.threads = 0;
    scene.save_directory.clear();
    scene.expect.clear();
    std::uint64_t h = kHashBegin;
    for (unsigned char c : toYaml(printParams(scene))) h = (h ^ c) * 1099511628211ull;
    h = hashPoints(rest.points, h);
    return hashPoints(rest.dense.positions, h);
  }

  std::shared_ptr<const Snapshot::Contents> save() const {
    return std::make_shared<const Snapshot::Contents>(Snapshot::Contents{
        identify(), state, steps, pinned, pinned_turns, gravity.gravity, forces.all(), tools, grips.all(), contact.all(),
        cutting ? cutting->cuts() : std::vector<model::MassSpring::Link>(), surface.saveCut(), march.memory(),
        part ? part->march().memory() : part_march, part != nullptr, activity.memory(),
        surface.saveInserted(), estimator ? estimator->memory() : nullptr, statistics});
  }

  void restore(const Snapshot::Contents& saved) {
    if (cutting) cutting->setCuts(saved.cuts);
    state = saved.state;
    rest.model->adopt(state);
    placeAnchors();
    steps = saved.steps;
    pinned = saved.pinned;
    pinned_turns = saved.pinned_turns;
    clampHeld();
    gravity.gravity = saved.gravity;
    forces.restore(saved.forces);
    part.reset();
    setTools(saved.tools);
    grips.restore(saved.grips);
    contact.restore(saved.bodies);
    march.setMemory(saved.march);
    part_march = saved.part_march;
    activity.setMemory(saved.activity, state);
    if (saved.has_part) makePart();
    tool_watch.look(tools, time());
    changed();
    if (estimator && saved.estimate) estimator->setMemory(*saved.estimate);
    if (estimator && !saved.estimate) estimator->lose();
    surface.restoreInserted(saved.resampler.get());
    if (cutting) surface.restoreCut(saved.severed.get(), rest.model->stretchLinks());
    statistics = saved.statistics;
  }

  // Contact as stiff as the surface's own stiffest motion at rest bears: the stable step stays nearly what it is without. Once, before
  // the first tool.
  void findContactRate() {
    State at_rest;
    at_rest.positions = rest.points;
    at_rest.velocities.assign(rest.points.size(), Vec3::Zero());
    rest.model->beginAtRest(at_rest);
    const double stable = march.findStableStep(0.0, at_rest);
    rest.model->adopt(state);
    contact_rate = kContactRate * 2.0 / (std::isfinite(stable) ? stable : params.integrator.time_step);
    contact.setRate(contact_rate);
  }

  // Tells the model what is held; what was measured and kept of it with other clamps is then worth nothing.
  void clampHeld() {
    held = pinned;
    held_turns = pinned_turns;
    if (rest.model->setHeld(pinned)) march.restart();
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
      const std::string passed = contact.endStep(now, dt, state, held, rest.model->triangles());
      if (!passed.empty()) outcome.notice += (outcome.notice.empty() ? "" : "; ") + passed;
    }
    if (may_be_cut && cutting->endStep(tools, now, dt, state.positions, surface)) {
      wakeAll();
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
  ActivePart::Loads partLoads() const { return {gravity, anchors, forces, contact, contact_rate}; }
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
    rest.model->adopt(state);
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
    statistics.springs = static_cast<std::uint32_t>(rest.model->stretchLinks().size() + rest.model->bendLinks().size());
    statistics.awake = 0;
    for (Index i = 0; i < state.size(); ++i) statistics.awake += !held[i] && activity.isMoving(i);
    statistics.kinetic_energy = system.kineticEnergy(state);
    statistics.elastic_energy = rest.model->elasticEnergy(state);
    statistics.potential_energy = system.loadPotential(time(), state);
    statistics.max_stretch = rest.model->maxStretch(state);
    double squared_speed = 0.0;
    for (const Vec3& v : state.velocities) squared_speed = std::max(squared_speed, v.squaredNorm());
    statistics.max_speed = std::sqrt(squared_speed);
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
