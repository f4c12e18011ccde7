// How a dynamics is made, begun anew, set, saved and restored: what its parts are told when tools, materials or clamps change.
// Apart from the step, which only uses what is set here.
#include "dynamics.h"

#include "deformable_surface/base/error.h"
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

double findSpacing(const RestSurface& rest) { return std::sqrt(rest.area / static_cast<double>(rest.points.size())); }


}  // namespace

Dynamics::Dynamics(const SceneParams& params, Made made)
    : params_(params),
      rest_(std::move(made.rest)),
      model_(std::move(made.model)),
      particles_(dynamic_cast<model::OrientedParticles*>(model_.get())),
      solid_(dynamic_cast<model::ElasticSolid*>(model_.get())),
      loads_(*model_, params),
      system_(*model_, loads_.acting(), held_, params.material.damping, &held_turns_),
      march_(system_, *model_, params_.integrator),
      activity_(params.activity, rest_->points, findSpacing(*rest_), params.integrator.time_step, *model_, canBeInParts()) {
  chosen_.made = params.material;
  loads_.contact.setArriving(params.integrator.type != solve::IntegratorType::kStatic);
  if (particles_) life_ = std::make_unique<ParticleLife>(*particles_);
  if (solid_) loads_.forces.setDropped(solid_->across());
  if (particles_ && params.oriented_particles.mode == model::ParticleMode::kPlane) loads_.forces.setDropped(Vec3::UnitY());
  if (auto* mass_spring = dynamic_cast<model::MassSpring*>(model_.get()))
    cutting_ = std::make_unique<Cutting>(*mass_spring, params.mass_spring.tear_strain);
}

Dynamics::Dynamics(const SceneParams& params, RestSurface rest) : Dynamics(params, take(std::move(rest))) {
  requireTools(params.tools);
  reset();
}

Dynamics::Made Dynamics::take(RestSurface&& rest) {
  std::unique_ptr<model::DeformableModel> model = std::move(rest.model);
  return {std::make_shared<const RestSurface>(std::move(rest)), std::move(model)};
}

void Dynamics::reset() {
  if (cutting_) cutting_->setCuts({});
  State& points = now_.points;
  points.positions = rest_->points;
  points.velocities.assign(rest_->points.size(), Vec3::Zero());
  model_->beginAtRest(points);
  activity_.reset();
  steps_ = 0;
  now_.pinned = rest_->pinned;
  now_.pinned_turns = rest_->pinned_turns;
  now_.clamp_edges = rest_->clamp_edges;
  placePins();
  placeAnchors();
  if (particles_) {
    life_ = std::make_unique<ParticleLife>(*particles_);
    particles_->setSpacing(particles_->statedSpacing());  // what an earlier fit made of it is gone
    for (Index i = 0; i < points.size(); ++i) points.traits[i].is_smooth = !rest_->creased[i];
    if (params_.oriented_particles.fit) growth_notice_ = grow(params_.oriented_particles.growth).notice;
  }
  clampHeld();
  loads_.track.restore({});
  values_ = rest_->values;
  now_.membrane_share = chosen_.membrane_share;
  applyMaterial();
  system_.setDamping(params_.material.damping);
  loads_.gravity.gravity = params_.gravity;
  loads_.forces.clear();
  for (const ForceParams& force : params_.forces) loads_.forces.set(force);
  grips_.reset();
  loads_.contact.reset();
  part_.reset();
  now_.followed.clear();
  part_march_ = {};
  loads_.contact.setTools({});  // by which the rate of contact must not be measured
  loads_.choose();
  now_.contact_rate = 0.0;
  setTools(params_.tools);
  if (chosen_.integrator != solve::IntegratorType::kAuto) params_.integrator.type = chosen_.integrator;
  tool_watch_.reset();
  loose_said_ = 0;
  Changes all;
  all.loads = all.parts = all.motion = all.everywhere = true;
  follow(all);
}

std::vector<AnchorLoad::Anchor> Dynamics::makeAnchors() const {
  std::vector<AnchorLoad::Anchor> list;
  for (const AnchorParams& a : params_.anchors) list.push_back({nearestPoint(rest_->points, a.point), a.target, a.stiffness});
  return list;
}

