// Sums the forces of pairs: points are divided into fixed blocks, each with memory of its own for the points its pairs reach.
// Blocks run in parallel, and sums do not depend on the number of threads.
#pragma once

#include "deformable_surface/base/types.h"

#include <vector>

namespace deformable_surface::model {

class PointRooms {
 public:
  static constexpr Index kPoints = 256;  // of a block, a multiple of four
  static constexpr Index kNumbers = 8;   // of a place in a room: x y z, one to spare, force, one to spare

  /// pairs: for each point, the points that it exerts forces on; a pair may come twice.
  explicit PointRooms(const Lists& pairs);

  /// (pairs) the place of the second point of a pair in the memory of the first one's block. The block's own points come first.
  const std::vector<Index>& places() const { return places_; }

  /// The memory of the block [begin, end), with positions (4 x n, padded) filled in and forces set to zero.
  double* fill(Index begin, Index end, const double* positions);
  /// Adds the forces of all blocks on the points [begin, end) to forces (n x 3).
  void addForces(Index begin, Index end, double* forces) const;

 private:
  std::vector<Index> places_;
  Lists others_;              // of every block, the points that are not its own
  std::vector<Index> begin_;  // (blocks) of its room, in places
  Lists copies_;              // of every point, its places in other blocks' rooms, ascending
  std::vector<double> room_;  // scratch
};

}  // namespace deformable_surface::model
