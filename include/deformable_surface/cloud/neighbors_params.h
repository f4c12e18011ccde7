// How neighbourhoods are chosen.
#pragma once

#include "deformable_surface/base/or_auto.h"
#include "deformable_surface/base/params.h"
#include "deformable_surface/base/types.h"

namespace deformable_surface::cloud {

struct NeighborsParams {
  Index k = 16;                      // 6 .. 64: nearest neighbours among which a ring is found [Su 2007: 10 .. 20]
  OrAuto<double> geodesic_exponent;  // 1 = Euclidean neighbourhoods, > 1 = the published exponent, auto = without a parameter
  OrAuto<double> radius;             // m; only auto (by k): see below

  bool areEuclidean() const { return !geodesic_exponent.is_auto && geodesic_exponent.value == 1.0; }
};

inline void visit(Fields& fields, NeighborsParams& p) {
  fields.integer("k", p.k, "", between(6, 64), "number of nearest neighbours from which the ring of a point is built");
  fields.number(
      "geodesic_exponent", p.geodesic_exponent, "", between(1.0, 64.0),
      "1 = Euclidean neighbours; above 1 = geodesic neighbours by shortest paths with link weights |x_i - "
      "x_j|^geodesic_exponent, as "
      "published; `auto` = geodesic neighbours by paths whose link length is limited by the spacing that connects the surface "
      "(docs/geodesics.md)");
  fields.number("radius", p.radius, "m", between(1e-9, kMaxLength),
                "only `auto`: neighbours are the k nearest. A fixed radius, as published, gives too few neighbours in sparse "
                "regions and too many in dense ones");
  fields.require(p.radius.is_auto, "radius", "found a number; accepted: auto (neighbours are the k nearest, see neighbors.k)");
}

}  // namespace deformable_surface::cloud