// On the points that are there.
void Dynamics::placeAnchors() {
  loads_.anchors = AnchorLoad(makeAnchors());
  if (!particles_) return;
  const State& points = now_.points;
  std::vector<Index> index_of_id(points.next_id, -1);
  for (Index i = 0; i < points.size(); ++i) index_of_id[points.traits[i].id] = i;
  loads_.anchors.renumber(index_of_id);
}

// The first of the scene's pins that holds a point at rest or, where it rides on one, a neighbour of it; as many as there are:
// none.
std::size_t Dynamics::findPin(Index point) const {
  const std::vector<PinParams>& pins = params_.pins;
  const auto find = [&](Index i) -> std::size_t {
    const auto holds = [&](const PinParams& pin) { return pin.region.contains(rest_->points[i]); };
    return std::find_if(pins.begin(), pins.end(), holds) - pins.begin();
  };
  std::size_t pin = find(point);
  if (pin < pins.size() || rest_->pinned[point] != kRidesOnPin) return pin;
  const Lists& ring = rest_->rings.ring;
  for (const Index* j = ring.begin(point); j != ring.end(point) && pin == pins.size(); ++j)
    if (rest_->pinned[*j] == kInPin) pin = find(*j);
  return pin;
}

// Those that go along a path. A point of two pins goes with the first.
void Dynamics::placePins() {
  const std::vector<PinParams>& pins = params_.pins;
  grips_.clearPins();
  std::vector<std::vector<Index>> points(pins.size());
  for (Index i = 0; i < now_.points.size(); ++i) {
    const std::size_t p = findPin(i);
    if (p < points.size()) points[p].push_back(i);
  }
  for (std::size_t p = 0; p < pins.size(); ++p)
    if (!pins[p].path.empty() && !points[p].empty())
      grips_.addPin("pins[" + std::to_string(p) + "]", pins[p].path, 0.0, std::move(points[p]), now_.points);
}

void Dynamics::requireTools(const std::vector<tool::ToolParams>& tools) const {
  for (const tool::ToolParams& tool : tools)
    if (tool.shape.kind == geometry::Solid::Kind::kMesh && !tool.shape.mesh)
      throw InputError("tool " + quote(tool.id) +
                       " shape.mesh.file: found one that has not been read; accepted: vertices and triangles");
  for (const tool::ToolParams& tool : tools)
    if (cutting_ && tool.mode == tool::Mode::kCut && (params_.output.resample || params_.mass_spring.volume_stiffness > 0.0))
      throw InputError("tool " + quote(tool.id) + " mode: found cut on a surface that " +
                       (params_.output.resample ? "inserts points, which would not know their side" : "keeps its volume") +
                       "; accepted: cut without output.resample and mass_spring.volume_stiffness");
}

void Dynamics::setTools(std::vector<tool::ToolParams> tools) {
  if (!tools.empty() && !(now_.contact_rate > 0.0)) findContactRate();
  tools_ = std::move(tools);
  giveContactTools();
  grips_.setTools(tools_);
}

// Knives cut springs without resistance; particles they push, too.
void Dynamics::giveContactTools() {
  std::vector<tool::ToolParams> pushing = tools_;
  const auto isKnife = [](const tool::ToolParams& tool) { return tool.mode == tool::Mode::kCut; };
  if (cutting_) pushing.erase(std::remove_if(pushing.begin(), pushing.end(), isKnife), pushing.end());
  loads_.contact.setTools(pushing);
}

// Tells the model what its points are made of. Returns whether that is news to it.
bool Dynamics::applyMaterial() {
  if (values_.empty()) return false;
  std::vector<model::PointMaterial> now = findShares(chosen_.made, params_.material, values_);
  for (model::PointMaterial& point : now) point.stretching *= now_.membrane_share;
  if (shares_.empty()) shares_ = findShares(chosen_.made, chosen_.made, rest_->values);
  if (now == shares_) return false;
  model_->setMaterial(now);
  shares_ = std::move(now);
  return true;
}

