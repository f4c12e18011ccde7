// Points that a solid has passed over. Where they are says no longer which way they came in, so that has to be remembered: it is
// what keeps a thin or fast tool from going through a surface. Apart from where a tool is, because it needs two moments.
#pragma once

#include "deformable_surface/geometry/solid.h"

#include <optional>

namespace deformable_surface::tool {

/// Where a point came in: a place on the surface of a solid, m, and its outward normal there, both in the solid's frame. The
/// plane through it stands for the surface until the point is in front of it again.
struct Entry {
  Vec3 place = Vec3::Zero(), normal = Vec3::UnitZ();

  /// m, of a point over the plane; negative behind it.
  double heightOf(const Vec3& point) const { return normal.dot(point - place); }
};

/// Where a straight way that begins outside meets a solid first (both ends in the solid's frame, m); nothing if it stays outside.
/// By sphere tracing [Hart 1996], for which no solid is too thin.
std::optional<Entry> findEntry(const geometry::Solid& solid, const Vec3& from, const Vec3& to);

/// Where a point came in that went straight between two places (in the solid's frame, m), if at the end of it the solid would no
/// longer push it back to where it came from: it lies behind the solid, or so deep inside that another way out is shorter.
std::optional<Entry> findCrossing(const geometry::Solid& solid, const Vec3& from, const Vec3& to);

/// Whether a point that came in there is still held up by the solid: behind the plane, and in the solid or with the solid in its
/// way back along the normal. now: its signed distance.
bool isHeldUp(const geometry::Solid& solid, const Entry& entry, const Vec3& point, const geometry::SignedDistance& now);

/// Whether the solid by itself pushes a point inside it back to about where it came in.
bool pushesBack(const Entry& entry, const geometry::SignedDistance& now);

}  // namespace deformable_surface::tool
