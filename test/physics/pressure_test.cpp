// Membranes under pressure: the clamped disc of Hencky and the balloon.
#include "deformable_surface/model/mass_spring/mass_spring.h"
#include "statics.h"

#include <cmath>

namespace deformable_surface::test {
namespace {

using model::Bending;
using model::MassSpring;
using model::Membrane;

model::MassSpringParams membraneOnly(Membrane membrane) {
  model::MassSpringParams p;
  p.membrane = membrane;
  p.bending = Bending::kNone;
  return p;
}

// A disc of rings of points about the centre; the outermost is the rim.
Surface makeDisc(int rings, double radius) {
  Points points{Vec3::Zero()};
  for (int r = 1; r <= rings; ++r) {
    const int n = 6 * r;
    for (int k = 0; k < n; ++k) {
      const double angle = 2.0 * M_PI * (k + 0.5 * (r % 2)) / n;
      points.emplace_back(radius * r / rings * std::cos(angle), radius * r / rings * std::sin(angle), 0.0);
    }
  }
  return connect(points, Points(points.size(), Vec3::UnitZ()));
}

TEST(ClampedDisc, RisesUnderPressureAsHenckysMembrane) {
  // w0 / a = 0.653443 (p a / (E h))^(1/3) for Poisson's ratio 0.3 [Hencky 1915, corrected; valid for small p a / (E h)].
  const double radius = 0.5, Eh = 100.0, q = 1e-4;
  std::vector<double> errors;
  for (int rings : {8, 16}) {
    Surface s = makeDisc(rings, radius);
    std::vector<char> held(s.points.size(), 0);
    for (std::size_t i = 0; i < held.size(); ++i) held[i] = s.points[i].norm() > radius * (1.0 - 1e-9);
    model::MaterialParams material;
    material.young_modulus = Eh / material.thickness;
    material.poisson_ratio = 0.3;
    const MassSpring disc(s.points, s.normals, s.rings, s.area, s.isClosed(), material, membraneOnly(Membrane::kTriangles));
    const simulation::PressureLoad air(disc, q * Eh / radius);
    // A flat membrane has no stiffness against the load: start slightly raised.
    Points start = s.points;
    for (Vec3& p : start) p.z() = 0.03 * radius * (1.0 - p.squaredNorm() / (radius * radius));
    const Points end = solveStatics(disc, {&air}, held, start, 1e-7);
    errors.push_back(std::abs(end[0].z() / radius / (0.653443 * std::cbrt(q)) - 1.0));
  }
  EXPECT_LT(errors[1], 0.01);
  EXPECT_LT(errors[1], 0.5 * errors[0]);
}

TEST(Balloon, PressureOfCorotatedTrianglesFollowsTheClosedForm) {
  // p = 2 E h (lambda - 1) / ((1 - nu) R0 lambda^2) for the uniform stretch lambda of a sphere.
  const double radius = 0.3, Eh = 100.0, nu = 0.2, wanted = 1.3;
  const Surface s = makeSphere(800, radius);
  model::MaterialParams material;
  material.young_modulus = Eh / material.thickness;
  material.poisson_ratio = nu;
  const MassSpring balloon(s.points, s.normals, s.rings, s.area, s.isClosed(), material, membraneOnly(Membrane::kTriangles));
  const double pressure = 2.0 * Eh * (wanted - 1.0) / ((1.0 - nu) * radius * wanted * wanted);
  const simulation::PressureLoad air(balloon, pressure);
  const std::vector<char> held(s.points.size(), 0);
  const Points end = solveStatics(balloon, {&air}, held, s.points, 1e-7);
  double mean = 0.0;
  for (const Vec3& p : end) mean += p.norm() / end.size();
  EXPECT_NEAR(mean / radius, wanted, 0.01);
}

}  // namespace
}  // namespace deformable_surface::test
