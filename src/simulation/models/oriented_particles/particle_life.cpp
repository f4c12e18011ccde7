#include "particle_life.h"

#include "deformable_surface/base/error.h"
#include "deformable_surface/base/interrupt.h"
#include "deformable_surface/base/value.h"
#include "deformable_surface/cloud/kd_tree.h"
#include "deformable_surface/model/oriented_particles/grow_surface.h"
#include "deformable_surface/model/oriented_particles/relax_on_surface.h"
#include "deformable_surface/model/oriented_particles/rest_shape.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "settle_particles.h"
#include "thin_blade.h"

namespace deformable_surface::simulation {
namespace {

using model::State;
using tool::Mode;
using tool::ToolParams;

constexpr Index kSweeps = 20;     // between two passes of growth: near equilibrium is enough
constexpr Index kSmoothings = 4;  // of rest curvatures if samples are noisy: about the distance between samples
// Of the spacing: the growth rules leave a looser arrangement than a lattice, which would contract when released.
constexpr double kDensity = 0.95;
constexpr Index kLastIterations = 40;    // the same when growth has ended
constexpr double kLastTolerance = 1e-4;  // of its first force

constexpr Index kMostDebris = 4;  // pieces of newborns alone: a few may have been cut off by tools
constexpr double kHeap = 1.5;     // times the bonds of a lattice: draped and torn sheets stay near 1, heaps have 2 and more
constexpr double kClosest = 0.3;  // of the spacing: as near as particles may be after growth, as after an edit
constexpr Index kLook = 1024;     // particles between two looks at an interrupt

// A knife with a temperature weakens bonds [Szeliski 1991, sec. 6]; one without cuts them.
bool isHotKnife(const ToolParams& tool) { return tool.mode == Mode::kCut && tool.strength > 0.0; }
bool isKnife(const ToolParams& tool, double time) {
  return tool.mode == Mode::kCut && !isHotKnife(tool) && tool::isActive(tool, time);
}

// Distance of a point from a tool, m; negative inside.
double distanceTo(const ToolParams& tool, const tool::Pose& pose, const Vec3& point) {
  return tool::findSignedDistance(tool.shape, pose, point).distance;
}

// Growth leaves varying distances, and not the area of as many particles of a lattice. At the stated spacing the whole surface
// would pull, and closed surfaces would contract. Particles slide until they are evenly spaced, and the
// lattice takes the spacing at which they have no tension as a whole.
void takeSpacingOf(const std::vector<char>& fixed, model::OrientedParticles& particles, State& state) {
  cloud::CleanCloud surface;
  surface.positions = state.positions;
  for (const Quaternion& q : state.orientations) surface.normals.push_back(q * Vec3::UnitZ());
  model::OrientedParticles attraction = particles;
  const double even = attraction.measureSpacing(state);
  if (even > 0.0) attraction.setSpacing(even);
  attraction.leaveOnlyAttraction();
  slideParticles(surface, attraction, fixed, fixed, state);
  particles.setSpacing(particles.findSpacingWithoutTension(state));
}

// Tells of particles that are on no triangle. Beside a grown surface, samples there did not tell which way it goes.
template <class Warn>
void warnOfLonely(const model::OrientedParticles& particles, const State& state, const Warn& warn) {
  particles.refreshDisplay(state);
  std::vector<char> is_lonely(state.positions.size(), 1);
  for (const model::WeightedTriangle& t : particles.triangles())
    for (const Index i : t.corner) is_lonely[i] = 0;
  const auto first = std::find(is_lonely.begin(), is_lonely.end(), 1);
  if (first == is_lonely.end()) return;
  const Index count = static_cast<Index>(std::count(is_lonely.begin(), is_lonely.end(), 1));
  const Vec3& at = state.positions[first - is_lonely.begin()];
  warn(std::to_string(count) + (count == 1 ? " particle belongs" : " particles belong") + " to no surface, the first at " +
       formatShort(at.x()) + ", " + formatShort(at.y()) + ", " + formatShort(at.z()));
}

// Moves particles nearer to each other than a distance, m, apart to it along the line between them, those in one place along the
// x axis of the first. Growth and relaxation on both sides of something thin can bring two into nearly one place, where repulsion
// does not part them. fixed (n) stay. One after the other, in the order of their numbers. Returns the number of pairs that are
// still nearer.
Index moveApart(double least, const std::vector<char>& fixed, State& state) {
  constexpr Index kPasses = 50;
  constexpr double kBeyond = 1e-6;  // of the distance: rounding must not undo it
  Index near_pairs = 0;
  std::vector<cloud::Neighbor> near;
  for (Index pass = 0; pass <= kPasses; ++pass) {
    endIfInterrupted();
    near_pairs = 0;
    const cloud::KdTree tree(state.positions);
    for (Index i = 0; i < state.size(); ++i) {
      tree.withinRadius(state.positions[i], least, near);
      std::sort(near.begin(), near.end(), [](const auto& a, const auto& b) { return a.index < b.index; });
      for (const cloud::Neighbor& q : near) {
        const Index j = q.index;
        if (j <= i) continue;
        Vec3 line = state.positions[j] - state.positions[i];
        const double distance = line.norm();
        if (!(distance < least)) continue;
        ++near_pairs;
        if (pass == kPasses || (fixed[i] && fixed[j])) continue;
        line = distance > 0.0 ? Vec3(line / distance) : Vec3(state.orientations[i] * Vec3::UnitX());
        const double missing = (1.0 + kBeyond) * least - distance;
        const double share = fixed[i] ? 0.0 : fixed[j] ? 1.0 : 0.5;  // of particle i
        state.positions[i] -= share * missing * line;
        state.positions[j] += (1.0 - share) * missing * line;
      }
    }
    if (near_pairs == 0) break;
  }
  return near_pairs;
}

// Refuses a volume that has not been read, and a seed of which more is outside of the iso-surface than inside.
void requireSeed(const model::GuideParams& guide, const State& state) {
  if (!guide.grid)
    throw InputError("oriented_particles.guide.volume: found one that has not been read; accepted: a grid of values");
  Index inside = 0;
  for (const Vec3& p : state.positions) inside += guide.distance(p) > 0.0;
  if (2 * inside < state.size())
    throw InputError(
        "oriented_particles.guide: found " + std::to_string(inside) + " of " + std::to_string(state.size()) +
        " particles inside of the iso-surface; accepted: half of them or more (guide.inside states which side it is)");
}

// Whether the inside of the iso-surface reaches the border of the grid.
bool reachesBorder(const model::GuideParams& guide) {
  const double side = guide.inside == model::GuideInside::kAbove ? 1.0 : -1.0;
  const std::array<Index, 3>& size = guide.grid->size();
  std::size_t at = 0;
  for (Index k = 0; k < size[2]; ++k)
    for (Index j = 0; j < size[1]; ++j)
      for (Index i = 0; i < size[0]; ++i, ++at) {
        const bool is_border = i == 0 || j == 0 || k == 0 || i + 1 == size[0] || j + 1 == size[1] || k + 1 == size[2];
        if (is_border && side * (guide.grid->values()[at] - guide.iso_value) > 0.0) return true;
      }
  return false;
}

}  // namespace

model::GrowthParams ParticleLife::growthParams() const {
  model::GrowthParams growth = model_.params().growth;
  growth.chain = model_.params().mode == model::ParticleMode::kPlane;
  return growth;
}

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

void ParticleLife::remove(double time, bool looks, const std::vector<ToolParams>& tools, State& state,
                          Population& changes) const {
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
      if (distanceTo(tool, pose, state.positions[i]) > reach) continue;
      is_gone_[i] = is_gone_[i] || !solid || inside_[i];
      inside_[i] = solid;
    }
  }
  if (looks && scene_.oriented_particles.guide.grid) markMeeting(state);
  if (std::count(is_gone_.begin(), is_gone_.end(), 1) == 0) return;
  takeOut(is_gone_, state, changes);
}

