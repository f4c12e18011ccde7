// Layers of a surface that lie on each other, a spacing or so apart.
#pragma once

#include "deformable_surface/base/types.h"

#include <cmath>

namespace deformable_surface::cloud {

/// Whether a link leads from one layer to another one: both ends face alike, up to 45 degrees, and it is steeper than 45 degrees
/// against the tangent planes of both. Normals: unit, of any sides.
inline bool leadsUp(const Vec3& link, const Vec3& normal_from, const Vec3& normal_to) {
  constexpr double kHalf = 0.7071;  // sine and cosine of 45 degrees
  const double steep = kHalf * link.norm();
  return std::abs(normal_from.dot(normal_to)) > kHalf && std::abs(link.dot(normal_from)) > steep &&
         std::abs(link.dot(normal_to)) > steep;
}

/// How many points list, among their nearest neighbours, one that lies above or below them, not nearer than most of these.
/// normals: (n) unit, of any sides; neighbors: nearest first.
Index countLinkedUp(const Points& positions, const Points& normals, const Lists& neighbors);

/// Pairs that lists no longer hold.
struct LostPairs {
  Index up = 0, along = 0;  // that lead to other layers, and that do not
};
/// Of the nearest neighbours that lists held before. normals: (n) unit, as known now.
LostPairs countLost(const Points& positions, const Points& normals, const Lists& before, const Lists& after);

/// Normals on which points and those around them agree.
struct AgreedNormals {
  Points normals;     // (n) unit
  Points at_creases;  // (n) where those around a point agree on two normals the second, else the same
};

/// Each normal that is not nearly that of all around it becomes the one of these with which most agree, and then that of the
/// points around it which lie on its plane. Between layers about a spacing apart, planes across the layers hold as many points as
/// the layers themselves. Single points take them for the surface; most points do not. neighbors: in space, nearest first;
/// normals: (n) unit. Parallel; O(n k^2).
AgreedNormals agreeOnNormals(const Points& positions, const Lists& neighbors, Points normals);

}  // namespace deformable_surface::cloud
