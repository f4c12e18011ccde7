// What is proven of the motion of a surface, checked on a part of its points while all others rest.
#pragma once

#include "deformable_surface/contact/clearance.h"

#include <memory>
#include <vector>

namespace deformable_surface::contact {

class PartClearance {
 public:
  /// points: of the part, ascending; n: number of all points.
  PartClearance(std::vector<Index> points, Index n);

  /// Takes over what is proven (null: nothing). False if it does not predict that the others rest where they are: positions,
  /// (n x 3) m, of which only those are read.
  bool follow(std::shared_ptr<const ClearMotion> motion, const Points& positions);
  void forget() { motion_.reset(); }
  /// Whether the part, (points x 3) m, is as predicted: nothing then crosses anything. Needs follow().
  bool covers(const Points& part) const;

 private:
  std::vector<Index> points_;
  std::vector<char> is_part_;  // (n)
  std::shared_ptr<const ClearMotion> motion_;
  Index leader_ = -1;  // of the part, the leader of the motion
};

}  // namespace deformable_surface::contact
