// One constant for all springs changes a measurable length: the sag of a hanging sheet, against closed forms of the lattice.
#include "deformable_surface/model/mass_spring/mass_spring.h"
#include "statics.h"

namespace deformable_surface::test {
namespace {

using model::MassSpringParams;

constexpr double kLength = 5.0, kWidth = 0.5;
constexpr Index kRows = 4;
// The held edge cannot contract. Over half a width the strain is less by a quarter at most (square lattice of one constant, whose
// contraction is half its strain). This is the resulting share of the sag.
constexpr double kHeldEdge = 0.025;

/// How far the lower edge of a long sheet sinks under its weight, which acts along x, held at x = 0. finer: width of the cells
/// over their length.
double sagOf(const MassSpringParams& params, const model::MaterialParams& material, Index finer, double gravity) {
  const Index columns = static_cast<Index>(kLength / kWidth) * kRows * finer;
  const Surface s = makeSheet(columns + 1, kRows + 1, kLength, kWidth);
  const model::MassSpring m(s.points, s.normals, s.rings, s.area, s.isClosed(), material, params);
  const simulation::GravityLoad weight(m.masses(), Vec3(gravity, 0.0, 0.0));
  std::vector<char> held;
  for (const Vec3& p : s.points) held.push_back(p.x() == 0.0);
  const Points x = solveStatics(m, {&weight}, held, s.points);
  double sag = 0.0;
  for (Index i = 1; i <= kRows + 1; ++i) sag += (x[x.size() - i].x() - kLength) / (kRows + 1);
  return sag;
}

// Cells of a by b, strains e1 along the weight and e2 across. Springs of one constant k in a column of cells hold
//   U = k/2 [(rows + 1) a^2 e1^2 + rows b^2 e2^2 + 2 rows (a^2 e1 + b^2 e2)^2 / (a^2 + b^2)],
// least for e2 = -2 a^2 e1 / (a^2 + 3 b^2); the tension is S e1 with S = dU/de1 / (a e1), the sag weight * length / (2 S).
// Springs from the material have k = E h b / a, E h a / b and E h a b / (2 (a^2 + b^2)), halved at the edges, with which
//   S = E h width (1 + x^2 - (x y)^2 / (1 + y^2)),  x = a^2 / (a^2 + b^2), y = 1 - x.
TEST(UniformSprings, SagDependsOnThePatternOfThePointsAndHardlyWithStiffnessFromTheMaterial) {
  model::MaterialParams material;
  material.bending_rigidity = 1e-3;  // a flat network has no stiffness out of its plane
  MassSpringParams calibrated, uniform;
  calibrated.membrane = uniform.membrane = model::Membrane::kSprings;
  uniform.stiffness = model::Stiffness::kUniform;
  const double k = uniform.spring_constant = 80.0, gravity = 1e-3;
  const double weight = material.arealDensity() * kLength * kWidth * gravity;
  double uniform_sag[2], calibrated_sag[2];
  for (Index finer : {1, 2}) {
    const double b2 = std::pow(kWidth / kRows, 2), a2 = b2 / (finer * finer), a = std::sqrt(a2);
    const double stiffness = k * a * (kRows + 1 + 2 * kRows * (a2 - 2.0 * a2 * b2 / (a2 + 3.0 * b2)) / (a2 + b2));
    const double exact = weight * kLength / (2.0 * stiffness);
    uniform_sag[finer - 1] = sagOf(uniform, material, finer, gravity);
    calibrated_sag[finer - 1] = sagOf(calibrated, material, finer, gravity);
    const double x = a2 / (a2 + b2), y = 1.0 - x;
    const double calibrated_stiffness =
        material.young_modulus * material.thickness * kWidth * (1.0 + x * x - x * x * y * y / (1.0 + y * y));
    const double calibrated_exact = weight * kLength / (2.0 * calibrated_stiffness);
    EXPECT_NEAR(uniform_sag[finer - 1], exact, kHeldEdge * exact);
    EXPECT_NEAR(calibrated_sag[finer - 1], calibrated_exact, kHeldEdge * calibrated_exact);
  }
  // With twice as many points along the sheet it is a different sheet.
  EXPECT_GT(uniform_sag[1], 2.4 * uniform_sag[0]);
  EXPECT_LT(calibrated_sag[1], 1.2 * calibrated_sag[0]);
}

}  // namespace
}  // namespace deformable_surface::test
