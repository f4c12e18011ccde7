// The scenes for run time against error: bodies, durations, and numbers of simulation points.
#pragma once

#include "deformable_surface/simulation/simulation.h"

#include <functional>
#include <string>
#include <vector>

namespace deformable_surface::benchmark {

struct AccuracyScene {
  std::string name;
  simulation::SceneParams params;  // the default settings, except for what the scene needs
  cloud::PointCloud cloud;
  double duration;            // s; 0 = the equilibrium
  std::vector<Index> levels;  // numbers of simulation points, falling; without a closed form the full cloud first
  /// The closed form: the place of a point by its place at rest, m. Empty: the reference is the full cloud in fine steps.
  std::function<Vec3(const Vec3& rest)> exact;
};

/// large: the sizes of docs/benchmark.md; otherwise about a third of them. The scan is skipped if its file is missing.
std::vector<AccuracyScene> makeAccuracyScenes(bool large);

/// Sheets of rubber at rest under their weight: between two held edges and hanging from one, soft to stiff. large: 1254 points,
/// else 400.
std::vector<AccuracyScene> makeStaticScenes(bool large);

/// The scene with another number of simulation points; the full cloud where that is all of them.
simulation::SceneParams atLevel(const AccuracyScene& scene, Index num_points);

}  // namespace deformable_surface::benchmark
