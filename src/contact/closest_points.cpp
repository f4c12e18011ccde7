#include "deformable_surface/contact/closest_points.h"

#include <algorithm>

namespace deformable_surface::contact {
namespace {

constexpr double kFlat = 1e-12;  // squared area of a degenerate triangle, as a fraction of the squares of two edges

double divide(double a, double b) { return b > 0.0 ? std::clamp(a / b, 0.0, 1.0) : 0.0; }

Closest onTriangle(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c, double wb, double wc) {
  const double wa = 1.0 - wb - wc;
  return {p - (wa * a + wb * b + wc * c), {1.0, -wa, -wb, -wc}};
}

// In a degenerate triangle, rounding would decide the region of the point.
Closest findClosestToLine(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c) {
  const auto projectOn = [&](const Vec3& from, const Vec3& edge) { return divide(edge.dot(p - from), edge.squaredNorm()); };
  const double on_ab = projectOn(a, b - a), on_ac = projectOn(a, c - a), on_bc = projectOn(b, c - b);
  const std::array<Closest, 3> edges{onTriangle(p, a, b, c, on_ab, 0.0), onTriangle(p, a, b, c, 0.0, on_ac),
                                     onTriangle(p, a, b, c, 1.0 - on_bc, on_bc)};
  return *std::min_element(edges.begin(), edges.end(), [](const Closest& one, const Closest& other) {
    return one.squaredDistance() < other.squaredDistance();
  });
}

}  // namespace

// By the Voronoi region of the point [Ericson 2005, sec. 5.1.5].
Closest findClosestToTriangle(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c) {
  const Vec3 ab = b - a, ac = c - a;
  if (ab.cross(ac).squaredNorm() <= kFlat * ab.squaredNorm() * ac.squaredNorm()) return findClosestToLine(p, a, b, c);
  const double ab_a = ab.dot(p - a), ac_a = ac.dot(p - a);
  if (ab_a <= 0.0 && ac_a <= 0.0) return onTriangle(p, a, b, c, 0.0, 0.0);
  const double ab_b = ab.dot(p - b), ac_b = ac.dot(p - b);
  if (ab_b >= 0.0 && ac_b <= ab_b) return onTriangle(p, a, b, c, 1.0, 0.0);
  const double vc = ab_a * ac_b - ab_b * ac_a;
  if (vc <= 0.0 && ab_a >= 0.0 && ab_b <= 0.0) return onTriangle(p, a, b, c, divide(ab_a, ab_a - ab_b), 0.0);
  const double ab_c = ab.dot(p - c), ac_c = ac.dot(p - c);
  if (ac_c >= 0.0 && ab_c <= ac_c) return onTriangle(p, a, b, c, 0.0, 1.0);
  const double vb = ab_c * ac_a - ab_a * ac_c;
  if (vb <= 0.0 && ac_a >= 0.0 && ac_c <= 0.0) return onTriangle(p, a, b, c, 0.0, divide(ac_a, ac_a - ac_c));
  const double va = ab_b * ac_c - ab_c * ac_b;
  if (va <= 0.0 && ac_b - ab_b >= 0.0 && ab_c - ac_c >= 0.0) {
    const double w = divide(ac_b - ab_b, (ac_b - ab_b) + (ab_c - ac_c));
    return onTriangle(p, a, b, c, 1.0 - w, w);
  }
  const double sum = va + vb + vc;
  return onTriangle(p, a, b, c, vb / sum, vc / sum);
}

// [Ericson 2005, sec. 5.1.9].
Closest findClosestOfEdges(const Vec3& p, const Vec3& q, const Vec3& a, const Vec3& b) {
  const Vec3 u = q - p, v = b - a, w = p - a;
  const double uu = u.squaredNorm(), vv = v.squaredNorm(), uv = u.dot(v), uw = u.dot(w), vw = v.dot(w);
  double s = divide(uv * vw - vv * uw, uu * vv - uv * uv), t = vv > 0.0 ? (uv * s + vw) / vv : 0.0;
  if (t <= 0.0) {
    t = 0.0;
    s = divide(-uw, uu);
  } else if (t >= 1.0) {
    t = 1.0;
    s = divide(uv - uw, uu);
  }
  return {w + s * u - t * v, {1.0 - s, s, t - 1.0, -t}};
}

bool pierces(const Vec3& p, const Vec3& q, const Vec3& a, const Vec3& b, const Vec3& c) {
  const Vec3 normal = (b - a).cross(c - a), along = q - p;
  const double from = normal.dot(p - a), to = normal.dot(q - a);
  if (!(from * to < 0.0)) return false;
  const double u = along.dot((b - p).cross(c - p)), v = along.dot((c - p).cross(a - p)), w = along.dot((a - p).cross(b - p));
  return (u > 0.0 && v > 0.0 && w > 0.0) || (u < 0.0 && v < 0.0 && w < 0.0);
}

}  // namespace deformable_surface::contact
