// Which particles are near which, kept while nothing has moved far. It is a file of its own because it knows positions and
// descent only.
#pragma once

#include "deformable_surface/model/deformable_model.h"

#include <utility>

namespace deformable_surface::model {

/// Lists of all others within a radius and a skin [Verlet 1967], made anew only when some particle has moved more than half the
/// skin since. Cells are sorted by a hash of their place [Teschner 2003], so that empty space costs nothing however far
/// particles fly.
class NeighborList {
 public:
  /// More than these are not listed: such a heap of particles is no surface.
  static constexpr Index kMostNeighbors = 1024;

  /// radius, skin: m, > 0. apart: of every first particle, by its id, those that are no neighbours of it however near they are,
  /// ascending, and symmetric; empty: there are none. What descends from two that are apart is apart, too.
  NeighborList(double radius, double skin, Lists apart = {}) : radius_(radius), skin_(skin), apart_(std::move(apart)) {}

  /// Makes the lists hold every pair within the radius at these positions that is not apart, and none
  /// beyond radius and skin at those of the last
  /// rebuild. False if that cannot be: a position is not finite, or a particle has more than kMostNeighbors others; the lists are
  /// then not to be used. Parallel; allocates only where there is more to list than before. O(n).
  /// traits: (n), read only if some particles are apart.
  bool update(const Points& positions, const std::vector<ParticleTraits>& traits = {});
  /// Other lengths, m, > 0, for the same particles.
  void setRadius(double radius, double skin) {
    radius_ = radius;
    skin_ = skin;
    forget();
  }
  /// One of nothing yet, for particles of the same descent.
  NeighborList alike() const { return {radius_, skin_, apart_}; }
  /// m, what a particle may move before lists are made anew.
  double margin() const { return 0.5 * skin_; }
  /// The next update makes the lists anew: the particles are others.
  void forget() { is_valid_ = false; }

  /// The others near particle i, ascending.
  const Index* begin(Index i) const { return blocks_[i / kBlock].data() + begins_[i]; }
  const Index* end(Index i) const { return begin(i) + counts_[i]; }

  Index numRebuilds() const { return num_rebuilds_; }
  /// Bytes that are held.
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

  bool hasMovedFar(const Points& positions, bool& is_finite) const;
  Cell cellOf(const Vec3& p) const;
  Index findBin(std::uint64_t row, std::int64_t x) const;
  void sortIntoBins(const Points& positions);
  bool listNeighbors(const Points& positions, const std::vector<ParticleTraits>& traits);

  static constexpr Index kBlock = 1024;

  double radius_, skin_;
  Lists apart_;
  double cell_ = 0.0;  // m, edge of the cells
  Points rebuilt_at_;
  bool is_valid_ = false;
  std::vector<std::vector<Index>> blocks_;  // the lists of kBlock particles one after the other
  std::vector<Index> begins_, counts_;      // (n), within the block
  std::vector<Index> bins_, starts_;        // of each particle; (number of bins + 1) into slots_
  std::vector<Slot> slots_;                 // (n) by bin, then by index
  Index mask_ = 0;                          // number of bins - 1, a power of two less one
  Index num_rebuilds_ = 0;
};

}  // namespace deformable_surface::model
