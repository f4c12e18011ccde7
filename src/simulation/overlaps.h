// Whether triangles of a surface overlap at rest.
#pragma once

#include "deformable_surface/contact/self_contact.h"

#include <vector>

namespace deformable_surface::simulation {

// Fraction of a length: what is nearer belongs to overlapping triangles.
constexpr double kOverlap = 0.05;

inline bool hasCorner(const contact::Triangle& t, Index v) { return t[0] == v || t[1] == v || t[2] == v; }

/// Its normal with a length of twice the area, m^2.
inline Vec3 findNormal(const Points& rest, const contact::Triangle& t) {
  return (rest[t[1]] - rest[t[0]]).cross(rest[t[2]] - rest[t[0]]);
}

/// Longest edge, m.
double findLongestEdge(const Points& rest, const contact::Triangle& t);

/// m. Larger by kOverlap than the triangle.
contact::Box findBox(const Points& rest, const contact::Triangle& t);
std::vector<contact::Box> listBoxes(const Points& rest, const std::vector<contact::Triangle>& triangles);

/// Whether a point lies on a triangle: nearer than kOverlap of its first edge.
bool liesOn(const Points& rest, Index v, const contact::Triangle& t);

/// Whether edges without a common point come nearer than kOverlap of the shorter one.
bool doEdgesOverlap(const Points& rest, Index a, Index b, Index c, Index d);
/// Whether an edge passes through a triangle that has none of its points.
bool passesThrough(const Points& rest, Index from, Index to, const contact::Triangle& t);

/// Whether edges without a common point come nearer than kOverlap of the shorter one, a point of one triangle lies on the other,
/// or an edge of one passes through the other. rest: (n) m.
bool doOverlap(const Points& rest, const contact::Triangle& one, const contact::Triangle& other);

}  // namespace deformable_surface::simulation
