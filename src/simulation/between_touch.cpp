#include "between_touch.h"

#include <cmath>

namespace deformable_surface::simulation {
namespace {

// Factors on the radius of a cell, which is half of the spacing. Larger balls enter the surface between simulation points by no
// more than a hundredth of the spacing; heights below the second factor hardly count.
constexpr double kLargeBall = 40.0, kFlat = 0.02;

// Distances from the edges of a flat face, over the radius of a cell: nearer than the first all of its points touch, farther
// than the second only its simulation point.
constexpr double kNearEdge = 3.0, kFarFromEdge = 6.0;

// How far a place lies from the nearest edge of the face that it is nearest to, and the gradient. On the side of a cylinder,
// which is not flat, less than 0.
struct EdgeDistance {
  double value;
  Vec3 gradient;
};
EdgeDistance findEdgeDistance(const geometry::Solid& shape, const Vec3& place) {
  if (shape.kind == geometry::Solid::Kind::kCylinder) {
    const Vec3 aside(place.x(), place.y(), 0.0);
    // Less the depth below the cap: so nothing jumps where the side becomes nearer than the cap.
    const double beyond_rim = aside.norm() - shape.radius, above = std::abs(place.z()) - 0.5 * shape.height;
    return {above - beyond_rim, std::copysign(1.0, place.z()) * Vec3::UnitZ() - aside.stableNormalized()};
  }
  const Vec3 beyond = place.cwiseAbs() - 0.5 * shape.size;
  int face, side;
  beyond.maxCoeff(&face);
  side = face == 0 ? 1 : 0;
  for (int k = 0; k < 3; ++k)
    if (k != face && beyond[k] > beyond[side]) side = k;
  return {-beyond[side], std::copysign(1.0, -place[side]) * Vec3::Unit(side)};
}

}  // namespace

bool mayTouchBetween(const geometry::Solid& shape, const transfer::SampledPoints& between, Index cell) {
  if (between.begin(cell) == between.end(cell)) return false;
  const bool is_flat = shape.kind == geometry::Solid::Kind::kPlane ||
                       (shape.kind == geometry::Solid::Kind::kSphere && shape.radius > kLargeBall * between.extent(cell));
  return !is_flat || between.height(cell) > kFlat * between.extent(cell);
}

EdgeShare findEdgeShare(const geometry::Solid& shape, const tool::Pose& pose, const transfer::SampledPoints& between, Index cell,
                        const Points& positions) {
  const double extent = between.extent(cell);
  const bool has_faces = shape.kind == geometry::Solid::Kind::kBox || shape.kind == geometry::Solid::Kind::kCylinder;
  if (!has_faces || between.areLinear() || between.height(cell) > kFlat * extent) return {};
  const EdgeDistance distance = findEdgeDistance(shape, pose.orientation.conjugate() * (positions[cell] - pose.position));
  const double width = (kFarFromEdge - kNearEdge) * extent, t = (distance.value - kNearEdge * extent) / width;
  if (!(t > 0.0)) return {};
  if (!(t < 1.0)) return {0.0, Vec3::Zero()};
  const double slope = 6.0 * t * (1.0 - t) / width;
  return {1.0 - t * t * (3.0 - 2.0 * t), pose.orientation * (-slope * distance.gradient)};
}

}  // namespace deformable_surface::simulation
