#include "deformable_surface/contact/chart.h"

#include "deformable_surface/base/parallel.h"
#include "deformable_surface/base/simd.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace deformable_surface::contact {
namespace {

using Triangle = std::array<Index, 3>;

constexpr double kFar = std::numeric_limits<double>::infinity();
constexpr double kMostTolerance = 0.2;  // of the median edge: more is not asked for, as few proofs have as much
constexpr Index kBlock = 512;           // triangles per task

// Twice the signed area between a and b, two sides that change linearly. It is quadratic in time: not below the least of its
// coefficients over the polynomials of Bernstein.
double leastArea(double a_u, double a_v, double b_u, double b_v, double a_u_end, double a_v_end, double b_u_end, double b_v_end) {
  const double first = a_u * b_v - a_v * b_u, last = a_u_end * b_v_end - a_v_end * b_u_end;
  const double middle = 0.5 * ((a_u * b_v_end - a_v * b_u_end) + (a_u_end * b_v - a_v_end * b_u));
  return std::min({first, middle, last});
}

double largestSquare(double u, double v, double u_end, double v_end) {
  return std::max(u * u + v * v, u_end * u_end + v_end * v_end);
}

// The least rooms of four triangles at a time. size: a multiple of four. See roomOf().
DEFORMABLE_SURFACE_WIDE void findRooms(Index size, const Triangle* triangles, const double* flat, double distance, double most,
                                       double& uncrossed, double& apart) {
  Double4 least{kFar, kFar, kFar, kFar}, least_apart = least;
  for (Index t = 0; t < size; t += 4) {
    Double4 p[4], q[4], r[4];  // of four triangles; then u, v, u_end, v_end
    for (int k = 0; k < 4; ++k) {
      load(flat + 4 * triangles[t + k][0], p[k]);
      load(flat + 4 * triangles[t + k][1], q[k]);
      load(flat + 4 * triangles[t + k][2], r[k]);
      q[k] -= p[k];
      r[k] -= p[k];
    }
    transpose(q[0], q[1], q[2], q[3]);
    transpose(r[0], r[1], r[2], r[3]);
    const Double4 first = q[0] * r[1] - q[1] * r[0], last = q[2] * r[3] - q[3] * r[2];
    const Double4 middle = 0.5 * ((q[0] * r[3] - q[1] * r[2]) + (q[2] * r[1] - q[3] * r[0]));
    Double4 twice = first < last ? first : last;
    twice = middle < twice ? middle : twice;
    Double4 longest{};
    for (int end = 0; end < 4; end += 2) {
      const Double4 u = r[end] - q[end], v = r[end + 1] - q[end + 1];
      const Double4 a = q[end] * q[end] + q[end + 1] * q[end + 1], b = r[end] * r[end] + r[end + 1] * r[end + 1],
                    c = u * u + v * v;
      longest = a > longest ? a : longest;
      longest = b > longest ? b : longest;
      longest = c > longest ? c : longest;
    }
    takeRoots(longest);
    const Double4 change = 4.0 * (longest + most);
    const Double4 room = twice / change, room_apart = (twice - distance * longest) / (change + 2.0 * distance);
    least = room >= least ? least : room;
    least_apart = room_apart >= least_apart ? least_apart : room_apart;
  }
  uncrossed = apart = kFar;
  for (int k = 0; k < 4; ++k) {
    uncrossed = least[k] >= uncrossed ? uncrossed : least[k];
    apart = least_apart[k] >= apart ? apart : least_apart[k];
  }
}

}  // namespace

void Chart::Room::restrict(const Room& other) {
  uncrossed = uncrossed <= other.uncrossed ? uncrossed : other.uncrossed;
  apart = apart <= other.apart ? apart : other.apart;
}

// Each point within d of its prediction changes an area by at most 2 d (|a| + |b|) + 4 d^2, a length by at most 2 d.
// length: the longest that the altitude may have as its base; arms: the sum of those of the sides.
Chart::Room Chart::roomOf(double twice_area, double length, double arms) const {
  const double most = kMostTolerance * outlines_.edge;
  return {twice_area / (2.0 * arms + 4.0 * most),
          (twice_area - distance_ * length) / (2.0 * arms + 4.0 * most + 2.0 * distance_)};
}

// The normal of the surface's mean, half-way through the motion: by the theorem of Stokes it follows from the boundary.
Vec3 Chart::findDirection(const Outlines::Part& part, const Outlines::Part& next, const Points& positions,
                          const Points& motion) const {
  Vec3 sum = Vec3::Zero();
  for (Index l = part.first_loop; l < next.first_loop; ++l) {
    const Index first = outlines_.loops[l].first, end = outlines_.loops[l + 1].first;
    const auto place = [&](Index k) -> Vec3 {
      return positions[outlines_.loop_points[k]] + 0.5 * motion[outlines_.loop_points[k]];
    };
    const Vec3 origin = place(first);
    Vec3 p = place(end - 1) - origin;
    for (Index k = first; k < end; ++k) {
      const Vec3 q = place(k) - origin;
      sum += p.cross(q);
      p = q;
    }
  }
  return sum.normalized();
}

void Chart::project(const Outlines::Part& part, const Outlines::Part& next, const Vec3& direction, const Points& positions,
                    const Points& motion, std::vector<Flat>& flat) const {
  const Vec3 across = direction.unitOrthogonal(), other = direction.cross(across);
  const Vec3 origin = positions[outlines_.points[part.first_point]];
  parallelFor(next.first_point - part.first_point, kBlock, [&](Index begin, Index end) {
    for (Index k = part.first_point + begin; k < part.first_point + end; ++k) {
      const Index i = outlines_.points[k];
      const Vec3 place = positions[i] - origin;
      const double u = across.dot(place), v = other.dot(place);
      flat[i] = {u, v, u + across.dot(motion[i]), v + other.dot(motion[i])};
    }
  });
}

