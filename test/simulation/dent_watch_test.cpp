// Dents between the points of a sphere whose buckling load and rate of growth are known in closed form.
#include "../../src/simulation/dent_watch.h"

#include "../support/surfaces.h"

#include <gtest/gtest.h>

#include <cmath>

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

TEST(DentWatch, HasNoLoadOfShellsWhoseDentsThePointsShow) {
  Sphere thick(0.0, 100.0 * kThinness);
  EXPECT_FALSE(thick.watch.isOverloaded(thick.loaded(1000.0 * 0.1)));
}

// A square of 400 points that is pushed together along x.
TEST(DentWatch, SeesFoldsOfAFlatSheetThatGrowFarUnlessTheyAreAllPoints) {
  const Surface sheet = makeSheet(20, 20, 1.0, 1.0);
  const double shortening = 0.01,
               force = kStretching * (shortening - 0.5 * shortening * shortening) / (1.0 - kPoisson * kPoisson);
  const double k = 2.0 * 3.14159265358979 / 0.14;  // 1/m: between four spacings of the points and four of 1600 points
  model::MaterialParams m;
  m.thickness = 0.001;
  m.young_modulus = kStretching / m.thickness;
  m.density = kMass / m.thickness;
  m.poisson_ratio = kPoisson;
  m.bending_rigidity.is_auto = false;
  m.bending_rigidity.value = force / (2.0 * k * k);  // so that this wave grows fastest
  const double rate = k * std::sqrt(0.5 * force / kMass);
  Points pushed = sheet.points;
  for (Vec3& x : pushed) x.x() *= 1.0 - shortening;
  const double step = 1e-3;
  const auto findGrowth = [&](Index num_full) {
    DentWatch watch(m, sheet.points, findTriangles(sheet), sheet.area, num_full);
    for (int i = 1; i <= 200; ++i)
      if (watch.followStep(pushed, step)) return i * step;
    return 0.0;
  };
  EXPECT_NEAR(findGrowth(1600), 10.0 / rate, 1.5 * step);  // by a factor of e^10, to the step
  EXPECT_EQ(findGrowth(400), 0.0);
  m.bending_rigidity.value *= 100.0;  // too stiff for folds so short
  EXPECT_EQ(findGrowth(1600), 0.0);
}

TEST(DentWatch, SeesAForceThatPressesAPatchInAsPressureWould) {
  const Sphere sphere;
  const double classical = 4.0 * kStretching * kThinness, radius = 0.2;  // N/m^2; m
  const double force = classical * 3.14159 * radius * radius;
  const std::vector<Index> loaded{0, 1, 2};
  EXPECT_FALSE(sphere.watch.isPushed(loaded, 0.1 * force, radius));
  EXPECT_TRUE(sphere.watch.isPushed(loaded, 0.8 * force, radius));
  EXPECT_FALSE(sphere.watch.isPushed(loaded, 0.8 * force, 4.0 * radius));
  EXPECT_TRUE(sphere.watch.isPushed(loaded, 0.1 * force, 0.0));  // on a point, whose part of the full cloud is small
}

TEST(DentWatch, LeavesForcesOnAThickSphereToThePointsWhichShowItsDents) {
  const Sphere sphere(0.0, 0.05);
  EXPECT_FALSE(sphere.watch.isPushed({0, 1, 2}, 1e3, 0.2));
}

}  // namespace
}  // namespace deformable_surface::test
