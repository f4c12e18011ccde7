#include "deformable_surface/geometry/solid.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace deformable_surface::geometry {
namespace {

SignedDistance fromSphere(double radius, const Vec3& p) {
  const double r = p.norm();
  return {r - radius, r > 0.0 ? Vec3(p / r) : Vec3(Vec3::UnitZ())};
}

SignedDistance fromBox(const Vec3& half, const Vec3& p) {
  const Vec3 beyond = p.cwiseAbs() - half;  // per axis; all negative inside
  const Vec3 sign(std::copysign(1.0, p.x()), std::copysign(1.0, p.y()), std::copysign(1.0, p.z()));
  if (beyond.maxCoeff() > 0.0) {
    const Vec3 out = beyond.cwiseMax(0.0);
    const double distance = out.norm();
    return {distance, out.cwiseProduct(sign) / distance};
  }
  int axis;
  const double depth = beyond.maxCoeff(&axis);
  return {depth, sign[axis] * Vec3::Unit(axis)};
}

// A solid of revolution whose half profile is convex: corners (n) of (r, z), counter-clockwise, beginning and ending on the axis.
template <int n>
SignedDistance fromProfile(const Vec2 (&corners)[n], const Vec3& p) {
  const double r = std::hypot(p.x(), p.y());
  const Vec3 radial = r > 0.0 ? Vec3(p.x() / r, p.y() / r, 0.0) : Vec3(Vec3::UnitX());
  const Vec2 q(r, p.z());
  double deepest = -std::numeric_limits<double>::infinity(), nearest = std::numeric_limits<double>::infinity();
  Vec2 face = Vec2::UnitX(), away = Vec2::Zero();
  for (int i = 0; i + 1 < n; ++i) {
    const Vec2 edge = corners[i + 1] - corners[i], out = Vec2(edge.y(), -edge.x()).normalized();
    const double height = out.dot(q - corners[i]);
    if (height > deepest) {
      deepest = height;
      face = out;
    }
    const double along = std::min(1.0, std::max(0.0, edge.dot(q - corners[i]) / edge.squaredNorm()));
    const Vec2 gap = q - (corners[i] + along * edge);
    if (gap.norm() < nearest) {
      nearest = gap.norm();
      away = gap;
    }
  }
  // Inside, or on the surface: along the nearest face. Outside: away from the nearest point.
  const bool outside = deepest > 0.0 && nearest > 0.0;
  const Vec2 normal = outside ? Vec2(away / nearest) : face;
  return {outside ? nearest : deepest, normal.x() * radial + normal.y() * Vec3::UnitZ()};
}

bool isSame(const Polyhedron* a, const Polyhedron* b) {
  return a == b || (a && b && a->vertices() == b->vertices() && a->triangles() == b->triangles());
}

}  // namespace

SignedDistance findSignedDistance(const Solid& solid, const Vec3& point, double limit) {
  const double r = solid.radius, h = 0.5 * solid.height;
  switch (solid.kind) {
    case Solid::Kind::kSphere: return fromSphere(r, point);
    case Solid::Kind::kBox: return fromBox(0.5 * solid.size, point);
    case Solid::Kind::kCylinder: return fromProfile<4>({Vec2(0.0, -h), Vec2(r, -h), Vec2(r, h), Vec2(0.0, h)}, point);
    case Solid::Kind::kCone: return fromProfile<3>({Vec2(0.0, -h), Vec2(r, -h), Vec2(0.0, h)}, point);
    case Solid::Kind::kMesh: {
      const double least = solid.mesh->boundDistance(point);
      return least > limit ? SignedDistance{least, Vec3::UnitZ()} : solid.mesh->findSignedDistance(point);
    }
    case Solid::Kind::kPlane: break;
  }
  const Vec3 normal = solid.normal.normalized();
  return {normal.dot(point) - solid.offset, normal};
}

bool isSame(const Solid& a, const Solid& b) {
  return a.kind == b.kind && a.radius == b.radius && a.height == b.height && a.size == b.size && a.normal == b.normal &&
         a.offset == b.offset && isSame(a.mesh.get(), b.mesh.get());
}

double findLargestExtent(const Solid& solid) {
  switch (solid.kind) {
    case Solid::Kind::kSphere: return 2.0 * solid.radius;
    case Solid::Kind::kBox: return solid.size.maxCoeff();
    case Solid::Kind::kCylinder:
    case Solid::Kind::kCone: return std::max(2.0 * solid.radius, solid.height);
    case Solid::Kind::kMesh: return (solid.mesh->high() - solid.mesh->low()).maxCoeff();
    case Solid::Kind::kPlane: break;
  }
  return std::numeric_limits<double>::infinity();
}

double findSmallestExtent(const Solid& solid) {
  switch (solid.kind) {
    case Solid::Kind::kSphere: return 2.0 * solid.radius;
    case Solid::Kind::kBox: return solid.size.minCoeff();
    case Solid::Kind::kCylinder:
    case Solid::Kind::kCone: return std::min(2.0 * solid.radius, solid.height);
    case Solid::Kind::kMesh: return (solid.mesh->high() - solid.mesh->low()).minCoeff();
    case Solid::Kind::kPlane: break;
  }
  return std::numeric_limits<double>::infinity();
}

}  // namespace deformable_surface::geometry
