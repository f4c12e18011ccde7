#include "deformable_surface/tool/crossing.h"

#include <cmath>

namespace deformable_surface::tool {
namespace {

using geometry::SignedDistance;
using geometry::Solid;

constexpr double kSameSide = 0.5;  // cosine between normals that push to the same side
constexpr int kMaxTraces =
    200;                       // steps: a path at five degrees to the surface has then come to a hundred-millionth of its length
constexpr double kMet = 1e-9;  // fraction of the path: a distance that counts as zero
constexpr double kGrazed = 1e-3;  // fraction of the path: if as near after all steps, the path runs along the surface

}  // namespace

std::optional<Entry> findEntry(const Solid& solid, const Vec3& from, const Vec3& to) {
  const double length = (to - from).norm();
  if (!(length > 0.0)) return std::nullopt;
  const Vec3 along = (to - from) / length;
  double way = 0.0, nearest = length;
  for (int k = 0; k < kMaxTraces; ++k) {
    const Vec3 place = from + way * along;
    const SignedDistance d = geometry::findSignedDistance(solid, place, length - way);
    if (d.distance <= kMet * length) return Entry{place, d.normal};
    way += d.distance;
    nearest = d.distance;
    if (way > length) return std::nullopt;
  }
  if (nearest > kGrazed * length) return std::nullopt;
  const Vec3 place = from + way * along;
  return Entry{place, geometry::findSignedDistance(solid, place).normal};
}

bool pushesBack(const Entry& entry, const SignedDistance& now) {
  return now.distance < 0.0 && now.normal.dot(entry.normal) > kSameSide;
}

bool isHeldUp(const Solid& solid, const Entry& entry, const Vec3& point, const SignedDistance& now) {
  const double height = entry.heightOf(point);
  if (!(height < 0.0)) return false;
  return now.distance <= 0.0 || findEntry(solid, point, point - height * entry.normal).has_value();
}

bool isBeside(const Solid& solid, const Entry& entry, const Vec3& point, const SignedDistance& now) {
  return entry.heightOf(point) < 0.0 && !isHeldUp(solid, entry, point, now);
}

std::optional<Entry> findCrossing(const Solid& solid, const Vec3& from, const Vec3& to) {
  if (solid.kind == Solid::Kind::kPlane) return std::nullopt;  // a plane has no other side
  const double length = (to - from).norm();
  const SignedDistance before = geometry::findSignedDistance(solid, from, length);
  if (before.distance > length) return std::nullopt;
  const std::optional<Entry> entry =
      before.distance > 0.0 ? findEntry(solid, from, to) : Entry{from - before.distance * before.normal, before.normal};
  if (!entry) return std::nullopt;
  const SignedDistance after = geometry::findSignedDistance(solid, to);
  if (pushesBack(*entry, after) || !isHeldUp(solid, *entry, to, after)) return std::nullopt;
  return entry;
}

}  // namespace deformable_surface::tool
