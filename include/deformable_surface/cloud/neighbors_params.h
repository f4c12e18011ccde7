// How neighbourhoods are chosen.
#pragma once

#include "deformable_surface/base/or_auto.h"
#include "deformable_surface/base/params.h"
#include "deformable_surface/base/types.h"

namespace deformable_surface::cloud {

struct NeighborsParams {
  Index k = 16;                 // 6 .. 64: nearest neighbours among which a ring is found [Su 2007: 10 .. 20]
  OrAuto<double> geodesicness;  // 1 = Euclidean neighbourhoods, > 1 = the published exponent, auto = without a parameter
  OrAuto<double> radius;        // m; only auto (by k): see below

  bool areEuclidean() const { return !geodesicness.is_auto && geodesicness.value == 1.0; }
};

inline void visit(Fields& fields, NeighborsParams& p) {
  fields.integer("k", p.k, "", between(6, 64), "nearest neighbours among which a point's ring is found");
  fields.number(
      "geodesicness", p.geodesicness, "", between(1.0, 64.0),
      "1 = neighbours in space; above 1 = those near on the surface by shortest paths of links |x_i - x_j|^geodesicness, "
      "as published; `auto` = by paths whose links are trusted up to what holds the surface together");
  fields.number("radius", p.radius, "m", between(1e-9, kMaxLength),
                "only `auto`: neighbours are the k nearest. Those within one distance, as published, are too few where points "
                "are sparse, hundreds where they are dense, and none among simulation points, which are farther apart than it");
  fields.require(p.radius.is_auto, "radius", "found a number; accepted: auto (neighbours are the k nearest, see neighbors.k)");
}

}  // namespace deformable_surface::cloud
