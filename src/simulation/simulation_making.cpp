// How a simulation is made, begun anew and set: what its parts are told when tools, materials, damping or clamps change. Apart
// from the step, which only uses what is set here.
#include "simulation_impl.h"

#include "deformable_surface/base/error.h"
#include "deformable_surface/base/notice.h"
#include "deformable_surface/base/value.h"

#include <algorithm>
#include <cmath>

namespace deformable_surface::simulation {
namespace {

constexpr double kContactRate = 0.45;  // of the highest frequency at rest: its square then grows by a fifth at most

Index nearestPoint(const Points& points, const Vec3& to) {
  Index nearest = 0;
  for (Index i = 1; i < static_cast<Index>(points.size()); ++i)
    if ((points[i] - to).squaredNorm() < (points[nearest] - to).squaredNorm()) nearest = i;
  return nearest;
}

}  // namespace

Simulation::Impl::Impl(const SceneParams& given, std::shared_ptr<const cloud::PointCloud> cloud,
                       std::unique_ptr<model::DeformableModel> material, std::shared_ptr<const RestSurface> built)
    : params(given),
      shared_input(std::move(cloud)),
      model(std::move(material)),
      particles(dynamic_cast<model::OrientedParticles*>(model.get())),
      solid(dynamic_cast<model::ElasticSolid*>(model.get())),
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
  if (solid) forces.setDropped(solid->across());
  if (particles && params.oriented_particles.mode == model::ParticleMode::kPlane) forces.setDropped(Vec3::UnitY());
  if (auto* mass_spring = dynamic_cast<model::MassSpring*>(model.get()))
    cutting = std::make_unique<Cutting>(*mass_spring, params.mass_spring.tear_strain);
}

std::unique_ptr<Simulation::Impl> Simulation::Impl::make(const SceneParams& params, cloud::PointCloud&& cloud,
                                                         RestSurface built) {
  std::unique_ptr<model::DeformableModel> model = std::move(built.model);
  auto impl = std::make_unique<Impl>(params, std::make_shared<const cloud::PointCloud>(std::move(cloud)), std::move(model),
                                     std::make_shared<const RestSurface>(std::move(built)));
  impl->reset();
  return impl;
}

std::vector<AnchorLoad::Anchor> Simulation::Impl::makeAnchors() const {
  std::vector<AnchorLoad::Anchor> list;
  for (const AnchorParams& a : params.anchors) list.push_back({nearestPoint(rest.points, a.point), a.target, a.stiffness});
  return list;
}

// On the points that are there.
void Simulation::Impl::placeAnchors() {
  anchors = AnchorLoad(makeAnchors());
  if (!particles) return;
  std::vector<Index> index_of_id(state.next_id, -1);
  for (Index i = 0; i < state.size(); ++i) index_of_id[state.traits[i].id] = i;
  anchors.renumber(index_of_id);
}

// The first of the scene's pins that holds a point at rest or, where it rides on one, a neighbour of it; as many as there are:
// none.
std::size_t Simulation::Impl::findPin(Index point) const {
  const auto find = [&](Index i) -> std::size_t {
    const auto holds = [&](const PinParams& pin) { return pin.region.contains(rest.points[i]); };
    return std::find_if(params.pins.begin(), params.pins.end(), holds) - params.pins.begin();
  };
  std::size_t pin = find(point);
  if (pin < params.pins.size() || rest.pinned[point] != kRidesOnPin) return pin;
  for (const Index* j = rest.rings.ring.begin(point); j != rest.rings.ring.end(point) && pin == params.pins.size(); ++j)
    if (rest.pinned[*j] == kInPin) pin = find(*j);
  return pin;
}

// Those that go along a path. A point of two pins goes with the first.
void Simulation::Impl::placePins() {
  grips.clearPins();
  std::vector<std::vector<Index>> points(params.pins.size());
  for (Index i = 0; i < state.size(); ++i) {
    const std::size_t p = findPin(i);
    if (p < points.size()) points[p].push_back(i);
  }
  for (std::size_t p = 0; p < params.pins.size(); ++p)
    if (!params.pins[p].path.empty() && !points[p].empty())
      grips.addPin("pins[" + std::to_string(p) + "]", params.pins[p].path, 0.0, std::move(points[p]), state);
}

