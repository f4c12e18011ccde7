#include "particle_life.h"

#include "deformable_surface/base/interrupt.h"
#include "deformable_surface/base/notice.h"
#include "deformable_surface/base/step_time.h"
#include "deformable_surface/base/value.h"
#include "deformable_surface/model/oriented_particles/sheet_joint.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "../../rest_parts.h"
#include "../../tool_reach.h"
#include "particle_guide.h"
#include "thin_blade.h"

namespace deformable_surface::simulation {
namespace {

using model::State;
using tool::Mode;
using tool::ToolParams;

constexpr double kHeap = 1.5;  // times the bonds of a lattice: draped and torn sheets stay near 1, heaps have 2 and more
// Spacings: sheets are joined before they are in reach of bonds, which bend them and push them apart. With 0.4 for 0.2 the torus
// of particles_torus was less round (0.21 in place of 0.17 spacings).
constexpr double kBeyondBonds = 0.2;
// In sqrt(D / E h): stiffer sheets are joined from farther away, by a tube that is bent less sharply. Chosen on particles_handle,
// where this is 5.2 spacings; from the reach of bonds, 2.8, its tube had holes. In particles_torus the reach of bonds is more.
constexpr double kStiffTube = 4.0;
constexpr double kFar = 2.0;   // times that distance: tools that stop farther apart are not meant to join sheets
constexpr double kFlat = 0.7;  // cosine between a particle's normal and that of a tool
// Angle between neighbours, seen from a particle: in a lattice, and at a missing particle, it is at most 120 degrees; at a
// straight edge 180.
constexpr double kOpen = 140.0 / 180.0 * kPi;
constexpr Index kLook = 1024;  // particles between two looks at an interrupt

// A knife with a temperature weakens bonds [Szeliski 1991, sec. 6]; one without cuts them.
bool isHotKnife(const ToolParams& tool) { return tool.mode == Mode::kCut && tool.strength > 0.0; }
bool isKnife(const ToolParams& tool, double time) {
  return tool.mode == Mode::kCut && !isHotKnife(tool) && tool::isActive(tool, time);
}

// Distance of a point from a tool, m; negative inside.
double distanceTo(const ToolParams& tool, const tool::Pose& pose, const Vec3& point) {
  return tool::findSignedDistance(tool.shape, pose, point).distance;
}

// sqrt(D / E h), m.
double findStiffLength(const model::MaterialParams& material) {
  return std::sqrt(material.bendingRigidity() / (material.young_modulus * material.thickness));
}

// Whether any two of the chosen tools come nearer to each other.
bool doAnyApproach(double time, const std::vector<ToolParams>& tools, const std::vector<char>& is_chosen) {
  for (std::size_t a = 0; a < tools.size(); ++a)
    for (std::size_t b = a + 1; b < tools.size(); ++b) {
      if (!is_chosen[a] || !is_chosen[b]) continue;
      const Vec3 line = tool::interpolate(tools[b].path, time).position - tool::interpolate(tools[a].path, time).position;
      const Vec3 velocity = tool::findMotion(tools[b].path, time).velocity - tool::findMotion(tools[a].path, time).velocity;
      if (velocity.dot(line) < 0.0) return true;
    }
  return false;
}

}  // namespace

// Cooling over the step, then particles that tools heat: they hold their temperature.
void ParticleLife::heat(double time, double step, const std::vector<ToolParams>& tools, State& state) const {
  for (model::ParticleTraits& particle : state.traits)
    if (particle.temperature > 0.0) particle.temperature = model_.coolDown(particle.temperature, step);
  for (const ToolParams& tool : tools) {
    if (!tool::isActive(tool, time) || (tool.mode != Mode::kHeat && !isHotKnife(tool))) continue;
    const tool::Pose pose = tool::interpolate(tool.path, time);
    const double reach =
        tool.mode == Mode::kCut ? 0.5 * model_.lattice().spacing : 0.0;  // half a spacing: the particle as a disc
    for (Index i = 0; i < state.size(); ++i) {
      endIfInterrupted(i, kLook);
      if (distanceTo(tool, pose, state.positions[i]) <= reach)
        state.traits[i].temperature = std::max(state.traits[i].temperature, tool.strength);
    }
  }
}

void ParticleLife::remove(double time, bool looks, const std::vector<ToolParams>& tools, State& state, Population& changes) {
  is_gone_.assign(state.positions.size(), 0);
  inside_.assign(state.positions.size(), 0);
  for (const ToolParams& tool : tools) {
    const bool solid = model_.params().delete_trapped && (tool.mode == Mode::kSolid || isHotKnife(tool));
    if (!tool::isActive(tool, time) || !(solid || tool.mode == Mode::kErase)) continue;
    const tool::Pose pose = tool::interpolate(tool.path, time);
    for (Index i = 0; i < state.size(); ++i) {
      endIfInterrupted(i, kLook);
      // A solid tool keeps particles at its surface: a disc that overlaps it is in contact.
      const double reach = solid ? 0.5 * model_.lattice().spacing : 0.0;
      const geometry::SignedDistance to_tool = tool::findSignedDistance(tool.shape, pose, state.positions[i]);
      if (to_tool.distance > reach) continue;
      // A surface that lies across the line between two tools is not trapped: they push it out.
      const bool lies_flat = std::abs(to_tool.normal.dot(state.orientations[i] * Vec3::UnitZ())) > kFlat;
      is_gone_[i] = is_gone_[i] || !solid || (inside_[i] && lies_flat);
      inside_[i] = inside_[i] || solid;
    }
  }
  if (looks && scene_.oriented_particles.guide.grid) markMeeting(state);
  if (looks) markLoose(state);
  std::vector<model::NewParticle> tube;
  if (looks && mayJoin(state)) tube = join(time, tools, state, changes);
  if (std::count(is_gone_.begin(), is_gone_.end(), 1) == 0) return;
  takeOut(is_gone_, state, changes);
  const Index first = state.size();
  for (model::NewParticle& particle : tube) {
    for (Index& parent : particle.parents) parent = changes.new_index[parent];
    append(particle, state);
  }
  changes.born += static_cast<Index>(tube.size());
  followBirths(state, first, tube);
}

// Where tubes are made growth must close what is wide between them and the rims.
bool ParticleLife::mayJoin(const State& state) const {
  const model::OrientedParticlesParams& params = model_.params();
  const bool grows = params.stretching || params.growing != model::Growing::kNone;
  return params.delete_trapped && grows && params.mode == model::ParticleMode::kSpace &&
         state.size() < params.growth.max_particles;
}

// Two sheets that two tools press towards each other: solid ones, and hands with what they hold.
std::vector<model::NewParticle> ParticleLife::join(double time, const std::vector<ToolParams>& tools, const State& state,
                                                   Population& changes) {
  constexpr Index kNone = -1;
  constexpr int kKinds = 2;  // a hand reaches beyond the sheet that it holds, to the one that it is pressed on
  const double spacing = model_.lattice().spacing;
  std::vector<Index> candidates;
  std::vector<std::array<Index, kKinds>> pressed_by(state.positions.size(), {kNone, kNone});
  // A disc that overlaps a solid tool touches it.
  std::vector<std::array<double, kKinds>> nearest(state.positions.size(), {0.5 * spacing, 0.0});
  for (std::size_t t = 0; t < tools.size(); ++t) {
    const bool is_hand = tools[t].mode == Mode::kMove;
    if (!tool::isActive(tools[t], time) || !(is_hand || tools[t].mode == Mode::kSolid)) continue;
    const tool::Pose pose = tool::interpolate(tools[t].path, time);
    for (Index i = 0; i < state.size(); ++i) {
      endIfInterrupted(i, kLook);
      const double distance = distanceTo(tools[t], pose, state.positions[i]);
      if (!(distance < nearest[i][is_hand])) continue;
      nearest[i][is_hand] = distance;
      pressed_by[i][is_hand] = static_cast<Index>(t);
    }
  }
  std::vector<char> is_pressing(tools.size(), 0);
  for (Index i = 0; i < state.size(); ++i) {
    if (pressed_by[i][0] != kNone || pressed_by[i][1] != kNone) candidates.push_back(i);
    for (const Index t : pressed_by[i])
      if (t != kNone) is_pressing[t] = 1;
  }
  const auto arePressedByTwo = [&](Index i, Index j) {
    for (const Index a : pressed_by[i])
      for (const Index b : pressed_by[j])
        if (a != kNone && b != kNone && a != b) return true;
    return false;
  };
  const model::OrientedParticlesParams& params = model_.params();
  const double reach = params.cutoff * model_.lattice().pair.distance;
  // Stiff sheets are joined from afar once the tools stop: those that go on would crush the tube.
  const double near = reach + kBeyondBonds * spacing;
  const bool waits = doAnyApproach(time, tools, is_pressing);
  const double meeting = waits ? near : std::max(near, kStiffTube * findStiffLength(scene_.material));
  const auto joinWithin = [&](double distance) {
    return model::joinSheets(state.positions, state.orientations, is_gone_, spacing, reach, distance, near, candidates,
                             arePressedByTwo);
  };
  std::optional<model::SheetJoint> joint = joinWithin(meeting);
  if (!joint && !waits && !has_reported_gap_) {
    if (const std::optional<model::SheetJoint> far = joinWithin(kFar * meeting)) {
      has_reported_gap_ = true;
      appendNotice(changes.notice, "tools that press two sheets towards each other stop " + formatShort(far->apart) +
                                       " m apart; sheets are joined from " + formatShort(meeting) + " m on");
    }
  }
  if (!joint || state.positions.size() + joint->tube.size() > static_cast<std::size_t>(params.growth.max_particles)) return {};
  is_gone_ = std::move(joint->is_gone);
  appendNotice(changes.notice,
               "two sheets that tools press towards each other are joined at " + formatPlace(joint->middle) + " m");
  return std::move(joint->tube);
}

void ParticleLife::takeOut(const std::vector<char>& is_gone, State& state, Population& changes) {
  Index kept = 0;
  for (const char gone : is_gone) changes.new_index.push_back(gone ? -1 : kept++);
  keepThose(changes.new_index, state.positions);
  keepThose(changes.new_index, state.velocities);
  keepThose(changes.new_index, state.orientations);
  keepThose(changes.new_index, state.spins);
  keepThose(changes.new_index, state.traits);
}

Population ParticleLife::begin(const std::vector<char>& pinned, const std::vector<char>& pinned_turns, State& state) {
  has_reported_debris_ = has_reported_heap_ = has_reported_gap_ = false;
  piercing_.reset();
  torn_.clear();
  model_.setSpacing(model_.statedSpacing());  // undoes the change by growing a surface
  for (Index i = 0; i < state.size(); ++i) state.traits[i].is_smooth = !creased_[i];
  const model::OrientedParticlesParams& params = scene_.oriented_particles;
  has_arrived_ = false;
  const bool is_guided = params.guide.grid || !params.guide.volume.empty();
  if (is_guided) requireSeed(params.guide, state);
  Population begun = params.grow_surface ? growSurface(params.growth, pinned, pinned_turns, true, state) : Population();
  if (is_guided && reachesBorder(params.guide))
    appendNotice(begun.notice, "the iso-surface of oriented_particles.guide reaches the border of its volume, which closes it");
  return begun;
}

Evolution::Change ParticleLife::beforeStep(double time, double step, const std::vector<ToolParams>& tools, State& state) {
  Change change;
  heat(time, step, tools, state);
  model_.turnAxes(step, state);
  const bool has_flowed = model_.flow(state);
  // Heat and plastic flow change the energy of bonds.
  is_hot_ = std::any_of(state.traits.begin(), state.traits.end(),
                        [](const model::ParticleTraits& particle) { return particle.temperature > 0.0; }) ||
            has_flowed;
  change.has_energy = is_hot_;
  const double interval = scene_.oriented_particles.growth_interval;
  const bool looks =
      std::floor((time + kTimeRounding * step) / interval) > std::floor((time - (1.0 - kTimeRounding) * step) / interval);
  remove(time, looks, tools, state, change.population);
  if (looks) grow(time, tools, state, change.population);
  if (looks && change.population.born == 0) reportArrival(state, change.population);
  if (looks) reportPiercing(time, tools, state, change.population);
  if (!torn_.empty()) appendNotice(change.population.notice, std::exchange(torn_, {}));
  if (looks && !has_reported_heap_) {
    const double bonds = model_.meanBonds(state), in_lattice = model_.latticeBonds();
    has_reported_heap_ = bonds > kHeap * in_lattice;
    if (has_reported_heap_)
      appendNotice(change.population.notice, "particles pile up: found " + formatShort(bonds) +
                                                 " bonds each (mean), a flat surface has " + formatShort(in_lattice) +
                                                 "; a step costs accordingly (material.bending_rigidity keeps a surface flat)");
  }
  return change;
}

// Of free bonds: how wide a tool must be follows from the tension that they carry.
void ParticleLife::reportPiercing(double time, const std::vector<ToolParams>& tools, const State& state, Population& changes) {
  const model::OrientedParticlesParams& params = model_.params();
  if (model_.hasKeptBonds() || params.mode != model::ParticleMode::kSpace) return;
  const double spacing = model_.lattice().spacing;
  const auto keepOpen = [&](std::vector<char>& is_open) { model_.keepOpen(state, kOpen, is_open); };
  for (const PiercingWatch::Found& found : piercing_.look(time, tools, state, spacing, keepOpen)) {
    const double least = findLeastWidth(spacing, findStiffLength(scene_.material)), width = findWidth(found.tool->shape);
    std::string sentence = "tool " + quote(found.tool->id) + ", " + formatShort(width) + " m wide, has " +
                           (found.is_through ? "gone through the surface" : "torn the surface open");
    if (found.is_first)
      sentence += width < least ? "; a deep dent holds tools that are at least " + formatShort(least) +
                                      " m wide: four spacings, and 16 sqrt(D / E h) (a larger tool, more particles or a smaller "
                                      "material.bending_rigidity)"
                                : "; it was pushed harder than bonds hold (a slower tool, or less material.damping)";
    appendNotice(changes.notice, sentence);
  }
}

// Kept bonds that the last step has broken beside a solid tool, apart from those that have melted.
void ParticleLife::noteTorn(double time, const std::vector<ToolParams>& tools, const State& state) {
  const std::shared_ptr<const model::ParticleCuts::Pairs> before = begun_with_.severed(), after = model_.cuts().severed();
  std::vector<Index> index_of_id(state.next_id, 0);
  for (Index i = 0; i < state.size(); ++i) index_of_id[state.traits[i].id] = i;
  Points broken;
  for (const model::ParticleCuts::Pair& pair : *after) {
    if (before && std::binary_search(before->begin(), before->end(), pair)) continue;
    const Index i = index_of_id[pair.first], j = index_of_id[pair.second];
    if (std::max(state.traits[i].temperature, state.traits[j].temperature) >= model_.params().melting) continue;
    broken.push_back(state.positions[i]);
    broken.push_back(state.positions[j]);
  }
  for (const ToolParams* tool : piercing_.lookAtBroken(time, tools, broken, model_.lattice().spacing))
    appendNotice(torn_, "tool " + quote(tool->id) + ", " + formatShort(findWidth(tool->shape)) +
                            " m wide, has torn the surface open: kept bonds beside it have broken (a wider tool, or a slower or "
                            "shallower push)");
}

void ParticleLife::hold(State& state, std::vector<char>& held, std::vector<char>& held_turns) const {
  const double cold = scene_.oriented_particles.freeze_below;
  if (!(cold > 0.0)) return;
  for (Index i = 0; i < state.size(); ++i) {
    if (state.traits[i].temperature >= cold) continue;
    held[i] = held_turns[i] = 1;
    state.velocities[i].setZero();
    state.spins[i].setZero();
  }
}

bool ParticleLife::maySleep() const {
  const model::OrientedParticlesParams& params = scene_.oriented_particles;
  if (params.axis_alignment_rate > 0.0) return false;  // axes turn even in particles at rest
  return !is_hot_ && !params.stretching && params.growing == model::Growing::kNone;
}

bool ParticleLife::maySleepInParts() const {
  const model::OrientedParticlesParams& params = scene_.oriented_particles;
  return !(params.yield_curvature > 0.0) && !(params.freeze_below > 0.0);
}

std::shared_ptr<const Evolution::Memory> ParticleLife::memory() const {
  const double now = model_.lattice().spacing;
  if (!kept_ || kept_->spacing != now || !kept_->cuts.isSameAs(model_.cuts())) {
    auto kept = std::make_shared<Kept>();
    kept->spacing = now;
    kept->cuts = model_.cuts();
    kept_ = std::move(kept);
  }
  return kept_;
}

void ParticleLife::setMemory(const std::shared_ptr<const Memory>& saved) {
  const Kept& kept = static_cast<const Kept&>(*saved);
  if (model_.lattice().spacing != kept.spacing) model_.setSpacing(kept.spacing);
  model_.setCuts(kept.cuts);
}

bool ParticleLife::isPushedBy(const ToolParams& tool) const { return tool.mode != Mode::kCut || isHotKnife(tool); }

void ParticleLife::beginStep(double time, const std::vector<ToolParams>& tools, const Points& positions) {
  begun_with_ = model_.cuts();
  before_.clear();
  if (std::any_of(tools.begin(), tools.end(), [&](const ToolParams& tool) { return isKnife(tool, time); })) before_ = positions;
}

bool ParticleLife::isAnyStretched(const model::DeformableModel& model, const State& state) const {
  return static_cast<const model::OrientedParticles&>(model).isAnyStretched(state);
}

std::optional<double> ParticleLife::breakStretched(const State& state) {
  if (!model_.isAnyStretched(state)) return {};
  const double before = model_.elasticEnergy(state);
  model_.setCuts(model_.cuts().sever(model_.findBroken(state)));
  return before - model_.elasticEnergy(state);
}

Evolution::AfterStep ParticleLife::endStep(double time, double step, const std::vector<ToolParams>& tools, State& state,
                                           CutFollower*) {
  AfterStep after;
  if (model_.hasKeptBonds())
    model_.setCuts(model_.cuts().sever(model_.findBroken(state)));  // those that have melted, too
  else
    model_.setCuts(model_.followCuts(state));
  after.has_flowed = !model_.cuts().isSameAs(begun_with_);
  if (after.has_flowed && model_.hasKeptBonds()) noteTorn(time + step, tools, state);
  after.leaves_copies = after.has_flowed || is_hot_;
  after.has_cut = !before_.empty() && cut(time, step, tools, state);
  return after;
}

bool ParticleLife::cut(double time, double step, const std::vector<ToolParams>& tools, const State& state) {
  bool has_cut = false;
  const model::ParticleCuts::Lengths lengths = model_.cutLengths();
  const double spacing = model_.lattice().spacing;
  for (const ToolParams& tool : tools) {
    if (!isKnife(tool, time)) continue;
    for (const ThinBlade& thin :
         findBlades(tool, time, step, before_, state.positions, state.orientations, lengths.sight, spacing)) {
      const double resolution = tool::findBladeResolution(thin.tool, thin.begin, thin.step, thin.before, thin.after, spacing);
      const tool::BladeSweep blade(thin.tool, thin.begin, thin.step, thin.before, thin.after, lengths.sight, resolution);
      if (!blade.isNear()) continue;
      std::vector<Index> near;
      for (Index i = 0; i < state.size(); ++i)
        if (blade.isNear(thin.before[i])) near.push_back(i);
      const auto wentBetween = [&](Index i, Index j) {
        return blade.wentBetween(thin.before[i], thin.after[i], thin.before[j], thin.after[j], blade.all());
      };
      const auto isNear = [&](Index i) { return std::binary_search(near.begin(), near.end(), i); };
      const model::ParticleCuts before = model_.cuts();
      if (model_.hasKeptBonds())
        model_.setCuts(before.sever(
            model_.findCrossed(state, [&](Index i, Index j) { return isNear(i) && isNear(j) && wentBetween(i, j); })));
      else
        model_.setCuts(before.cut(thin.before, state.traits, near, lengths, wentBetween));
      has_cut = has_cut || !model_.cuts().isSameAs(before);
    }
  }
  return has_cut;
}

}  // namespace deformable_surface::simulation
