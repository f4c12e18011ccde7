// Where forces of pairs are added up: points in fixed blocks, each with room of its own for all that its pairs reach, so that
// blocks run beside each other, and sums do not depend on the number of threads. A file of its own because it knows no material.
#pragma once

#include "deformable_surface/base/types.h"

#include <vector>

namespace deformable_surface::model {

class PointRooms {
 public:
  static constexpr Index kPoints = 256;  // of a block, a multiple of four
  static constexpr Index kNumbers = 8;   // of a place in a room: x y z, one to spare, force, one to spare

  /// pairs: of each point with those that it exerts forces on, which may come twice.
  explicit PointRooms(const Lists& pairs);

  /// (pairs) where the second point of a pair stands in the room of the first one's block; the block's own points stand first.
  const std::vector<Index>& places() const { return places_; }

  /// The room of the block that begins at a point, with positions (4 x n, padded), and no forces yet. end: of the block.
  double* fill(Index begin, Index end, const double* positions);
  /// Adds what all blocks do to the points [begin, end) to forces (n x 3).
  void addForces(Index begin, Index end, double* forces) const;

 private:
  std::vector<Index> places_;
  Lists others_;              // of every block, the points that are not its own
  std::vector<Index> begin_;  // (blocks) of its room, in places
  Lists copies_;              // of every point, its places in other blocks' rooms, ascending
  std::vector<double> room_;  // scratch
};

}  // namespace deformable_surface::model