// Where two fronts of the surface meet inside of the iso-surface that guides it, both go. Their rims then join, and the surface
// has a handle more.
void ParticleLife::markMeeting(const State& state) const {
  constexpr double kMeeting = 2.0;  // spacings: in reach of bonds, which hold fronts apart
  constexpr double kFacing = -0.5;  // cosine between normals
  constexpr double kAhead = 0.7;    // cosine between a normal and the line to the other
  const cloud::KdTree tree(state.positions);
  std::vector<cloud::Neighbor> near;
  for (Index i = 0; i < state.size(); ++i) {
    endIfInterrupted(i, kLook);
    const Vec3 normal = state.orientations[i] * Vec3::UnitZ();
    tree.withinRadius(state.positions[i], kMeeting * model_.lattice().spacing, near);
    for (const cloud::Neighbor& q : near) {
      const Vec3 line = state.positions[q.index] - state.positions[i], other = state.orientations[q.index] * Vec3::UnitZ();
      if (!(normal.dot(other) < kFacing && normal.dot(line) > kAhead * line.norm())) continue;
      if (scene_.oriented_particles.guide.distance(state.positions[i] + 0.5 * line) > 0.0) is_gone_[i] = is_gone_[q.index] = 1;
    }
  }
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

// A new particle has the mean velocity, spin, curvature and temperature of its parents.
void ParticleLife::append(const model::NewParticle& particle, State& state) const {
  const Index a = particle.parents[0], b = particle.parents[1] >= 0 ? particle.parents[1] : a;
  model::ParticleTraits traits;
  traits.id = state.next_id++;
  traits.ancestor = state.traits[a].ancestor;
  traits.parents[0] = state.traits[a].id;
  traits.parents[1] = particle.parents[1] >= 0 ? state.traits[b].id : model::kNoParent;
  traits.turn = state.traits[a].turn;
  const auto curvature = [&](Index i) {
    return model::turnCurvatureToWorld(state.orientations[i], state.traits[i].rest_curvature);
  };
  if (model_.isBent())
    traits.rest_curvature = model::turnCurvatureToFrame(particle.orientation, 0.5 * (curvature(a) + curvature(b)));
  traits.temperature = 0.5 * (state.traits[a].temperature + state.traits[b].temperature);
  state.positions.push_back(particle.position);
  state.velocities.push_back(0.5 * (state.velocities[a] + state.velocities[b]));
  state.orientations.push_back(particle.orientation);
  state.spins.push_back(0.5 * (state.spins[a] + state.spins[b]));
  state.traits.push_back(traits);
}

// Number of connected pieces that consist of grown particles only.
Index ParticleLife::countDebris(const State& state) const {
  const Index n = state.size();
  const double range = model_.params().growth.neighbor_range * model_.lattice().spacing;
  const cloud::KdTree tree(state.positions);
  std::vector<char> is_seen(n, 0);
  std::vector<Index> piece;
  std::vector<cloud::Neighbor> near;
  Index debris = 0;
  for (Index first = 0; first < n; ++first) {
    if (is_seen[first]) continue;
    bool is_newborn = true;
    piece.assign(1, first);
    is_seen[first] = 1;
    for (std::size_t k = 0; k < piece.size(); ++k) {
      endIfInterrupted(k, static_cast<std::size_t>(kLook));
      is_newborn = is_newborn && state.traits[piece[k]].parents[0] != model::kNoParent;
      tree.withinRadius(state.positions[piece[k]], range, near);
      for (const cloud::Neighbor& q : near) {
        if (std::exchange(is_seen[q.index], 1)) continue;
        piece.push_back(q.index);
      }
    }
    debris += is_newborn;
  }
  return debris;
}

Population ParticleLife::begin(const std::vector<char>& pinned, State& state) {
  has_reported_debris_ = has_reported_heap_ = false;
  model_.setSpacing(model_.statedSpacing());  // undoes the change by growing a surface
  for (Index i = 0; i < state.size(); ++i) state.traits[i].is_smooth = !creased_[i];
  const model::OrientedParticlesParams& params = scene_.oriented_particles;
  has_arrived_ = false;
  const bool is_guided = params.guide.grid || !params.guide.volume.empty();
  if (is_guided) requireSeed(params.guide, state);
  Population begun = params.grow_surface ? growSurface(params.growth, pinned, true, state) : Population();
  if (is_guided && reachesBorder(params.guide))
    begun.notice += std::string(begun.notice.empty() ? "" : "; ") +
                    "the iso-surface of oriented_particles.guide reaches the border of its volume, which closes it";
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
  const bool looks = std::floor((time + 1e-6 * step) / interval) > std::floor((time - (1.0 - 1e-6) * step) / interval);
  remove(time, looks, tools, state, change.population);
  if (looks) grow(state, change.population);
  if (looks && change.population.born == 0) reportArrival(state, change.population);
  if (looks && !has_reported_heap_) {
    const double bonds = model_.meanBonds(state), in_lattice = model_.latticeBonds();
    has_reported_heap_ = bonds > kHeap * in_lattice;
    if (has_reported_heap_)
      change.population.notice +=
          (change.population.notice.empty() ? "" : "; ") +
          ("particles pile up: found " + formatShort(bonds) + " bonds each (mean), a flat surface has " +
           formatShort(in_lattice) + "; a step costs accordingly (material.bending_rigidity keeps a surface flat)");
  }
  return change;
}

// Once, when the surface lies on the iso-surface that guides it, or hardly moves elsewhere.
void ParticleLife::reportArrival(const State& state, Population& changes) {
  constexpr double kNear = 1.0;   // spacings: what still grows is farther from what is ahead of it
  constexpr double kSlow = 1e-3;  // spacings between two looks: growing surfaces move a hundred times as fast
  const model::GuideParams& guide = scene_.oriented_particles.guide;
  if (has_arrived_ || !guide.grid || state.size() == 0) return;
  const double spacing = model_.lattice().spacing;
  double squares = 0.0, largest = 0.0, fastest = 0.0;
  for (Index i = 0; i < state.size(); ++i) {
    const double d = std::abs(guide.distance(state.positions[i])) / spacing;
    squares += d * d;
    largest = std::max(largest, d);
    fastest = std::max(fastest, state.velocities[i].norm());
  }
  const bool is_near = largest<kNear, has_moved = fastest> 0.0;
  has_arrived_ = is_near || (has_moved && fastest * scene_.oriented_particles.growth_interval < kSlow * spacing);
  if (!has_arrived_) return;
  model_.refreshDisplay(state);
  const model::ParticleTopology found = model::measureTopology(state.size(), model_.triangles());
  changes.notice += (changes.notice.empty() ? "" : "; ") +
                    (is_near ? std::string("the surface has come to the iso-surface: ")
                             : std::string("the surface hardly moves, and not all of it is at the iso-surface: ")) +
                    std::to_string(state.size()) + " particles, " + formatShort(std::sqrt(squares / state.size())) +
                    " spacings from it (rms), " + formatShort(largest) + " at most; components " +
                    std::to_string(found.components) + ", boundary loops " + std::to_string(found.boundary_loops) +
                    ", Euler characteristic " + std::to_string(found.euler_characteristic);
}

void ParticleLife::grow(State& state, Population& changes) {
  const model::OrientedParticlesParams& params = model_.params();
  const bool grows = params.stretching || params.growing != model::Growing::kNone;
  if (!grows || state.size() == 0 || state.size() >= params.growth.max_particles) return;
  const model::GrowthParams growth = growthParams();
  std::vector<model::NewParticle> newborn;
  std::vector<char> flags(state.positions.size(), model::kGrowsNothing);
  for (Index i = 0; i < state.size(); ++i)
    if (state.traits[i].is_smooth) flags[i] = model::kFillsGaps;
  model::AreApart apart;
  if (!model_.cuts().isEmpty())
    apart = [&](Index i, Index j) { return !model_.cuts().mayBind(state.traits[i].id, state.traits[j].id); };
  const double spacing = model_.lattice().spacing;
  // Rules take turns: one whose places are all taken does not keep the next from its own.
  const auto found = [&](std::vector<model::NewParticle> proposed) {
    model::leaveOutCrowded(state.positions, growth.clearance * spacing, proposed);
    newborn = std::move(proposed);
    return !newborn.empty();
  };
  const auto findRoom = [&] {
    if (params.stretching &&
        found(model::proposeStretched(state.positions, state.orientations, flags, spacing, growth, {}, apart)))
      return;
    if (params.growing == model::Growing::kNone) return;
    std::vector<char> growing = flags;
    if (params.growing == model::Growing::kEdges)
      for (char& flag : growing) flag = static_cast<char>(flag | (flag ? model::kExtendsEdge : 0));
    // The surroundings must agree: else, beside edges that tools have brought together, new particles would stand across the
    // surface and others grow on them, until layers fill the inside.
    model::GrowthParams witnessed = growth;
    witnessed.witnessed = true;
    found(model::proposeGrown(state.positions, state.orientations, growing, spacing, witnessed, {}, apart));
  };
  findRoom();
  if (newborn.empty()) return;
  if (const Index debris = countDebris(state); debris > kMostDebris) {
    if (!std::exchange(has_reported_debris_, true))
      changes.notice = "growth has run away and rests: found " + std::to_string(debris) +
                       " pieces of newborn particles alone, which have come loose from the surface; accepted: up to " +
                       std::to_string(kMostDebris);
    return;
  }
  const Index first = state.size();
  newborn.resize(std::min<std::size_t>(newborn.size(), growth.max_particles - first));
  for (const model::NewParticle& particle : newborn) append(particle, state);
  changes.born += static_cast<Index>(newborn.size());
  followBirths(state, first, newborn);
  if (state.size() >= growth.max_particles)
    changes.notice = "growth has reached oriented_particles.growth.max_particles, " + std::to_string(growth.max_particles);
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
  before_.clear();
  if (std::any_of(tools.begin(), tools.end(), [&](const ToolParams& tool) { return isKnife(tool, time); })) before_ = positions;
}

Evolution::AfterStep ParticleLife::endStep(double time, double step, const std::vector<ToolParams>& tools, State& state,
                                           CutFollower*) {
  AfterStep after;
  const model::ParticleCuts before = model_.cuts();
  if (model_.hasKeptBonds())
    model_.setCuts(before.sever(model_.findBroken(state)));
  else
    model_.setCuts(model_.followCuts(state));
  after.has_flowed = !model_.cuts().isSameAs(before);
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
      const model::ParticleCuts before = model_.cuts();
      if (model_.hasKeptBonds()) {
        model_.setCuts(before.sever(model_.findCrossed(state, [&](Index i, Index j) {
          return std::binary_search(near.begin(), near.end(), i) && std::binary_search(near.begin(), near.end(), j) &&
                 blade.wentBetween(thin.before[i], thin.after[i], thin.before[j], thin.after[j], blade.all());
        })));
        has_cut = has_cut || !model_.cuts().isSameAs(before);
        continue;
      }
      model_.setCuts(before.cut(thin.before, state.traits, near, lengths, [&](Index i, Index j) {
        return blade.wentBetween(thin.before[i], thin.after[i], thin.before[j], thin.after[j], blade.all());
      }));
      has_cut = has_cut || !model_.cuts().isSameAs(before);
    }
  }
  return has_cut;
}

