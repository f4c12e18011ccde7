// Largest distance of a tool's surface from its origin, its width, and points of its axis. Contact skips points beyond the
// distance, and sleeping points within it wake. Narrow tools pass between points.
#pragma once

#include "deformable_surface/tool/tool.h"

#include <array>
#include <cstddef>

namespace deformable_surface::simulation {

/// Between the frame of a tool at a pose and the world, m.
inline Vec3 toWorld(const tool::Pose& pose, const Vec3& place) { return pose.position + pose.orientation * place; }
inline Vec3 toTool(const tool::Pose& pose, const Vec3& point) { return pose.orientation.conjugate() * (point - pose.position); }

/// Radius (m) of a ball about the tool's origin that holds its shape; infinite for a plane.
double findRadius(const geometry::Solid& shape);

/// The width (m) of what passes through a surface with the longest extent ahead: the second of the three extents.
double findWidth(const geometry::Solid& shape);

struct AxisPoints {
  std::array<Vec3, 8> places;
  std::size_t count;

  std::size_t size() const { return count; }
  const Vec3* begin() const { return places.data(); }
  const Vec3* end() const { return places.data() + count; }
  const Vec3& operator[](std::size_t k) const { return places[k]; }
};

/// Points of the tool's axis, m, in its frame, that tell whether it has gone through a surface: the origin and, where the shape
/// is longer than wide, one towards either end, as deep as half its width (of a wide cone: at a quarter of its height from either
/// end). Of a mesh, points in the body (Polyhedron::axisPoints()): its origin may be anywhere.
AxisPoints listAxisPoints(const geometry::Solid& shape);

/// Places near the edges of a flat tool, m, and the normal of its plane, all in one frame.
struct EdgePlaces {
  AxisPoints places;
  Vec3 across;
};

/// Of a box or a cylinder that is flat and thinner than the spacing (m) of a surface's points: eight places around its middle,
/// one and a half spacings inside its edges. Surfaces that lie on it are cut by the edges less deep than that. Of other tools
/// none.
EdgePlaces listEdgePlaces(const geometry::Solid& shape, double spacing);

/// Whether any of the points (n x 3) is within that ball at a time (s) at which the tool acts; for tools that attract, within
/// tool.reach of the ball.
bool isInReach(const tool::ToolParams& tool, double time, const Points& points);

}  // namespace deformable_surface::simulation
