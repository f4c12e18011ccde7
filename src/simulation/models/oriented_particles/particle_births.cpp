// Particles that are added in a run, one look after the other, where the surface has room for them.
#include "particle_life.h"

#include "deformable_surface/base/interrupt.h"
#include "deformable_surface/base/notice.h"
#include "deformable_surface/cloud/kd_tree.h"
#include "deformable_surface/model/oriented_particles/rest_shape.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

namespace deformable_surface::simulation {
namespace {

using model::State;

constexpr Index kMostDebris = 4;  // pieces of newborns alone: a few may have been cut off by tools
constexpr Index kLook = 1024;     // particles between two looks at an interrupt

// An edge grows where the kinetic energy of a particle's motion against the mean of its neighbours is below this share of the
// depth of its bonds: the rules are for surfaces near equilibrium. Chosen on two spherical caps of 456 and 235 particles, one of
// them displaced by 0.1 spacings: without it they threw off up to eight pieces, with it none.
constexpr double kQuiet = 0.01;

// What would be born inside a solid tool is born on it: contact would throw it off the surface. What lies deeper than half a
// spacing is no place of the surface.
void placeOnTools(double time, const std::vector<tool::ToolParams>& tools, double spacing,
                  std::vector<model::NewParticle>& newborn) {
  constexpr double kDeepest = 0.5;  // spacings
  for (const tool::ToolParams& tool : tools) {
    if (tool.mode != tool::Mode::kSolid || !tool::isActive(tool, time)) continue;
    const tool::Pose pose = tool::interpolate(tool.path, time);
    const auto isDeep = [&](model::NewParticle& particle) {
      const geometry::SignedDistance d = tool::findSignedDistance(tool.shape, pose, particle.position);
      if (!(d.distance < 0.0)) return false;
      particle.position -= d.distance * d.normal;
      return d.distance < -kDeepest * spacing;
    };
    newborn.erase(std::remove_if(newborn.begin(), newborn.end(), isDeep), newborn.end());
  }
}

// What would be born between two sheets that face opposite ways, as in a tube, is no place of either: it plugs the tube, and its
// repulsion throws particles through the walls.
void leaveOutBetween(const State& state, const cloud::KdTree& tree, double distance, std::vector<model::NewParticle>& newborn) {
  std::vector<cloud::Neighbor> near;
  const auto isBetween = [&](const model::NewParticle& particle) {
    const Vec3 normal = particle.orientation * Vec3::UnitZ();
    tree.withinRadius(particle.position, distance, near);
    return std::any_of(near.begin(), near.end(),
                       [&](const cloud::Neighbor& q) { return normal.dot(state.orientations[q.index] * Vec3::UnitZ()) < 0.0; });
  };
  newborn.erase(std::remove_if(newborn.begin(), newborn.end(), isBetween), newborn.end());
}

}  // namespace

model::GrowthParams ParticleLife::growthParams() const {
  model::GrowthParams growth = model_.params().growth;
  growth.chain = model_.params().mode == model::ParticleMode::kPlane;
  return growth;
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

// New particles take part in the cuts of their parents.
void ParticleLife::followBirths(const State& state, Index first, const std::vector<model::NewParticle>& born) {
  if (model_.cuts().isEmpty() || born.empty()) return;
  std::vector<model::ParticleCuts::Pair> parents;
  for (const model::NewParticle& particle : born) parents.emplace_back(particle.parents[0], particle.parents[1]);
  model_.setCuts(model_.cuts().inherit(state.positions, state.traits, first, parents, model_.cutLengths()));
}

// Number of connected pieces that consist of grown particles only.
Index ParticleLife::countDebris(const State& state, const cloud::KdTree& tree) const {
  const Index n = state.size();
  const double range = model_.params().growth.neighbor_range * model_.lattice().spacing;
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

// The particles that hardly move against their neighbours.
std::vector<Index> ParticleLife::findQuiet(const State& state, const cloud::KdTree& tree) const {
  if (model_.masses().empty()) return {};  // edits have filled an empty surface in this step
  const double range = model_.params().growth.neighbor_range * model_.lattice().spacing;
  const double most = 2.0 * kQuiet * model_.lattice().pair.depth / model_.masses().front();  // m^2/s^2
  std::vector<Index> quiet;
  std::vector<cloud::Neighbor> near;
  for (Index i = 0; i < state.size(); ++i) {
    endIfInterrupted(i, kLook);
    tree.withinRadius(state.positions[i], range, near);
    Vec3 mean = Vec3::Zero();  // of it and its neighbours
    for (const cloud::Neighbor& q : near) mean += state.velocities[q.index];
    mean /= static_cast<double>(near.size());
    if ((state.velocities[i] - mean).squaredNorm() <= most) quiet.push_back(i);
  }
  return quiet;
}

// New particles, alone or two together, that neither bonds nor growth reach any more. While more pieces than a few have come off,
// growth pauses, and they stay for the user to see.
void ParticleLife::markLoose(const State& state) {
  const double far = std::max(model_.params().growth.max_gap * model_.lattice().spacing, model_.lattice().pair.cutoff);
  const auto isNewborn = [&](Index i) { return state.traits[i].parents[0] != model::kNoParent; };
  constexpr Index kPair = 2, kNext = 3;
  std::optional<cloud::KdTree> tree;
  std::vector<cloud::Neighbor> near;
  const auto isOut = [&](std::size_t k) { return k >= near.size() || !(near[k].squared_distance <= far * far); };
  for (Index i = 0; i < state.size(); ++i) {
    if (!isNewborn(i)) continue;
    endIfInterrupted(i, kLook);
    if (!tree) tree.emplace(state.positions);
    tree->nearest(state.positions[i], kNext, near);
    if (!isOut(kPair)) continue;
    bool is_loose = isOut(1);
    if (!is_loose && isNewborn(near[1].index)) {
      tree->nearest(state.positions[near[1].index], kNext, near);
      is_loose = isOut(kPair);
    }
    if (is_loose) is_gone_[i] = 1;
  }
}

void ParticleLife::grow(double time, const std::vector<tool::ToolParams>& tools, State& state, Population& changes) {
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
  std::optional<cloud::KdTree> made;
  const auto tree = [&]() -> const cloud::KdTree& {
    if (!made) made.emplace(state.positions);
    return *made;
  };
  // Rules take turns: one whose places are all taken does not keep the next from its own.
  const auto found = [&](double clearance, std::vector<model::NewParticle> proposed) {
    placeOnTools(time, tools, spacing, proposed);
    model::leaveOutCrowded(state.positions, clearance * spacing, proposed);
    if (!growth.chain && !proposed.empty()) leaveOutBetween(state, tree(), growth.neighbor_range * spacing, proposed);
    newborn = std::move(proposed);
    return !newborn.empty();
  };
  const auto findRoom = [&] {
    if (params.stretching &&
        found(growth.clearance, model::proposeStretched(state.positions, state.orientations, flags, spacing, growth, {}, apart)))
      return;
    if (params.growing == model::Growing::kNone) return;
    std::vector<char> growing = flags;
    if (params.growing == model::Growing::kEdges)
      for (const Index i : findQuiet(state, tree()))
        if (growing[i]) growing[i] = static_cast<char>(growing[i] | model::kExtendsEdge);
    // The surroundings must agree: else, beside edges that tools have brought together, new particles would stand across the
    // surface and others grow on them, until layers fill the inside.
    model::GrowthParams witnessed = growth;
    witnessed.witnessed = true;
    if (params.growing == model::Growing::kEdges)
      witnessed.clearance = std::max(growth.clearance, model::findLeastDistance(model_.lattice().pair) / spacing);
    found(witnessed.clearance, model::proposeGrown(state.positions, state.orientations, growing, spacing, witnessed, {}, apart));
  };
  findRoom();
  if (newborn.empty()) return;
  if (const Index debris = countDebris(state, tree()); debris > kMostDebris) {
    if (!std::exchange(has_reported_debris_, true))
      appendNotice(changes.notice, "growth is out of control and pauses: " + std::to_string(debris) +
                                       " pieces of new particles have come off the surface; it goes on at " +
                                       std::to_string(kMostDebris) + " or fewer");
    return;
  }
  const Index first = state.size();
  newborn.resize(std::min<std::size_t>(newborn.size(), growth.max_particles - first));
  for (const model::NewParticle& particle : newborn) append(particle, state);
  changes.born += static_cast<Index>(newborn.size());
  followBirths(state, first, newborn);
  if (state.size() >= growth.max_particles)
    appendNotice(changes.notice,
                 "growth has reached oriented_particles.growth.max_particles, " + std::to_string(growth.max_particles));
}

}  // namespace deformable_surface::simulation
