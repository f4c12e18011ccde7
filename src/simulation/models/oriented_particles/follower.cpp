#include "follower.h"

#include "deformable_surface/cloud/kd_tree.h"

#include <algorithm>
#include <limits>

namespace deformable_surface::simulation {
namespace {

constexpr Index kGone = -1;
const float kNaN = std::numeric_limits<float>::quiet_NaN();

}  // namespace

ParticleFollower::ParticleFollower(const RestSurface& rest, const transfer::TransferParams& transfer,
                                   const model::OrientedParticles& model)
    : rest_(rest), transfer_(transfer), model_(model), is_direct_(rest.points == rest.dense.positions) {}

void ParticleFollower::reset() {
  ids_.clear();
  point_of_id_.clear();
  survivors_.reset();
  severed_.reset();
  beside_cuts_.reset();
}

// A dense point follows those of its particles from which the particle nearest to it can be reached over bonds at rest that no
// knife has cut. A point within half a spacing of the knife's way may therefore go with the other side.
void ParticleFollower::followCuts() {
  if (is_direct_ || severed_ == model_.cuts().severed()) return;
  severed_ = model_.cuts().severed();
  beside_cuts_.reset();
  if (!severed_) return;
  beside_cuts_ = std::make_unique<transfer::Transfer>(survivors_ ? *survivors_ : rest_.transfer);
  const Index first = static_cast<Index>(rest_.points.size());
  std::vector<char> is_cut(first, 0);
  for (const auto& [a, b] : *severed_)
    for (const Index id : {a, b})
      if (id < first) is_cut[id] = 1;
  const double bond = model_.cutLengths().bond;
  std::vector<Index> refit, sources, reached;
  Lists followed;
  for (Index d = 0; d < static_cast<Index>(rest_.dense.positions.size()); ++d) {
    sources = beside_cuts_->sourcesOf(d);
    if (std::none_of(sources.begin(), sources.end(), [&](Index j) { return is_cut[j]; })) continue;
    const Vec3& at = rest_.dense.positions[d];
    std::sort(sources.begin(), sources.end(), [&](Index a, Index b) {
      const double to_a = (rest_.points[a] - at).squaredNorm(), to_b = (rest_.points[b] - at).squaredNorm();
      return to_a != to_b ? to_a < to_b : a < b;
    });
    const auto isReached = [&](Index j) { return std::find(reached.begin(), reached.end(), j) != reached.end(); };
    reached.assign(1, sources.front());
    for (std::size_t k = 0; k < reached.size(); ++k)
      for (const Index j : sources) {
        const bool is_bond = (rest_.points[j] - rest_.points[reached[k]]).norm() < bond;
        if (is_bond && !isReached(j) && !model_.cuts().isSevered(reached[k], j)) reached.push_back(j);
      }
    if (reached.size() == sources.size()) continue;
    refit.push_back(d);
    for (const Index j : sources)
      if (isReached(j)) followed.items.push_back(j);
    followed.offsets.push_back(static_cast<Index>(followed.items.size()));
  }
  beside_cuts_->refit(refit, followed, rest_.dense.normals, transfer_);
}

// Which initial particles are left, and the transfer without the others: a dense point follows the remaining particles
// around it, but is removed with the particle nearest to it.
void ParticleFollower::followPopulation(const model::State& state) {
  const Index first = static_cast<Index>(rest_.points.size());
  bool is_same = ids_.size() == state.traits.size() && static_cast<Index>(point_of_id_.size()) == state.next_id;
  for (std::size_t i = 0; is_same && i < ids_.size(); ++i) is_same = ids_[i] == state.traits[i].id;
  if (!is_same) {
    ids_.clear();
    point_of_id_.assign(state.next_id, kGone);
    for (const model::ParticleTraits& particle : state.traits) {
      point_of_id_[particle.id] = static_cast<Index>(ids_.size());
      ids_.push_back(particle.id);
    }

    std::vector<char> is_left(first);
    for (Index id = 0; id < first; ++id) is_left[id] = point_of_id_[id] != kGone;
    const bool all_left = std::count(is_left.begin(), is_left.end(), 1) == first;
    is_gone_.assign(all_left ? 0 : rest_.dense.positions.size(), 0);
    survivors_.reset();
    if (!all_left && is_direct_) {
      for (std::size_t d = 0; d < is_gone_.size(); ++d) is_gone_[d] = !is_left[d];
    } else if (!all_left) {
      const cloud::KdTree tree(rest_.points);
      std::vector<cloud::Neighbor> nearest;
      for (std::size_t d = 0; d < is_gone_.size(); ++d) {
        tree.nearest(rest_.dense.positions[d], 1, nearest);
        is_gone_[d] = !is_left[nearest.front().index];
      }
      survivors_ =
          std::make_unique<transfer::Transfer>(rest_.dense.positions, rest_.dense.normals, rest_.points, is_left, transfer_);
    }
  }
  if (!is_same) {
    severed_.reset();
    beside_cuts_.reset();
  }
  followCuts();
  first_positions_ = rest_.points;
  for (Index id = 0; id < first; ++id)
    if (point_of_id_[id] != kGone) first_positions_[id] = state.positions[point_of_id_[id]];
}

void ParticleFollower::follow(const model::State& state, Points& dense, std::vector<Eigen::Vector3f>* normals) {
  followPopulation(state);
  if (!is_direct_) {
    const transfer::Transfer& transfer = beside_cuts_ ? *beside_cuts_ : survivors_ ? *survivors_ : rest_.transfer;
    return normals ? transfer.apply(first_positions_, dense, *normals) : transfer.apply(first_positions_, dense);
  }
  dense = first_positions_;
  if (!normals) return;
  normals->assign(dense.size(), Eigen::Vector3f::UnitZ());
  for (std::size_t id = 0; id < dense.size(); ++id)
    if (point_of_id_[id] != kGone) (*normals)[id] = (state.orientations[point_of_id_[id]] * Vec3::UnitZ()).cast<float>();
}

// Added particles, a row each, always in the order of birth. They have no rest position and so no displacement.
void ParticleFollower::append(const model::State& state, const std::vector<Index>& first_input, bool with_normals,
                              Surface& surface) const {
  for (std::size_t id = rest_.points.size(); id < point_of_id_.size(); ++id) {
    const Index i = point_of_id_[id];
    surface.positions.push_back(i == kGone ? Vec3::Constant(kNaN) : state.positions[i]);
    surface.displacement.push_back(kNaN);
    const Index ancestor = i == kGone ? 0 : state.traits[i].ancestor;
    surface.source.push_back(first_input[rest_.dense_index[ancestor]]);
    if (!with_normals) continue;
    const Eigen::Vector3f nowhere = Eigen::Vector3f::Constant(kNaN);
    surface.normals.push_back(i == kGone ? nowhere : Eigen::Vector3f((state.orientations[i] * Vec3::UnitZ()).cast<float>()));
  }
}

}  // namespace deformable_surface::simulation
