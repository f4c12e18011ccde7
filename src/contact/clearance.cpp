#include "deformable_surface/contact/clearance.h"

#include "deformable_surface/base/parallel.h"
#include "deformable_surface/base/simd.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <limits>
#include <utility>

namespace deformable_surface::contact {
namespace {

constexpr double kFar = std::numeric_limits<double>::infinity();
// Of the median edge: more tolerance is not asked for, as few proofs have as much; less would be used up within a sub-step.
constexpr double kMostTolerance = 0.2, kLeastTolerance = 0.002;
constexpr int kSpares = 4;             // motions held at once where no snapshots are: by the step, its beginning, its part
constexpr Index kBlock = 512;          // triangles per task
constexpr Index kNumberBlock = 16384;  // coordinates per task

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

// A prediction, and how near coordinates must be to it.
struct Near {
  const double *from, *way;
  double share, tolerance;
};

using Flags = decltype(Double4{} < Double4{});

DEFORMABLE_SURFACE_INLINE void dropFar(const Near& near, const Double4& at, const Double4& from, const Double4& way, Flags& all) {
  const Double4 aside = at - (from + near.share * way);
  all &= (aside <= near.tolerance) & (aside >= -near.tolerance);
}

bool isNear(const Near& near, Index k, double at) {
  return std::abs(at - (near.from[k] + near.share * near.way[k])) <= near.tolerance;
}

// Whether no coordinate is farther than the tolerance from the prediction, nor undefined.
DEFORMABLE_SURFACE_WIDE bool areNear(const Near& near, Index begin, Index end, const double* x) {
  Flags all{-1, -1, -1, -1};
  Index k = begin;
  for (; k + 4 <= end; k += 4) {
    Double4 at, from, way;
    load(x + k, at);
    load(near.from + k, from);
    load(near.way + k, way);
    dropFar(near, at, from, way, all);
  }
  bool is_near = (all[0] & all[1] & all[2] & all[3]) != 0;
  for (; k < end; ++k) is_near = is_near && isNear(near, k, x[k]);
  return is_near;
}

// The same for coordinates x now and x + time v later.
DEFORMABLE_SURFACE_WIDE bool areNear(const Near& now, const Near& later, double time, Index begin, Index end, const double* x,
                                     const double* v) {
  Flags all{-1, -1, -1, -1};
  Index k = begin;
  for (; k + 4 <= end; k += 4) {
    Double4 at, speed, from, way;
    load(x + k, at);
    load(v + k, speed);
    load(now.from + k, from);
    load(now.way + k, way);
    dropFar(now, at, from, way, all);
    dropFar(later, at + time * speed, from, way, all);
  }
  bool is_near = (all[0] & all[1] & all[2] & all[3]) != 0;
  for (; k < end; ++k) is_near = is_near && isNear(now, k, x[k]) && isNear(later, k, x[k] + time * v[k]);
  return is_near;
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

void Clearance::Room::restrict(const Room& other) {
  uncrossed = uncrossed <= other.uncrossed ? uncrossed : other.uncrossed;
  apart = apart <= other.apart ? apart : other.apart;
}

Clearance::Clearance(const Points& rest, const std::vector<Triangle>& triangles, double distance)
    : distance_(distance), outlines_(findOutlines(rest, triangles)) {
  if (outlines_.numParts() == 0) return;
  flat_.resize(rest.size());
  rooms_.resize((outlines_.triangles.size() - 1) / kBlock + 1);
  boxes_.resize(outlines_.numParts());
  for (int k = 0; k < kSpares; ++k) {
    spares_.push_back(std::make_shared<ClearMotion>());
    spares_.back()->from.reserve(rest.size());
    spares_.back()->way.reserve(rest.size());
  }
}

// Each point within d of its prediction changes an area by at most 2 d (|a| + |b|) + 4 d^2, a length by at most 2 d.
// length: the longest that the altitude may have as its base; arms: the sum of those of the sides.
Clearance::Room Clearance::roomOf(double twice_area, double length, double arms) const {
  const double most = kMostTolerance * outlines_.edge;
  return {twice_area / (2.0 * arms + 4.0 * most),
          (twice_area - distance_ * length) / (2.0 * arms + 4.0 * most + 2.0 * distance_)};
}

// The normal of the surface's mean, half-way through the motion: by the theorem of Stokes it follows from the boundary.
Vec3 Clearance::findDirection(const Outlines::Part& part, const Outlines::Part& next, const Points& positions,
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

void Clearance::project(const Outlines::Part& part, const Outlines::Part& next, const Vec3& direction, const Points& positions,
                        const Points& motion) {
  const Vec3 across = direction.unitOrthogonal(), other = direction.cross(across);
  const Vec3 origin = positions[outlines_.points[part.first_point]];
  parallelFor(next.first_point - part.first_point, kBlock, [&](Index begin, Index end) {
    for (Index k = part.first_point + begin; k < part.first_point + end; ++k) {
      const Index i = outlines_.points[k];
      const Vec3 place = positions[i] - origin;
      const double u = across.dot(place), v = other.dot(place);
      flat_[i] = {u, v, u + across.dot(motion[i]), v + other.dot(motion[i])};
    }
  });
}

Clearance::Room Clearance::checkTriangles(Index begin, Index end) const {
  Room room{kFar, kFar};
  const double* const flat = &flat_.data()->u;
  const double most = kMostTolerance * outlines_.edge;
  const Index whole = (end - begin) / 4 * 4;
  findRooms(whole, &outlines_.triangles[begin], flat, distance_, most, room.uncrossed, room.apart);
  if (begin + whole == end) return room;
  std::array<Triangle, 4> others;
  others.fill(outlines_.triangles[end - 1]);
  std::copy(outlines_.triangles.begin() + begin + whole, outlines_.triangles.begin() + end, others.begin());
  Room other{kFar, kFar};
  findRooms(4, others.data(), flat, distance_, most, other.uncrossed, other.apart);
  room.restrict(other);
  return room;
}

Clearance::Room Clearance::checkLoop(const Outlines::Loop& loop, Index end) const {
  Flat middle{0.0, 0.0, 0.0, 0.0};
  for (Index k = loop.first; k < end; ++k) {
    const Flat& p = flat_[outlines_.loop_points[k]];
    middle = {middle.u + p.u, middle.v + p.v, middle.u_end + p.u_end, middle.v_end + p.v_end};
  }
  double share = 1.0 / static_cast<double>(end - loop.first);
  const double sense = loop.is_hole ? -1.0 : 1.0;
  if (loop.middle >= 0) {
    middle = flat_[loop.middle];
    share = 1.0;
  }
  const auto arm = [&](Index k) -> Flat {
    const Flat& p = flat_[outlines_.loop_points[k]];
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

Clearance::Room Clearance::checkParts(const Points& positions, const Points& motion) {
  const std::size_t num = boxes_.size();
  for (std::size_t p = 0; p < num; ++p) {
    boxes_[p].setEmpty();
    for (Index k = outlines_.parts[p].first_point; k < outlines_.parts[p + 1].first_point; ++k) {
      boxes_[p].extend(positions[outlines_.points[k]]);
      boxes_[p].extend(positions[outlines_.points[k]] + motion[outlines_.points[k]]);
    }
  }
  Room room{kFar, kFar};
  for (std::size_t p = 0; p < num; ++p)
    for (std::size_t q = p + 1; q < num; ++q) {
      const double gap = (boxes_[q].min() - boxes_[p].max()).cwiseMax(boxes_[p].min() - boxes_[q].max()).maxCoeff();
      room.restrict({0.5 * gap, 0.5 * (gap - distance_)});
    }
  return room;
}

Clearance::Room Clearance::findRoom(const Points& positions, const Points& motion) {
  Room room{kMostTolerance * outlines_.edge, kMostTolerance * outlines_.edge};
  if (outlines_.numParts() > 1) room.restrict(checkParts(positions, motion));
  for (Index p = 0; p < outlines_.numParts() && room.isLeft(); ++p) {
    const Outlines::Part &part = outlines_.parts[p], &next = outlines_.parts[p + 1];
    project(part, next, findDirection(part, next, positions, motion), positions, motion);
    for (Index l = part.first_loop; l < next.first_loop && room.isLeft(); ++l)
      room.restrict(checkLoop(outlines_.loops[l], outlines_.loops[l + 1].first));
    if (!room.isLeft()) break;
    parallelFor(next.first_triangle - part.first_triangle, kBlock, [&](Index begin, Index end) {
      rooms_[begin / kBlock] = checkTriangles(part.first_triangle + begin, part.first_triangle + end);
    });
    const Index num_blocks = (next.first_triangle - part.first_triangle - 1) / kBlock + 1;
    for (Index b = 0; b < num_blocks; ++b) room.restrict(rooms_[b]);
  }
  return room;
}

// Allocates only while more motions are held elsewhere than ever before, as in snapshots.
std::shared_ptr<ClearMotion> Clearance::takeSpare() {
  for (const std::shared_ptr<ClearMotion>& spare : spares_)
    if (spare.use_count() == 1) {
      std::atomic_thread_fence(std::memory_order_acquire);  // the last other holder may have been on another thread
      return spare;
    }
  return spares_.emplace_back(std::make_shared<ClearMotion>());
}

bool Clearance::prove(const Points& positions, const Points& velocities, double time) {
  forget();
  if (outlines_.numParts() == 0) return false;
  const std::shared_ptr<ClearMotion> motion = takeSpare();
  Points& way = motion->way;
  way.resize(positions.size());
  Index leader = 0;
  for (std::size_t i = 0; i < way.size(); ++i) {
    way[i] = time * velocities[i];
    if (way[i].squaredNorm() > way[leader].squaredNorm()) leader = static_cast<Index>(i);
  }
  const Room room = findRoom(positions, way);
  if (!(room.uncrossed > kLeastTolerance * outlines_.edge)) return false;
  motion->from = positions;
  motion->leader = leader;
  motion->tolerance = room.uncrossed / std::sqrt(3.0);
  motion->apart_tolerance = room.apart > kLeastTolerance * outlines_.edge ? room.apart / std::sqrt(3.0) : -1.0;
  proven_ = motion;
  // Undefined numbers, which comparisons pass over, are never near.
  if (!isNear(positions, motion->tolerance)) forget();
  return proven_ != nullptr;
}

double ClearMotion::shareAt(const Vec3& of_leader) const {
  const double squared = way[leader].squaredNorm();
  return squared > 0.0 ? std::clamp((of_leader - from[leader]).dot(way[leader]) / squared, 0.0, 1.0) : 0.0;
}

bool Clearance::isNear(const Points& positions, double tolerance) const {
  const Near near{proven_->from.data()->data(), proven_->way.data()->data(), proven_->shareAt(positions[proven_->leader]),
                  tolerance};
  return parallelMax(3 * static_cast<Index>(positions.size()), kNumberBlock, [&](Index begin, Index end) {
           return areNear(near, begin, end, positions.data()->data()) ? 0.0 : 1.0;
         }) == 0.0;
}

bool Clearance::staysApart(const Points& positions, const Points& velocities, double time) const {
  if (!isApart()) return false;
  const Index i = proven_->leader;
  Near now{proven_->from.data()->data(), proven_->way.data()->data(), proven_->shareAt(positions[i]), proven_->apart_tolerance};
  Near later = now;
  later.share = proven_->shareAt(positions[i] + time * velocities[i]);
  return parallelMax(3 * static_cast<Index>(positions.size()), kNumberBlock, [&](Index begin, Index end) {
           return areNear(now, later, time, begin, end, positions.data()->data(), velocities.data()->data()) ? 0.0 : 1.0;
         }) == 0.0;
}

}  // namespace deformable_surface::contact
