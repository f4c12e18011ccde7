// Neighbours of places that move little between one search and the next, as in a relaxation. Candidates are found by a tree and
// looked through again as long as no other point can have come nearer. The answers are those of a new tree, to the bit.
#pragma once

#include "deformable_surface/cloud/kd_tree.h"

#include <optional>

namespace deformable_surface::cloud {

/// All points within a radius of each, where all points move.
class KeptNeighborhoods {
 public:
  /// m, both above 0. Candidates are looked for up to radius + skin: with a wide skin they are many, with a narrow one they must
  /// be searched again soon.
  KeptNeighborhoods(double radius, double skin);

  /// Takes the places of the points, (n x 3); InputError if one is not finite. O(n), and a new tree if more than a few have moved
  /// by more than half of the skin since the last tree.
  void update(const Points& positions);

  /// Overwrites out with the points within the radius of point i, itself included, nearest first, as of the last update.
  /// Different points may be asked for at the same time.
  void find(Index i, std::vector<Neighbor>& out);

 private:
  double radius_, skin_;                           // m
  Points positions_, searched_;                    // (n x 3) present; of the tree
  std::optional<KdTree> tree_;                     // of searched_
  std::vector<Index> strays_;                      // ascending: moved by more than half of the skin since then
  std::vector<std::vector<Neighbor>> candidates_;  // (n) in the order of the last answer; empty: not asked for yet
};

/// The k nearest of points that stay, where the places that ask move.
class KeptNearest {
 public:
  /// tree: of these points. Both must outlive it.
  KeptNearest(const KdTree& tree, const Points& points, Index k, Index num_places);

  /// Overwrites out with the min(k, n) nearest points, nearest first. place: 0 .. num_places - 1, where the candidates are kept;
  /// different places may be asked for at the same time.
  void find(Index place, const Vec3& at, std::vector<Neighbor>& out);

 private:
  struct Candidates {
    Vec3 searched_at = Vec3::Zero();
    double distance = -1.0;       // m, of searched_at: no other point is nearer
    std::vector<Neighbor> found;  // in the order of the last answer
  };

  const KdTree& tree_;
  const Points& points_;
  Index k_;
  std::vector<Candidates> candidates_;
};

}  // namespace deformable_surface::cloud
