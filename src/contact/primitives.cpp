#include "deformable_surface/contact/primitives.h"

#include "deformable_surface/base/simd.h"

#include <algorithm>
#include <limits>

namespace deformable_surface::contact {
namespace {

// Squared distances are compared with a limit that is larger by this share: more than rounding makes of them.
constexpr double kRounding = 1e-6;
constexpr Index kBall = 16;  // numbers of four balls

struct Lanes {
  Double4 x, y, z;
};

DEFORMABLE_SURFACE_INLINE void subtract(const Lanes& a, const Lanes& b, Lanes& to) {
  to.x = a.x - b.x;
  to.y = a.y - b.y;
  to.z = a.z - b.z;
}

DEFORMABLE_SURFACE_INLINE void dot(const Lanes& a, const Lanes& b, Double4& to) { to = a.x * b.x + a.y * b.y + a.z * b.z; }

DEFORMABLE_SURFACE_INLINE void cross(const Lanes& a, const Lanes& b, Lanes& to) {
  to.x = a.y * b.z - a.z * b.y;
  to.y = a.z * b.x - a.x * b.z;
  to.z = a.x * b.y - a.y * b.x;
}

// a / b between 0 and 1; 0 where b is not positive.
DEFORMABLE_SURFACE_INLINE void divide(const Double4& a, const Double4& b, Double4& to) {
  const Double4 zero{}, one = zero + 1.0;
  to = b > zero ? a / b : zero;
  to = to < zero ? zero : to;
  to = to > one ? one : to;
}

// Places of four points.
DEFORMABLE_SURFACE_INLINE void gather(const double* const (&from)[4], Index offset, Lanes& to) {
  Double4 rest;
  load(from[0] + offset, to.x);
  load(from[1] + offset, to.y);
  load(from[2] + offset, to.z);
  load(from[3] + offset, rest);
  transpose(to.x, to.y, to.z, rest);
}

// As findClosestOfEdges().
DEFORMABLE_SURFACE_INLINE void squareDistanceOfEdges(const double* const (&one)[4], const double* const (&other)[4],
                                                     Double4& to) {
  Lanes p, q, a, b, u, v, w;
  gather(one, 0, p);
  gather(one, 4, q);
  gather(other, 0, a);
  gather(other, 4, b);
  subtract(q, p, u);
  subtract(b, a, v);
  subtract(p, a, w);
  Double4 uu, vv, uv, uw, vw, s, t, begin, end;
  dot(u, u, uu);
  dot(v, v, vv);
  dot(u, v, uv);
  dot(u, w, uw);
  dot(v, w, vw);
  const Double4 zero{}, full = zero + 1.0;
  divide(uv * vw - vv * uw, uu * vv - uv * uv, s);
  t = vv > zero ? (uv * s + vw) / vv : zero;
  divide(-uw, uu, begin);
  divide(uv - uw, uu, end);
  s = t <= zero ? begin : s;
  s = t >= full ? end : s;
  t = t <= zero ? zero : t;
  t = t >= full ? full : t;
  const Double4 x = w.x + s * u.x - t * v.x, y = w.y + s * u.y - t * v.y, z = w.z + s * u.z - t * v.z;
  to = x * x + y * y + z * z;
}

// Of points and edges, both from the begin of the edge.
DEFORMABLE_SURFACE_INLINE void squareDistanceToEdge(const Lanes& point, const Lanes& edge, Double4& to) {
  Double4 along, square, share;
  dot(point, edge, along);
  dot(edge, edge, square);
  divide(along, square, share);
  const Double4 x = point.x - share * edge.x, y = point.y - share * edge.y, z = point.z - share * edge.z;
  to = x * x + y * y + z * z;
}

// The least of the distances to the edges and, above the triangle, to its plane.
DEFORMABLE_SURFACE_INLINE void squareDistanceToTriangle(const double* const (&one)[4], const double* const (&other)[4],
                                                        Double4& to) {
  Lanes p, a, b, c, ab, ac, bc, ap, bp, normal, across;
  gather(one, 0, p);
  gather(other, 0, a);
  gather(other, 4, b);
  gather(other, 8, c);
  subtract(b, a, ab);
  subtract(c, a, ac);
  subtract(c, b, bc);
  subtract(p, a, ap);
  subtract(p, b, bp);
  Double4 edge, square, of_b, of_c, height;
  squareDistanceToEdge(ap, ab, to);
  squareDistanceToEdge(ap, ac, edge);
  to = edge < to ? edge : to;
  squareDistanceToEdge(bp, bc, edge);
  to = edge < to ? edge : to;
  cross(ab, ac, normal);
  dot(normal, normal, square);
  cross(ap, ac, across);
  dot(across, normal, of_b);
  cross(ab, ap, across);
  dot(across, normal, of_c);
  dot(ap, normal, height);
  const Double4 zero{};
  const Double4 plane = height * height / square;
  const auto is_above = (of_b >= zero) & (of_c >= zero) & (of_b + of_c <= square) & (plane < to);
  to = is_above ? plane : to;
}

// Those of the balls that meet a box; also compacted, by coordinate and radius with `stride` numbers each. Returns their number.
DEFORMABLE_SURFACE_WIDE Index selectMeeting(Index num_blocks, const double* balls, const double* low, const double* high,
                                            Index stride, Index* chosen, double* chosen_balls) {
  Index num = 0;
  const Double4 zero{};
  for (Index block = 0; block < num_blocks; ++block, balls += kBall) {
    Double4 center, radius, squared = zero;
    for (int axis = 0; axis < 3; ++axis) {
      load(balls + 4 * axis, center);
      const Double4 below = low[axis] - center, above = center - high[axis];
      Double4 gap = below > above ? below : above;
      gap = gap < zero ? zero : gap;
      squared += gap * gap;
    }
    load(balls + 12, radius);
    const auto meets = squared <= radius * radius;
    for (Index k = 0; k < 4; ++k) {
      if (meets[k] == 0) continue;
      chosen[num] = 4 * block + k;
      for (Index part = 0; part < 4; ++part) chosen_balls[part * stride + num] = balls[4 * part + k];
      ++num;
    }
  }
  return num;
}

// Pairs of the first balls and the second ones, compacted as above, whose surfaces are nearer than reach.
DEFORMABLE_SURFACE_WIDE Index matchBalls(Index num, const Index* first, Index stride, const double* balls, Index num_second,
                                         const Index* second, Index second_stride, const double* second_balls, double reach,
                                         bool is_same, std::array<Index, 2>* matches) {
  Index found = 0;
  const Double4 zero{};
  for (Index i = 0; i < num; ++i) {
    const Double4 x = zero + balls[i], y = zero + balls[stride + i], z = zero + balls[2 * stride + i],
                  most = zero + (reach + balls[3 * stride + i]);
    for (Index j = is_same ? (i + 1) / 4 * 4 : 0; j < num_second; j += 4) {
      Double4 u, v, w, radius;
      load(second_balls + j, u);
      load(second_balls + second_stride + j, v);
      load(second_balls + 2 * second_stride + j, w);
      load(second_balls + 3 * second_stride + j, radius);
      u -= x;
      v -= y;
      w -= z;
      radius += most;
      const auto is_near = u * u + v * v + w * w < radius * radius;
      if ((is_near[0] | is_near[1] | is_near[2] | is_near[3]) == 0) continue;
      for (Index k = 0; k < 4; ++k) {
        if (is_near[k] == 0 || j + k >= num_second || (is_same && j + k <= i)) continue;
        matches[found++] = {first[i], second[j + k]};
      }
    }
  }
  return found;
}

// Drops the pairs that are not nearer than a squared distance. Returns the number of the others.
template <int kCorners, int kOtherCorners>
DEFORMABLE_SURFACE_INLINE Index keep(Index num, const double* places, const double* other_places, double squared,
                                     std::array<Index, 2>* matches) {
  Index kept = 0;
  for (Index begin = 0; begin < num; begin += 4) {
    const double *one[4], *other[4];
    std::array<Index, 2> four[4];
    for (Index k = 0; k < 4; ++k) {
      four[k] = matches[std::min(begin + k, num - 1)];
      one[k] = places + 4 * kCorners * four[k][0];
      other[k] = other_places + 4 * kOtherCorners * four[k][1];
    }
    Double4 distance;
    if constexpr (kCorners == 2)
      squareDistanceOfEdges(one, other, distance);
    else
      squareDistanceToTriangle(one, other, distance);
    for (Index k = 0; k < std::min<Index>(4, num - begin); ++k)
      if (!(distance[k] >= squared)) matches[kept++] = four[k];
  }
  return kept;
}

DEFORMABLE_SURFACE_WIDE Index keepNearEdges(Index num, const double* places, const double* other_places, double squared,
                                            std::array<Index, 2>* matches) {
  return keep<2, 2>(num, places, other_places, squared, matches);
}

DEFORMABLE_SURFACE_WIDE Index keepNearTriangles(Index num, const double* places, const double* other_places, double squared,
                                                std::array<Index, 2>* matches) {
  return keep<1, 3>(num, places, other_places, squared, matches);
}

// Centres and radii of four primitives, whose corners follow each other.
DEFORMABLE_SURFACE_WIDE void enclose(Index num_blocks, int num_corners, const double* places, double* balls) {
  for (Index block = 0; block < num_blocks; ++block, balls += kBall) {
    const Index size = 4 * num_corners;
    const double* const from[4] = {places + 4 * block * size, places + (4 * block + 1) * size, places + (4 * block + 2) * size,
                                   places + (4 * block + 3) * size};
    Lanes corners[3], middle{}, arm;
    for (int k = 0; k < num_corners; ++k) {
      gather(from, 4 * k, corners[k]);
      middle.x += corners[k].x;
      middle.y += corners[k].y;
      middle.z += corners[k].z;
    }
    const double share = 1.0 / num_corners;
    middle.x *= share;
    middle.y *= share;
    middle.z *= share;
    Double4 radius{};
    for (int k = 0; num_corners > 1 && k < num_corners; ++k) {
      Double4 squared;
      subtract(corners[k], middle, arm);
      dot(arm, arm, squared);
      radius = squared > radius ? squared : radius;
    }
    takeRoots(radius);
    store(middle.x, balls);
    store(middle.y, balls + 4);
    store(middle.z, balls + 8);
    store(radius, balls + 12);
  }
}

}  // namespace

void Primitives::end() {
  const Index blocks = (size() + 3) / 4;
  balls_.resize(blocks * kBall);
  if (size() % 4 != 0)
    std::fill_n(&places_[4 * num_corners_ * size()], 4 * num_corners_ * (4 * blocks - size()),
                std::numeric_limits<double>::quiet_NaN());
  enclose(blocks, num_corners_, places_.data(), balls_.data());
}

// Returns their number.
Index Primitives::selectNear(const Box& box, std::vector<Index>& chosen, std::vector<double>& balls) const {
  const std::size_t most = balls_.size() / 4;  // a multiple of four
  if (chosen.size() < most) chosen.resize(most);
  if (balls.size() < 4 * most) balls.resize(4 * most);
  return selectMeeting(static_cast<Index>(balls_.size()) / kBall, balls_.data(), box.min().data(), box.max().data(),
                       static_cast<Index>(most), chosen.data(), balls.data());
}

// Returns their number.
Index Primitives::match(const Box& near, const Primitives& other, const Box& near_other, double reach, Scratch& scratch) const {
  auto& [first, second, first_balls, second_balls, matches] = scratch;
  const Index num_second = other.selectNear(near, second, second_balls);
  if (num_second == 0) return 0;
  const Index num_first = selectNear(near_other, first, first_balls);
  const std::size_t most = static_cast<std::size_t>(num_first) * num_second;
  if (matches.size() < most) matches.resize(most);
  const Index num =
      matchBalls(num_first, first.data(), static_cast<Index>(balls_.size()) / 4, first_balls.data(), num_second, second.data(),
                 static_cast<Index>(other.balls_.size()) / 4, second_balls.data(), reach, &other == this, matches.data());
  const double squared = (1.0 + kRounding) * reach * reach;
  return num_corners_ == 2 ? keepNearEdges(num, places_.data(), other.places_.data(), squared, matches.data())
                           : keepNearTriangles(num, places_.data(), other.places_.data(), squared, matches.data());
}

}  // namespace deformable_surface::contact
