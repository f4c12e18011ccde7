// Springs push parts of a surface apart, and the limit of motion keeps them from crossing.
#include "deformable_surface/contact/self_contact.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "../support/crossings.h"
#include "folded_sheets.h"

namespace deformable_surface::contact {
namespace {

const SelfContactParams kParams{0.002, 400.0, 0.05};

double massOf(std::size_t i) { return 1e-4 * (1.0 + 0.3 * (i % 3)); }

SelfContact makeContact(const test::Sheets& sheets, const Points& rest, const SelfContactParams& params = kParams) {
  std::vector<double> masses;
  for (std::size_t i = 0; i < rest.size(); ++i) masses.push_back(massOf(i));
  return SelfContact(rest, sheets.triangles, masses, params);
}

// The rest shape has the sheets farther apart, so that no pair is too close at rest.
Points spread(Points points, int per_sheet) {
  for (std::size_t i = 0; i < points.size(); ++i) points[i].z() += 0.05 * (i / per_sheet);
  return points;
}

// The forces are minus the gradient of the potential, and sum up to none.
void checkGradient(const test::Sheets& sheets, const SelfContactParams& params) {
  SelfContact contact = makeContact(sheets, spread(sheets.points, 25), params);
  Points forces(sheets.points.size(), Vec3::Zero());
  contact.addForces(sheets.points, forces);
  Vec3 sum = Vec3::Zero(), torque = Vec3::Zero();
  double largest = 0.0;
  for (std::size_t i = 0; i < forces.size(); ++i) {
    sum += forces[i];
    torque += sheets.points[i].cross(forces[i]);
    largest = std::max(largest, forces[i].norm());
  }
  EXPECT_GT(largest, 1e-3);
  EXPECT_LT(sum.norm(), 1e-12 * largest * forces.size());
  EXPECT_LT(torque.norm(), 1e-12 * largest * forces.size());
  const double h = 1e-8;
  for (std::size_t i = 0; i < forces.size(); i += 3)
    for (int k = 0; k < 3; ++k) {
      Points plus = sheets.points, minus = sheets.points;
      plus[i][k] += h;
      minus[i][k] -= h;
      const double slope = (contact.potential(plus) - contact.potential(minus)) / (2.0 * h);
      EXPECT_NEAR(forces[i][k], -slope, 1e-4 * largest) << i << ' ' << k;
    }
}

TEST(SelfContact, PushesWithTheGradientOfItsPotential) { checkGradient(test::makeSheets(2, 5, 0.0013, 0.0004), kParams); }

// Sheets a sixth, a third and nearly half of the thickness into each other, whose edges are a degree to some ten apart in angle.
TEST(SelfContact, SpringsThatHardenPushWithTheGradientOfTheirPotential) {
  SelfContactParams params = kParams;
  params.hardens = true;
  for (const double gap : {0.00167, 0.00135, 0.00108})
    for (const double turn : {0.02, 0.1, 0.3}) {
      test::Sheets sheets = test::makeSheets(2, 5, gap, 0.00003);
      const Eigen::AngleAxisd rotation(turn, Vec3::UnitZ());
      for (std::size_t i = 25; i < sheets.points.size(); ++i) sheets.points[i] = rotation * sheets.points[i];
      checkGradient(sheets, params);
    }
}

// Pads a fifth as stiff as the penalty, with the barrier of springs that harden.
TEST(SelfContact, SpringsOfPadsPushWithTheGradientOfTheirPotential) {
  SelfContactParams params = kParams;
  params.areas.assign(50, 1e-4);
  const test::Sheets sheets = test::makeSheets(2, 5, 0.0012, 0.0001);
  SelfContact hard = makeContact(sheets, spread(sheets.points, 25), params);
  params.compliance = 5.0 * hard.ownCompliance();
  SelfContact soft = makeContact(sheets, spread(sheets.points, 25), params);
  EXPECT_LT(soft.potential(sheets.points), 0.3 * hard.potential(sheets.points));
  for (const bool hardens : {false, true}) {
    params.hardens = hardens;
    checkGradient(sheets, params);
  }
}

// A balance is found only where no force sets in at once.
TEST(SelfContact, ForcesOfSpringsThatHardenAreContinuousAndStrongWhereMotionIsLimited) {
  SelfContactParams params = kParams;
  params.hardens = true;
  const auto measure = [&](double gap, bool is_damped) {
    const test::Sheets sheets = test::makeSheets(2, 5, gap, 0.0);
    SelfContact contact = makeContact(sheets, spread(sheets.points, 25), params);
    Points velocities(sheets.points.size(), Vec3::Zero()), forces = velocities;
    for (std::size_t i = 25; i < velocities.size(); ++i) velocities[i].z() = -0.1;
    if (is_damped)
      contact.addDampingForces(sheets.points, velocities, forces);
    else
      contact.addForces(sheets.points, forces);
    double sum = 0.0;
    for (std::size_t i = 25; i < forces.size(); ++i) sum += forces[i].z();
    return sum;
  };
  const double t = params.thickness, full = measure(0.8 * t, true);
  EXPECT_GT(full, 0.0);
  EXPECT_GT(measure(0.999 * t, true), 0.0);
  EXPECT_LT(measure(0.999 * t, true), 0.02 * full);
  EXPECT_NEAR(measure(0.7501 * t, false), measure(0.7499 * t, false), 2e-3 * measure(0.75 * t, false));
  EXPECT_GT(measure(0.505 * t, false), 50.0 * measure(0.75 * t, false));
}

// Sheets that approach, rest or part slowly where damping sets in.
TEST(SelfContact, StiffnessIsTheDerivativeOfSpringsAndOfDampingThatSetsIn) {
  constexpr double kStep = 1e-3, kSmall = 1e-9;
  SelfContactParams params = kParams;
  params.hardens = true;
  for (const double speed : {-0.1, 0.0, 0.01}) {
    const test::Sheets sheets = test::makeSheets(2, 5, 0.95 * params.thickness, 0.0);
    SelfContact contact = makeContact(sheets, spread(sheets.points, 25), params);
    const auto findForce = [&](double moved) {
      Points points = sheets.points, velocities(points.size(), Vec3::Zero()), forces = velocities;
      for (std::size_t i = 25; i < points.size(); ++i) {
        points[i].z() += moved;
        velocities[i].z() = speed + moved / kStep;
      }
      contact.addForces(points, forces);
      contact.addDampingForces(points, velocities, forces);
      double sum = 0.0;
      for (std::size_t i = 25; i < forces.size(); ++i) sum += forces[i].z();
      return sum;
    };
    const double slope = (findForce(kSmall) - findForce(-kSmall)) / (2.0 * kSmall);
    Points velocities(sheets.points.size(), Vec3::Zero());
    Eigen::VectorXd up = Eigen::VectorXd::Zero(3 * static_cast<Eigen::Index>(sheets.points.size())), product;
    for (std::size_t i = 25; i < velocities.size(); ++i) {
      velocities[i].z() = speed;
      up[3 * static_cast<Eigen::Index>(i) + 2] = 1.0;
    }
    BlockSparse matrix;
    matrix.begin(static_cast<Index>(sheets.points.size()));
    contact.addStiffness(sheets.points, velocities, kStep, matrix);
    matrix.finish();
    matrix.multiply(up, product);
    EXPECT_LT(slope, 0.0);
    EXPECT_NEAR(up.dot(product), -slope, 1e-4 * std::abs(slope)) << speed;
  }
}

TEST(SelfContact, PartsUpToOneAndAHalfThicknessesApartMayTouch) {
  for (const double gap : {0.9, 1.2, 1.4, 1.6, 3.0}) {
    const test::Sheets sheets = test::makeSheets(2, 5, gap * kParams.thickness, 0.0);
    SelfContact contact = makeContact(sheets, spread(sheets.points, 25));
    EXPECT_EQ(contact.mayTouch(sheets.points, Points(sheets.points.size(), Vec3::Zero()), 0.01), gap < 1.5) << gap;
    EXPECT_EQ(contact.countTouching(sheets.points) > 0, gap < 1.0) << gap;
  }
}

TEST(SelfContact, DampingTakesEnergyAndNoMomentum) {
  const test::Sheets sheets = test::makeSheets(2, 5, 0.0013, 0.0004);
  SelfContact contact = makeContact(sheets, spread(sheets.points, 25));
  std::mt19937 generator(4);
  Points velocities, forces(sheets.points.size(), Vec3::Zero());
  for (std::size_t i = 0; i < forces.size(); ++i) velocities.push_back(test::randomVector(generator));
  contact.addDampingForces(sheets.points, velocities, forces);
  double power = 0.0;
  Vec3 sum = Vec3::Zero();
  for (std::size_t i = 0; i < forces.size(); ++i) {
    power += forces[i].dot(velocities[i]);
    sum += forces[i];
  }
  EXPECT_LT(power, -1e-6);
  EXPECT_LT(sum.norm(), 1e-12);
}

// All springs at a point together are damped at most three times as strongly as one alone, in shares of critical damping.
TEST(SelfContact, DampingIsAShareOfTheCriticalOneOfAllSpringsAtAPoint) {
  const test::Sheets sheets = test::makeSheets(6, 5, 0.0008, 0.0002);
  SelfContact contact = makeContact(sheets, spread(sheets.points, 25));
  std::vector<double> stiffness(sheets.points.size()), damping(sheets.points.size());
  contact.addStiffnessBounds(sheets.points, stiffness);
  contact.addDampingBounds(sheets.points, damping);
  double most = 0.0;
  for (std::size_t i = 0; i < damping.size(); ++i) {
    // The bounds are twice the sums.
    const double critical = 2.0 * std::sqrt(0.5 * stiffness[i] * massOf(i));
    EXPECT_LE(0.5 * damping[i], 3.0 * kParams.damping * critical * (1.0 + 1e-12)) << i;
    most = std::max(most, stiffness[i] / (massOf(i) * kParams.rate * kParams.rate));
  }
  EXPECT_GT(most, 20.0);  // springs at a point: of two layers alone it would be a few
}

constexpr double kStep = 1e9;  // s, in which springs of friction relax whatever their dampers do

SelfContactParams withFriction(double coefficient) {
  SelfContactParams params = kParams;
  params.friction = params.kinetic_friction = coefficient;
  return params;
}

TEST(SelfContact, FrictionsEnergyAtOtherTimesNeedsNoSearch) {
  const test::Sheets sheets = test::makeSheets(2, 5, 0.0019, 0.0);
  SelfContact contact = makeContact(sheets, spread(sheets.points, 25), withFriction(0.5));
  std::vector<PairAnchor> anchors;
  contact.moveAnchors(sheets.points, Points(sheets.points.size(), Vec3::Zero()), kStep, anchors);
  Points moved = sheets.points;
  for (std::size_t i = 25; i < moved.size(); ++i) moved[i].x() += 1e-6;
  contact.countTouching(moved);
  const Index num_searches = contact.numSearches();
  Points far = moved;
  for (Vec3& p : far) p *= 3.0;
  EXPECT_EQ(contact.frictionEnergy(far, anchors), 0.0);
  EXPECT_GT(contact.frictionEnergy(moved, anchors), 0.0);
  EXPECT_EQ(contact.numSearches(), num_searches);
}

// The upper sheet is moved along the lower one: it is held by the springs of friction, up to Coulomb's limit.
TEST(SelfContact, FrictionHoldsUpToItsLimitAndKeepsMomentum) {
  const test::Sheets sheets = test::makeSheets(2, 5, 0.0019, 0.0);
  SelfContact contact = makeContact(sheets, spread(sheets.points, 25), withFriction(0.5));
  const Points still(sheets.points.size(), Vec3::Zero());
  std::vector<PairAnchor> anchors;
  contact.moveAnchors(sheets.points, still, kStep, anchors);
  ASSERT_GT(anchors.size(), 20u);
  for (const auto& [way, slides] : {std::pair<double, bool>{1e-6, false}, {1e-3, true}}) {
    Points moved = sheets.points, pushing(moved.size(), Vec3::Zero()), rubbing = pushing;
    for (std::size_t i = 25; i < moved.size(); ++i) moved[i].x() += way;
    contact.addForces(moved, pushing);
    contact.addFriction(moved, still, anchors, rubbing);
    double pressed = 0.0, held = 0.0;
    Vec3 sum = Vec3::Zero();
    for (std::size_t i = 0; i < moved.size(); ++i) {
      sum += rubbing[i];
      if (i < 25) continue;
      pressed += pushing[i].z();
      held -= rubbing[i].x();
    }
    EXPECT_LT(sum.norm(), 1e-12 * pressed);
    EXPECT_GT(held, 0.0);
    if (slides) {
      EXPECT_NEAR(held, 0.5 * pressed, 1e-3 * pressed);
    } else {
      EXPECT_LT(held, 0.2 * pressed);
    }
    std::vector<PairAnchor> next = anchors;
    contact.moveAnchors(moved, still, kStep, next);
    for (const PairAnchor& anchor : next) EXPECT_EQ(anchor.slid > 0.0, slides);
    // The friction springs that remain carry the whole load.
    Points again(moved.size(), Vec3::Zero());
    contact.addFriction(moved, still, next, again);
    for (std::size_t i = 0; i < moved.size(); ++i) EXPECT_LT((again[i] - rubbing[i]).norm(), 1e-9 * pressed) << i;
  }
}

// The places of anchors are remembered with the pairs: other anchors at the same positions are found as well.
TEST(SelfContact, FrictionDoesNotDependOnTheAnchorsBefore) {
  const test::Sheets sheets = test::makeSheets(2, 5, 0.0019, 0.0);
  const auto make = [&] { return makeContact(sheets, spread(sheets.points, 25), withFriction(0.5)); };
  const Points still(sheets.points.size(), Vec3::Zero());
  std::vector<PairAnchor> all, odd, first;
  make().moveAnchors(sheets.points, still, kStep, all);
  for (std::size_t k = 0; k < all.size(); ++k) {
    if (k % 2 == 1) odd.push_back(all[k]);
    if (k < 5) first.push_back(all[k]);
  }
  Points moved = sheets.points;
  for (std::size_t i = 25; i < moved.size(); ++i) moved[i].x() += 1e-6;
  SelfContact contact = make();
  for (const std::vector<PairAnchor>& anchors : {all, odd, {}, first, all, first, odd}) {
    Points forces(moved.size(), Vec3::Zero()), expected = forces;
    contact.addFriction(moved, still, anchors, forces);
    make().addFriction(moved, still, anchors, expected);
    EXPECT_EQ(forces, expected) << anchors.size();
    std::vector<PairAnchor> next = anchors, expected_next = anchors;
    contact.moveAnchors(moved, still, kStep, next);
    make().moveAnchors(moved, still, kStep, expected_next);
    ASSERT_EQ(next.size(), all.size());
    for (std::size_t k = 0; k < all.size(); ++k) {
      EXPECT_EQ(next[k].vertices, all[k].vertices);
      EXPECT_EQ(next[k].is_edges, all[k].is_edges);
      EXPECT_EQ(next[k].offset, expected_next[k].offset);
    }
  }
}

TEST(SelfContact, WhatSlidesHasTheKineticCoefficient) {
  const test::Sheets sheets = test::makeSheets(2, 5, 0.0019, 0.0);
  SelfContactParams params = withFriction(0.5);
  params.kinetic_friction = 0.2;
  SelfContact contact = makeContact(sheets, spread(sheets.points, 25), params);
  const Points still(sheets.points.size(), Vec3::Zero());
  std::vector<PairAnchor> anchors;
  contact.moveAnchors(sheets.points, still, kStep, anchors);
  Points moved = sheets.points;
  for (const double limit : {0.5, 0.2}) {  // as it breaks away, and as it goes on
    Points pushing(moved.size(), Vec3::Zero()), rubbing = pushing;
    for (std::size_t i = 25; i < moved.size(); ++i) moved[i].x() += 1e-3;
    contact.addForces(moved, pushing);
    contact.addFriction(moved, still, anchors, rubbing);
    double pressed = 0.0, held = 0.0;
    for (std::size_t i = 25; i < moved.size(); ++i) {
      pressed += pushing[i].z();
      held -= rubbing[i].x();
    }
    EXPECT_NEAR(held, limit * pressed, 1e-3 * pressed);
    contact.moveAnchors(moved, still, kStep, anchors);
  }
}

TEST(SelfContact, FrictionOfWhatMovesTogetherIsNone) {
  const test::Sheets sheets = test::makeSheets(2, 5, 0.0019, 0.0);
  SelfContact contact = makeContact(sheets, spread(sheets.points, 25), withFriction(0.5));
  const Points even(sheets.points.size(), Vec3(1.0, 2.0, 0.0));
  std::vector<PairAnchor> anchors;
  contact.moveAnchors(sheets.points, even, kStep, anchors);
  Points moved = sheets.points, forces(moved.size(), Vec3::Zero());
  for (Vec3& x : moved) x += Vec3(0.3, -0.2, 0.1);
  contact.addFriction(moved, even, anchors, forces);
  for (const Vec3& force : forces) EXPECT_LT(force.norm(), 1e-12);
  EXPECT_LT(contact.frictionEnergy(moved, anchors), 1e-20);
}

TEST(SelfContact, StiffnessStaysBelowItsBounds) {
  const test::Sheets sheets = test::makeSheets(2, 4, 0.0013, 0.0004);
  SelfContact contact = makeContact(sheets, spread(sheets.points, 16));
  std::vector<double> stiffness(sheets.points.size()), damping(sheets.points.size());
  contact.addStiffnessBounds(sheets.points, stiffness);
  contact.addDampingBounds(sheets.points, damping);
  const double h = 1e-8;
  const auto forcesAt = [&](const Points& x) {
    Points forces(x.size(), Vec3::Zero());
    contact.addForces(x, forces);
    return forces;
  };
  for (std::size_t i = 0; i < stiffness.size(); ++i) {
    double largest = 0.0;  // of the diagonal block along an axis
    for (int k = 0; k < 3; ++k) {
      Points plus = sheets.points, minus = sheets.points;
      plus[i][k] += h;
      minus[i][k] -= h;
      largest = std::max(largest, (forcesAt(minus)[i] - forcesAt(plus)[i])[k] / (2.0 * h));
    }
    EXPECT_LE(largest, stiffness[i] * (1.0 + 1e-4) + 1e-6) << i;
  }
}

void expectNoCrossingBetween(const Points& from, const Points& to, const std::vector<Triangle>& triangles) {
  for (int k = 1; k <= 10; ++k) {
    Points between;
    for (std::size_t i = 0; i < from.size(); ++i) between.push_back(from[i] + 0.1 * k * (to[i] - from[i]));
    EXPECT_TRUE(test::findCrossings(between, triangles).empty()) << "after " << k << " tenths of the way";
  }
}

// Points with random motion far beyond the gaps.
TEST(SelfContact, NothingCrossesOnLimitedWays) {
  std::mt19937 generator(6);
  Index num_crossing_before = 0;
  for (unsigned seed = 1; seed <= 6; ++seed) {
    const test::Sheets sheets = test::makeSheets(3, 6, 0.0025, 0.0006, seed);
    SelfContact contact = makeContact(sheets, spread(sheets.points, 36));
    Points positions = sheets.points;
    ASSERT_TRUE(test::findCrossings(positions, sheets.triangles).empty());
    for (int step = 0; step < 30; ++step) {
      Points after = positions;
      for (std::size_t i = 0; i < after.size(); ++i)
        if (i % 7 != 0) after[i] += Vec3(0.0, 0.0, 0.003 * (1.0 - i / 36)) + 0.002 * test::randomVector(generator);
      const Points wanted = after;
      double wanted_energy = 0.0, energy = 0.0;  // the motion up to a factor
      num_crossing_before += !test::findCrossings(after, sheets.triangles).empty();
      const std::vector<Index> cut = contact.limit(positions, after);
      for (std::size_t i = 0; i < after.size(); ++i) {
        const bool is_cut = std::binary_search(cut.begin(), cut.end(), static_cast<Index>(i));
        EXPECT_TRUE(is_cut || after[i] == wanted[i]) << i;
        EXPECT_TRUE(i % 7 != 0 || after[i] == positions[i]) << i;
        wanted_energy += massOf(i) * (wanted[i] - positions[i]).squaredNorm();
        energy += massOf(i) * (after[i] - positions[i]).squaredNorm();
      }
      EXPECT_LE(energy, wanted_energy);
      expectNoCrossingBetween(positions, after, sheets.triangles);
      ASSERT_FALSE(HasFailure()) << seed << ' ' << step;
      positions = after;
    }
  }
  EXPECT_GT(num_crossing_before, 100);
}

// A few points fly by up to five edges, the others hardly move.
TEST(SelfContact, NothingCrossesWhereFewPointsAreFast) {
  std::mt19937 generator(3);
  Index num_crossing_before = 0;
  for (unsigned seed = 1; seed <= 6; ++seed) {
    const test::Sheets sheets = test::makeSheets(3, 8, 0.0025, 0.0006, seed);
    SelfContact contact = makeContact(sheets, spread(sheets.points, 64));
    Points positions = sheets.points;
    for (int step = 0; step < 12; ++step) {
      Points after = positions;
      double wanted_energy = 0.0, energy = 0.0;  // the motion up to a factor
      for (std::size_t i = 0; i < after.size(); ++i) {
        const bool is_fast = (i + 17 * step) % 61 == 0;
        after[i] += (is_fast ? 0.07 : 1e-4) * test::randomVector(generator);
        wanted_energy += massOf(i) * (after[i] - positions[i]).squaredNorm();
      }
      num_crossing_before += !test::findCrossings(after, sheets.triangles).empty();
      contact.limit(positions, after);
      for (std::size_t i = 0; i < after.size(); ++i) energy += massOf(i) * (after[i] - positions[i]).squaredNorm();
      EXPECT_LE(energy, wanted_energy);
      expectNoCrossingBetween(positions, after, sheets.triangles);
      ASSERT_FALSE(HasFailure()) << seed << ' ' << step;
      positions = after;
    }
  }
  EXPECT_GT(num_crossing_before, 60);
}

TEST(SelfContact, LooksOnlyAroundAFastPoint) {
  const test::Sheets sheets = test::makeSheets(1, 40, 0.0, 0.0004);
  SelfContact contact = makeContact(sheets, sheets.points, {0.0004, 400.0, 0.05});
  Points after = sheets.points;
  after[820] += Vec3(0.006, 0.0, 0.006);  // three edges
  EXPECT_FALSE(contact.limit(sheets.points, after).empty());
  EXPECT_GT(contact.numApproaches(), 100);
  // In the whole sheet 1.7 million pairs are as near to each other as this way is long.
  EXPECT_LT(contact.numApproaches(), 20000);
}

TEST(SelfContact, CollisionsKeepMomentum) {
  const test::Sheets sheets = test::makeSheets(2, 5, 0.0016, 0.0);
  SelfContact contact = makeContact(sheets, spread(sheets.points, 25));
  Points after = sheets.points;
  for (std::size_t i = 0; i < after.size(); ++i) after[i] += Vec3(2e-4, 1e-4, i >= 25 ? -8e-4 : 3e-4);
  Vec3 before_sum = Vec3::Zero(), after_sum = Vec3::Zero();
  for (std::size_t i = 0; i < after.size(); ++i) before_sum += massOf(i) * (after[i] - sheets.points[i]);
  EXPECT_GT(contact.limit(sheets.points, after).size(), 20u);
  for (std::size_t i = 0; i < after.size(); ++i) after_sum += massOf(i) * (after[i] - sheets.points[i]);
  EXPECT_LT((after_sum - before_sum).norm(), 1e-9 * before_sum.norm());
}

// A point that a blow throws through the other sheet, many edges far, does not drag its neighbours along.
TEST(SelfContact, WhatOutrunsTheOthersMovesOnWithThemAsOne) {
  const test::Sheets sheets = test::makeSheets(2, 5, 0.0016, 0.0);
  SelfContact contact = makeContact(sheets, spread(sheets.points, 25));
  for (const bool does_one_stay : {false, true}) {
    Points after = sheets.points;
    for (std::size_t i = does_one_stay ? 1 : 0; i < after.size(); ++i) after[i] += Vec3(1e-5, 0.0, 0.0);
    after[37].z() -= 10.0;
    Vec3 momentum = Vec3::Zero(), motion = Vec3::Zero();
    double mass = 0.0;
    for (std::size_t i = 0; i < after.size(); ++i) {
      momentum += massOf(i) * (after[i] - sheets.points[i]);
      mass += massOf(i);
    }
    if (!does_one_stay) motion = momentum / mass;
    EXPECT_GT(contact.limit(sheets.points, after).size(), 48u);
    for (std::size_t i = 0; i < after.size(); ++i)
      EXPECT_LT((after[i] - sheets.points[i] - motion).norm(), 1e-12 + 1e-12 * motion.norm()) << i;
  }
}

TEST(SelfContact, LimitsOnlyWhatComesNearer) {
  const test::Sheets sheets = test::makeSheets(2, 5, 0.0012, 0.0);
  SelfContact contact = makeContact(sheets, spread(sheets.points, 25));
  const auto countCut = [&](const Vec3& of_upper, const Vec3& of_all) {
    Points after = sheets.points;
    for (std::size_t i = 0; i < after.size(); ++i) after[i] += of_all + (i >= 25 ? of_upper : Vec3(0.0, 0.0, 0.0));
    return contact.limit(sheets.points, after).size();
  };
  EXPECT_EQ(countCut(Vec3::Zero(), Vec3(0.3, -0.2, 1.0)), 0u);             // together
  EXPECT_EQ(countCut(Vec3(0.0, 0.0, 0.02), Vec3::Zero()), 0u);             // apart
  EXPECT_EQ(countCut(Vec3(0.0004, 0.0, 0.0), Vec3(1e-9, 0.0, 0.0)), 0u);   // along each other
  EXPECT_GT(countCut(Vec3(0.0, 0.0, -0.002), Vec3(1e-9, 0.0, 0.0)), 20u);  // on to each other
}

TEST(SelfContact, OnlyPartsThatComeNearerMayTouch) {
  const test::Sheets sheets = test::makeSheets(2, 5, 0.006, 0.0);
  SelfContact contact = makeContact(sheets, spread(sheets.points, 25));
  const auto mayTouch = [&](const auto& velocityOf) {
    Points velocities;
    for (std::size_t i = 0; i < sheets.points.size(); ++i) velocities.push_back(velocityOf(i));
    return contact.mayTouch(sheets.points, velocities, 0.01);
  };
  const auto moveUpper = [](const Vec3& velocity) {
    return [velocity](std::size_t i) { return i >= 25 ? velocity : Vec3(0.0, 0.0, 0.0); };
  };
  EXPECT_TRUE(mayTouch(moveUpper(Vec3(0.0, 0.0, -1.0))));
  EXPECT_FALSE(mayTouch(moveUpper(Vec3(0.0, 0.0, -0.1))));  // not within this time
  EXPECT_FALSE(mayTouch(moveUpper(Vec3(0.0, 0.0, 1.0))));
  EXPECT_FALSE(mayTouch([](std::size_t) { return Vec3(3.0, -2.0, -5.0); }));                               // together
  EXPECT_FALSE(mayTouch([&](std::size_t i) { return Vec3(20.0, -30.0, 40.0).cross(sheets.points[i]); }));  // turning
  EXPECT_TRUE(
      mayTouch([&](std::size_t i) { return i >= 25 ? Vec3(0.0, 80.0, 0.0).cross(sheets.points[i]) : Vec3(0.0, 0.0, 0.0); }));
}

// Springs that are off in the step in which parts meet come on with their energy in the next one. The thickness is up to a third
// of the edges here, and the gap 1.8 thicknesses.
TEST(SelfContact, PartsOfAnyThicknessThatComeNearerMayTouch) {
  SelfContactParams params = kParams;
  for (const double thickness : {0.002, 0.005, 0.0085}) {
    params.thickness = thickness;
    const test::Sheets sheets = test::makeSheets(2, 5, 1.8 * thickness, 0.0);
    SelfContact contact = makeContact(sheets, spread(sheets.points, 25), params);
    const auto mayTouch = [&](double speed) {
      Points velocities(sheets.points.size(), Vec3::Zero());
      for (std::size_t i = 25; i < velocities.size(); ++i) velocities[i].z() = -speed;
      return contact.mayTouch(sheets.points, velocities, 0.01);
    };
    EXPECT_TRUE(mayTouch(40.0 * thickness)) << thickness;   // comes to 1.4 thicknesses
    EXPECT_TRUE(mayTouch(170.0 * thickness)) << thickness;  // to 0.1
    EXPECT_FALSE(mayTouch(10.0 * thickness)) << thickness;  // to 1.7
  }
}

// Proofs of parts, which cost more than the lists that they save, would leave couples of patches out.
TEST(SelfContact, OfClosedSurfacesSearchesAllPartsAtOnce) {
  const test::Sheets ball = test::makeBall(20, 40);
  SelfContact contact = makeContact(ball, ball.points, {0.0001, 400.0, 0.05});
  ASSERT_FALSE(Clearance(ball.points, ball.triangles, 0.0001).hasOutline());
  PairList all(ball.points, ball.triangles, 0.0001);
  all.update(ball.points, 0.0002);
  Points velocities;
  for (const Vec3& p : ball.points) velocities.push_back(Vec3(0.0, 0.0, -0.3 * p.z()));
  EXPECT_FALSE(contact.mayTouch(ball.points, velocities, 1.0));
  EXPECT_GE(contact.numSearches(), all.numSearches());
}

TEST(SelfContact, WithOtherMassesIsAsMadeWithThem) {
  const test::Sheets sheets = test::makeSheets(2, 5, 0.0013, 0.0004);
  const Points rest = spread(sheets.points, 25);
  std::vector<double> masses;
  for (std::size_t i = 0; i < rest.size(); ++i) masses.push_back(massOf(i) * (1.0 + 0.7 * (i % 2)));
  SelfContact changed = makeContact(sheets, rest), made(rest, sheets.triangles, masses, kParams);
  changed.potential(sheets.points);
  changed.setMasses(masses);
  EXPECT_EQ(changed.potential(sheets.points), made.potential(sheets.points));
  Points of_changed(rest.size(), Vec3::Zero()), of_made = of_changed, after = sheets.points, after_made = after;
  changed.addForces(sheets.points, of_changed);
  made.addForces(sheets.points, of_made);
  EXPECT_EQ(of_changed, of_made);
  for (Points* const ends : {&after, &after_made})
    for (Vec3& p : *ends) p.z() *= 0.2;
  changed.limit(sheets.points, after);
  made.limit(sheets.points, after_made);
  EXPECT_EQ(after, after_made);
}

TEST(SelfContact, DoesNotDependOnWhatWasAskedBefore) {
  const test::Sheets sheets = test::makeSheets(3, 6, 0.0018, 0.0004);
  const Points rest = spread(sheets.points, 36);
  SelfContact used = makeContact(sheets, rest), fresh = makeContact(sheets, rest);
  Points moved = sheets.points;
  std::mt19937 generator(9);
  for (Vec3& p : moved) p += 0.001 * test::randomVector(generator);
  Points scratch = moved;
  used.limit(sheets.points, scratch);
  used.leastDistance(moved);
  Points of_used(moved.size(), Vec3::Zero()), of_fresh = of_used, after = moved, after_fresh = moved;
  for (Vec3& p : after) p.z() *= 0.2;
  for (Vec3& p : after_fresh) p.z() *= 0.2;
  used.addForces(moved, of_used);
  fresh.addForces(moved, of_fresh);
  EXPECT_EQ(of_used, of_fresh);
  used.limit(moved, after);
  fresh.limit(moved, after_fresh);
  EXPECT_EQ(after, after_fresh);
}

}  // namespace
}  // namespace deformable_surface::contact
