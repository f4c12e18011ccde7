// Which vertices, edges and triangles of two patches are near each other, four at a time.
#pragma once

#include "deformable_surface/contact/box_tree.h"

#include <array>
#include <cstddef>
#include <vector>

namespace deformable_surface::contact {

/// Primitives of one kind. Those that are added follow each other in memory, so that four are compared with four.
class Primitives {
 public:
  /// num_corners: of each, 1 to 3.
  explicit Primitives(int num_corners) : num_corners_(num_corners) {}

  void clear() { items_.clear(); }
  /// corners: (num_corners), of all positions, (n x 3) m.
  void add(Index item, const Index* corners, const Points& positions) {
    const std::size_t begin = items_.size() * 4 * num_corners_;
    items_.push_back(item);
    if (places_.size() < begin + kMost) places_.resize(2 * (begin + kMost));
    for (int k = 0; k < num_corners_; ++k) {
      const Vec3& place = positions[corners[k]];
      double* const to = &places_[begin + 4 * k];
      to[0] = place.x();
      to[1] = place.y();
      to[2] = place.z();
    }
  }
  /// After the last add().
  void end();
  Index size() const { return static_cast<Index>(items_.size()); }

  /// Memory of one thread.
  struct Scratch {
    std::vector<Index> first, second;
    std::vector<double> first_balls, second_balls;
    std::vector<std::array<Index, 2>> matches;  // in larger memory
  };
  /// Calls visit(item, item of other) for all pairs nearer than reach (m), ascending; also for some that are farther apart by
  /// rounding. near: all that is nearer than reach to anything of these; near_other: the same of the others. Vertices with
  /// triangles, or edges with edges.
  template <class Visit>
  void visitNear(const Box& near, const Primitives& other, const Box& near_other, double reach, Scratch& scratch,
                 const Visit& visit) const {
    const Index num = match(near, other, near_other, reach, scratch);
    for (Index k = 0; k < num; ++k) visit(items_[scratch.matches[k][0]], other.items_[scratch.matches[k][1]]);
  }

 private:
  static constexpr std::size_t kMost = 48;  // numbers of four triangles

  Index match(const Box& near, const Primitives& other, const Box& near_other, double reach, Scratch& scratch) const;
  Index selectNear(const Box& box, std::vector<Index>& chosen, std::vector<double>& balls) const;

  int num_corners_;
  std::vector<Index> items_;
  std::vector<double> places_;  // (size x num_corners x 4) m: x, y, z, any; in larger memory
  std::vector<double> balls_;   // (size / 4, rounded up, x 4 x 4) m: x, y, z and radius of four balls that contain a primitive
                                // each; x is NaN where there is none
};

}  // namespace deformable_surface::contact
