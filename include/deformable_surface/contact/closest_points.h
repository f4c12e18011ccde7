// Closest points of the two kinds of pairs in which triangles first touch: a vertex and a triangle, or two edges.
#pragma once

#include "deformable_surface/base/types.h"

#include <array>

namespace deformable_surface::contact {

/// Closest points of two primitives with four vertices in total. The gap is the vector from the closest point of the second
/// primitive to that of the first: the sum of weight[v] times the position of vertex v. Weights of the first primitive are in [0,
/// 1] and sum to 1. Those of the second are in [-1, 0] and sum to -1.
struct Closest {
  Vec3 gap;  // m
  std::array<double, 4> weight;

  double squaredDistance() const { return gap.squaredNorm(); }
};

/// Vertex p and triangle a b c, which may be degenerate: a line or a point.
Closest findClosestToTriangle(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c);

/// Edge p q and edge a b; either may be a point. Parallel edges: any closest pair.
Closest findClosestOfEdges(const Vec3& p, const Vec3& q, const Vec3& a, const Vec3& b);

/// Whether edge p q passes through the inside of triangle a b c.
bool pierces(const Vec3& p, const Vec3& q, const Vec3& a, const Vec3& b, const Vec3& c);

}  // namespace deformable_surface::contact
