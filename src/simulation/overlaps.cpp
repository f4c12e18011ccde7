#include "overlaps.h"

#include <algorithm>
#include <cmath>

namespace deformable_surface::simulation {

using contact::Triangle;

double findLongestEdge(const Points& rest, const Triangle& t) {
  double squared = 0.0;
  for (int k = 0; k < 3; ++k) squared = std::max(squared, (rest[t[(k + 1) % 3]] - rest[t[k]]).squaredNorm());
  return std::sqrt(squared);
}

contact::Box findBox(const Points& rest, const Triangle& t) {
  contact::Box box(rest[t[0]]);
  box.extend(rest[t[1]]).extend(rest[t[2]]);
  const Vec3 margin = Vec3::Constant(kOverlap * box.diagonal().norm());
  return {box.min() - margin, box.max() + margin};
}

std::vector<contact::Box> listBoxes(const Points& rest, const std::vector<Triangle>& triangles) {
  std::vector<contact::Box> boxes;
  boxes.reserve(triangles.size());
  for (const Triangle& t : triangles) boxes.push_back(findBox(rest, t));
  return boxes;
}

bool liesOn(const Points& rest, Index v, const Triangle& t) {
  const Vec3 &a = rest[t[0]], &b = rest[t[1]], &c = rest[t[2]];
  return contact::findClosestToTriangle(rest[v], a, b, c).squaredDistance() < kOverlap * kOverlap * (b - a).squaredNorm();
}

bool doEdgesOverlap(const Points& rest, Index a, Index b, Index c, Index d) {
  if (a == c || a == d || b == c || b == d) return false;
  const double shorter = std::min((rest[b] - rest[a]).squaredNorm(), (rest[d] - rest[c]).squaredNorm());
  return contact::findClosestOfEdges(rest[a], rest[b], rest[c], rest[d]).squaredDistance() < kOverlap * kOverlap * shorter;
}

bool passesThrough(const Points& rest, Index from, Index to, const Triangle& t) {
  return !hasCorner(t, from) && !hasCorner(t, to) && contact::pierces(rest[from], rest[to], rest[t[0]], rest[t[1]], rest[t[2]]);
}

bool doOverlap(const Points& rest, const Triangle& one, const Triangle& other) {
  for (int k = 0; k < 3; ++k) {
    const Index a = one[k], b = one[(k + 1) % 3];
    for (int m = 0; m < 3; ++m)
      if (doEdgesOverlap(rest, a, b, other[m], other[(m + 1) % 3])) return true;
    if (!hasCorner(other, a) && liesOn(rest, a, other)) return true;
    if (!hasCorner(one, other[k]) && liesOn(rest, other[k], one)) return true;
    if (passesThrough(rest, a, b, other) || passesThrough(rest, other[k], other[(k + 1) % 3], one)) return true;
  }
  return false;
}

}  // namespace deformable_surface::simulation
