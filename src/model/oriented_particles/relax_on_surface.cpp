#include "deformable_surface/model/oriented_particles/relax_on_surface.h"

#include "deformable_surface/base/parallel.h"
#include "deformable_surface/cloud/kept_neighbors.h"

#include <cmath>

namespace deformable_surface::model {
namespace {

constexpr Index kBlock = 64;
constexpr double kReach = 2.0;  // spacings: beyond, weights are below a seventh
constexpr double kSkin = 0.4;   // spacings: neighbours are found anew after moves of half of it; not tried otherwise
constexpr double kShare = 0.5;  // of the way to where a particle alone would end: all move at once

struct Step {
  Vec3 position, normal;
};

Step findStep(const std::vector<cloud::Neighbor>& near, const Points& positions, const Points& normals, double spacing, Index i) {
  const Vec3 &p = positions[i], &normal = normals[i];
  Vec3 push = Vec3::Zero(), mirrored = Vec3::Zero();
  double height = 0.0, total = 0.0;
  for (const cloud::Neighbor& q : near) {
    const Vec3 line = positions[q.index] - p, &other = normals[q.index], bisector = normal + other;
    const double distance = line.norm(), slope = bisector.dot(normal);
    if (!(distance > 0.0 && other.dot(normal) > 0.0)) continue;
    if (distance < spacing) push -= kShare * (spacing - distance) * line / distance;
    const double weight = std::exp(-q.squared_distance / (2.0 * spacing * spacing));
    height += weight * slope * bisector.dot(line);
    total += weight * slope * slope;
    mirrored += weight * (other - 2.0 * other.dot(line) / q.squared_distance * line);
  }
  if (!(total > 0.0)) return {p, normal};
  const Vec3 along = push - push.dot(normal) * normal;
  return {p + kShare * (along + height / total * normal), (normal + mirrored.normalized()).normalized()};
}

}  // namespace

void relaxOnSurface(double spacing, Index sweeps, const std::vector<char>& fixed, Points& positions, Orientations& orientations) {
  const Index n = static_cast<Index>(positions.size());
  Points normals(n), moved(n), turned(n);
  cloud::KeptNeighborhoods neighborhoods(kReach * spacing, kSkin * spacing);
  for (Index sweep = 0; sweep < sweeps; ++sweep) {
    neighborhoods.update(positions);
    for (Index i = 0; i < n; ++i) normals[i] = orientations[i] * Vec3::UnitZ();
    parallelFor(n, kBlock, [&](Index begin, Index end) {
      std::vector<cloud::Neighbor> near;
      for (Index i = begin; i < end; ++i) {
        Step step{positions[i], normals[i]};
        if (!fixed[i]) {
          neighborhoods.find(i, near);
          step = findStep(near, positions, normals, spacing, i);
        }
        moved[i] = step.position;
        turned[i] = step.normal;
      }
    });
    for (Index i = 0; i < n; ++i) {
      if (fixed[i]) continue;
      positions[i] = moved[i];
      orientations[i] = (Quaternion::FromTwoVectors(normals[i], turned[i]) * orientations[i]).normalized();
    }
  }
}

}  // namespace deformable_surface::model
