#include "deformable_surface/contact/clear_motion.h"

#include "deformable_surface/base/parallel.h"
#include "deformable_surface/base/simd.h"

#include <algorithm>
#include <array>
#include <limits>

namespace deformable_surface::contact {
namespace {

constexpr Index kLanes = 12;    // coordinates of four points
constexpr Index kBlock = 3072;  // coordinates per task: a few microseconds of work
constexpr Index kTasks = 16;    // at most

// Of the coordinates of points, minus those predicted: least and largest, by axis in turn.
struct Aside {
  std::array<double, kLanes> least, largest;
  double undefined = 0.0;  // not zero if any coordinate is undefined

  Aside() {
    least.fill(std::numeric_limits<double>::infinity());
    largest.fill(-std::numeric_limits<double>::infinity());
  }
};

// Extends the range by x + time v, for coordinates x now, of size coordinates, a multiple of kLanes. v: null for none.
DEFORMABLE_SURFACE_WIDE void boundAside(Index size, const double* x, const double* v, double time, const double* from,
                                        const double* way, double share, double* least, double* largest, double* undefined) {
  Double4 least_of[3], largest_of[3], lost{};
  for (Index k = 0; k < 3; ++k) {
    load(least + 4 * k, least_of[k]);
    load(largest + 4 * k, largest_of[k]);
  }
  for (Index i = 0; i < size; i += kLanes)
    for (Index k = 0; k < 3; ++k) {
      Double4 at, begin, motion;
      load(x + i + 4 * k, at);
      load(from + i + 4 * k, begin);
      load(way + i + 4 * k, motion);
      if (v) {
        Double4 speed;
        load(v + i + 4 * k, speed);
        at += time * speed;
      }
      const Double4 aside = at - (begin + share * motion);
      least_of[k] = aside < least_of[k] ? aside : least_of[k];
      largest_of[k] = aside > largest_of[k] ? aside : largest_of[k];
      lost += aside - aside;
    }
  for (Index k = 0; k < 3; ++k) {
    store(least_of[k], least + 4 * k);
    store(largest_of[k], largest + 4 * k);
  }
  *undefined += lost[0] + lost[1] + lost[2] + lost[3];
}

// By axis, m: how far the coordinates range beside the prediction. Infinite if any is undefined.
Vec3 findRange(const Points& positions, const Points* velocities, double time, const ClearMotion& motion, double share) {
  const Index size = 3 * static_cast<Index>(positions.size()), whole = size - size % kLanes;
  const double *x = positions.data()->data(), *v = velocities ? velocities->data()->data() : nullptr,
               *from = motion.from.data()->data(), *way = motion.way.data()->data();
  // Extremes do not depend on how the coordinates are divided.
  const Index block = std::max(kBlock, (whole / kLanes + kTasks - 1) / kTasks * kLanes);
  std::array<Aside, kTasks> ranges;
  parallelFor(whole, block, [&](Index begin, Index end) {
    Aside& part = ranges[begin / block];
    boundAside(end - begin, x + begin, v ? v + begin : nullptr, time, from + begin, way + begin, share, part.least.data(),
               part.largest.data(), &part.undefined);
  });
  Aside range = ranges[0];
  for (const Aside& part : ranges)
    for (Index k = 0; k < kLanes; ++k) {
      range.least[k] = std::min(range.least[k], part.least[k]);
      range.largest[k] = std::max(range.largest[k], part.largest[k]);
    }
  range.undefined = 0.0;
  for (const Aside& part : ranges) range.undefined += part.undefined;
  for (Index i = whole; i < size; ++i) {
    const double aside = x[i] + (v ? time * v[i] : 0.0) - (from[i] + share * way[i]);
    range.least[i - whole] = std::min(range.least[i - whole], aside);
    range.largest[i - whole] = std::max(range.largest[i - whole], aside);
    range.undefined += aside - aside;
  }
  if (range.undefined != 0.0) return Vec3::Constant(std::numeric_limits<double>::infinity());
  Vec3 by_axis;
  for (Index axis = 0; axis < 3; ++axis) {
    for (Index k = axis + 3; k < kLanes; k += 3) {
      range.least[axis] = std::min(range.least[axis], range.least[k]);
      range.largest[axis] = std::max(range.largest[axis], range.largest[k]);
    }
    by_axis[axis] = range.largest[axis] - range.least[axis];
  }
  return by_axis;
}

bool isWithin(const Points& positions, const Points* velocities, double time, const ClearMotion& motion, double share,
              double tolerance) {
  return (findRange(positions, velocities, time, motion, share).array() <= 2.0 * tolerance).all();
}

}  // namespace

void ClearMotion::predict(const Points& positions, const Points& velocities, double time) {
  from = positions;
  way.resize(positions.size());
  leader = 0;
  for (std::size_t i = 0; i < way.size(); ++i) {
    way[i] = time * velocities[i];
    if (way[i].squaredNorm() > way[leader].squaredNorm()) leader = static_cast<Index>(i);
  }
}

void ClearMotion::rest(const Points& positions) {
  from = positions;
  way.assign(positions.size(), Vec3::Zero());
  leader = 0;
}

double ClearMotion::shareAt(const Vec3& of_leader) const {
  const double squared = way[leader].squaredNorm();
  return squared > 0.0 ? std::clamp((of_leader - from[leader]).dot(way[leader]) / squared, 0.0, 1.0) : 0.0;
}

bool ClearMotion::isNear(const Points& positions, double tolerance) const {
  return isWithin(positions, nullptr, 0.0, *this, shareAt(positions[leader]), tolerance);
}

double ClearMotion::boundAside(const Points& positions) const {
  return findRange(positions, nullptr, 0.0, *this, shareAt(positions[leader])).norm();
}

bool ClearMotion::isNear(const Points& positions, const Points& velocities, double time, double tolerance) const {
  const double later = shareAt(positions[leader] + time * velocities[leader]);
  return isNear(positions, tolerance) && isWithin(positions, &velocities, time, *this, later, tolerance);
}

}  // namespace deformable_surface::contact
