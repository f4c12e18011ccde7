#include "deformable_surface/model/mass_spring/mass_spring.h"
#include "deformable_surface/base/error.h"
#include "model_checks.h"
#include "plates.h"

#include <Eigen/Eigenvalues>

namespace deformable_surface::test {
namespace {

using model::Bending;
using model::MassSpring;
using model::MassSpringParams;
using model::MaterialParams;
using model::Membrane;

struct Variant {
  const char* name;
  MassSpringParams params;
  bool sphere;
};

MassSpringParams choose(Membrane membrane, Bending bending, double volume = 0.0) {
  MassSpringParams p;
  p.membrane = membrane;
  p.bending = bending;
  p.volume_stiffness = volume;
  return p;
}

// Springs of one constant, damped by eq. 3 of [Su 2007].
MassSpringParams chooseUniform(Bending bending, double constant) {
  MassSpringParams p = choose(Membrane::kSprings, bending);
  p.stiffness = model::Stiffness::kUniform;
  p.spring_constant = constant;
  p.bending_spring_ratio = 1.0;
  p.damping = model::Damping::kRelativeVelocity;
  return p;
}

MassSpringParams withRelativeDamping(MassSpringParams p) {
  p.damping = model::Damping::kRelativeVelocity;
  return p;
}

const Variant kVariants[] = {
    {"SpringsAlone", choose(Membrane::kSprings, Bending::kNone), false},
    {"SpringsAsPublished", choose(Membrane::kSprings, Bending::kSprings), false},
    {"UniformSpringsAsPublished", chooseUniform(Bending::kSprings, 1500.0), false},
    {"TrianglesDampedAsPublished", withRelativeDamping(choose(Membrane::kTriangles, Bending::kSprings)), true},
    {"SpringsAndCurvature", choose(Membrane::kSprings, Bending::kCurvature), true},
    {"TrianglesAlone", choose(Membrane::kTriangles, Bending::kNone), false},
    {"TrianglesAndCurvature", choose(Membrane::kTriangles, Bending::kCurvature), false},
    {"TrianglesAndCurvatureOnSphere", choose(Membrane::kTriangles, Bending::kCurvature), true},
    {"TrianglesAndBendingSprings", choose(Membrane::kTriangles, Bending::kSprings), true},
    {"TrianglesAndVolume", choose(Membrane::kTriangles, Bending::kNone, 1e4), true},
};

class MassSpringVariants : public testing::TestWithParam<Variant> {
 protected:
  static constexpr double kLength = 0.1;  // spacing

  MassSpringVariants() : surface(GetParam().sphere ? makeSphere(120, 0.3) : makeSheet(9, 8, 0.8, 0.7, 0.3)) {
    material.thickness = 0.02;  // thick, so that bending and membrane stiffness are similar
    material.spring_damping = 1e-3;
    material.poisson_ratio = GetParam().params.membrane == Membrane::kSprings ? 1.0 / 3.0 : 0.2;
    mass_spring = std::make_unique<MassSpring>(surface.points, surface.normals, surface.rings, surface.area, surface.isClosed(),
                                               material, GetParam().params);
  }
  double forceScale() const { return material.young_modulus * material.thickness * kLength; }

