#include "deformable_surface/model/oriented_particles/particle_cuts.h"

#include "deformable_surface/base/hash.h"
#include "deformable_surface/base/parallel.h"
#include "deformable_surface/cloud/kd_tree.h"
#include "deformable_surface/model/oriented_particles/neighbor_list.h"

#include <algorithm>
#include <set>
#include <unordered_map>

namespace deformable_surface::model {
namespace {

using Pair = ParticleCuts::Pair;
using Pairs = ParticleCuts::Pairs;

constexpr Index kBlock = 8;  // particles: each tests some dozen pairs against the knife
constexpr Index kGone = -1;

Pair pairOf(Index a, Index b) { return {std::min(a, b), std::max(a, b)}; }

// Pairs that a knife goes between, by number: bonds, and wider pairs with bonds to a third particle.
struct Crossed {
  Pairs bonds, wide;
};

// A particle on the way of a knife may lose its bonds to both sides, or all but one. It then keeps those to one side, the one
// with most particles: no particle is cut off alone. around(i): the particles with bonds to i, ascending.
template <class Around>
void keepWithOneSide(const Around& around, Crossed& crossed) {
  constexpr std::size_t kFewest = 2;  // bonds of a corner of a triangle
  std::set<Pair> bonds(crossed.bonds.begin(), crossed.bonds.end());
  const auto isWhole = [&](Index i, Index j) { return bonds.count(pairOf(i, j)) == 0; };
  std::set<Index> touched;
  for (const auto& [i, j] : crossed.bonds) touched.insert({i, j});
  for (const Index p : touched) {
    const std::vector<Index> partners = around(p);
    std::size_t whole = 0;
    for (const Index q : partners) whole += isWhole(p, q);
    if (whole >= kFewest) continue;
    std::vector<Index> best, side;
    std::set<Index> left(partners.begin(), partners.end());
    while (!left.empty()) {
      side.assign(1, *left.begin());
      left.erase(left.begin());
      for (std::size_t k = 0; k < side.size(); ++k)
        for (const Index q : around(side[k]))
          if (isWhole(side[k], q) && left.erase(q) > 0) side.push_back(q);
      if (side.size() > best.size()) best = side;
    }
    if (best.size() <= whole) continue;
    for (const Index q : partners) bonds.insert(pairOf(p, q));
    for (const Index q : best) bonds.erase(pairOf(p, q));
    // Wider pairs with what it is still beside.
    const auto isBeside = [&](const Pair& pair) {
      if (pair.first != p && pair.second != p) return false;
      const Index other = pair.first == p ? pair.second : pair.first;
      const std::vector<Index> its = around(other);
      return std::any_of(best.begin(), best.end(),
                         [&](Index q) { return std::binary_search(its.begin(), its.end(), q) && isWhole(q, other); });
    };
    crossed.wide.erase(std::remove_if(crossed.wide.begin(), crossed.wide.end(), isBeside), crossed.wide.end());
  }
  crossed.bonds.assign(bonds.begin(), bonds.end());
}

void sortUnique(Pairs& pairs) {
  std::sort(pairs.begin(), pairs.end());
  pairs.erase(std::unique(pairs.begin(), pairs.end()), pairs.end());
}

}  // namespace

bool ParticleCuts::contains(const Pairs& pairs, Index a, Index b) {
  return std::binary_search(pairs.begin(), pairs.end(), pairOf(a, b));
}

ParticleCuts ParticleCuts::make(Lists lists) {
  ParticleCuts cuts;
  if (std::find(lists.is_cut.begin(), lists.is_cut.end(), 1) != lists.is_cut.end())
    cuts.lists_ = std::make_shared<const Lists>(std::move(lists));
  return cuts;
}

ParticleCuts ParticleCuts::cut(const Points& positions, const std::vector<ParticleTraits>& traits, const std::vector<Index>& near,
                               const Lengths& lengths, const std::function<bool(Index, Index)>& goes_between) const {
  const cloud::KdTree tree(positions);
  std::vector<char> is_near(positions.size(), 0);
  for (const Index i : near) is_near[i] = 1;
  const auto mayBindAt = [&](Index i, Index j) { return mayBind(traits[i].id, traits[j].id); };
  const auto areBonded = [&](Index i, Index j) {
    return (positions[j] - positions[i]).squaredNorm() < lengths.bond * lengths.bond && mayBindAt(i, j);
  };
  const Index count = static_cast<Index>(near.size());
  std::vector<Crossed> of_block(count / kBlock + 1);
  parallelFor(count, kBlock, [&](Index begin, Index end) {
    std::vector<cloud::Neighbor> around;
    for (Index k = begin; k < end; ++k) {
      const Index i = near[k];
      tree.withinRadius(positions[i], lengths.sight, around);
      for (const cloud::Neighbor& q : around) {
        const Index j = q.index;
        if (j == i || (is_near[j] && j < i)) continue;
        const bool is_bond = areBonded(i, j);
        const auto isBetween = [&](const cloud::Neighbor& other) {
          return other.index != i && other.index != j && areBonded(i, other.index) && areBonded(other.index, j);
        };
        if (isSevered(traits[i].id, traits[j].id)) continue;
        if (!is_bond && std::none_of(around.begin(), around.end(), isBetween)) continue;
        if (goes_between(std::min(i, j), std::max(i, j)))
          (is_bond ? of_block[begin / kBlock].bonds : of_block[begin / kBlock].wide).push_back(pairOf(i, j));
      }
    }
  });

  Crossed crossed;
  for (const Crossed& some : of_block) {
    crossed.bonds.insert(crossed.bonds.end(), some.bonds.begin(), some.bonds.end());
    crossed.wide.insert(crossed.wide.end(), some.wide.begin(), some.wide.end());
  }
  if (crossed.bonds.empty()) return *this;
  keepWithOneSide(
      [&](Index i) {
        std::vector<cloud::Neighbor> found;
        std::vector<Index> partners;
        tree.withinRadius(positions[i], lengths.bond, found);
        for (const cloud::Neighbor& q : found)
          if (q.index != i && areBonded(i, q.index)) partners.push_back(q.index);
        std::sort(partners.begin(), partners.end());
        return partners;
      },
      crossed);

  // A knife above a valley goes between its slopes, but cuts nothing.
  Lists lists = lists_ ? *lists_ : Lists();
  Pairs severed = lists_ ? *lists_->severed : Pairs();
  std::vector<char> has_lost(positions.size(), 0);
  for (Index i = 0; i < static_cast<Index>(traits.size()); ++i) has_lost[i] = isCut(traits[i].id);
  for (const auto& [i, j] : crossed.bonds) {
    has_lost[i] = has_lost[j] = 1;
    severed.push_back(pairOf(traits[i].id, traits[j].id));
  }
  if (crossed.bonds.empty()) return *this;
  for (const auto& [i, j] : crossed.wide)
    if (has_lost[i] || has_lost[j]) severed.push_back(pairOf(traits[i].id, traits[j].id));
  sortUnique(severed);
  Index last_id = severed.back().second;
  for (const Pair& pair : severed) last_id = std::max(last_id, pair.second);
  lists.is_cut.resize(std::max<std::size_t>(lists.is_cut.size(), last_id + 1), 0);
  for (const auto& [a, b] : severed) lists.is_cut[a] = lists.is_cut[b] = 1;

  // What the particles beside it still have: their bonds, and wider pairs that keep bonds to a third one.
  const auto isWhole = [&](Index i, Index j) { return areBonded(i, j) && !contains(severed, traits[i].id, traits[j].id); };
  std::vector<cloud::Neighbor> around;
  std::unordered_map<Index, Index> index_of_id;
  if (!lists.bound.empty())
    for (const Index i : near) index_of_id[traits[i].id] = i;
  // A wide pair from which this cut takes all that has bonds to both may lie on both sides of it, although the knife went between
  // them at so small an angle, or in so many steps, that it did not sever them.
  const auto hasLostThird = [&](const Pair& pair) {
    const auto a = index_of_id.find(pair.first), b = index_of_id.find(pair.second);
    if (a == index_of_id.end() || b == index_of_id.end()) return false;
    const Index i = a->second, j = b->second;
    if (areBonded(i, j)) return false;
    tree.withinRadius(positions[i], lengths.bond, around);
    bool had_third = false;
    for (const cloud::Neighbor& q : around) {
      const Index k = q.index;
      if (k == i || k == j || !areBonded(i, k) || !areBonded(k, j)) continue;
      if (isWhole(i, k) && isWhole(k, j)) return false;
      had_third = true;
    }
    return had_third;
  };
  lists.bound.erase(
      std::remove_if(lists.bound.begin(), lists.bound.end(),
                     [&](const Pair& pair) { return contains(severed, pair.first, pair.second) || hasLostThird(pair); }),
      lists.bound.end());
  for (Index i = 0; i < static_cast<Index>(positions.size()); ++i) {
    const Index id = traits[i].id;
    if (id >= static_cast<Index>(lists.is_cut.size()) || !lists.is_cut[id] || isCut(id)) continue;
    tree.withinRadius(positions[i], lengths.sight, around);
    for (const cloud::Neighbor& q : around) {
      const Index j = q.index;
      if (j == i || !mayBindAt(i, j) || contains(severed, id, traits[j].id)) continue;
      const auto isBetween = [&](const cloud::Neighbor& other) {
        return other.index != i && other.index != j && isWhole(i, other.index) && isWhole(other.index, j);
      };
      if (isWhole(i, j) || std::any_of(around.begin(), around.end(), isBetween)) lists.bound.push_back(pairOf(id, traits[j].id));
    }
  }
  sortUnique(lists.bound);
  lists.severed = std::make_shared<const Pairs>(std::move(severed));
  return make(std::move(lists));
}

ParticleCuts ParticleCuts::sever(const Pairs& pairs) const {
  if (pairs.empty()) return *this;
  Lists lists = lists_ ? *lists_ : Lists();
  Pairs severed = lists.severed ? *lists.severed : Pairs();
  severed.insert(severed.end(), pairs.begin(), pairs.end());
  sortUnique(severed);
  for (const auto& [a, b] : severed) {
    lists.is_cut.resize(std::max<std::size_t>(lists.is_cut.size(), b + 1), 0);
    lists.is_cut[a] = lists.is_cut[b] = 1;
  }
  lists.severed = std::make_shared<const Pairs>(std::move(severed));
  return make(std::move(lists));
}

ParticleCuts ParticleCuts::follow(const Points& positions, const std::vector<ParticleTraits>& traits, const NeighborList& lists,
                                  const Lengths& lengths, double welding, Scratch& scratch) const {
  if (isEmpty()) return *this;
  Index num_ids = static_cast<Index>(lists_->is_cut.size());
  for (const ParticleTraits& particle : traits) num_ids = std::max(num_ids, particle.id + 1);
  auto& [index_of_id, bound, severed, added, welded] = scratch;
  for (Pairs* pairs : {&bound, &severed, &added, &welded}) pairs->clear();
  index_of_id.assign(num_ids, kGone);
  for (std::size_t i = 0; i < traits.size(); ++i) index_of_id[traits[i].id] = static_cast<Index>(i);
  const auto distanceOf = [&, &index_of_id = index_of_id](const Pair& pair) {
    return (positions[index_of_id[pair.second]] - positions[index_of_id[pair.first]]).norm();
  };
  const auto isGone = [&, &index_of_id = index_of_id](const Pair& pair) {
    return index_of_id[pair.first] == kGone || index_of_id[pair.second] == kGone;
  };
  const auto isHot = [&](Index i) { return traits[i].temperature >= welding; };

  // Pairs that have gone, or are too far apart.
  for (const Pair& pair : lists_->bound)
    if (!isGone(pair) && distanceOf(pair) <= lengths.end) bound.push_back(pair);
  const auto isNear = [&](Index i, Index j) { return (positions[j] - positions[i]).squaredNorm() < lengths.bond * lengths.bond; };
  const auto haveThird = [&](Index i, Index j) {
    const Index *a = lists.begin(i), *b = lists.begin(j);
    while (a != lists.end(i) && b != lists.end(j)) {
      if (*a == *b && isNear(i, *a) && isNear(j, *b)) return true;
      *a < *b ? ++a : ++b;
    }
    return false;
  };
  for (Index i = 0; lists.hasParted() && i < static_cast<Index>(positions.size()); ++i)
    for (const Index* j = lists.beginParted(i); j != lists.endParted(i); ++j) {
      if (*j < i || !isNear(i, *j)) continue;
      const Pair pair = pairOf(traits[i].id, traits[*j].id);
      if (isHot(i) && isHot(*j)) {
        added.push_back(pair);
      } else if (!contains(*lists_->severed, pair.first, pair.second) && haveThird(i, *j)) {
        added.push_back(pair);
      }
    }
  // Wider pairs weld with those between them.
  for (const Pair& pair : *lists_->severed) {
    if (isGone(pair)) continue;
    if (isHot(index_of_id[pair.first]) && isHot(index_of_id[pair.second]) && distanceOf(pair) <= lengths.sight) {
      welded.push_back(pair);
    } else {
      severed.push_back(pair);
    }
  }
  const bool is_same = added.empty() && welded.empty() && severed.size() == lists_->severed->size();
  if (is_same && bound.size() == lists_->bound.size()) return *this;

  Lists next;
  next.is_cut = lists_->is_cut;
  bound.insert(bound.end(), added.begin(), added.end());
  bound.insert(bound.end(), welded.begin(), welded.end());
  sortUnique(bound);
  if (severed.size() == lists_->severed->size()) {
    next.severed = lists_->severed;
  } else {
    // Particles that have got back all that they had lost are whole again.
    std::vector<char> has_lost(num_ids, 0);
    for (const auto& [a, b] : severed) has_lost[a] = has_lost[b] = 1;
    for (const Pair& pair : welded)
      for (const Index id : {pair.first, pair.second})
        if (!has_lost[id]) next.is_cut[id] = 0;
    next.severed = std::make_shared<const Pairs>(severed);
  }
  bound.erase(std::remove_if(bound.begin(), bound.end(),
                             [&](const Pair& pair) {
                               const auto isCutNow = [&](Index id) {
                                 return id < static_cast<Index>(next.is_cut.size()) && next.is_cut[id];
                               };
                               return !isCutNow(pair.first) && !isCutNow(pair.second);
                             }),
              bound.end());
  next.bound = bound;
  return make(std::move(next));
}

ParticleCuts ParticleCuts::inherit(const Points& positions, const std::vector<ParticleTraits>& traits, Index first,
                                   const std::vector<Pair>& parents, const Lengths& lengths) const {
  if (isEmpty()) return *this;
  Lists next = *lists_;
  std::set<Pair> bound(next.bound.begin(), next.bound.end()), severed(lists_->severed->begin(), lists_->severed->end());
  const auto isCutNow = [&](Index id) { return id < static_cast<Index>(next.is_cut.size()) && next.is_cut[id]; };
  // Only particles near a new one, and those that a parent is severed from, may be concerned.
  const cloud::KdTree tree(positions);
  std::unordered_map<Index, Index> index_of_id;
  for (std::size_t i = 0; i < traits.size(); ++i) index_of_id[traits[i].id] = static_cast<Index>(i);
  std::unordered_map<Index, std::vector<Index>> severed_from;  // by id: numbers of present particles
  const auto sever = [&](Index i, Index j) {
    severed_from[traits[i].id].push_back(j);
    severed_from[traits[j].id].push_back(i);
  };
  for (const auto& [a, b] : severed) {
    const auto i = index_of_id.find(a), j = index_of_id.find(b);
    if (i != index_of_id.end() && j != index_of_id.end()) sever(i->second, j->second);
  }
  std::vector<cloud::Neighbor> near;
  std::vector<Index> others;
  for (std::size_t k = 0; k < parents.size(); ++k) {
    const Index child = first + static_cast<Index>(k), id = traits[child].id;
    std::vector<Index> from;  // parents
    for (const Index parent : {parents[k].first, parents[k].second})
      if (parent >= 0) from.push_back(parent);
    next.is_cut.resize(std::max<std::size_t>(next.is_cut.size(), id + 1), 0);
    for (const Index parent : from) next.is_cut[id] = next.is_cut[id] || isCutNow(traits[parent].id);
    others.clear();
    tree.withinRadius(positions[child], lengths.sight, near);
    for (const cloud::Neighbor& q : near) others.push_back(q.index);
    for (const Index parent : from) {
      const auto found = severed_from.find(traits[parent].id);
      if (found != severed_from.end()) others.insert(others.end(), found->second.begin(), found->second.end());
    }
    std::sort(others.begin(), others.end());
    others.erase(std::unique(others.begin(), others.end()), others.end());
    for (const Index x : others) {
      if (x >= child) break;  // later ones see this one
      const Pair pair = pairOf(id, traits[x].id);
      const bool is_parent = std::find(from.begin(), from.end(), x) != from.end();
      const auto isSeveredFrom = [&](Index parent) { return severed.count(pairOf(traits[parent].id, traits[x].id)) > 0; };
      if (!is_parent && std::any_of(from.begin(), from.end(), isSeveredFrom)) {
        severed.insert(pair);
        sever(child, x);
        continue;
      }
      if (!(isCutNow(id) || isCutNow(traits[x].id))) continue;
      if (!((positions[x] - positions[child]).squaredNorm() < lengths.sight * lengths.sight)) continue;
      const auto mayBindTo = [&](Index parent) {
        if (parent == x || (!isCutNow(traits[parent].id) && !isCutNow(traits[x].id))) return true;
        return bound.count(pairOf(traits[parent].id, traits[x].id)) > 0;
      };
      if (std::any_of(from.begin(), from.end(), mayBindTo)) bound.insert(pair);
    }
  }
  next.bound.assign(bound.begin(), bound.end());
  if (severed.size() != lists_->severed->size()) next.severed = std::make_shared<const Pairs>(severed.begin(), severed.end());
  return make(std::move(next));
}

std::uint64_t ParticleCuts::addToHash(std::uint64_t h) const {
  if (!lists_) return h;
  for (const char is_cut : lists_->is_cut) h = mixHash(h, static_cast<std::uint64_t>(is_cut));
  for (const Pairs* pairs : {&lists_->bound, lists_->severed.get()}) {
    h = mixHash(h, pairs->size());
    for (const auto& [a, b] : *pairs) h = mixHash(mixHash(h, static_cast<std::uint64_t>(a)), static_cast<std::uint64_t>(b));
  }
  return h;
}

std::size_t ParticleCuts::bytes() const {
  if (!lists_) return 0;
  return lists_->is_cut.capacity() + (lists_->bound.capacity() + lists_->severed->capacity()) * sizeof(Pair) + sizeof(Lists);
}

}  // namespace deformable_surface::model