// Contact as stiff as the surface's own stiffest motion at rest bears: the stable step stays nearly what it is without. Once,
// before the first tool.
void Dynamics::findContactRate() {
  State at_rest;
  at_rest.positions = rest_->points;
  at_rest.velocities.assign(rest_->points.size(), Vec3::Zero());
  model_->beginAtRest(at_rest);
  // The points at rest have clamps of their own: particles may have gone and come since.
  std::vector<char> now_held = rest_->pinned, now_held_turns = rest_->pinned_turns;
  held_.swap(now_held);
  held_turns_.swap(now_held_turns);
  const double stable = march_.findStableStep(0.0, at_rest);
  held_.swap(now_held);
  held_turns_.swap(now_held_turns);
  model_->adopt(now_.points);
  now_.contact_rate = kContactRate * 2.0 / (std::isfinite(stable) ? stable : params_.integrator.time_step);
  loads_.contact.setRate(now_.contact_rate);
}

// With another stiffness. What tools hold up stays up.
void Dynamics::findContactRateAgain() {
  const std::vector<ContactLoad::Body> bodies = loads_.contact.all();
  loads_.contact.setTools({});
  loads_.choose();
  now_.contact_rate = 0.0;
  if (!tools_.empty()) findContactRate();
  loads_.contact.restore(bodies);
  loads_.choose();
}

// Where a region that has just been pinned ends; inside (m): its points. Returns the points that ride on it.
std::vector<Index> Dynamics::findClamps(const std::vector<char>& inside, const Contains& contains) {
  if (!canClamp(params_)) return {};
  const std::vector<char> clamping = markClamping(rest_->points, rest_->rings.ring, inside, findSpacing(*rest_));
  const ClampEdges found = findClampEdges(
      {rest_->points, now_.points.positions, rest_->rings.ring, rest_->rings.open, model_->triangles()}, clamping, contains);
  std::vector<Index> riding;
  for (const Index i : found.riding) {
    if (now_.pinned[i]) continue;
    now_.pinned[i] = kRidesOnPin;
    now_.points.velocities[i].setZero();
    riding.push_back(i);
  }
  std::vector<model::ClampEdge>& edges = now_.clamp_edges;
  for (const model::ClampEdge& edge : found.edges) {
    const auto at = std::lower_bound(edges.begin(), edges.end(), edge.point,
                                     [](const model::ClampEdge& e, Index point) { return e.point < point; });
    if (at != edges.end() && at->point == edge.point)
      *at = edge;
    else
      edges.insert(at, edge);
  }
  return riding;
}

// After points have been let go: what rode on them goes with them.
void Dynamics::endClamps() {
  if (!canClamp(params_)) return;
  const Lists& ring = rest_->rings.ring;
  std::vector<char>& pinned = now_.pinned;
  std::vector<model::ClampEdge>& edges = now_.clamp_edges;
  const auto isInPin = [&](Index j) { return pinned[j] == kInPin; };
  for (Index i = 0; i < now_.points.size(); ++i)
    if (pinned[i] == kRidesOnPin && std::none_of(ring.begin(i), ring.end(i), isInPin)) pinned[i] = kNotPinned;
  edges.erase(std::remove_if(edges.begin(), edges.end(), [&](const model::ClampEdge& edge) { return !pinned[edge.point]; }),
              edges.end());
}

// Tells the model what is held; what was measured and kept of it with other clamps is then worth nothing.
void Dynamics::clampHeld() {
  held_ = now_.pinned;
  held_turns_ = now_.pinned_turns;
  if (model_->setHeld(now_.pinned, now_.clamp_edges)) march_.restart();
  const double cold = params_.oriented_particles.hold_below;
  if (!life_ || !(cold > 0.0)) return;
  State& points = now_.points;
  for (Index i = 0; i < points.size(); ++i) {
    if (points.traits[i].temperature >= cold) continue;
    held_[i] = held_turns_[i] = 1;
    points.velocities[i].setZero();
    points.spins[i].setZero();
  }
}

void Dynamics::setInterrupt(const std::atomic<bool>* interrupt) {
  interrupt_ = interrupt;
  march_.setInterrupt(interrupt);
  if (part_) part_->march().setInterrupt(interrupt);
}

void Dynamics::setFineness(Index fineness) {
  fineness_ = fineness;
  march_.setFineness(fineness);
  if (part_) part_->march().setFineness(fineness);
}

void Dynamics::setIntegrator(solve::IntegratorType type) {
  if (params_.integrator.type == type) return;
  params_.integrator.type = type;
  Changes changes;
  changes.everywhere = true;
  follow(changes);
}

