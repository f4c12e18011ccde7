#include "deformable_surface/simulation/loads.h"
#include "clouds.h"
#include "deformable_surface/model/mass_spring/mass_spring.h"

#include <gtest/gtest.h>

#include <cmath>

namespace deformable_surface::test {
namespace {

using model::MassSpring;
using simulation::State;

State still(const Points& positions) { return {positions, Points(positions.size(), Vec3::Zero())}; }

Points forcesOf(const solve::ExternalLoad& load, const State& state) {
  Points forces(state.positions.size(), Vec3::Zero());
  load.addForces(0.0, state, forces);
  return forces;
}

Vec3 sum(const Points& vectors) {
  Vec3 total = Vec3::Zero();
  for (const Vec3& v : vectors) total += v;
  return total;
}

MassSpring makeModel(const Surface& s) {
  return MassSpring(s.points, s.normals, s.rings, s.area, s.isClosed(), model::MaterialParams(), model::MassSpringParams());
}

// Minus the slope of the potential along single coordinates.
void checkPotential(const solve::ExternalLoad& load, const State& state) {
  ASSERT_TRUE(load.isConservative());
  const Points forces = forcesOf(load, state);
  const double h = 1e-5;
  for (std::size_t i = 0; i < forces.size(); i += 1 + forces.size() / 7)
    for (int c = 0; c < 3; ++c) {
      State ahead = state, behind = state;
      ahead.positions[i][c] += h;
      behind.positions[i][c] -= h;
      const double slope = (load.potential(0.0, ahead) - load.potential(0.0, behind)) / (2.0 * h);
      EXPECT_NEAR(-slope, forces[i][c], 1e-6 * (1.0 + forces[i].norm())) << i;
    }
}

TEST(Gravity, PullsEveryPointByItsWeight) {
  const Surface s = makeSheet(6, 5, 1.0, 0.8);
  const MassSpring m = makeModel(s);
  const simulation::GravityLoad load(m.masses(), Vec3(0.0, 1.0, -9.0));
  EXPECT_LT((sum(forcesOf(load, still(s.points))) - s.area * 1.0 * Vec3(0.0, 1.0, -9.0)).norm(), 1e-12);  // 1 kg/m^2
  checkPotential(load, still(s.points));
}

TEST(Pressure, PushesASheetByItsAreaAlongItsNormal) {
  const Surface s = makeSheet(9, 8, 1.0, 0.8, 0.2);
  const MassSpring m = makeModel(s);
  const simulation::PressureLoad load(m, 3.0);
  EXPECT_LT((sum(forcesOf(load, still(s.points))) - Vec3(0.0, 0.0, 3.0 * 0.8)).norm(), 1e-10);
  EXPECT_FALSE(load.isConservative());
}

TEST(Pressure, FollowsTheCurrentAreaAndNormal) {
  const Surface s = makeSheet(9, 8, 1.0, 0.8);
  const MassSpring m = makeModel(s);
  const simulation::PressureLoad load(m, 3.0);
  const Mat3 rotation = someRotation();
  Points moved = s.points;
  for (Vec3& p : moved) p = rotation * (2.0 * p);
  EXPECT_LT((sum(forcesOf(load, still(moved))) - rotation * Vec3(0.0, 0.0, 4.0 * 3.0 * 0.8)).norm(), 1e-10);
}

TEST(Pressure, InAClosedSurfaceHasNoNetForceAndAPotential) {
  const Surface s = makeSphere(300, 0.4);
  const MassSpring m = makeModel(s);
  const simulation::PressureLoad load(m, 5.0);
  const Points forces = forcesOf(load, still(s.points));
  double outward = 0.0;
  for (std::size_t i = 0; i < forces.size(); ++i) outward += forces[i].dot(s.normals[i]);
  EXPECT_NEAR(outward, 5.0 * 4.0 * M_PI * 0.16, 0.03 * outward);
  EXPECT_LT(sum(forces).norm(), 1e-12 * outward);
  checkPotential(load, still(s.points));
}

// The change of the forces along a displacement, against the matrix and its skew part. A closed surface has none. The triangles
// of this one do not quite close.
TEST(Pressure, HasTheDerivativeOfItsForces) {
  for (const Surface& s : {makeSheet(9, 8, 1.0, 0.8, 0.2), makeSphere(300, 0.4)}) {
    const MassSpring m = makeModel(s);
    const simulation::PressureLoad load(m, 5.0);
    const Index n = static_cast<Index>(s.points.size());
    const State state = still(s.points);
    Points way;
    for (Index i = 0; i < n; ++i) way.emplace_back(std::sin(3.0 * i), std::cos(5.0 * i), std::sin(7.0 * i + 1.0));
    const double h = 1e-5;
    State ahead = state, behind = state;
    for (Index i = 0; i < n; ++i) {
      ahead.positions[i] += h * way[i];
      behind.positions[i] -= h * way[i];
    }
    const Points forces_ahead = forcesOf(load, ahead), forces_behind = forcesOf(load, behind);
    BlockSparse matrix;
    matrix.begin(n);
    load.addIndefiniteStiffness(0.0, state, matrix);
    matrix.finish();
    Eigen::VectorXd product;
    matrix.multiply(Eigen::Map<const Eigen::VectorXd>(way[0].data(), 3 * n), product);
    Points skew(n, Vec3::Zero());
    load.addSkewProduct(0.0, state, way, skew);
    double largest = 0.0, largest_skew = 0.0, work = 0.0;
    for (Index i = 0; i < n; ++i) {
      const Vec3 change = (forces_ahead[i] - forces_behind[i]) / (2.0 * h);
      EXPECT_LT((Vec3(product.segment<3>(3 * i)) + skew[i] + change).norm(), s.isClosed() ? 5e-4 : 1e-6) << i;
      largest = std::max(largest, change.norm());
      largest_skew = std::max(largest_skew, skew[i].norm());
      work += skew[i].dot(way[i]);
    }
    EXPECT_GT(largest, 0.5);
    EXPECT_NEAR(work, 0.0, 1e-9);
    EXPECT_EQ(load.hasSkewStiffness(), !s.isClosed());
    EXPECT_EQ(largest_skew > 0.0, !s.isClosed());
  }
}

TEST(Drag, BrakesTheNormalVelocityOnly) {
  const Surface s = makeSheet(9, 8, 1.0, 0.8);
  const MassSpring m = makeModel(s);
  const simulation::DragLoad load(m, 2.0);
  State state = still(s.points);
  for (Vec3& v : state.velocities) v = Vec3(7.0, -3.0, 1.5);
  EXPECT_LT((sum(forcesOf(load, state)) - Vec3(0.0, 0.0, -2.0 * 1.5 * 0.8)).norm(), 1e-10);
}

TEST(Drag, BringsAFallingSheetToItsTerminalSpeed) {
  // c A v = m g.
  simulation::SceneParams p;
  p.viscous_drag = 4.0;
  p.simplification.target_points = 60;
  simulation::Simulation s(p, sheetCloud(10));
  run(s, 300);
  for (const Vec3& v : s.state().velocities) EXPECT_NEAR(v.z(), -9.81 / 4.0, 0.02);
}

TEST(Anchors, PullTheNearestPointTowardsTheirTarget) {
  const simulation::AnchorLoad load({{3, Vec3(1.0, 2.0, 3.0), 50.0}});
  const State state = still(Points(5, Vec3(1.0, 1.0, 1.0)));
  const Points forces = forcesOf(load, state);
  EXPECT_LT((forces[3] - Vec3(0.0, 50.0, 100.0)).norm(), 1e-12);
  EXPECT_EQ(forces[0], Vec3(Vec3::Zero()));
  checkPotential(load, state);
}

TEST(Anchors, HoldASurfaceWhereTheSpringsBalanceItsWeight) {
  // Four springs at the corners, each a quarter of the weight: the corners hang by m g / (4 k).
  simulation::SceneParams p;
  p.material.damping = 5.0;
  p.material.young_modulus = 1e7;
  p.material.bending_rigidity = 10.0;
  p.simplification.method = cloud::SimplificationMethod::kNone;
  const cloud::PointCloud cloud = asCloud(makeSheet(6, 6, 1.0, 1.0).points);
  for (const Vec3& corner : {Vec3(0.0, -0.5, 0.0), Vec3(0.0, 0.5, 0.0), Vec3(1.0, -0.5, 0.0), Vec3(1.0, 0.5, 0.0)})
    p.anchors.push_back({corner, corner, 100.0});
  p.integrator.type = solve::IntegratorType::kStatic;
  simulation::Simulation s(p, cloud);
  run(s, 1);
  for (Index i = 0; i < s.state().size(); ++i)
    if (std::abs(std::abs(s.input().positions[i].y()) - 0.5) < 1e-9 && std::abs(s.input().positions[i].x() - 0.5) > 0.499) {
      EXPECT_NEAR(s.state().positions[i].z(), -9.81 / 400.0, 1e-3);
    }
}

TEST(NamedForces, AreSharedByMassAmongThePointsInTheirRadius) {
  const std::vector<double> masses{1.0, 2.0, 3.0, 4.0};
  const std::vector<char> none(4, 0);
  simulation::NamedForces forces(masses);
  State state = still({Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(2, 0, 0), Vec3(9, 0, 0)});
  forces.set({"a", Vec3(1, 0, 0), Vec3(0, 0, 12), 1.0, 0.0, 1e300});
  forces.update(0.0, state, none);
  const Points found = forcesOf(forces, state);
  EXPECT_DOUBLE_EQ(found[0].z(), 2.0);
  EXPECT_DOUBLE_EQ(found[1].z(), 4.0);
  EXPECT_DOUBLE_EQ(found[2].z(), 6.0);
  EXPECT_DOUBLE_EQ(found[3].z(), 0.0);
  checkPotential(forces, state);
  // The points are kept although they move away.
  state.positions[0].x() = -100.0;
  forces.update(1.0, state, none);
  EXPECT_DOUBLE_EQ(forcesOf(forces, state)[0].z(), 2.0);
}

TEST(NamedForces, TakeTheNearestPointWhereTheRadiusHoldsNone) {
  const std::vector<double> masses{1.0, 2.0};
  const std::vector<char> none(2, 0);
  simulation::NamedForces forces(masses);
  const State state = still({Vec3(0, 0, 0), Vec3(1, 0, 0)});
  forces.set({"a", Vec3(0.6, 5, 0), Vec3(0, 0, 3), 0.1, 0.0, 1e300});
  forces.update(0.0, state, none);
  EXPECT_DOUBLE_EQ(forcesOf(forces, state)[1].z(), 3.0);
}

TEST(NamedForces, TellOnceOfAForceThatActsFarAwayOrOnPinnedPointsOnly) {
  const std::vector<double> masses{1.0, 2.0, 3.0};
  const std::vector<char> pinned{1, 1, 0};
  simulation::NamedForces forces(masses);
  const State state = still({Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(2, 0, 0)});
  const auto put = [&](const Vec3& point, double radius) {
    forces.set({"a", point, Vec3::UnitZ(), radius, 0.0, 1e300});
    return forces.update(0.0, state, pinned).notice;
  };
  const auto putAnew = [&](const Vec3& point, double radius) {
    forces.clear();
    return put(point, radius);
  };
  EXPECT_EQ(put(Vec3(2, 0, 0), 0.1), "");
  EXPECT_EQ(put(Vec3(1, 0, 0), 1.0), "");  // one of its points is free
  EXPECT_EQ(put(Vec3(2, 5, 0), 0.0), "");  // without a radius the nearest one is meant
  EXPECT_EQ(put(Vec3(2, 5, 0), 0.1),
            "force 'a': no simulation point lies within its radius of 0.1 m; it acts on the nearest one, 5 m from its point");
  EXPECT_EQ(put(Vec3(2, 6, 0), 0.1), "");  // reported
  EXPECT_EQ(forces.update(0.0, state, pinned).notice, "");
  EXPECT_EQ(put(Vec3(2, 0, 0), 0.1), "");
  EXPECT_NE(put(Vec3(2, 6, 0), 0.1), "");  // it was valid in between
  EXPECT_NE(putAnew(Vec3(2, 6, 0), 0.1), "");
  EXPECT_NE(putAnew(Vec3(-5, 0, 0), 0.1).find("5 m from its point, which is pinned"), std::string::npos);
  EXPECT_EQ(putAnew(Vec3(0.9, 0, 0), 0.0), "force 'a': the simulation point that it acts on is pinned; it moves nothing");
  EXPECT_EQ(putAnew(Vec3(0.5, 0, 0), 0.5), "force 'a': all 2 simulation points that it acts on are pinned; it moves nothing");
}

TEST(NamedForces, TellOnceOfAPartThatTheModelDrops) {
  const std::vector<double> masses{1.0, 2.0};
  const State state = still({Vec3(0, 0, 0), Vec3(1, 0, 0)});
  simulation::NamedForces forces(masses);
  forces.setDropped(Vec3::UnitY());
  const auto put = [&](const Vec3& force) {
    forces.set({"a", Vec3::Zero(), force, 0.0, 0.0, 1e300});
    return forces.update(0.0, state, {0, 0}).notice;
  };
  EXPECT_EQ(put(Vec3(3, 0, 4)), "");
  EXPECT_EQ(put(Vec3(3, -4, 0)),
            "force 'a': 4 N of its 5 N are perpendicular to the plane in which this planar solid moves, and are ignored");
  EXPECT_EQ(put(Vec3(3, -4, 0)), "");  // reported
}

TEST(NamedForces, ActInTheStepsThatBeginInTheirWindow) {
  const auto acts = [](double start, double end) {
    return simulation::actsInAStep({"a", Vec3::Zero(), Vec3::UnitZ(), 0.0, start, end}, 0.1, 1.0);
  };
  EXPECT_TRUE(acts(0.0, 1e300));
  EXPECT_TRUE(acts(-1e300, 0.05));
  EXPECT_TRUE(acts(0.9, 1.0));
  EXPECT_TRUE(acts(3 * 0.1, 0.35));  // rounded up
  EXPECT_FALSE(acts(0.95, 1e300));   // the last step begins before
  EXPECT_FALSE(acts(1.0, 2.0));
  EXPECT_FALSE(acts(-1.0, 0.0));
  EXPECT_FALSE(acts(0.22, 0.28));  // between two steps
  EXPECT_FALSE(acts(1e300, 1e301));
}

}  // namespace
}  // namespace deformable_surface::test
