// Construction, resets and settings of a dynamics: updates of its parts when tools, materials or the method change. Steps only
// use what is set here.
#include "dynamics.h"

#include "deformable_surface/base/error.h"
#include "deformable_surface/base/value.h"

#include <algorithm>
#include <cmath>

#include "contact_areas.h"
#include "points_between.h"
#include "rest_parts.h"
#include "spacing.h"

namespace deformable_surface::simulation {
namespace {

constexpr double kContactRate = 0.45;     // of the highest frequency at rest: its square then grows by a fifth at most
constexpr double kSelfContactRate = 0.1;  // the same: a point may be in contact with many triangles and edges
constexpr double kBornePerSpring = 2.0;  // layers of the surface that a spring of contact bears: eight on four springs of a point

Index nearestPoint(const Points& points, const Vec3& to) {
  Index nearest = 0;
  for (Index i = 1; i < static_cast<Index>(points.size()); ++i)
    if ((points[i] - to).squaredNorm() < (points[nearest] - to).squaredNorm()) nearest = i;
  return nearest;
}

}  // namespace

Dynamics::Dynamics(const SceneParams& params, Made made)
    : params_(params),
      rest_(std::move(made.rest)),
      model_(std::move(made.model)),
      kind_(findModel(params.model)),
      evolution_(kind_.makeEvolution(*model_, *rest_, params_)),
      loads_(*model_, params),
      burst_(*model_, loads_.pressure),
      system_(*model_, loads_.acting(), held_, params.material.damping, &held_turns_),
      march_(system_, *model_, params_.integrator),
      activity_(params.sleep, rest_->points, findSpacing(rest_->area, rest_->points.size()), params.integrator.time_step, *model_,
                canBeInParts()) {
  chosen_.made = params.material;
  chosen_.made_for = params.integrator.type;
  loads_.contact.setArriving(params.integrator.type != solve::IntegratorType::kStatic);
  if (params.contact.compliance > 0.0)
    loads_.contact.setCompliance(params.contact.compliance,
                                 made.is_fork ? std::move(made.areas) : findContactAreas(params, *rest_, *model_));
  makeSelfContact(std::move(made));
  loads_.forces.setDropped(rest_->across);
  num_links_ = model_->links() ? static_cast<Index>(model_->links()->stretchLinks().size()) : 0;
}
// `auto` is decided here, once: forks do as what they are forked from.
void Dynamics::makeSelfContact(Made made) {
  const OrAuto<bool> wanted = params_.contact.self;
  const ModelTraits traits = kind_.traits();
  // Equilibria far away can often not be checked on the way, and would be searched twice.
  const bool is_static = params_.integrator.type == solve::IntegratorType::kStatic;
  const bool may_be_auto = traits.meets_itself && rest_->across.isZero(0.0) && !is_static;
  if (wanted.is_auto && !may_be_auto)
    why_no_self_contact_ = is_static ? "equilibria are searched without it" : "planar solids have none";
  if (!wanted.valueOr(may_be_auto) || (made.is_fork && !made.meeting)) return;
  contact::SelfContactParams meeting;
  meeting.thickness = findContactThickness(params_, *rest_);
  meeting.friction = params_.contact.friction;
  meeting.kinetic_friction = params_.contact.kinetic_friction.valueOr(params_.contact.friction);
  meeting.hardens = is_static || params_.integrator.type == solve::IntegratorType::kImplicit;
  meeting.is_body = !traits.is_surface;
  meeting.compliance = params_.contact.compliance;
  meeting.areas = loads_.contact.points().areas().of_points;
  if (!made.meeting) made.meeting = std::make_shared<const ContactSkin>(rest_->points, kind_.findSkin(*rest_, *model_));
  const auto make = [&] {
    loads_.self_contact = std::make_unique<SelfContactLoads>(rest_->points, made.meeting, *model_, meeting);
  };
  meeting.looks_first = made.looks_first;
  make();
  const auto isClear = [&] { return loads_.self_contact->contact.isClear(rest_->points); };
  if (wanted.is_auto && !made.is_fork && !isClear()) {
    meeting.looks_first = true;
    make();
    if (!isClear()) {
      why_no_self_contact_ =
          "parts are near each other at rest, within about two spacings of their points or more if contact is thick, as at " +
          formatPlace(loads_.self_contact->contact.placeSeen()) + " m";
      skin_without_contact_ = loads_.self_contact->skin();
      loads_.self_contact.reset();
      return;
    }
  }
  system_.setMotionLimit(&loads_.self_contact->limit);
}

std::shared_ptr<const ContactSkin> Dynamics::skinWithoutContact() {
  if (!skin_without_contact_)
    skin_without_contact_ = std::make_shared<const ContactSkin>(rest_->points, kind_.findSkin(*rest_, *model_));
  return skin_without_contact_;
}

Dynamics::Dynamics(const SceneParams& params, RestSurface rest) : Dynamics(params, take(std::move(rest))) {
  requireTools(params.tools);
  reset();
}

Dynamics::Made Dynamics::take(RestSurface&& rest) {
  std::unique_ptr<model::DeformableModel> model = std::move(rest.model);
  return {std::make_shared<const RestSurface>(std::move(rest)), std::move(model), nullptr};
}

void Dynamics::reset() {
  const bool was_cut = evolution_->memory() != nullptr;
  evolution_->forget();
  if (was_cut) followCuts();
  State& points = now_.points;
  points.positions = rest_->points;
  points.velocities.assign(rest_->points.size(), Vec3::Zero());
  points.friction.clear();
  points.self_friction.clear();
  beginAtRest(*model_, points);
  activity_.reset();
  steps_ = 0;
  now_.pinned = rest_->pinned;
  now_.pinned_turns = rest_->pinned_turns;
  now_.clamp_edges = rest_->clamp_edges;
  grips_.reset();
  placePins();
  placeAnchors();
  const Population begun = evolution_->begin(now_.pinned, now_.pinned_turns, points);
  followPopulation(begun);
  growth_notice_ = begun.notice;
  growth_warning_ = begun.warning;
  clampHeld();
  loads_.track.restore({});
  values_ = rest_->values;
  now_.membrane_share = chosen_.membrane_share;
  applyMaterial();
  system_.setDamping(params_.material.damping);
  loads_.gravity.gravity = params_.gravity;
  loads_.forces.clear();
  for (const ForceParams& force : params_.forces) loads_.forces.set(force);
  placeLoadPoints();
  loads_.contact.reset();
  part_.reset();
  now_.followed.clear();
  part_march_ = {};
  loads_.contact.setTools({});  // the rate of contact must not be measured with tools
  if (loads_.self_contact) loads_.self_contact->setMemory({});
  findTangles();
  loads_.choose();
  now_.contact_rate = 0.0;
  setTools(params_.tools);
  if (chosen_.integrator != solve::IntegratorType::kAuto) params_.integrator.type = chosen_.integrator;
  tool_watch_.reset();
  const std::size_t near = told_.contact_work.near;
  told_ = {};
  told_.contact_work.near = near;
  Changes all;
  all.loads = all.parts = all.motion = all.everywhere = true;
  follow(all);
}

std::vector<AnchorLoad::Anchor> Dynamics::makeAnchors() const {
  std::vector<AnchorLoad::Anchor> list;
  for (const AnchorParams& a : params_.anchors) list.push_back({nearestPoint(rest_->points, a.point), a.target, a.stiffness});
  return list;
}

// On the present points.
void Dynamics::placeAnchors() {
  loads_.anchors = AnchorLoad(makeAnchors());
  if (!kind_.traits().has_population) return;
  const State& points = now_.points;
  std::vector<Index> index_of_id(points.next_id, -1);
  for (Index i = 0; i < points.size(); ++i) index_of_id[points.traits[i].id] = i;
  loads_.anchors.renumber(index_of_id);
}

void Dynamics::requireTools(const std::vector<tool::ToolParams>& tools) const {
  for (const tool::ToolParams& tool : tools)
    if (tool.shape.kind == geometry::Solid::Kind::kMesh && !tool.shape.mesh)
      throw InputError("tool " + quote(tool.id) +
                       " shape.mesh.file: found one that has not been read; accepted: vertices and triangles");
  for (const tool::ToolParams& tool : tools) {
    const std::string problem = kind_.refuseTool(params_, tool);
    if (!problem.empty()) throw InputError("tool " + quote(tool.id) + " " + problem);
  }
}

void Dynamics::setTools(std::vector<tool::ToolParams> tools) {
  if (hasContact(tools) && !(now_.contact_rate > 0.0)) findContactRate();
  tools_ = std::move(tools);
  giveContactTools();
  if (loads_.friction.isEmpty()) now_.points.friction.clear();
  grips_.setTools(tools_);
}

// Once, when the first solid tool comes that may touch them.
void Dynamics::placePointsBetween() {
  if (has_between_ || std::none_of(tools_.begin(), tools_.end(), tool::isPushing)) return;
  const std::vector<model::WeightedTriangle>& skin = outside();
  has_between_ = !skin.empty();
  loads_.contact.setBetween(kind_.makeBetween(params_, *rest_, skin));
  severPointsBetween();
}

// What is cut has left some of them without a side. They are looked for only where links have changed: tools move in each step.
void Dynamics::severPointsBetween() {
  if (!model_->links()) return;
  const std::vector<std::pair<Index, Index>>& links = model_->links()->stretchLinks();
  const bool is_cut = static_cast<Index>(links.size()) < num_links_;
  const auto severedOf = [&](const transfer::SampledPoints& between) {
    return is_cut ? findSevered(between, links, static_cast<Index>(model_->masses().size())) : std::vector<char>();
  };
  if (loads_.contact.points().between()) loads_.contact.setSevered(severedOf(*loads_.contact.points().between()));
  if (loads_.forces.loadPoints()) loads_.forces.setSevered(severedOf(*loads_.forces.loadPoints()->between));
}

// The parts of contact and of loads that are cut with the surface.
void Dynamics::followCuts() {
  severPointsBetween();
  if (loads_.self_contact) loads_.self_contact->followCut(*model_);
}

// Positions are new. Looks for what crosses itself, if that is to be pushed apart.
void Dynamics::findTangles() {
  if (!params_.contact.untangle) return;
  SelfContactLoads& self = *loads_.self_contact;
  self.followCrossings(now_.points.positions);
  untangling_ = {static_cast<Index>(self.contact.pairs().crossings().size()), 0.0, false};
}

// Once, when the first force with a radius comes.
void Dynamics::placeLoadPoints() {
  if (has_load_points_ || !loads_.forces.needLoadPoints()) return;
  has_load_points_ = true;
  loads_.forces.setLoadPoints(kind_.makeLoadPoints(params_, *rest_));
  severPointsBetween();
}

void Dynamics::giveContactTools() {
  placePointsBetween();
  std::vector<tool::ToolParams> pushing = tools_;
  const auto passes = [&](const tool::ToolParams& tool) { return !evolution_->isPushedBy(tool); };
  pushing.erase(std::remove_if(pushing.begin(), pushing.end(), passes), pushing.end());
  loads_.contact.setTools(pushing);
}

// Gives the model the materials of its points. Returns whether they have changed.
bool Dynamics::applyMaterial() {
  if (values_.empty()) return false;
  std::vector<model::PointMaterial> now = findShares(chosen_.made, params_.material, values_);
  for (model::PointMaterial& point : now) point.stretching *= now_.membrane_share;
  if (shares_.empty()) shares_ = findShares(chosen_.made, chosen_.made, rest_->values);
  if (now == shares_) return false;
  if (!model_->pointMaterials())
    throw InputError("material: found values that differ from those the model was made with; accepted: those, for this model");
  model_->pointMaterials()->setMaterial(now);
  loads_.contact.followMasses();
  if (loads_.self_contact) loads_.self_contact->contact.setMasses(model_->masses());
  shares_ = std::move(now);
  return true;
}

bool Dynamics::hasContact(const std::vector<tool::ToolParams>& tools) const { return !tools.empty() || loads_.self_contact; }

void Dynamics::setContactRate(double rate) {
  now_.contact_rate = rate;
  loads_.contact.setRate(rate);
  const ModelTraits& traits = kind_.traits();
  loads_.contact.setStiffening(traits.contact_stiffening);
  if (!loads_.self_contact) return;
  contact::SelfContact& contact = loads_.self_contact->contact;
  // With less, soft layers that lie on each other would rest at half of the thickness, where contact limits motion.
  const double bearing = std::sqrt(2.0 * kBornePerSpring * loads_.gravity.gravity.norm() / contact.pairs().thickness());
  contact.setRate(std::max(std::sqrt(traits.self_contact_stiffening) * kSelfContactRate / kContactRate * rate, bearing));
}

// Contact as stiff as the surface's own stiffest motion at rest: the stable step then stays nearly the same. Done once,
// before the first tool or, with self-contact, before the first step.
void Dynamics::findContactRate() {
  State at_rest;
  at_rest.positions = rest_->points;
  at_rest.velocities.assign(rest_->points.size(), Vec3::Zero());
  beginAtRest(*model_, at_rest);
  // The points at rest have clamps of their own: particles may have been removed and added since.
  std::vector<char> now_held = rest_->pinned, now_held_turns = rest_->pinned_turns;
  held_.swap(now_held);
  held_turns_.swap(now_held_turns);
  const double stable = march_.findStableStep(0.0, at_rest);
  held_.swap(now_held);
  held_turns_.swap(now_held_turns);
  adopt(*model_, now_.points);
  setContactRate(kContactRate * 2.0 / (std::isfinite(stable) ? stable : params_.integrator.time_step));
}

// After a change of the stiffness. Points held up by tools stay held up.
void Dynamics::findContactRateAgain() {
  const std::vector<ContactLoad::Body> bodies = loads_.contact.all();
  loads_.contact.setTools({});
  loads_.choose();
  now_.contact_rate = 0.0;
  if (hasContact(tools_)) findContactRate();
  loads_.contact.restore(bodies);
  loads_.choose();
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

}  // namespace deformable_surface::simulation
