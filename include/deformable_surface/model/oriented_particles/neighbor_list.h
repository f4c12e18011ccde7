// Neighbour lists of particles, reused while nothing has moved far. They depend on positions and
// descent only.
#pragma once

#include "deformable_surface/model/deformable_model.h"
#include "deformable_surface/model/oriented_particles/approach_tree.h"
#include "deformable_surface/model/oriented_particles/particle_cuts.h"

#include <limits>
#include <utility>

namespace deformable_surface::model {

/// Lists of all others within a radius plus a skin [Verlet 1967], rebuilt only when two particles have come within the radius
/// that were out of reach, or when finding this out would cost as much. Cells are sorted by a hash of their place [Teschner
/// 2003], so that empty space costs nothing however far particles fly.
class NeighborList {
 public:
  /// Particles with more neighbours than this are refused: such a heap of particles is no surface.
  static constexpr Index kMostNeighbors = 1024;

  /// radius, skin: m, > 0. apart: for every initial particle, by its id, the particles that are never its neighbours however near
  /// they are, ascending and symmetric; empty: there are none. Descendants of two such particles are no neighbours either. They
  /// have lists of their own.
  NeighborList(double radius, double skin, Lists apart = {}) : radius_(radius), skin_(skin), apart_(std::move(apart)) {}

  /// Makes the lists hold every pair within the radius at these positions that is not kept apart, and none
  /// beyond radius and skin at the positions of the last
  /// rebuild. False if this is impossible: a position is not finite, or a particle has more than kMostNeighbors others. The lists
  /// must then not be used. Parallel; allocates only where there is more to list than before. O(n).
  /// traits: (n), read only if some particles are kept apart or cut. Pairs between which there are cuts are no neighbours, but
  /// have lists of their own. cuts must be the same until forget().
  bool update(const Points& positions, const std::vector<ParticleTraits>& traits = {}, const ParticleCuts& cuts = {});
  /// Changes the lengths, m, > 0, for the same particles.
  void setRadius(double radius, double skin) {
    radius_ = radius;
    skin_ = skin;
    forget();
  }
  /// An empty list with the same lengths, for particles of the same descent.
  NeighborList alike() const {
    NeighborList lists(radius_, skin_, apart_);
    lists.apart_ranges_ = apart_ranges_;
    return lists;
  }
  /// The pairs that are kept apart, by the ids of initial particles.
  const Lists& apart() const { return apart_; }
  /// How near, m, each of these pairs may come before it repels; as long as apart().items. Before, it is infinite.
  void setApartRanges(std::vector<double> ranges) {
    apart_ranges_ = std::move(ranges);
    forget();
  }
  /// m, the distance that every particle may move before lists may have to be rebuilt.
  double margin() const { return 0.5 * skin_; }
  /// The particles have changed: the next update rebuilds the lists.
  void forget() { is_valid_ = false; }

  /// The others near particle i, ascending.
  const Index* begin(Index i) const { return blocks_[i / kBlock].data() + begins_[i]; }
  const Index* end(Index i) const { return begin(i) + counts_[i]; }

  /// Those from which it is cut, ascending.
  const Index* beginParted(Index i) const { return hasParted() ? parted_[i / kBlock].data() + parted_begins_[i] : nullptr; }
  const Index* endParted(Index i) const { return hasParted() ? beginParted(i) + parted_counts_[i] : nullptr; }
  bool hasParted() const { return !parted_begins_.empty(); }

  /// One that is kept apart from a particle, and how near it may come.
  struct Apart {
    Index particle;
    double range;  // m
  };
  /// Those near particle i that are kept apart from it, ascending; all within their range.
  const Apart* beginApart(Index i) const { return hasApart() ? near_apart_[i / kBlock].data() + apart_begins_[i] : nullptr; }
  const Apart* endApart(Index i) const { return hasApart() ? beginApart(i) + apart_counts_[i] : nullptr; }
  bool hasApart() const { return !apart_begins_.empty(); }

  Index numRebuilds() const { return num_rebuilds_; }
  /// Memory in use.
  std::size_t bytes() const;

 private:
  struct Slot {
    double x, y, z;     // m
    std::uint32_t row;  // which line of cells along x
    Index particle;
  };
  struct Cell {
    std::int64_t x, y, z;
  };

  // Bounds of displacements since the last rebuild, or the base of the tree, m.
  struct Range {
    Vec3 low = Vec3::Constant(std::numeric_limits<double>::infinity());
    Vec3 high = Vec3::Constant(-std::numeric_limits<double>::infinity());
    bool is_finite = true;
  };

  bool hasApproached(const Points& positions, bool& is_finite);
  Cell cellOf(const Vec3& p) const;
  Index findBin(std::uint64_t row, std::int64_t x) const;
  void sortIntoBins(const Points& positions);
  bool listNeighbors(const Points& positions, const std::vector<ParticleTraits>& traits, const ParticleCuts& cuts);

  static constexpr Index kBlock = 1024;

  double radius_, skin_;
  Lists apart_;
  std::vector<double> apart_ranges_;  // m, of apart_.items; empty: infinite
  double cell_ = 0.0;                 // m, edge of the cells
  Points rebuilt_at_;
  bool is_valid_ = false;
  std::vector<std::vector<Index>> blocks_;            // the lists of kBlock particles one after the other
  std::vector<Index> begins_, counts_;                // (n), within the block
  std::vector<std::vector<Index>> parted_;            // the same for pairs with a cut between them
  std::vector<Index> parted_begins_, parted_counts_;  // (n); empty: there are no cuts
  std::vector<std::vector<Apart>> near_apart_;        // the same for pairs that are kept apart
  std::vector<Index> apart_begins_, apart_counts_;    // (n); empty: none are
  std::vector<Index> bins_, starts_;                  // of each particle; (number of bins + 1) into slots_
  std::vector<Slot> slots_;                           // (n) by bin, then by index
  Index mask_ = 0;                                    // number of bins - 1, a power of two less one
  std::vector<Range> ranges_;                         // of displacements, by block
  ApproachTree tree_;
  Index num_rebuilds_ = 0;
};

}  // namespace deformable_surface::model
