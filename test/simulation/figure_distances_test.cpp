// How far the figures of [Szeliski and Tonnesen 1991] that end as a known shape are from it. Apart from their scenes, whose `expect` knows
// the shape that the cloud began as.
#include "support/figures.h"

#include <algorithm>

namespace deformable_surface::test {
namespace {

using simulation::Simulation;

Simulation runParticles(const std::string& name) {
  const simulation::SceneParams scene = loadScene(name);
  Simulation s(scene, io::makeShape(scene.cloud));
  const long steps = std::lround(scene.duration / scene.integrator.time_step);
  for (long i = 0; i < steps; ++i) EXPECT_TRUE(s.step().ok);
  return s;
}

// Figure 9: particles at the ball's upper part lie on it, those under its middle leave it.
TEST(FigureDistances, TheStretchedSheetLiesOnTheBallThatWasPushedThroughIt) {
  const Simulation s = runParticles("particles_stretch");
  const tool::ToolParams& ball = s.params().tools.at(0);
  const Vec3 middle = ball.path.back().position;
  const double radius = ball.shape.radius, spacing = s.particles()->lattice().spacing;
  Index touching = 0;
  for (const Vec3& p : s.state().positions) {
    const double distance = (p - middle).norm() - radius;
    EXPECT_GT(distance, -0.05 * spacing);  // contact gives way by a little
    if (!(p.z() > middle.z() + 0.6 * radius)) continue;
    EXPECT_LT(std::abs(distance), 0.05 * spacing);
    ++touching;
  }
  EXPECT_GT(touching, 30);  // the cap of that height has 0.2 of the sphere's area: 73 lattice cells
}

// Figure 14: radii found by least squares along z = 0; the paper says of its own torus that it is not circularly symmetric.
TEST(FigureDistances, TheSphereThatBecameATorusIsNearARoundOne) {
  const Simulation s = runParticles("particles_torus");
  const Points& points = s.state().positions;
  const double n = static_cast<double>(points.size());
  const auto findTube = [](const Vec3& p, double ring) { return std::hypot(std::hypot(p.x(), p.y()) - ring, p.z()); };
  double least = HUGE_VAL, ring = 0.0, tube = 0.0;
  for (double r = 0.2; r < 0.5; r += 0.002) {
    double mean = 0.0, squares = 0.0;
    for (const Vec3& p : points) mean += findTube(p, r) / n;
    for (const Vec3& p : points) squares += (findTube(p, r) - mean) * (findTube(p, r) - mean);
    if (!(squares < least)) continue;
    least = squares;
    ring = r;
    tube = mean;
  }
  // The balls came to within 0.2 of the middle plane from either side; the whole was a sphere of radius 0.5.
  EXPECT_NEAR(ring, 0.37, 0.02);
  EXPECT_NEAR(tube, 0.23, 0.02);
  EXPECT_LT(std::sqrt(least / n), 0.2 * s.particles()->lattice().spacing);
}

}  // namespace
}  // namespace deformable_surface::test