  Surface surface;
  MaterialParams material;
  std::unique_ptr<MassSpring> mass_spring;
};

TEST_P(MassSpringVariants, RestIsAtRest) { checkRestIsAtRest(*mass_spring, surface.points, forceScale()); }

TEST_P(MassSpringVariants, FastForcesAndThenSlowOnesAreAllForcesBitForBit) {
  State state = stateAt(perturb(surface.points, 0.3 * kLength));
  std::mt19937 generator(3);
  for (Vec3& v : state.velocities) v = randomVector(generator);
  Points parts(state.positions.size(), Vec3::Zero());
  mass_spring->addFastForces(state, parts);
  if (mass_spring->hasCurvature()) mass_spring->addSlowForces(state, parts);
  EXPECT_EQ(parts, forcesAt(*mass_spring, state));
}

TEST_P(MassSpringVariants, FastStiffnessIsThatOfTheFastForces) {
  if (!mass_spring->hasCurvature()) GTEST_SKIP() << "no slow forces";
  const State state = stateAt(perturb(surface.points, 0.1 * kLength));
  BlockSparse stiffness;
  stiffness.begin(state.size());
  mass_spring->addFastStiffness(state, 0.0, model::Hessian::kExact, stiffness);
  stiffness.finish();
  Eigen::VectorXd motion(3 * state.size()), product;
  std::mt19937 generator(5);
  for (Index i = 0; i < state.size(); ++i) motion.segment<3>(3 * i) = randomVector(generator);
  stiffness.multiply(motion, product);
  constexpr double kShift = 1e-6 * kLength;
  Points forces[2];
  for (const int side : {0, 1}) {
    State moved = state;
    for (Index i = 0; i < state.size(); ++i) moved.positions[i] += (side ? kShift : -kShift) * motion.segment<3>(3 * i);
    forces[side].assign(state.size(), Vec3::Zero());
    mass_spring->addFastForces(moved, forces[side]);
  }
  double largest = 0.0;
  for (Index i = 0; i < state.size(); ++i)
    largest = std::max(largest, ((forces[0][i] - forces[1][i]) / (2.0 * kShift) - product.segment<3>(3 * i)).norm());
  EXPECT_LT(largest, 1e-5 * product.norm());
}

TEST(CurvatureBendingRate, IsNotBelowTheLargestEigenvalueAndNotFarAbove) {
  for (const Surface& surface : {makeSphere(120, 0.3), makeSheet(9, 8, 0.8, 0.7, 0.3)}) {
    const Index n = static_cast<Index>(surface.points.size());
    std::vector<double> masses;
    for (Index i = 0; i < n; ++i) masses.push_back(1.0 + 0.1 * (i % 7));
    // The last one crushed.
    for (const auto& [nu, scale, amount] : {std::tuple(0.3, 1.0, 0.0), {-0.9, 1.0, 0.03}, {0.3, 1.0, 0.03}, {0.3, 0.1, 0.003}}) {
      const model::CurvatureBending bending(plateOf(surface, 2.0, nu));
      Points positions = surface.points;
      for (Vec3& x : positions) x *= scale;
      const State state = stateAt(perturb(positions, amount));
      BlockSparse stiffness;
      stiffness.begin(n);
      bending.addStiffness(state, model::Hessian::kPositive, stiffness);
      stiffness.finish();
      Eigen::MatrixXd matrix = makeDense(stiffness);
      for (Index i = 0; i < n; ++i) {
        matrix.middleRows<3>(3 * i) /= std::sqrt(masses[i]);
        matrix.middleCols<3>(3 * i) /= std::sqrt(masses[i]);
      }
      const double largest =
          Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(matrix, Eigen::EigenvaluesOnly).eigenvalues().maxCoeff();
      const double bound = bending.boundRate(state, masses);
      EXPECT_GE(bound, largest);
      // No single fit is stiffer than all of them together, and about seventeen overlap at a point.
      EXPECT_LE(bound, 17.0 * largest);
    }
  }
}

// Where the tangents vanish, a normal of unit length would turn by any angle over no distance, and so would the forces.
TEST(CrushedCurvature, ForcesAreMinusTheGradientAndHaveABound) {
  const Surface surface = makeSheet(9, 8, 0.8, 0.7, 0.3);
  const model::CurvatureBending bending(plateOf(surface, 2.0, 0.3));
  const auto energyAt = [&](const Points& positions) {
    PaddedPoints padded;
    padded.assign(positions);
    return bending.energy(padded);
  };
  const auto forcesOf = [&](const Points& positions) {
    PaddedPoints padded;
    padded.assign(positions);
    Points forces(positions.size(), Vec3::Zero());
    bending.addForces(padded, forces);
    return forces;
  };
  // Crushed to a fifth of its size, a line and a point; each a little rough.
  for (const Vec3& scale : {Vec3(0.2, 0.2, 0.2), Vec3(1.0, 1e-3, 1e-3), Vec3(1e-9, 1e-9, 1e-9)}) {
    Points positions = surface.points;
    for (Vec3& x : positions) x = x.cwiseProduct(scale);
    positions = perturb(positions, 0.01);
    const Points forces = forcesOf(positions);
    Vec3 sum = Vec3::Zero(), moment = Vec3::Zero();
    for (std::size_t i = 0; i < forces.size(); ++i) {
      sum += forces[i];
      moment += positions[i].cross(forces[i]);
    }
    EXPECT_LT(sum.norm(), 1e-10 * largest(forces));
    EXPECT_LT(moment.norm(), 1e-10 * largest(forces));
    const double step = 1e-7;
    for (Index i = 0; i < static_cast<Index>(positions.size()); i += 5)
      for (int c = 0; c < 3; ++c) {
        Points above = positions, below = positions;
        above[i][c] += step;
        below[i][c] -= step;
        EXPECT_NEAR(forces[i][c], (energyAt(below) - energyAt(above)) / (2.0 * step), 1e-5 * largest(forces))
            << scale.transpose();
      }
  }
  // However close to the state in which the tangents vanish.
  double before = 0.0;
  for (const double amount : {1e-3, 1e-6, 1e-9, 0.0}) {
    Points positions = perturb(Points(surface.points.size(), Vec3::Zero()), amount);
    const double now = largest(forcesOf(positions));
    if (before > 0.0) {
      EXPECT_LE(now, 1.01 * before) << amount;
    }
    before = now;
  }
}

TEST_P(MassSpringVariants, MomentumIsKept) {
  const bool angular = GetParam().params.damping == model::Damping::kAlongSpring;
  checkMomentumIsKept(*mass_spring, stateAt(perturb(surface.points, 0.3 * kLength)), angular);
}

TEST_P(MassSpringVariants, RigidMotionIsNotNoticed) {
  checkRigidMotionIsNotNoticed(*mass_spring, perturb(surface.points, 0.3 * kLength));
}

TEST_P(MassSpringVariants, ForcesAreMinusTheGradientOfTheEnergy) {
  checkForcesAreMinusTheGradient(*mass_spring, perturb(surface.points, 0.2 * kLength), kLength);
}

TEST_P(MassSpringVariants, StiffnessAtRestIsTheDerivativeOfTheForces) {
  checkStiffnessIsTheDerivative(*mass_spring, surface.points, kLength);
}

TEST_P(MassSpringVariants, ExactStiffnessIsTheDerivativeFarFromRestToo) {
  if (GetParam().params.volume_stiffness > 0.0) GTEST_SKIP() << "the change of the volume's gradient is left out by design";
  checkStiffnessIsTheDerivative(*mass_spring, perturb(surface.points, 0.2 * kLength), kLength);
}

TEST_P(MassSpringVariants, DampingMatrixGivesTheViscousForces) {
  checkDampingMatrixGivesTheViscousForces(*mass_spring, perturb(surface.points, 0.2 * kLength));
}

TEST_P(MassSpringVariants, StiffnessIsPositiveAlsoFarFromRest) {
  checkStiffnessIsPositive(*mass_spring, perturb(surface.points, 0.6 * kLength));
}

TEST_P(MassSpringVariants, RowBoundsHold) { checkRowBoundsHold(*mass_spring, surface.points); }

TEST_P(MassSpringVariants, WhatACutLeavesKeepsTheRulesAndIsWholeAgainWithoutIt) {
  if (GetParam().params.volume_stiffness > 0.0) GTEST_SKIP() << "a volume that is kept is not cut: the scene is refused";
  const State state = stateAt(perturb(surface.points, 0.2 * kLength));
  const Points whole = forcesAt(*mass_spring, state);
  const std::vector<double> masses = mass_spring->masses();
  const auto isOnTheLeft = [&](Index i) { return surface.points[i].x() < 0.05; };
  std::vector<MassSpring::Link> cuts;
  for (const auto* links : {&mass_spring->stretchLinks(), &mass_spring->bendLinks()})
    for (const MassSpring::Link& link : *links)
      if (isOnTheLeft(link.first) != isOnTheLeft(link.second)) cuts.push_back(link);
  std::sort(cuts.begin(), cuts.end());
  ASSERT_FALSE(cuts.empty());
  mass_spring->setCuts(cuts);
  EXPECT_EQ(mass_spring->masses(), masses);
  EXPECT_FALSE(mass_spring->isClosed());
  checkRestIsAtRest(*mass_spring, surface.points, forceScale());
  checkMomentumIsKept(*mass_spring, state, GetParam().params.damping == model::Damping::kAlongSpring);
  checkForcesAreMinusTheGradient(*mass_spring, state.positions, kLength);
  // One side moves. There is no force on the other.
  State moved = stateAt(surface.points);
  for (Index i = 0; i < moved.size(); ++i)
    if (isOnTheLeft(i)) moved.positions[i] += Vec3(-0.3, 0.1, 0.2) + 0.01 * surface.points[i];
  const Points forces = forcesAt(*mass_spring, moved);
  for (Index i = 0; i < moved.size(); ++i)
    if (!isOnTheLeft(i)) {
      EXPECT_LT(forces[i].norm(), 1e-10 * forceScale());
    }
  const std::vector<MassSpring::Link> all = mass_spring->cuts();
  mass_spring->setCuts(all);
  EXPECT_EQ(mass_spring->cuts(), all);
  mass_spring->setCuts({});
  EXPECT_EQ(forcesAt(*mass_spring, state), whole);
}

// Two materials that differ by a factor of hundreds: the checks hold for both.
TEST_P(MassSpringVariants, PartsOfOtherMaterialKeepEnergyAndMomentum) {
  std::vector<model::PointMaterial> parts(surface.points.size());
  for (std::size_t i = 0; i < parts.size(); ++i)
    if (surface.points[i].x() > 0.1) parts[i] = {300.0, 0.01, 5.0};
  const std::vector<double> masses = mass_spring->masses();
  mass_spring->setMaterial(parts);
  for (std::size_t i = 0; i < parts.size(); ++i) EXPECT_EQ(mass_spring->masses()[i], parts[i].density * masses[i]);
  const Points deformed = perturb(surface.points, 0.2 * kLength);
  checkRestIsAtRest(*mass_spring, surface.points, 300.0 * forceScale());
  checkForcesAreMinusTheGradient(*mass_spring, deformed, kLength);
  checkStiffnessIsTheDerivative(*mass_spring, surface.points, kLength);
  checkRowBoundsHold(*mass_spring, surface.points);
  checkMomentumIsKept(*mass_spring, stateAt(deformed), GetParam().params.damping == model::Damping::kAlongSpring);
  // As after construction, bit for bit.
  const Points changed = forcesAt(*mass_spring, stateAt(deformed));
  mass_spring->setMaterial(std::vector<model::PointMaterial>(parts.size()));
  const MassSpring made(surface.points, surface.normals, surface.rings, surface.area, surface.isClosed(), material,
                        GetParam().params);
  EXPECT_EQ(forcesAt(*mass_spring, stateAt(deformed)), forcesAt(made, stateAt(deformed)));
  EXPECT_NE(changed, forcesAt(made, stateAt(deformed)));
}

TEST_P(MassSpringVariants, MassesSumToTheSurfaces) {
  double sum = 0.0;
  for (double m : mass_spring->masses()) {
    EXPECT_GT(m, 0.0);
    sum += m;
  }
  EXPECT_NEAR(sum, material.arealDensity() * surface.area, 1e-12 * sum);
}

TEST_P(MassSpringVariants, CollapsedSurfacesGiveFiniteForces) {
  const Index n = static_cast<Index>(surface.points.size());
  Points line = surface.points, plane = surface.points;
  for (Vec3& p : line) p = Vec3(p.x(), 0.0, 0.0);
  for (Vec3& p : plane) p.z() = -p.z();
  for (const Points& collapsed : {Points(n, Vec3(1.0, 2.0, 3.0)), line, plane}) {
    for (const Vec3& f : forcesAt(*mass_spring, stateAt(collapsed))) ASSERT_TRUE(f.allFinite());
    EXPECT_TRUE(std::isfinite(mass_spring->elasticEnergy(stateAt(collapsed))));
  }
}

INSTANTIATE_TEST_SUITE_P(All, MassSpringVariants, testing::ValuesIn(kVariants),
                         [](const testing::TestParamInfo<Variant>& info) { return info.param.name; });

// Energy of a homogeneous strain of a patch over that of the material, per unit area.
double energyRatio(const MassSpring& m, const Surface& s, const Mat2& strain, const MaterialParams& material) {
  Points strained = s.points;
  for (Vec3& p : strained) p.head<2>() += strain * p.head<2>();
  const double Eh = material.young_modulus * material.thickness, nu = material.poisson_ratio;
  const double trace = strain.trace();
  const double density = Eh / (2.0 * (1.0 + nu)) * strain.squaredNorm() + 0.5 * Eh * nu / (1.0 - nu * nu) * trace * trace;
  return m.elasticEnergy(stateAt(strained)) / (density * s.area);
}

TEST(MassSpring, TrianglesCarryHomogeneousStrainsExactlyForAnyPoissonRatio) {
  const Surface s = makeSheet(12, 12, 1.0, 1.0, 0.3);
  for (double nu : {-0.3, 0.0, 1.0 / 3.0, 0.49}) {
    MaterialParams material;
    material.poisson_ratio = nu;
    const MassSpring m(s.points, s.normals, s.rings, s.area, s.isClosed(), material,
                       choose(Membrane::kTriangles, Bending::kNone));
    for (const Mat2& strain : {Mat2{{1e-3, 0.0}, {0.0, 0.0}}, Mat2{{0.0, 1e-3}, {1e-3, 0.0}}, Mat2{{1e-3, 0.0}, {0.0, 1e-3}}})
      EXPECT_NEAR(energyRatio(m, s, strain, material), 1.0, 2e-3) << nu;
  }
}

// A triangle of area A gives each of its edges E h w A / l^2 (w = 1/2: both diagonals of a cell are there), so that a small
// strain e costs E h w A / 2 (n . e n)^2 at each edge of direction n. Over the four right triangles of a square cell, per area:
//   W = E h / 2 [e11^2 + e22^2 + (n+ . e n+)^2 / 2 + (n- . e n-)^2 / 2],  n+ . e n+ and n- . e n- = (e11 + e22) / 2 +- e12.
// The cells do not notice each other, hence no effects of edges; sum k l^2 = 3 E h A, hence no scaling. Over the material's at
// Poisson's ratio 1/3 that is 2/3 for shear along the axes, 4/3 for shear along the diagonals, 10/9 for a strain along an axis,
// and 1 for an even one: a square lattice is not isotropic.
TEST(MassSpring, RegularGridOfSpringsHasTheClosedFormStiffness) {
  const Surface s = makeSheet(12, 12, 1.0, 1.0);
  MaterialParams material;
  material.poisson_ratio = 1.0 / 3.0;
  const MassSpring m(s.points, s.normals, s.rings, s.area, s.isClosed(), material, choose(Membrane::kSprings, Bending::kNone));
  const double e = 1e-6, tolerance = e;  // lengths are not linear in the displacement: an error of the order of the strain
  EXPECT_NEAR(energyRatio(m, s, Mat2{{0.0, e}, {e, 0.0}}, material), 2.0 / 3.0, tolerance);
  EXPECT_NEAR(energyRatio(m, s, Mat2{{e, 0.0}, {0.0, -e}}, material), 4.0 / 3.0, tolerance);
  EXPECT_NEAR(energyRatio(m, s, Mat2{{e, 0.0}, {0.0, 0.0}}, material), 10.0 / 9.0, tolerance);
  EXPECT_NEAR(energyRatio(m, s, Mat2{{e, 0.0}, {0.0, e}}, material), 1.0, tolerance);
}

// nx by ny cells of a by b: of one constant k there are nx (ny + 1) springs along x and 2 nx ny diagonals, which a strain e
// along x makes longer by e a and e a^2 / sqrt(a^2 + b^2).
TEST(MassSpring, UniformSpringsAreSofterAlongTheFinerDirectionOfAGridAndThoseOfTheMaterialHardly) {
  const double e = 1e-6, constant = 150.0;
  double uniform[2], calibrated[2];
  for (int fine = 0; fine < 2; ++fine) {
    const Index nx = fine ? 20 : 10, ny = 10;
    const Surface s = makeSheet(nx + 1, ny + 1, 1.0, 1.0);
    MaterialParams material;
    const auto energyOf = [&](const MassSpringParams& params) {
      const MassSpring m(s.points, s.normals, s.rings, s.area, s.isClosed(), material, params);
      Points stretched = s.points;
      for (Vec3& p : stretched) p.x() *= 1.0 + e;
      return m.elasticEnergy(stateAt(stretched));
    };
    uniform[fine] = energyOf(chooseUniform(Bending::kNone, constant));
    calibrated[fine] = energyOf(choose(Membrane::kSprings, Bending::kNone));
    const double a2 = 1.0 / (nx * nx), b2 = 1.0 / (ny * ny);
    const double exact = 0.5 * constant * e * e * (nx * (ny + 1) * a2 + 2 * nx * ny * a2 * a2 / (a2 + b2));
    EXPECT_NEAR(uniform[fine], exact, e * exact);
  }
  // Without edges 0.35 and 0.832.
  EXPECT_LT(uniform[1], 0.4 * uniform[0]);
  EXPECT_GT(calibrated[1], 0.8 * calibrated[0]);
}

TEST(MassSpring, RigidRotationIsBrakedByPublishedDampingAndNotByDampingAlongTheSprings) {
  const Surface s = makeSheet(9, 8, 0.8, 0.7, 0.3);
  MaterialParams material;
  material.spring_damping = 1e-3;
  State spinning = stateAt(s.points);
  const Vec3 omega(2.0, -1.0, 3.0);
  for (Index i = 0; i < spinning.size(); ++i) spinning.velocities[i] = omega.cross(s.points[i]);
  const auto power = [&](const MassSpring& m) {
    const Points forces = forcesAt(m, spinning);
    double sum = 0.0;
    for (Index i = 0; i < spinning.size(); ++i) sum += forces[i].dot(spinning.velocities[i]);
    return sum;
  };
  const MassSpringParams along = choose(Membrane::kSprings, Bending::kNone);
  const MassSpring ours(s.points, s.normals, s.rings, s.area, s.isClosed(), material, along);
  const MassSpring published(s.points, s.normals, s.rings, s.area, s.isClosed(), material, withRelativeDamping(along));
  // Eq. 3 takes k_d |omega x I|^2 from each spring.
  const model::Springs& springs = published.stretchingSprings();
  double exact = 0.0;
  for (std::size_t l = 0; l < springs.links().size(); ++l) {
    const Vec3 link = s.points[springs.links()[l].second] - s.points[springs.links()[l].first];
    exact -= material.spring_damping * springs.stiffness()[l] * omega.cross(link).squaredNorm();
  }
  EXPECT_NEAR(power(published), exact, 1e-12 * std::abs(exact));
  EXPECT_NEAR(power(ours), 0.0, 1e-12 * std::abs(exact));
}

TEST(MassSpring, SpringsOfHexagonalLatticeHaveTheClosedFormStiffness) {
  Points points;
  const double a = 0.1;
  for (int i = 0; i < 14; ++i)
    for (int j = 0; j < 16; ++j) points.emplace_back(a * (i + 0.5 * (j % 2)), a * std::sqrt(0.75) * j, 0.0);
  const Surface s = connect(points, Points(points.size(), Vec3::UnitZ()));
  MaterialParams material;
  material.poisson_ratio = 1.0 / 3.0;
  const MassSpring m(s.points, s.normals, s.rings, s.area, s.isClosed(), material, choose(Membrane::kSprings, Bending::kNone));
  // k = (sqrt 3 / 2) E h in the interior of an equilateral lattice; the scaling to the whole patch moves it by its edges.
  const double exact = std::sqrt(0.75) * material.young_modulus * material.thickness;
  const model::Springs& springs = m.stretchingSprings();
  int count = 0;
  for (std::size_t e = 0; e < springs.links().size(); ++e) {
    const Vec3 middle = 0.5 * (points[springs.links()[e].first] + points[springs.links()[e].second]);
    if (middle.x() < 0.3 || middle.x() > 1.0 || middle.y() < 0.3 || middle.y() > 1.0) continue;
    EXPECT_NEAR(springs.stiffness()[e], exact, 0.06 * exact);
    ++count;
  }
  EXPECT_GT(count, 100);
}

TEST(MassSpring, CurvatureBendingOfACylinderHasTheStatedRigidity) {
  MaterialParams material;
  material.bending_rigidity = 2.5e-4;
  const Surface s = makeSheet(25, 13, 1.0, 0.5, 0.2);
  for (bool springs : {false, true}) {
    const MassSpring m(s.points, s.normals, s.rings, s.area, s.isClosed(), material,
                       choose(springs ? Membrane::kSprings : Membrane::kTriangles, Bending::kCurvature));
    const MassSpring membrane_only(s.points, s.normals, s.rings, s.area, s.isClosed(), material,
                                   choose(springs ? Membrane::kSprings : Membrane::kTriangles, Bending::kNone));
    const double radius = 2.0;
    Points rolled = s.points;
    for (Vec3& p : rolled) p = Vec3(radius * std::sin(p.x() / radius), p.y(), radius * (1.0 - std::cos(p.x() / radius)));
    const double bending = m.elasticEnergy(stateAt(rolled)) - membrane_only.elasticEnergy(stateAt(rolled));
    EXPECT_NEAR(bending / (0.5 * 2.5e-4 / (radius * radius) * s.area), 1.0, 0.01);
  }
}

// Small heights (p x^2 + q y^2) / 2 + r x y bend a plate by k_11 = p, k_22 = q, k_12 = r; per area it costs
// D/2 [(1 - nu) (p^2 + q^2 + 2 r^2) + nu (p + q)^2].
TEST(MassSpring, BendingOfASheetCostsWhatAPlateOfItsPoissonRatioCosts) {
  const Surface s = makeSheet(25, 25, 1.0, 1.0, 0.2);
  const double rigidity = 2.5e-4, size = 1e-4;  // 1/m: heights so small that the surface is not stretched
  for (const double nu : {-0.3, 0.0, 0.3, 0.49}) {
    MaterialParams material;
    material.bending_rigidity = rigidity;
    material.bending_poisson_ratio = nu;
    const MassSpring m(s.points, s.normals, s.rings, s.area, s.isClosed(), material,
                       choose(Membrane::kTriangles, Bending::kCurvature));
    for (const Vec3& bent : {Vec3(1.0, 0.0, 0.0), Vec3(1.0, 1.0, 0.0), Vec3(1.0, -1.0, 0.0), Vec3(0.0, 0.0, 1.0)}) {
      const Vec3 k = size * bent;  // p, q, r
      Points points = s.points;
      for (Vec3& x : points) x.z() = 0.5 * (k[0] * x.x() * x.x() + k[1] * x.y() * x.y()) + k[2] * x.x() * x.y();
      const double squares = k[0] * k[0] + k[1] * k[1] + 2.0 * k[2] * k[2], trace = k[0] + k[1];
      const double density = 0.5 * rigidity * ((1.0 - nu) * squares + nu * trace * trace);
      EXPECT_NEAR(m.elasticEnergy(stateAt(points)) / (density * s.area), 1.0, 1e-3) << nu << " " << bent.transpose();
    }
  }
}

TEST(MaterialParams, APlateOfOneMaterialBendsWithItsPoissonRatioAndAStatedRigidityIsThatOfStrips) {
  MaterialParams material;
  material.poisson_ratio = 0.2;
  EXPECT_EQ(material.bendingPoissonRatio(), 0.2);
  material.bending_rigidity = 1e-4;
  EXPECT_EQ(material.bendingPoissonRatio(), 0.0);
  material.bending_poisson_ratio = 0.4;
  EXPECT_EQ(material.bendingPoissonRatio(), 0.4);
}

TEST(MassSpring, CurvedRestShapeHasNoBendingEnergyAtRestAndResistsFlattening) {
  Surface flat = makeSheet(20, 9, 1.0, 0.4, 0.1);
  const double radius = 0.5;
  Points points, normals;
  for (const Vec3& p : flat.points) {
    points.emplace_back(radius * std::sin(p.x() / radius), p.y(), radius * (1.0 - std::cos(p.x() / radius)));
    normals.emplace_back(-std::sin(p.x() / radius), 0.0, std::cos(p.x() / radius));
  }
  const Surface s = connect(points, normals);
  MaterialParams material;
  material.bending_rigidity = 1e-3;
  const MassSpring m(s.points, s.normals, s.rings, s.area, s.isClosed(), material,
                     choose(Membrane::kTriangles, Bending::kCurvature));
  EXPECT_NEAR(m.elasticEnergy(stateAt(s.points)), 0.0, 1e-20);
  EXPECT_NEAR(m.elasticEnergy(stateAt(flat.points)) / (0.5 * 1e-3 / (radius * radius) * s.area), 1.0, 0.03);
}

TEST(MassSpring, PublishedBendingSpringsHaveNoStiffnessAtAFlatRestState) {
  // The energy grows with the fourth power of the curvature: a tenth of the curvature, a ten-thousandth of the energy.
  const Surface s = makeSheet(15, 10, 1.0, 0.6);
  MaterialParams material;
  const MassSpring m(s.points, s.normals, s.rings, s.area, s.isClosed(), material,
                     choose(Membrane::kTriangles, Bending::kSprings));
  const auto energyAtRadius = [&](double radius) {
    Points rolled = s.points;
    for (Vec3& p : rolled) p = Vec3(radius * std::sin(p.x() / radius), p.y(), radius * (1.0 - std::cos(p.x() / radius)));
    return m.elasticEnergy(stateAt(rolled));
  };
  EXPECT_NEAR(energyAtRadius(1.0) / energyAtRadius(10.0), 1e4, 2e2);
}

TEST(MassSpring, AreaVectorsOfASphereSumToZeroAndMeasureItsAreaAndVolume) {
  const Surface s = makeSphere(2000, 0.5);
  const MassSpring m(s.points, s.normals, s.rings, s.area, s.isClosed(), MaterialParams(), MassSpringParams());
  Points area;
  m.computeAreaVectors(stateAt(s.points), area);
  Vec3 sum = Vec3::Zero();
  double total = 0.0;
  for (std::size_t i = 0; i < area.size(); ++i) {
    sum += area[i];
    total += area[i].norm();
    EXPECT_GT(area[i].dot(s.normals[i]), 0.0);
  }
  EXPECT_LT(sum.norm(), 1e-3 * total);
  EXPECT_NEAR(total, M_PI, 0.01 * M_PI);
  EXPECT_NEAR(m.enclosedVolume(stateAt(s.points)), M_PI / 6.0, 0.01 * M_PI / 6.0);
}

TEST(MassSpring, VolumeStiffnessOfAnOpenSurfaceIsRefused) {
  const Surface s = makeSheet(6, 6, 1.0, 1.0);
  EXPECT_THROW(MassSpring(s.points, s.normals, s.rings, s.area, s.isClosed(), MaterialParams(),
                          choose(Membrane::kTriangles, Bending::kNone, 1.0)),
               InputError);
}

}  // namespace
}  // namespace deformable_surface::test
