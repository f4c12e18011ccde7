// Bonds with a rest shape: moduli on uneven triangles, and bonds that are gone.
#include "kept_patches.h"

#include <gtest/gtest.h>

namespace deformable_surface::test {
namespace {

TEST(KeptBonds, AConstantStrainHasThePlatesEnergyOnUnevenTriangles) {
  const State rest = unevenPatch();
  const OrientedParticles particles = makeKept(rest);
  const MaterialParams m = thinSheet();
  EXPECT_LT(std::abs(particles.elasticEnergy(rest)), 1e-20);
  const double nu = m.poisson_ratio, e = 1e-5;
  for (const Vec3& strain : {Vec3(e, 0.0, 0.0), Vec3(0.0, e, 0.0), Vec3(0.0, 0.0, e), Vec3(e, e, 0.0)}) {
    State s = rest;
    Mat3 by = Mat3::Identity();
    by(0, 0) += strain[0];
    by(1, 1) += strain[1];
    by(0, 1) = by(1, 0) = 0.5 * strain[2];
    for (Vec3& x : s.positions) x = by * x;
    const double density = 0.5 * m.young_modulus * m.thickness / (1.0 - nu * nu) *
                           (strain[0] * strain[0] + strain[1] * strain[1] + 2.0 * nu * strain[0] * strain[1] +
                            0.5 * (1.0 - nu) * strain[2] * strain[2]);
    EXPECT_NEAR(particles.elasticEnergy(s) / (areaOf(rest) * density), 1.0, 1e-4) << strain.transpose();
  }
}

TEST(KeptBonds, AConstantCurvatureHasThePlatesEnergyOnUnevenTriangles) {
  const State rest = unevenPatch();
  const OrientedParticles particles = makeKept(rest);
  const MaterialParams m = thinSheet();
  const double nu = m.bendingPoissonRatio(), k = 1e-5 / kSpacing;
  for (const Vec3& bend : {Vec3(k, 0.0, 0.0), Vec3(0.0, k, 0.0), Vec3(0.0, 0.0, k), Vec3(k, k, 0.0)}) {
    State s = rest;  // z = (xx x^2 + yy y^2 + xy x y) / 2
    for (Index i = 0; i < s.size(); ++i) {
      const Vec3 x = rest.positions[i];
      s.positions[i].z() = 0.5 * (bend[0] * x.x() * x.x() + bend[1] * x.y() * x.y() + bend[2] * x.x() * x.y());
      const Vec3 slope(bend[0] * x.x() + 0.5 * bend[2] * x.y(), bend[1] * x.y() + 0.5 * bend[2] * x.x(), 0.0);
      s.orientations[i] = turnBy(Vec3(slope.y(), -slope.x(), 0.0), Quaternion::Identity());
    }
    const double density =
        0.5 * m.bendingRigidity() *
        (bend[0] * bend[0] + bend[1] * bend[1] + 2.0 * nu * bend[0] * bend[1] + 0.5 * (1.0 - nu) * bend[2] * bend[2]);
    EXPECT_NEAR(particles.elasticEnergy(s) / (areaOf(rest) * density), 1.0, 1e-3) << bend.transpose();
  }
}

TEST(KeptBonds, ABondThatIsTooLongMeltedOrCutIsGone) {
  State s = unevenPatch();
  OrientedParticles particles = makeKept(s);
  EXPECT_TRUE(particles.findBroken(s).empty());
  s.traits[0].temperature = 2000.0;
  for (Index i = 35; i < 42; ++i) s.positions[i].y() += 2.0 * kSpacing;  // the last row
  const model::ParticleCuts::Pairs broken = particles.findBroken(s);
  EXPECT_EQ(broken.size(), 13 + 2);  // 13 between two rows of seven, two of the corner
  particles.setCuts(particles.cuts().sever(broken));
  particles.refreshDisplay(s);
  EXPECT_EQ(particles.triangles().size(), 60 - 12 - 1);
  s.traits[0].temperature = 0.0;
  for (Index i = 35; i < 42; ++i) s.positions[i].y() += 10.0 * kSpacing;
  EXPECT_LT(std::abs(particles.elasticEnergy(s)), 1e-20);  // nothing pulls, then or when it is cold again
}

TEST(KeptBonds, TheirMemoryCounts) {
  const State rest = unevenPatch();
  const OrientedParticles particles = makeKept(rest);
  EXPECT_GT(particles.elasticEnergy(rest), -1.0);  // which lists those that are present
  // Those of the rest shape and those that are present.
  EXPECT_GT(particles.bytes(), 2 * trianglesOfPatch().size() * sizeof(model::KeptBonds::Triangle));
}

}  // namespace
}  // namespace deformable_surface::test