// Only the loads that can act are evaluated.
void Simulation::Impl::chooseLoads() {
  loads = {&forces};
  if (!gravity.gravity.isZero(0.0)) loads.insert(loads.begin(), &gravity);
  if (params.pressure != 0.0) loads.push_back(&pressure);
  if (params.viscous_drag > 0.0) loads.push_back(&drag);
  if (!params.anchors.empty()) loads.push_back(&anchors);
  if (!contact.isEmpty()) loads.push_back(&contact);
  if (!friction.isEmpty()) loads.push_back(&friction);
  if (!track.isEmpty()) loads.push_back(&track);
}

void Simulation::Impl::setTools(std::vector<tool::ToolParams> given) {
  for (const tool::ToolParams& tool : given)
    if (tool.shape.kind == geometry::Solid::Kind::kMesh && !tool.shape.mesh)
      throw InputError("tool " + quote(tool.id) +
                       " shape.mesh.file: found one that has not been read; accepted: vertices and triangles");
  for (const tool::ToolParams& tool : given)
    if (cutting && tool.mode == tool::Mode::kCut && (params.output.resample || params.mass_spring.volume_stiffness > 0.0))
      throw InputError("tool " + quote(tool.id) + " mode: found cut on a surface that " +
                       (params.output.resample ? "inserts points, which would not know their side" : "keeps its volume") +
                       "; accepted: cut without output.resample and mass_spring.volume_stiffness");
  if (!given.empty()) leaveTrial("a tool came");
  if (!given.empty() && !(contact_rate > 0.0)) findContactRate();
  tools = std::move(given);
  giveContactTools();
  grips.setTools(tools);
  chooseLoads();
  loadsChanged();
  setParts();
}

// Knives cut springs without resistance; particles they push, too.
void Simulation::Impl::giveContactTools() {
  std::vector<tool::ToolParams> pushing = tools;
  const auto isKnife = [](const tool::ToolParams& tool) { return tool.mode == tool::Mode::kCut; };
  if (cutting) pushing.erase(std::remove_if(pushing.begin(), pushing.end(), isKnife), pushing.end());
  contact.setArriving(params.integrator.type != solve::IntegratorType::kStatic);
  contact.setTools(pushing);
}

void Simulation::Impl::reset() {
  if (cutting) cutting->setCuts({});
  state.positions = rest.points;
  state.velocities.assign(rest.points.size(), Vec3::Zero());
  model->beginAtRest(state);
  activity.reset();
  steps = 0;
  pinned = rest.pinned;
  pinned_turns = rest.pinned_turns;
  clamp_edges = rest.clamp_edges;
  placePins();
  placeAnchors();
  if (particles) {
    life = std::make_unique<ParticleLife>(*particles);
    particles->setSpacing(particles->statedSpacing());  // what an earlier fit made of it is gone
    for (Index i = 0; i < state.size(); ++i) state.traits[i].is_smooth = !rest.creased[i];
    if (params.oriented_particles.fit) {
      const std::string news = fit(params.oriented_particles.growth).notice;
      if (std::find(notes.begin(), notes.end(), news) == notes.end()) notes.push_back(news);
    }
  }
  clampHeld();
  track.restore({});
  values = rest.values;
  membrane_share = chosen_membrane_share;
  softening = 0.0;
  applyMaterial();
  setDamping(params.material.damping);
  gravity.gravity = params.gravity;
  forces.clear();
  for (const ForceParams& force : params.forces) forces.set(force);
  grips.reset();
  contact.reset();
  part.reset();
  followed.clear();
  part_march = {};
  contact.setTools({});  // by which the rate of contact must not be measured
  chooseLoads();
  contact_rate = 0.0;
  setTools(params.tools);
  if (chosen_integrator != solve::IntegratorType::kAuto) params.integrator.type = chosen_integrator;
  share_notice.clear();
  tool_watch.reset();
  march.restart();
  if (estimator) estimator->reset();
  is_wish_missed = false;
  loose_said = 0;
  surface.reset();
  statistics = Statistics{};
  changed();
  measure();
}

