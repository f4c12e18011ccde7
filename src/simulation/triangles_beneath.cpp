#include "triangles_beneath.h"

#include "overlaps.h"

namespace deformable_surface::simulation {
namespace {

using contact::Triangle;

constexpr double kBeneath = 0.1;  // of the longest edge: how far a place may be above or below a triangle of the surface
constexpr double kBeside = 0.01;  // of the longest edge: how far it may be beside one

}  // namespace

TrianglesBeneath::TrianglesBeneath(const Points& rest, const std::vector<Triangle>& triangles)
    : rest_(rest), triangles_(triangles), tree_(listBoxes(rest, triangles)) {}

bool TrianglesBeneath::find(const Triangle& t, const Vec3& place, Triangle& beneath) const {
  const Vec3 normal = findNormal(rest_, t).normalized();
  const double longest = findLongestEdge(rest_, t), reach = kBeneath * longest;
  double least = reach * reach;
  bool is_found = false;
  tree_.visitMeeting({place - Vec3::Constant(reach), place + Vec3::Constant(reach)}, [&](Index k) {
    const Triangle& under = triangles_[k];
    const Vec3 gap = contact::findClosestToTriangle(place, rest_[under[0]], rest_[under[1]], rest_[under[2]]).gap;
    if (!(gap.squaredNorm() < least) || !(normal.dot(findNormal(rest_, under)) > 0.0)) return;
    if ((gap - gap.dot(normal) * normal).norm() > kBeside * longest) return;
    least = gap.squaredNorm();
    beneath = under;
    is_found = true;
  });
  return is_found;
}

std::array<Vec3, 4> listPlaces(const Points& rest, const Triangle& t) {
  const Vec3 middle = (rest[t[0]] + rest[t[1]] + rest[t[2]]) / 3.0;
  return {middle, 0.5 * (middle + rest[t[0]]), 0.5 * (middle + rest[t[1]]), 0.5 * (middle + rest[t[2]])};
}

}  // namespace deformable_surface::simulation
