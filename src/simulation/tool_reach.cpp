#include "tool_reach.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace deformable_surface::simulation {
namespace {

constexpr double kInside = 1.5;  // spacings, from the edges of flat tools

}  // namespace

double findRadius(const geometry::Solid& shape) {
  using Kind = geometry::Solid::Kind;
  switch (shape.kind) {
    case Kind::kSphere: return shape.radius;
    case Kind::kBox: return 0.5 * shape.size.norm();
    case Kind::kCylinder:
    case Kind::kCone: return std::hypot(shape.radius, 0.5 * shape.height);
    case Kind::kMesh:
      if (shape.mesh) return shape.mesh->radius();
      break;
    case Kind::kPlane: break;
  }
  return std::numeric_limits<double>::infinity();
}

double findWidth(const geometry::Solid& shape) {
  Vec3 extents = Vec3::Constant(2.0 * shape.radius);
  if (shape.kind == geometry::Solid::Kind::kBox) extents = shape.size;
  if (shape.kind == geometry::Solid::Kind::kMesh) extents = shape.mesh->high() - shape.mesh->low();
  std::sort(extents.data(), extents.data() + 3);
  return extents[1];
}

AxisPoints listAxisPoints(const geometry::Solid& shape) {
  using Kind = geometry::Solid::Kind;
  if (shape.kind == Kind::kMesh) {
    const Points& places = shape.mesh->axisPoints();
    AxisPoints axis{{}, places.size()};
    std::copy(places.begin(), places.end(), axis.places.begin());
    return axis;
  }
  Vec3 end = Vec3::Zero();
  if (shape.kind == Kind::kCylinder) end.z() = 0.5 * shape.height - shape.radius;
  if (shape.kind == Kind::kCone) end.z() = std::max(0.25 * shape.height, 0.5 * shape.height - shape.radius);
  if (shape.kind == Kind::kBox) {
    Eigen::Index longest;
    const double length = shape.size.maxCoeff(&longest);
    end[longest] = 0.5 * (length - findWidth(shape));
  }
  const Vec3 origin = Vec3::Zero();
  return {{origin, end, -end}, end.maxCoeff() > 0.0 ? std::size_t{3} : std::size_t{1}};
}

EdgePlaces listEdgePlaces(const geometry::Solid& shape, double spacing) {
  using Kind = geometry::Solid::Kind;
  EdgePlaces edges{{{}, 0}, Vec3::Zero()};
  const bool is_cylinder = shape.kind == Kind::kCylinder;
  if (!is_cylinder && shape.kind != Kind::kBox) return edges;
  const Vec3 size = is_cylinder ? Vec3(2.0 * shape.radius, 2.0 * shape.radius, shape.height) : shape.size;
  Eigen::Index thinnest;
  if (!(size.minCoeff(&thinnest) < spacing)) return edges;
  Vec3 along = 0.5 * size - Vec3::Constant(kInside * spacing);
  along[thinnest] = 0.0;
  const Eigen::Index first = (thinnest + 1) % 3, second = (thinnest + 2) % 3;
  if (!(along[first] > 0.0 && along[second] > 0.0)) return edges;
  edges.across[thinnest] = 1.0;
  for (const int a : {-1, 0, 1})
    for (const int b : {-1, 0, 1}) {
      if (a == 0 && b == 0) continue;
      Vec3 place = Vec3::Zero();
      place[first] = a * along[first];
      place[second] = b * along[second];
      if (is_cylinder && a != 0 && b != 0) place *= std::sqrt(0.5);
      edges.places.places[edges.places.count++] = place;
    }
  return edges;
}

bool isInReach(const tool::ToolParams& tool, double time, const Points& points) {
  if (!tool::isActive(tool, time)) return false;
  const double reach = findRadius(tool.shape) + (tool.mode == tool::Mode::kAttract ? tool.reach : 0.0);
  const Vec3 origin = tool::interpolate(tool.path, time).position;
  return std::any_of(points.begin(), points.end(), [&](const Vec3& p) { return !((p - origin).squaredNorm() > reach * reach); });
}

}  // namespace deformable_surface::simulation