// Tells the model what its points are made of. What follows from the stiffness is found anew.
void Simulation::Impl::applyMaterial() {
  if (values.empty()) return;
  std::vector<model::PointMaterial> now = findShares(made, params.material, values);
  for (model::PointMaterial& point : now) point.stretching *= membrane_share;
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

// Back to the stated stiffness, until the next reset.
void Simulation::Impl::stiffenMembrane(const std::string& why) {
  if (membrane_share == 1.0) return;
  share_notice =
      "the membrane, of which " + formatReal(membrane_share) + " of the stated stiffness acted, has all of it again: " + why;
  membrane_share = 1.0;
  applyMaterial();
  if (estimator) estimator->stiffenMembrane();
}

// Back to what auto takes by itself, until the next reset.
void Simulation::Impl::leaveIntegrator(const std::string& why) {
  if (chosen_integrator == solve::IntegratorType::kAuto || params.integrator.type != chosen_integrator) return;
  params.integrator.type = solve::IntegratorType::kAuto;
  wakeAll();
  appendNotice(share_notice, "integrator.type is auto again: " + why);
}

// What happens from now on has not been tried.
void Simulation::Impl::leaveTrial(const char* how) {
  if (!(params.accuracy.position_error > 0.0)) return;
  const std::string why = std::string(how) + ", which was not tried";
  stiffenMembrane(why);
  leaveIntegrator(why);
}

void Simulation::Impl::setDamping(double damping) {
  system.setDamping(damping);
  if (estimator) estimator->setDamping(damping);
  wakeAll();
}

// Of params, to those who keep a copy of them.
void Simulation::Impl::takePhysics() {
  pressure.setPressure(params.pressure);
  drag.setDrag(params.viscous_drag);
  applyMaterial();
  chooseLoads();
  wakeAll();
  setParts();
}

// Contact as stiff as the surface's own stiffest motion at rest bears: the stable step stays nearly what it is without. Once,
// before the first tool.
void Simulation::Impl::findContactRate() {
  State at_rest;
  at_rest.positions = rest.points;
  at_rest.velocities.assign(rest.points.size(), Vec3::Zero());
  model->beginAtRest(at_rest);
  // The points at rest have clamps of their own: particles may have gone and come since.
  std::vector<char> now_held = rest.pinned, now_held_turns = rest.pinned_turns;
  held.swap(now_held);
  held_turns.swap(now_held_turns);
  const double stable = march.findStableStep(0.0, at_rest);
  held.swap(now_held);
  held_turns.swap(now_held_turns);
  model->adopt(state);
  contact_rate = kContactRate * 2.0 / (std::isfinite(stable) ? stable : params.integrator.time_step);
  contact.setRate(contact_rate);
}

// Where a region that has just been pinned ends; inside (m): its points. Returns the points that ride on it.
std::vector<Index> Simulation::Impl::findClamps(const std::vector<char>& inside, const Contains& contains) {
  if (!canClamp(params)) return {};
  const double spacing = std::sqrt(rest.area / static_cast<double>(rest.points.size()));
  const std::vector<char> clamping = markClamping(rest.points, rest.rings.ring, inside, spacing);
  const ClampEdges found = findClampEdges(
      {rest.points, state.positions, rest.rings.ring, rest.rings.open, model->triangles()}, clamping, contains);
  std::vector<Index> riding;
  for (const Index i : found.riding) {
    if (pinned[i]) continue;
    pinned[i] = kRidesOnPin;
    state.velocities[i].setZero();
    riding.push_back(i);
  }
  for (const model::ClampEdge& edge : found.edges) {
    const auto at = std::lower_bound(clamp_edges.begin(), clamp_edges.end(), edge.point,
                                     [](const model::ClampEdge& e, Index point) { return e.point < point; });
    if (at != clamp_edges.end() && at->point == edge.point)
      *at = edge;
    else
      clamp_edges.insert(at, edge);
  }
  return riding;
}

// After points have been let go: what rode on them goes with them.
void Simulation::Impl::endClamps() {
  if (!canClamp(params)) return;
  const Lists& ring = rest.rings.ring;
  const auto isInPin = [&](Index j) { return pinned[j] == kInPin; };
  for (Index i = 0; i < state.size(); ++i)
    if (pinned[i] == kRidesOnPin && std::none_of(ring.begin(i), ring.end(i), isInPin)) pinned[i] = kNotPinned;
  clamp_edges.erase(std::remove_if(clamp_edges.begin(), clamp_edges.end(),
                                   [&](const model::ClampEdge& edge) { return !pinned[edge.point]; }),
                    clamp_edges.end());
}

// Tells the model what is held; what was measured and kept of it with other clamps is then worth nothing.
void Simulation::Impl::clampHeld() {
  held = pinned;
  held_turns = pinned_turns;
  if (model->setHeld(pinned, clamp_edges)) march.restart();
  const double cold = params.oriented_particles.hold_below;
  if (!life || !(cold > 0.0)) return;
  for (Index i = 0; i < state.size(); ++i) {
    if (state.traits[i].temperature >= cold) continue;
    held[i] = held_turns[i] = 1;
    state.velocities[i].setZero();
    state.spins[i].setZero();
  }
}

}  // namespace deformable_surface::simulation