// New particles take part in the cuts of their parents.
void ParticleLife::followBirths(const State& state, Index first, const std::vector<model::NewParticle>& born) {
  if (model_.cuts().isEmpty() || born.empty()) return;
  std::vector<model::ParticleCuts::Pair> parents;
  for (const model::NewParticle& particle : born) parents.emplace_back(particle.parents[0], particle.parents[1]);
  model_.setCuts(model_.cuts().inherit(state.positions, state.traits, first, parents, model_.cutLengths()));
}

Population ParticleLife::growSurface(const model::GrowthParams& given, const std::vector<char>& held, bool is_start,
                                     State& state) {
  if (model_.hasKeptBonds())
    throw InputError(
        "grow_surface: found oriented_particles.bonds kept, with which new particles have no rest shape; accepted: free");
  model::GrowthParams growth = given;
  growth.chain = growthParams().chain;
  const bool keeps_shape = model_.params().restsAsCloud(), lets_go = !growth.fix_samples || growth.release_samples;
  const double spacing = kDensity * model_.lattice().spacing;
  const auto relax = [&](Points& positions, Orientations& orientations, const std::vector<char>& still) {
    std::vector<char> fixed = still;
    for (std::size_t i = 0; i < held.size(); ++i) fixed[i] = fixed[i] || held[i];
    model::relaxOnSurface(spacing, kSweeps, fixed, positions, orientations);
  };
  model::ParticleCuts cuts = model_.cuts();
  std::vector<model::ParticleTraits> traits = state.traits;
  model::GrowthCuts growth_cuts;
  if (!cuts.isEmpty()) {
    growth_cuts.apart = [&](Index i, Index j) { return !cuts.mayBind(traits[i].id, traits[j].id); };
    growth_cuts.follow = [&](const Points& positions, Index first, const std::vector<model::NewParticle>& added) {
      std::vector<model::ParticleCuts::Pair> parents;
      for (const model::NewParticle& particle : added) {
        parents.emplace_back(particle.parents[0], particle.parents[1]);
        traits.emplace_back();
        traits.back().id = state.next_id + static_cast<Index>(traits.size() - 1 - state.traits.size());  // as append() numbers
      }
      cuts = cuts.inherit(positions, traits, first, parents, model_.cutLengths());
    };
  }
  const model::GrownSurface grown = model::growSurface(state.positions, state.orientations, spacing, growth, relax, growth_cuts);
  model_.setCuts(cuts);

  Population changes;
  const std::size_t before = state.positions.size();
  for (const model::NewParticle& particle : grown.added) append(particle, state);
  state.positions = grown.positions;
  state.orientations = grown.orientations;
  // A separate dynamics for the particles alone, without loads.
  std::vector<char> fixed = held;
  fixed.resize(state.positions.size(), 0);
  if (!lets_go) std::fill_n(fixed.begin(), before, char{1});
  model::OrientedParticles particles = model_;
  particles.adopt(state);
  State trial = state;
  if (keeps_shape && is_start) {
    takeSpacingOf(fixed, particles, trial);
    model_.setSpacing(particles.lattice().spacing);
  }
  if (keeps_shape) particles.keepShape(trial);
  if (keeps_shape && growth.noise > 0.0) particles.smoothShape(kSmoothings, trial);
  // Existing particles keep their motion and, except at the start, their rest shape: their bending may come from a load.
  for (std::size_t i = 0; !is_start && i < before; ++i) trial.traits[i].rest_curvature = state.traits[i].rest_curvature;
  const double least = kClosest * particles.lattice().spacing;
  moveApart(least, fixed, trial);
  if (keeps_shape && is_start && !(growth.noise > 0.0))
    relaxInShape(particles, fixed, fixed, trial);
  else
    relaxParticles(particles, fixed, fixed, kLastIterations, kLastTolerance, trial);
  const Index near_pairs = moveApart(least, fixed, trial);
  state.positions = trial.positions;
  state.orientations = trial.orientations;
  state.traits = trial.traits;
  changes.born = static_cast<Index>(state.positions.size() - before);
  static const char* const kEnds[] = {"until there was no more room", "until growth.max_passes was reached",
                                      "until another pass would have gone beyond growth.max_particles"};
  changes.notice = "a surface is grown: " + std::to_string(changes.born) + " particles were added to " + std::to_string(before) +
                   " in " + std::to_string(grown.passes) + " passes, " + kEnds[static_cast<int>(grown.end)];
  const auto warn = [&](const std::string& sentence) { changes.warning += (changes.warning.empty() ? "" : "; ") + sentence; };
  if (grown.end == model::GrowthEnd::kMaxPasses)
    warn("growth ended at growth.max_passes, " + std::to_string(growth.max_passes) + ": the surface is not complete");
  if (grown.end == model::GrowthEnd::kMaxParticles)
    warn("growth ended at growth.max_particles, " + std::to_string(growth.max_particles) + ": the surface is not complete");
  if (!growth.chain) warnOfLonely(particles, state, warn);
  if (near_pairs > 0)
    changes.notice +=
        "; " + std::to_string(near_pairs) +
        " pairs of held particles are nearer to each other than 0.3 of the spacing, where repulsion hardly parts them";
  return changes;
}

}  // namespace deformable_surface::simulation
