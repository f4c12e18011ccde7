#include "deformable_surface/cloud/interior.h"

#include "deformable_surface/base/error.h"
#include "deformable_surface/base/parallel.h"
#include "deformable_surface/base/value.h"
#include "deformable_surface/cloud/kd_tree.h"

#include <cmath>

namespace deformable_surface::cloud {
namespace {

constexpr double kClear = 0.6;       // spacings that points inside keep from the surface: nearer ones would be slivers of cells
constexpr double kClearlyOff = 1.0;  // spacings from the surface at which the dipoles blur into it
constexpr double kNone = 0.25;       // from the nearer of zero and one: a winding number in between is neither
constexpr Index kBlock = 64;         // places a task
constexpr double kMostPlaces = 2e6;  // to be asked one by one: of a million surface points that is minutes

}  // namespace

SurfaceDipoles gatherDipoles(const Points& positions, const Points& normals, const std::vector<double>& areas,
                             const std::vector<Index>& owner, Index count) {
  SurfaceDipoles surface{Points(count, Vec3::Zero()), Points(count, Vec3::Zero())};
  std::vector<double> sum(count, 0.0);
  for (std::size_t i = 0; i < positions.size(); ++i) {
    if (owner[i] < 0) continue;
    surface.places[owner[i]] += areas[i] * positions[i];
    surface.areas[owner[i]] += areas[i] * normals[i];
    sum[owner[i]] += areas[i];
  }
  for (Index o = 0; o < count; ++o)
    if (sum[o] > 0.0) surface.places[o] /= sum[o];
  return surface;
}

double findWindingNumber(const SurfaceDipoles& surface, const Vec3& q) {
  double sum = 0.0;
  for (std::size_t i = 0; i < surface.places.size(); ++i) {
    const Vec3 d = surface.places[i] - q;
    const double square = d.squaredNorm();
    if (square > 0.0) sum += surface.areas[i].dot(d) / (square * std::sqrt(square));
  }
  return sum / (4.0 * kPi);
}

Interior fillSurface(const SurfaceDipoles& dipoles, const Points& surface, double spacing) {
  Vec3 low = surface[0], high = surface[0];
  for (const Vec3& p : surface) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  // As many places as fit, in the middle.
  const Eigen::Array3d across = ((high - low) / spacing).array().floor() + 1.0;
  if (!(across.prod() <= kMostPlaces))
    throw InputError("fill: found a surface whose box holds " +
                     (std::isfinite(across.prod()) ? formatShort(across.prod()) : "countless") + " places at a spacing of " +
                     formatShort(spacing) + " m; accepted: up to " + formatShort(kMostPlaces) +
                     "; ask for fewer simulation points");
  const Eigen::Array<Index, 3, 1> counts = across.cast<Index>();
  const Vec3 first = 0.5 * (low + high) - 0.5 * spacing * (counts.cast<double>() - 1.0).matrix();
  const auto placeAt = [&](Index k) {
    return Vec3(first + spacing * Vec3(k / (counts[1] * counts[2]), k / counts[2] % counts[1], k % counts[2]));
  };
  const Index places = counts.prod();
  std::vector<char> is_inside(places, 0), is_doubtful(places, 0);
  const KdTree tree(surface);
  parallelFor(places, kBlock, [&](Index begin, Index end) {
    std::vector<Neighbor> near;
    for (Index k = begin; k < end; ++k) {
      const Vec3 q = placeAt(k);
      tree.nearest(q, 1, near);
      const double distance = std::sqrt(near.front().squared_distance);
      if (!(distance > kClear * spacing)) continue;
      const double w = std::abs(findWindingNumber(dipoles, q));
      is_inside[k] = w > 0.5;
      is_doubtful[k] = distance > kClearlyOff * spacing && std::abs(w - 0.5) < 0.5 - kNone;
    }
  });
  Interior interior;
  double doubtful = 0.0, found = 0.0;
  for (Index k = 0; k < places; ++k) {
    if (is_inside[k]) interior.points.push_back(placeAt(k));
    doubtful += is_doubtful[k];
    found += is_inside[k] || is_doubtful[k];
  }
  interior.doubtful = found > 0.0 ? doubtful / found : 0.0;
  return interior;
}

}  // namespace deformable_surface::cloud