Chart::Room Chart::checkTriangles(Index begin, Index end, const std::vector<Flat>& flat) const {
  Room room{kFar, kFar};
  const double* const coordinates = &flat.data()->u;
  const double most = kMostTolerance * outlines_.edge;
  const Index whole = (end - begin) / 4 * 4;
  findRooms(whole, &outlines_.triangles[begin], coordinates, distance_, most, room.uncrossed, room.apart);
  if (begin + whole == end) return room;
  std::array<Triangle, 4> others;
  others.fill(outlines_.triangles[end - 1]);
  std::copy(outlines_.triangles.begin() + begin + whole, outlines_.triangles.begin() + end, others.begin());
  Room other{kFar, kFar};
  findRooms(4, others.data(), coordinates, distance_, most, other.uncrossed, other.apart);
  room.restrict(other);
  return room;
}

Chart::Room Chart::checkLoop(const Outlines::Loop& loop, Index end, const std::vector<Flat>& flat) const {
  Flat middle{0.0, 0.0, 0.0, 0.0};
  for (Index k = loop.first; k < end; ++k) {
    const Flat& p = flat[outlines_.loop_points[k]];
    middle = {middle.u + p.u, middle.v + p.v, middle.u_end + p.u_end, middle.v_end + p.v_end};
  }
  double share = 1.0 / static_cast<double>(end - loop.first);
  const double sense = loop.is_hole ? -1.0 : 1.0;
  if (loop.middle >= 0) {
    middle = flat[loop.middle];
    share = 1.0;
  }
  const auto arm = [&](Index k) -> Flat {
    const Flat& p = flat[outlines_.loop_points[k]];
    return {p.u - share * middle.u, p.v - share * middle.v, p.u_end - share * middle.u_end, p.v_end - share * middle.v_end};
  };
  const auto lengthOf = [](const Flat& p) { return std::sqrt(largestSquare(p.u, p.v, p.u_end, p.v_end)); };
  Room room{kFar, kFar};
  Index changes = 0;  // of the side on which the arm lies: two for each turn
  Flat p = arm(end - 1);
  double p_length = lengthOf(p);
  for (Index k = loop.first; k < end; ++k) {
    const Flat q = arm(k);
    const double q_length = lengthOf(q);
    const double twice = sense > 0.0 ? leastArea(p.u, p.v, q.u, q.v, p.u_end, p.v_end, q.u_end, q.v_end)
                                     : leastArea(q.u, q.v, p.u, p.v, q.u_end, q.v_end, p.u_end, p.v_end);
    // A point in the middle must also stay away from the edge, which is no longer than both arms.
    const double base = loop.middle >= 0 ? p_length + q_length : std::max(p_length, q_length);
    room.restrict(roomOf(twice, base, p_length + q_length));
    if ((p.v < 0.0) != (q.v < 0.0)) ++changes;
    p = q;
    p_length = q_length;
  }
  return changes == 2 ? room : Room{-1.0, -1.0};
}

Chart::Room Chart::checkParts(const Points& positions, const Points& motion, std::vector<Box>& boxes) const {
  const std::size_t num = outlines_.numParts();
  boxes.resize(num);
  for (std::size_t p = 0; p < num; ++p) {
    boxes[p].setEmpty();
    for (Index k = outlines_.parts[p].first_point; k < outlines_.parts[p + 1].first_point; ++k) {
      boxes[p].extend(positions[outlines_.points[k]]);
      boxes[p].extend(positions[outlines_.points[k]] + motion[outlines_.points[k]]);
    }
  }
  Room room{kFar, kFar};
  for (std::size_t p = 0; p < num; ++p)
    for (std::size_t q = p + 1; q < num; ++q) {
      const double gap = (boxes[q].min() - boxes[p].max()).cwiseMax(boxes[p].min() - boxes[q].max()).maxCoeff();
      room.restrict({0.5 * gap, 0.5 * (gap - distance_)});
    }
  return room;
}

Chart::Room Chart::findRoom(const Points& positions, const Points& motion, Scratch& scratch) const {
  Room room{kMostTolerance * outlines_.edge, kMostTolerance * outlines_.edge};
  std::vector<Flat>& flat = scratch.flat;
  if (flat.size() < positions.size()) flat.resize(positions.size());
  scratch.rooms.resize(std::max(scratch.rooms.size(), outlines_.triangles.size() / kBlock + 1));
  if (outlines_.numParts() > 1) room.restrict(checkParts(positions, motion, scratch.boxes));
  for (Index p = 0; p < outlines_.numParts() && room.isLeft(); ++p) {
    const Outlines::Part &part = outlines_.parts[p], &next = outlines_.parts[p + 1];
    project(part, next, findDirection(part, next, positions, motion), positions, motion, flat);
    for (Index l = part.first_loop; l < next.first_loop && room.isLeft(); ++l)
      room.restrict(checkLoop(outlines_.loops[l], outlines_.loops[l + 1].first, flat));
    if (!room.isLeft()) break;
    parallelFor(next.first_triangle - part.first_triangle, kBlock, [&](Index begin, Index end) {
      scratch.rooms[begin / kBlock] = checkTriangles(part.first_triangle + begin, part.first_triangle + end, flat);
    });
    const Index num_blocks = (next.first_triangle - part.first_triangle - 1) / kBlock + 1;
    for (Index b = 0; b < num_blocks; ++b) room.restrict(scratch.rooms[b]);
  }
  return room;
}

}  // namespace deformable_surface::contact
