// Memory of friction: the places to which points stick. Part of the state of a surface.
#pragma once

#include "deformable_surface/base/types.h"

#include <array>
#include <cstdint>

namespace deformable_surface::contact {

/// The place at which a point sticks to a rigid body, or would stick again.
struct BodyAnchor {
  std::uint64_t body;  // a hash of its name
  Index point;
  Vec3 place;   // m, in the body's frame
  double slid;  // m, the way of the place since it last stuck

  bool isBefore(std::uint64_t other_body, Index other_point) const {
    return body != other_body ? body < other_body : point < other_point;
  }
};

/// The place at which two parts of the surface stick to each other.
struct PairAnchor {
  std::array<Index, 4> vertices;  // of the pair, see contact::Pair
  bool is_edges;
  std::array<double, 4> weight;  // of the vertices in the gap between the two places
  Vec3 offset;                   // m, the gap at which the spring is unloaded
  double slid;                   // m, the way of that offset since the parts last stuck

  bool isBefore(const std::array<Index, 4>& other, bool other_is_edges) const {
    return is_edges != other_is_edges ? other_is_edges : vertices < other;
  }
};

}  // namespace deformable_surface::contact
