// Points that a solid has passed over. Their position no longer shows the side from which they entered, so the entry is stored.
// This keeps thin or fast tools from passing through a surface.
#pragma once

#include "deformable_surface/geometry/solid.h"

#include <optional>

namespace deformable_surface::tool {

/// Where a point entered: a place on the surface of a solid, m, and its outward normal there, both in the solid's frame. The
/// plane through it replaces the surface until the point is in front of it again.
struct Entry {
  Vec3 place = Vec3::Zero(), normal = Vec3::UnitZ();

  /// Height of a point above the plane, m; negative behind it.
  double heightOf(const Vec3& point) const { return normal.dot(point - place); }
};

/// The first intersection of a solid with a straight segment that begins outside (both ends in the solid's frame, m); nothing if
/// it stays outside. By sphere tracing [Hart 1996], which finds solids of any thickness.
std::optional<Entry> findEntry(const geometry::Solid& solid, const Vec3& from, const Vec3& to);

/// The entry of a point that moved straight between two places (in the solid's frame, m), if at the end the solid would no longer
/// push it back to where it entered: it lies behind the solid, or so deep inside that another way out is shorter.
std::optional<Entry> findCrossing(const geometry::Solid& solid, const Vec3& from, const Vec3& to);

/// Whether a point with this entry is still blocked by the solid: it is behind the plane, and either inside the solid, or the
/// solid lies on its way back along the normal. now: its signed distance.
bool isHeldUp(const geometry::Solid& solid, const Entry& entry, const Vec3& point, const geometry::SignedDistance& now);

/// Whether a point with this entry has come out over an edge: it is behind the plane, and the solid does not block it.
bool isBeside(const geometry::Solid& solid, const Entry& entry, const Vec3& point, const geometry::SignedDistance& now);

/// Whether the solid alone pushes a point inside it back to about the place of entry.
bool pushesBack(const Entry& entry, const geometry::SignedDistance& now);

}  // namespace deformable_surface::tool
