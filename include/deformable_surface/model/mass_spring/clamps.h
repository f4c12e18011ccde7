// Where a held patch of the surface ends. Curvature jumps there, from that of the patch, which cannot bend, to that of what is
// free: a fit across the edge sees half of it, and the clamp acts most of a spacing behind the last held points. So fits stay
// on one side.
#pragma once

#include "deformable_surface/base/types.h"

#include <vector>

namespace deformable_surface::model {

class Clamps {
 public:
  /// rest (n x 3), ring: neighbours; held (n), or empty if nothing is. Held points that span no patch (a single one, a line)
  /// are a hinge and clamp nothing.
  Clamps(const Points& rest, const Lists& ring, const std::vector<char>& held);

  /// Held, and the edge of a held patch that fixes the slope.
  bool isEdge(Index i) const { return !kind_.empty() && kind_[i] == Kind::kEdge; }
  /// Held, with nothing free beside it: it cannot bend.
  bool isInner(Index i) const { return !kind_.empty() && kind_[i] == Kind::kInner; }
  bool isHeld(Index i) const { return !kind_.empty() && kind_[i] != Kind::kFree; }
  /// Whether the curvature at i may be taken from the position of j.
  bool sees(Index i, Index j) const { return isEdge(i) || isInner(i) || !isInner(j); }
  /// The share of an edge point's area that can bend.
  double freeShare(Index i) const { return share_.empty() ? 1.0 : share_[i]; }
  bool any() const { return !share_.empty(); }

 private:
  enum class Kind : char { kFree, kHinge, kEdge, kInner };
  std::vector<Kind> kind_;
  std::vector<double> share_;
};

}  // namespace deformable_surface::model
