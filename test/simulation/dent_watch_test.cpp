// Dents between the points of a sphere whose buckling load and rate of growth are known in closed form.
#include "../../src/simulation/dent_watch.h"

#include "../support/surfaces.h"

#include <gtest/gtest.h>

namespace deformable_surface::test {
namespace {

using simulation::DentWatch;

constexpr double kPoisson = 0.3, kStretching = 1000.0, kThinness = 0.0025;  // -, N/m, sqrt(D / S) in m
constexpr double kMass = 0.5;  // kg/m^2

std::vector<model::WeightedTriangle> findTriangles(const Surface& surface) {
  std::vector<model::WeightedTriangle> triangles;
  for (const cloud::Triangle& t : surface.rings.triangles)
    triangles.push_back({{t.corner[0], t.corner[1], t.corner[2]}, t.weight});
  return triangles;
}

// A sphere of one metre's radius, thin enough for dents of three spacings.
struct Sphere {
  explicit Sphere(double damping = 0.0, double thinness = kThinness) : surface(makeSphere(1500, 1.0)) {
    model::MaterialParams m;
    m.thickness = 0.001;
    m.young_modulus = kStretching / m.thickness;
    m.density = kMass / m.thickness;
    m.poisson_ratio = kPoisson;
    m.damping = damping;
    m.bending_rigidity.is_auto = false;
    m.bending_rigidity.value = kStretching * thinness * thinness;
    watch = DentWatch(m, surface.points, findTriangles(surface), surface.area, 6000);
  }

  // Shrunk so that its compression is so many times the classical buckling load, 2 sqrt(S D) / R.
  Points loaded(double load) const {
    Points points = surface.points;
    for (Vec3& x : points) x *= 1.0 - load * 2.0 * kThinness * (1.0 - kPoisson);
    return points;
  }

  // Seconds until dents have grown; 0 if they do not within the given time.
  double findGrowth(double load, double longest, double step) {
    const Points points = loaded(load);
    for (int k = 1; k * step <= longest; ++k)
      if (watch.followStep(points, step)) return k * step;
    return 0.0;
  }

  Surface surface;
  DentWatch watch;
};

TEST(DentWatch, SeesAnEquilibriumWellBeyondTheClassicalLoad) {
  Sphere sphere;
  EXPECT_FALSE(sphere.watch.isOverloaded(sphere.surface.points));
  EXPECT_FALSE(sphere.watch.isOverloaded(sphere.loaded(1.45)));  // a tenth to either side for chords in place of arcs
  EXPECT_TRUE(sphere.watch.isOverloaded(sphere.loaded(1.75)));
  EXPECT_FALSE(sphere.watch.isOverloaded(sphere.loaded(-1.75)));
}

TEST(DentWatch, DentsGrowAtTheRateOfAShallowShellAndNotBelowTheClassicalLoad) {
  // rho s^2 = S (x^2 - 1) / R^2 at x times the load, until the growth is e^3.
  const double expected = 3.0 / std::sqrt(kStretching / kMass * (1.5 * 1.5 - 1.0));
  Sphere sphere;
  EXPECT_NEAR(sphere.findGrowth(1.5, 10.0 * expected, 0.01 * expected), expected, 0.1 * expected);
  sphere.watch.reset();
  EXPECT_EQ(sphere.findGrowth(0.9, 10.0 * expected, 0.01 * expected), 0.0);
  EXPECT_EQ(sphere.findGrowth(-1.5, 10.0 * expected, 0.01 * expected), 0.0);
}

TEST(DentWatch, DampingSlowsDentsAndRestMakesThemFade) {
  const double rate = std::sqrt(kStretching / kMass * (1.5 * 1.5 - 1.0)), damping = 2.0 * rate;
  // s^2 + c s = rate^2.
  const double expected = 3.0 / (rate * (std::sqrt(2.0) - 1.0));
  Sphere damped(damping);
  EXPECT_NEAR(damped.findGrowth(1.5, 10.0 * expected, 0.01 * expected), expected, 0.1 * expected);
  damped.watch.reset();
  for (int k = 0; k < 40; ++k) {
    EXPECT_EQ(damped.findGrowth(1.5, 0.5 * expected, 0.05 * expected), 0.0);
    EXPECT_EQ(damped.findGrowth(0.0, 3.0 / rate, 0.1 / rate), 0.0);
  }
}

TEST(DentWatch, GoesOnFromWhatItHadSeen) {
  Sphere whole, resumed;
  whole.watch.followStep(whole.loaded(1.5), 0.01);
  resumed.watch.setGrowth(whole.watch.growth());
  whole.watch.followStep(whole.loaded(1.2), 0.01);
  resumed.watch.followStep(whole.loaded(1.2), 0.01);
  EXPECT_EQ(resumed.watch.growth(), whole.watch.growth());
  EXPECT_GT(*std::max_element(whole.watch.growth().begin(), whole.watch.growth().end()), 0.0);
}

TEST(DentWatch, LeavesOutShellsWhoseDentsThePointsShow) {
  Sphere thick(0.0, 100.0 * kThinness);
  EXPECT_TRUE(thick.watch.growth().empty());
  EXPECT_FALSE(thick.watch.isOverloaded(thick.loaded(1000.0 * 0.1)));
  const Surface sheet = makeSheet(20, 20, 1.0, 1.0);
  const DentWatch flat(model::MaterialParams(), sheet.points, findTriangles(sheet), sheet.area, 1600);
  EXPECT_TRUE(flat.growth().empty());
}

}  // namespace
}  // namespace deformable_surface::test
