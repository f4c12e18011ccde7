// Where a surface of oriented particles is cut. Bonds between particles depend on distance alone and have no memory, so that a
// cut would heal where its edges meet. These lists are the memory.
#pragma once

#include "deformable_surface/base/types.h"
#include "deformable_surface/model/state.h"

#include <cstdint>
#include <functional>
#include <memory>
#include <utility>
#include <vector>

namespace deformable_surface::model {

class NeighborList;

/// The particles beside cuts, with the bonds that they have lost (severed pairs) and those that they have (bound pairs). A value;
/// copies share the lists. Particles are named by their ids, so that the numbers of the present ones do not matter.
///
/// A particle beside a cut has a bond to another only if the two are a bound pair. They become one
/// - at the cut, if no knife went between them,
/// - later, if both have bonds to a third particle and were not severed: particles of one sheet that move past each other,
/// - by birth, from a parent's bonds,
/// - if both are hot: a weld. It is the only way across a cut.
/// All other pairs form bonds by distance alone, as published.
class ParticleCuts {
 public:
  using Pair = std::pair<Index, Index>;  // ids, ascending
  using Pairs = std::vector<Pair>;       // ascending

  /// m
  struct Lengths {
    double bond = 0.0;   // longest bond
    double sight = 0.0;  // pairs up to here are severed as well, if both have bonds to a third particle
    double end = 0.0;    // a bound pair farther apart than this is none any more
  };

  bool isEmpty() const { return !lists_; }
  /// Whether a knife has cut a bond of this particle, or of an ancestor, that is not welded.
  bool isCut(Index id) const { return lists_ && id < static_cast<Index>(lists_->is_cut.size()) && lists_->is_cut[id]; }
  bool mayBind(Index a, Index b) const { return (!isCut(a) && !isCut(b)) || contains(lists_->bound, a, b); }
  bool isSevered(Index a, Index b) const { return lists_ && contains(*lists_->severed, a, b); }
  /// Null: none. The same pointer until one is added or welded.
  std::shared_ptr<const Pairs> severed() const { return lists_ ? lists_->severed : nullptr; }
  /// Whether the other has the same lists. False for equal lists that were made apart.
  bool isSameAs(const ParticleCuts& other) const { return lists_ == other.lists_; }

  /// A knife went between some of the particles (positions: n x 3 m, traits: n). near: those that it came near to, ascending.
  /// goesBetween(i, j): whether it did for this pair, i < j; called in parallel. Adds the bonds that it cut.
  /// near: they have no others within lengths.sight that the knife may have separated from them.
  ParticleCuts cut(const Points& positions, const std::vector<ParticleTraits>& traits, const std::vector<Index>& near,
                   const Lengths& lengths, const std::function<bool(Index, Index)>& goes_between) const;

  /// These pairs (ascending) are severed as well, whatever the distances.
  ParticleCuts sever(const Pairs& pairs) const;

  /// What follow() would otherwise allocate in every step.
  struct Scratch {
    std::vector<Index> index_of_id;
    Pairs bound, severed, added, welded;
  };
  /// What particles that have moved, cooled or gone change. lists: of these positions and traits, and of these cuts. welding: K,
  /// the temperature from which pairs weld.
  ParticleCuts follow(const Points& positions, const std::vector<ParticleTraits>& traits, const NeighborList& lists,
                      const Lengths& lengths, double welding, Scratch& scratch) const;

  /// Particles from index `first` on are new. They take part in the cuts of their parents (numbers of present particles, -1:
  /// none), two each: what one parent is severed from, the new one is severed from as well, so that none bridges a cut.
  /// O(n log n), and for each new one its neighbours and what its parents are severed from.
  ParticleCuts inherit(const Points& positions, const std::vector<ParticleTraits>& traits, Index first,
                       const std::vector<Pair>& parents, const Lengths& lengths) const;

  /// A hash extended by all lists; unchanged if nothing is cut.
  std::uint64_t addToHash(std::uint64_t hash) const;

  std::size_t bytes() const;

 private:
  struct Lists {
    std::vector<char> is_cut;  // by id
    Pairs bound;               // with at least one particle that is cut
    std::shared_ptr<const Pairs> severed;
  };

  static bool contains(const Pairs& pairs, Index a, Index b);
  static ParticleCuts make(Lists lists);

  std::shared_ptr<const Lists> lists_;  // null: nothing is cut
};

}  // namespace deformable_surface::model
