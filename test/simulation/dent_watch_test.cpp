// Dents between the points of a sphere, whose buckling load and growth rate are known in closed form.
#include "../../src/simulation/dent_watch.h"

#include "../support/surfaces.h"

#include <gtest/gtest.h>

#include <cmath>

namespace deformable_surface::test {
namespace {

using simulation::Buckling;
using simulation::DentWatch;

constexpr double kPoisson = 0.3, kStretching = 1000.0, kThinness = 0.0025;  // -, N/m, sqrt(D / S) in m
constexpr double kMass = 0.5;                                               // kg/m^2

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

  // Shrunk so that its compression is the given multiple of the classical buckling load, 2 sqrt(S D) / R.
  Points loaded(double load) const {
    Points points = surface.points;
    for (Vec3& x : points) x *= 1.0 - load * 2.0 * kThinness * (1.0 - kPoisson);
    return points;
  }

  // Seconds until dents have grown; 0 if they do not within the given time.
  double findGrowth(double load, double longest, double step) {
    const Points points = loaded(load);
    for (int k = 1; k * step <= longest; ++k)
      if (watch.followStep(points, step) == Buckling::kLikely) return k * step;
    return 0.0;
  }

  Surface surface;
  DentWatch watch;
};

TEST(DentWatch, SeesAnEquilibriumWellBeyondTheClassicalLoad) {
  Sphere sphere;
  // Within a tenth, because chords replace arcs.
  for (const auto& [load, expected] : {std::pair(0.0, Buckling::kUnlikely),
                                       {0.36, Buckling::kUnlikely},
                                       {0.44, Buckling::kPossible},
                                       {1.45, Buckling::kPossible},
                                       {1.75, Buckling::kLikely},
                                       {-1.75, Buckling::kUnlikely}})
    EXPECT_EQ(sphere.watch.judgeEquilibrium(sphere.loaded(load)), expected) << load;
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

TEST(DentWatch, NeverHoldsDentsForLikelyThatThePointsShow) {
  // Ten times as thick, with dents of ten spacings. Short dents begin at twelve times the load of the thin sphere.
  Sphere thick(0.0, 10.0 * kThinness);
  EXPECT_EQ(thick.watch.judgeEquilibrium(thick.loaded(2.0)), Buckling::kUnlikely);
  EXPECT_EQ(thick.watch.judgeEquilibrium(thick.loaded(10.0)), Buckling::kPossible);
  EXPECT_EQ(thick.watch.judgeEquilibrium(thick.loaded(50.0)), Buckling::kPossible);
}

// A square of 400 points that is pushed together along x.
TEST(DentWatch, SeesFoldsOfAFlatSheetThatGrowUnlessTheyAreAllPoints) {
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
  const auto findGrowth = [&](Index num_full, Buckling buckling) {
    DentWatch watch(m, sheet.points, findTriangles(sheet), sheet.area, num_full);
    for (int i = 1; i <= 200; ++i)
      if (watch.followStep(pushed, step) >= buckling) return i * step;
    return 0.0;
  };
  EXPECT_NEAR(findGrowth(1600, Buckling::kLikely), 10.0 / rate, 1.5 * step);  // by a factor of e^10, to the step
  EXPECT_NEAR(findGrowth(1600, Buckling::kPossible), std::log(50.0) / rate, 1.5 * step);
  EXPECT_EQ(findGrowth(400, Buckling::kPossible), 0.0);
  m.bending_rigidity.value *= 100.0;  // too stiff for folds so short
  EXPECT_EQ(findGrowth(1600, Buckling::kPossible), 0.0);
}

// Folded along a row of points, by an angle that both cells beside it share.
TEST(DentWatch, SeesFoldsSharperThanARadianFromPointToPoint) {
  const Surface sheet = makeSheet(21, 21, 1.0, 1.0);
  model::MaterialParams m;
  m.bending_rigidity = 1.0;  // so stiff that nothing grows
  DentWatch watch(m, sheet.points, findTriangles(sheet), sheet.area, 1600);
  const auto folded = [&](double angle) {
    Points points = sheet.points;
    for (Vec3& x : points)
      if (x.x() > 0.5) x = Vec3(0.5 + (x.x() - 0.5) * std::cos(angle), x.y(), (x.x() - 0.5) * std::sin(angle));
    return points;
  };
  // The normal on the fold is half way between those of both sides.
  for (const auto& [angle, expected] :
       {std::pair(0.0, Buckling::kUnlikely), {1.8, Buckling::kUnlikely}, {2.2, Buckling::kPossible}}) {
    EXPECT_EQ(watch.judgeEquilibrium(folded(angle)), expected) << angle;
    EXPECT_EQ(watch.followStep(folded(angle), 1e-6), expected) << angle;
  }
}

TEST(DentWatch, SeesAForceThatPressesAPatchInAsPressureWould) {
  const Sphere sphere;
  const double classical = 4.0 * kStretching * kThinness, radius = 0.2;  // N/m^2; m
  const double force = classical * 3.14159 * radius * radius;
  const std::vector<Index> loaded{0, 1, 2};
  const std::vector<double> shares{0.25, 0.25, 0.5};
  EXPECT_EQ(sphere.watch.judgeForce(loaded, shares, 0.02 * force, radius), Buckling::kUnlikely);
  EXPECT_EQ(sphere.watch.judgeForce(loaded, shares, 0.1 * force, radius), Buckling::kPossible);
  EXPECT_EQ(sphere.watch.judgeForce(loaded, shares, 0.8 * force, radius), Buckling::kLikely);
  EXPECT_EQ(sphere.watch.judgeForce(loaded, shares, 0.8 * force, 4.0 * radius), Buckling::kPossible);
  EXPECT_EQ(sphere.watch.judgeForce(loaded, shares, 0.1 * force, 0.0), Buckling::kLikely);  // on a point of the full cloud
}

TEST(DentWatch, LeavesForcesOnAThickSphereToThePointsWhichShowItsDents) {
  const Sphere sphere(0.0, 0.05);
  EXPECT_EQ(sphere.watch.judgeForce({0, 1, 2}, {0.2, 0.3, 0.5}, 1e3, 0.2), Buckling::kUnlikely);
}

}  // namespace
}  // namespace deformable_surface::test
