// A relaxation for the tests of growth, which needs no forces: particles push each other apart to the spacing, move along their
// normals to where they are co-circular with their neighbours, and turn to the normals that mirror theirs.
#pragma once

#include "deformable_surface/cloud/kd_tree.h"
#include "deformable_surface/model/oriented_particles/grow_surface.h"

namespace deformable_surface::model {

inline Relaxation makeRelaxation(double spacing, int sweeps) {
  return [=](Points& positions, Orientations& orientations, const std::vector<char>& fixed) {
    const Index n = static_cast<Index>(positions.size());
    const auto normalOf = [&](Index i) -> Vec3 { return orientations[i] * Vec3::UnitZ(); };
    for (int sweep = 0; sweep < sweeps; ++sweep) {
      const cloud::KdTree tree(positions);
      Points moves(n, Vec3::Zero()), normals(n);
      std::vector<cloud::Neighbor> near;
      for (Index i = 0; i < n; ++i) {
        const Vec3 normal = normalOf(i);
        normals[i] = normal;
        if (fixed[i]) continue;
        tree.withinRadius(positions[i], 2.0 * spacing, near);
        Vec3 push = Vec3::Zero(), mirrored = Vec3::Zero();
        double height = 0.0, total = 0.0;
        for (const cloud::Neighbor& q : near) {
          const Vec3 line = positions[q.index] - positions[i], other = normalOf(q.index), bisector = normal + other;
          const double distance = line.norm(), slope = bisector.dot(normal);
          if (!(distance > 0.0 && other.dot(normal) > 0.0)) continue;
          if (distance < spacing) push -= 0.5 * (spacing - distance) * line / distance;
          const double weight = std::exp(-q.squared_distance / (2.0 * spacing * spacing));
          height += weight * slope * bisector.dot(line);
          total += weight * slope * slope;
          mirrored += weight * (other - 2.0 * other.dot(line) / q.squared_distance * line);
        }
        if (!(total > 0.0)) continue;
        moves[i] = 0.5 * (push - push.dot(normal) * normal) + 0.5 * height / total * normal;
        normals[i] = (normal + mirrored.normalized()).normalized();
      }
      for (Index i = 0; i < n; ++i) {
        if (fixed[i]) continue;
        positions[i] += moves[i];
        orientations[i] = (Eigen::Quaterniond::FromTwoVectors(normalOf(i), normals[i]) * orientations[i]).normalized();
      }
    }
  };
}

inline void relaxNothing(Points&, Orientations&, const std::vector<char>&) {}

/// Orientations with these normals.
inline Orientations orientTo(const Points& normals) {
  Orientations orientations;
  for (const Vec3& n : normals) orientations.push_back(Eigen::Quaterniond::FromTwoVectors(Vec3::UnitZ(), n));
  return orientations;
}

}  // namespace deformable_surface::model