void Dynamics::softenMembrane(double share) {
  chosen_.membrane_share = share;
  setMembraneShare(share);
}

void Dynamics::setMembraneShare(double share) {
  now_.membrane_share = share;
  followMaterial();
}

void Dynamics::followMaterial() {
  if (!applyMaterial()) return;
  Changes changes;
  changes.material = changes.motion = changes.everywhere = true;
  follow(changes);
}

Index Dynamics::numOwnMaterial() const {
  return static_cast<Index>(std::count_if(values_.begin(), values_.end(), [](const PointValues& v) { return v.areOwn(); }));
}

// ---- memory ----

void Dynamics::keepWaiting(DynamicsState::Waiting& waiting) const {
  waiting.steps = steps_;
  waiting.forces = loads_.forces.all();
  waiting.watched = tool_watch_.memory();
  waiting.activity = activity_.memory();
  waiting.march = march_.memory();
  waiting.part_march = part_ ? part_->march().memory() : part_march_;
  waiting.has_part = part_ && !activity_.isAsleep();
}

void Dynamics::keepHolding(DynamicsState::Holding& holding) const {
  holding.integrator = params_.integrator.type;
  holding.grips = grips_.all();
  holding.bodies = loads_.contact.all();
  if (cutting_) holding.cuts = cutting_->cuts();
  holding.tracked = loads_.track.seen();
}

DynamicsState Dynamics::save() const {
  DynamicsState saved;
  keepWaiting(saved.waiting);
  saved.motion = now_;
  keepHolding(saved.holding);
  saved.settings.tools = tools_;
  saved.settings.values = values_;
  saved.settings.gravity = loads_.gravity.gravity;
  saved.settings.damping = system_.damping();
  saved.settings.spacing = particles_ ? particles_->lattice().spacing : 0.0;
  saved.settings.physics = findPhysics(params_);
  return saved;
}

void Dynamics::restore(const DynamicsState& saved, bool to_look) {
  const DynamicsState::Settings& settings = saved.settings;
  if (particles_ && particles_->lattice().spacing != settings.spacing) particles_->setSpacing(settings.spacing);
  tools_ = settings.tools;
  values_ = settings.values;
  setPhysics(settings.physics, params_);
  loads_.gravity.gravity = settings.gravity;
  loads_.pressure.setPressure(params_.pressure);
  loads_.drag.setDrag(params_.viscous_drag);
  system_.setDamping(settings.damping);
  giveContactTools();
  giveBack(saved, to_look);
}

// Of a step that is refused; of a snapshot, after its settings.
void Dynamics::giveBack(const DynamicsState& saved, bool to_look) {
  const auto& [waiting, motion, holding, settings] = saved;
  if (cutting_) cutting_->setCuts(holding.cuts);
  now_ = motion;
  model_->adopt(now_.points);
  placeAnchors();
  clampHeld();
  now_.points = motion.points;  // cold particles may have been moving
  steps_ = waiting.steps;
  params_.integrator.type = holding.integrator;
  applyMaterial();
  loads_.contact.setRate(now_.contact_rate);
  loads_.forces.restore(waiting.forces);
  loads_.track.restore(holding.tracked);
  grips_.restore(holding.grips);
  loads_.contact.restore(holding.bodies);
  loads_.choose();
  setParts();
  part_.reset();
  march_.setMemory(waiting.march);
  part_march_ = waiting.part_march;
  activity_.setMemory(waiting.activity, now_.points);
  now_.followed.clear();
  if (!motion.followed.empty() && activity_.isInParts()) followPartners(motion.followed);
  if (waiting.has_part && !to_look) makePart();
  tool_watch_.setMemory(waiting.watched);
  ++revision_;
}

std::unique_ptr<Dynamics> Dynamics::fork(bool to_look) const {
  std::unique_ptr<model::DeformableModel> model = model_->clone();
  if (!model) throw InputError("model: found one that cannot be copied; accepted: one of this package");
  std::unique_ptr<Dynamics> fork(new Dynamics(params_, Made{rest_, std::move(model)}));
  fork->chosen_ = chosen_;
  fork->shares_ = shares_;
  fork->growth_notice_ = growth_notice_;
  fork->restore(save(), to_look);
  return fork;
}

}  // namespace deformable_surface::simulation
