// A strip that bends under its own weight, against the exact heavy elastica: one number, Gamma = w L^3 / D, sets its shape.
#include "deformable_surface/model/mass_spring/mass_spring.h"
#include "statics.h"

#include <cmath>

namespace deformable_surface::test {
namespace {

// theta'' + Gamma (1 - s) cos(theta) = 0, theta(0) = 0, theta'(1) = 0, theta below the horizontal. Shooting from the free end, where
// the angle at the clamp grows with the angle of the tip.
struct Tip {
  double droop, reach;  // over the length
};

Tip solveElastica(double gamma) {
  const int n = 4000;
  const double h = 1.0 / n;
  double low = 0.0, high = 0.5 * M_PI;
  Tip tip{};
  for (int iteration = 0; iteration < 60; ++iteration) {
    const double start = 0.5 * (low + high);
    double theta = start, slope = 0.0;  // slope by the distance t from the free end
    tip = {0.0, 0.0};
    for (int i = 0; i < n; ++i) {
      // Midpoint rule.
      const double t = i * h;
      const double middle = theta + 0.5 * h * slope;
      const double middle_slope = slope - 0.5 * h * gamma * t * std::cos(theta);
      tip.droop += h * std::sin(middle);
      tip.reach += h * std::cos(middle);
      theta += h * middle_slope;
      slope -= h * gamma * (t + 0.5 * h) * std::cos(middle);
    }
    (theta > 0.0 ? high : low) = start;
  }
  return tip;
}

TEST(Elastica, TheReferenceAgreesWithThePublishedCurve) {
  EXPECT_NEAR(solveElastica(1.0).droop, 0.123471, 1e-5);
  EXPECT_NEAR(solveElastica(10.0).droop, 0.700200, 1e-5);
  EXPECT_NEAR(solveElastica(10.0).reach, 0.656354, 1e-5);
  EXPECT_NEAR(solveElastica(100.0).droop, 0.937524, 1e-4);
}

// Distance of the tip from the exact one, over the length. The strip is turned arbitrarily in space.
double tipError(double gamma, Index columns, Index rows, double jitter) {
  const double width = 0.2, areal_density = 1.0, gravity = 9.81;
  // Two columns are held: the strip is free beyond the second.
  const double spacing = 1.0 / (columns - 1), length = 1.0 + spacing;
  Surface s = makeSheet(columns + 1, rows, length, width, jitter);
  const Mat3 rotation = someRotation();
  std::vector<char> held(s.points.size(), 0), tip(s.points.size(), 0);
  for (std::size_t i = 0; i < s.points.size(); ++i) {
    held[i] = s.points[i].x() < 1.5 * spacing;
    tip[i] = s.points[i].x() > length - 1e-9;
    // The held columns are straight, so that the strip begins at one length.
    if (held[i]) s.points[i].x() = std::round(s.points[i].x() / spacing) * spacing;
    s.points[i] = rotation * s.points[i];
    s.normals[i] = rotation * s.normals[i];
  }
  s = connect(s.points, s.normals);
  model::MaterialParams material;
  material.young_modulus = 1e7;
  material.thickness = 1e-3;
  material.density = areal_density / material.thickness;
  material.bending_rigidity = areal_density * gravity / gamma;
  const model::MassSpring strip(s.points, s.normals, s.rings, s.area, s.isClosed(), material, {});
  const simulation::GravityLoad load(strip.masses(), rotation * Vec3(0.0, 0.0, -gravity));
  const Points end = solveStatics(strip, {&load}, held, s.points, 1e-6);
  Vec3 mean = Vec3::Zero();
  int count = 0;
  for (std::size_t i = 0; i < end.size(); ++i)
    if (tip[i]) {
      mean += rotation.transpose() * end[i];
      ++count;
    }
  mean /= count;
  const Tip exact = solveElastica(gamma);
  return std::hypot(mean.x() - spacing - exact.reach, mean.z() + exact.droop);
}

TEST(Elastica, TheStripFollowsItOverThreeDecades) {
  for (double gamma : {0.1, 1.0, 10.0, 100.0}) EXPECT_LT(tipError(gamma, 40, 9, 0.1), 0.03) << gamma;
}

TEST(Elastica, TheErrorFallsWithTheSpacing) {
  const double coarse = tipError(10.0, 26, 6, 0.1), fine = tipError(10.0, 52, 11, 0.1);
  EXPECT_LT(fine, 0.65 * coarse);
}

}  // namespace
}  // namespace deformable_surface::test
