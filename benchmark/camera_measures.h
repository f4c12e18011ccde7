// Measurements on a frame of a depth camera against its truth: neighbours, pieces, normals, and the motion of a surface made from
// it compared with one made from the same pixels without noise.
#pragma once

#include "../test/support/camera_scenes.h"
#include "deformable_surface/simulation/rest_surface.h"
#include "measure.h"

#include <string>
#include <vector>

namespace deformable_surface::benchmark {

struct Neighborhoods {
  OrAuto<double> geodesic_exponent, noise;
};

/// A cloud after set-up, with the time of the set-up.
struct SetUp {
  simulation::RestSurface rest;
  double cpu = 0.0;           // s
  std::vector<Index> pieces;  // points of each that the lists connect, of at least kPiecePoints, largest first
  Index parts = 0;            // of the simulation points, that links connect
  Index corners = 0;          // of the boundary
  Index numSimulated() const { return static_cast<Index>(rest.points.size()); }
};
constexpr Index kPiecePoints = 100;
constexpr Index kTargetPoints = 1500;  // simulation points asked for

SetUp setUp(const cloud::PointCloud& cloud, const Neighborhoods& how);

/// Entries of lists, by the truth of the pixels; of pixels that fly none.
struct PairCounts {
  Index across = 0;      // a gap of the true surface
  Index refused = 0;     // true neighbours among the candidates that are not in the lists
  Index candidates = 0;  // true neighbours among them
  Index missed = 0;      // true neighbours among the eight pixels that are truly nearest that are not in the lists
  Index nearest = 0;     // true neighbours among those eight
};
/// Candidates are the nearest where the rule looks for them, as many as it lists. In a large frame (RestSurface::leader) those of
/// every second pixel of every second row; each other pixel counts as one pair, with the pixel that it follows, refused if there
/// is none.
PairCounts countPairs(const test::CameraFrame& frame, const SetUp& made);

/// Degrees, root mean square of the angle to the true normal, whichever side it points to; of pixels that fly none.
double findNormalError(const test::CameraFrame& frame, const SetUp& made);

/// Motion of the visible pixels where the scene is held and pulled, by the static solver.
class PullTest {
 public:
  /// Finds the force that moves the noise-free surface by a centimetre.
  PullTest(const test::CameraScene& scene, const test::CameraFrame& frame);
  /// Root mean square of the difference to the motion of the noise-free surface, over its largest motion; or the reason why there
  /// is none.
  std::string compare(const Neighborhoods& how) const;

 private:
  Points move(const cloud::PointCloud& cloud, const Neighborhoods& how, double force) const;

  const test::CameraScene& scene_;
  const test::CameraFrame& frame_;
  double force_ = 0.0, largest_ = 0.0;  // N, m
  Points moved_;                        // (pixels) m, of the noise-free surface
};

}  // namespace deformable_surface::benchmark
