// The two rules on sheets, spheres and chains, one pass each: where particles are added, where not, and how exactly.
#include "deformable_surface/model/oriented_particles/growth.h"

#include "deformable_surface/base/error.h"
#include "deformable_surface/base/parallel.h"
#include "model/particle_relaxation.h"
#include "model/particle_surfaces.h"

#include <gtest/gtest.h>

namespace deformable_surface::model {
namespace {

Vec3 normalOf(const NewParticle& particle) { return particle.orientation * Vec3::UnitZ(); }

std::vector<NewParticle> stretch(const TestSurface& surface, double spacing, const GrowthParams& params = {},
                                 char flag = kFillsGaps) {
  return proposeStretched(surface.positions, orientTo(surface.normals), std::vector<char>(surface.size(), flag), spacing, params);
}

std::vector<NewParticle> grow(const TestSurface& surface, double spacing, const GrowthParams& params = {},
                              char flag = kFillsGaps) {
  return proposeGrown(surface.positions, orientTo(surface.normals), std::vector<char>(surface.size(), flag), spacing, params);
}

void expectTheSame(const std::vector<NewParticle>& found, const std::vector<NewParticle>& expected) {
  ASSERT_EQ(found.size(), expected.size());
  for (std::size_t i = 0; i < found.size(); ++i) {
    EXPECT_EQ(found[i].position, expected[i].position);
    EXPECT_EQ(found[i].orientation.coeffs(), expected[i].orientation.coeffs());
    EXPECT_EQ(found[i].parents[0], expected[i].parents[0]);
    EXPECT_EQ(found[i].parents[1], expected[i].parents[1]);
  }
}

TestSurface makePair(double distance) {
  TestSurface pair;
  pair.add(Vec3::Zero(), Vec3::UnitZ());
  pair.add(Vec3(distance, 0.0, 0.0), Vec3::UnitZ());
  return pair;
}

// Particles on a circle in the plane y = 0, facing outward; angles in radians from the z axis.
TestSurface makeArc(double radius, const std::vector<double>& angles) {
  TestSurface arc;
  for (double angle : angles) {
    const Vec3 outward(std::sin(angle), 0.0, std::cos(angle));
    arc.add(radius * outward, outward);
  }
  return arc;
}

TEST(StretchingRule, AddsOneParticleHalfwayBetweenTheGivenDistances) {
  EXPECT_TRUE(stretch(makePair(1.99), 1.0).empty());
  EXPECT_TRUE(stretch(makePair(2.51), 1.0).empty());
  for (double distance : {2.0, 2.2, 2.5}) {
    const std::vector<NewParticle> added = stretch(makePair(distance), 1.0);
    ASSERT_EQ(added.size(), 1u);
    EXPECT_LT((added[0].position - Vec3(0.5 * distance, 0.0, 0.0)).norm(), 1e-15);
    EXPECT_LT((normalOf(added[0]) - Vec3::UnitZ()).norm(), 1e-15);
    EXPECT_EQ(added[0].parents[0], 0);
    EXPECT_EQ(added[0].parents[1], 1);
  }
}

TEST(StretchingRule, AddsNothingWhereAnotherParticleIsWithinHalfTheSmallestGap) {
  TestSurface three = makePair(2.4);
  three.add(Vec3(1.2, 0.99, 0.0), Vec3::UnitZ());
  EXPECT_TRUE(stretch(three, 1.0).empty());
  three.positions[2].y() = 1.01;
  EXPECT_EQ(stretch(three, 1.0).size(), 1u);
  three.positions[2].y() = 0.5;
  three.normals[2] = -Vec3::UnitZ();  // of the other side of something thin
  EXPECT_EQ(stretch(three, 1.0).size(), 1u);
}

TEST(StretchingRule, PairsThatDoNotSeeEachOtherGetNothing) {
  TestSurface pair = makePair(2.2);
  pair.normals[1] = -Vec3::UnitZ();
  EXPECT_TRUE(stretch(pair, 1.0).empty());
  pair.normals[1] = Vec3::UnitZ();
  pair.positions[1] = 2.2 * Vec3(std::cos(0.55), 0.0, std::sin(0.55));  // steeper than 30 degrees
  EXPECT_TRUE(stretch(pair, 1.0).empty());
  pair.positions[1] = 2.2 * Vec3(std::cos(0.5), 0.0, std::sin(0.5));
  EXPECT_EQ(stretch(pair, 1.0).size(), 1u);
}

TEST(StretchingRule, FillsAVacancyOfAPerfectLatticeOnce) {
  TestSurface sheet = makeHexagons(0.1, 0.41);
  Index center = 0;
  while (sheet.positions[center].norm() > 1e-9) ++center;
  sheet.positions.erase(sheet.positions.begin() + center);
  sheet.normals.erase(sheet.normals.begin() + center);
  const std::vector<NewParticle> added = stretch(sheet, 0.1);  // three pairs have their middle there
  ASSERT_EQ(added.size(), 1u);
  EXPECT_LT(added[0].position.norm(), 1e-15);
  EXPECT_TRUE(stretch(makeHexagons(0.1, 0.41), 0.1).empty());
}

TEST(StretchingRule, FollowsTheCurvatureOfASphereExactly) {
  // Two particles alone, facing outward from a sphere: the place between them is on the great circle through them.
  for (double angle : {0.3, 0.8, 1.3}) {
    const TestSurface pair = makeArc(1.0, {0.0, angle});
    const std::vector<NewParticle> added = stretch(pair, (pair.positions[1] - pair.positions[0]).norm() / 2.2);
    ASSERT_EQ(added.size(), 1u);
    EXPECT_LT((added[0].position - Vec3(std::sin(0.5 * angle), 0.0, std::cos(0.5 * angle))).norm(), 1e-14) << angle;
    EXPECT_LT((normalOf(added[0]) - added[0].position).norm(), 1e-14) << angle;
  }
}

TEST(StretchingRule, WiderGapsAreBridgedOnlyBetweenTheirTwoSides) {
  // A row with a gap of six spacings: only its two ends are joined, whatever the reach of the search.
  TestSurface row;
  for (int i = 0; i < 20; ++i) row.add(Vec3(i < 10 ? i : i + 5, 0.0, 0.0), Vec3::UnitZ());
  GrowthParams params;
  EXPECT_TRUE(stretch(row, 1.0, params).empty());
  params.max_gap = 12.0;
  const std::vector<NewParticle> added = stretch(row, 1.0, params);
  ASSERT_EQ(added.size(), 1u);
  EXPECT_EQ(added[0].parents[0], 9);
  EXPECT_EQ(added[0].parents[1], 10);
}

TEST(StretchingRule, DoesNotJoinTwoSheetsThatLieClose) {
  for (double distance : {0.5, 1.0, 2.0, 2.3}) {
    for (double side : {1.0, -1.0}) {
      TestSurface both = makeHexagons(0.1, 0.6), other = both;
      for (Vec3& n : other.normals) n *= side;
      both.append(other, Vec3(0.03, 0.02, 0.1 * distance));
      for (const NewParticle& p : stretch(both, 0.1)) {
        const double z = p.position.z();
        EXPECT_LT(std::min(std::abs(z), std::abs(z - 0.1 * distance)), 1e-12) << distance << " " << side;
      }
    }
  }
}

TEST(StretchingRule, ParticlesWithoutTheFlagAreNoParents) {
  EXPECT_TRUE(stretch(makePair(2.2), 1.0, {}, kGrowsNothing).empty());
  EXPECT_TRUE(grow(makePair(3.0), 1.0, {}, kGrowsNothing).empty());
}

TEST(GrowingRule, LoneParticleGrowsSixAroundIt) {
  TestSurface one;
  one.add(Vec3(1.0, 2.0, 3.0), Vec3(1.0, 1.0, 1.0));
  EXPECT_TRUE(grow(one, 0.1).empty());  // nothing to grow towards
  const std::vector<NewParticle> added = grow(one, 0.1, {}, kFillsGaps | kExtendsEdge);
  ASSERT_EQ(added.size(), 6u);
  for (std::size_t i = 0; i < 6; ++i) {
    EXPECT_NEAR((added[i].position - one.positions[0]).norm(), 0.1, 1e-15);
    EXPECT_NEAR((added[i].position - added[(i + 1) % 6].position).norm(), 0.1, 1e-15);
    EXPECT_NEAR((added[i].position - one.positions[0]).dot(one.normals[0]), 0.0, 1e-15);
    EXPECT_EQ(added[i].parents[0], 0);
    EXPECT_EQ(added[i].parents[1], -1);
  }
}

TEST(GrowingRule, EdgeGrowsARowWhereItMay) {
  TestSurface strip;  // three rows of ten: the edges have gaps of a straight angle
  for (int i = 0; i < 30; ++i) strip.add(Vec3(i / 3 + 0.5 * (i % 3), std::sqrt(0.75) * (i % 3), 0.0), Vec3::UnitZ());
  EXPECT_TRUE(grow(strip, 1.0).empty());
  const std::vector<NewParticle> added = grow(strip, 1.0, {}, kFillsGaps | kExtendsEdge);
  EXPECT_EQ(added.size(), 28u);  // the next hexagonal row on all sides: 11 + 11 and 3 + 3
  for (const NewParticle& p : added) EXPECT_NEAR(p.position.z(), 0.0, 1e-12);
}

TEST(GrowingRule, NumbersOfNeighborsAndAnglesLimitIt) {
  const char both = kFillsGaps | kExtendsEdge;
  const TestSurface pair = makePair(1.0);
  EXPECT_EQ(grow(pair, 1.0, {}, both).size(), 8u);
  GrowthParams params;
  params.min_neighbors = 2;
  EXPECT_TRUE(grow(pair, 1.0, params, both).empty());
  params = {};
  params.max_neighbors = 0;
  EXPECT_TRUE(grow(pair, 1.0, params, both).empty());
  params = {};
  params.max_angle = 6.0;  // their gaps are full turns
  EXPECT_TRUE(grow(pair, 1.0, params, both).empty());
}

TEST(GrowingRule, PublishedExampleOfAnEdgeHasFourNeighborsAndAGapOfAStraightAngle) {
  const TestSurface sheet = makeHexagons(1.0, 5.1);
  GrowthParams params;
  params.min_neighbors = params.max_neighbors = 4;
  params.min_angle = 3.0;
  params.max_angle = 3.3;
  const std::vector<NewParticle> added = grow(sheet, 1.0, params, kFillsGaps | kExtendsEdge);
  EXPECT_FALSE(added.empty());
  for (const NewParticle& p : added) EXPECT_GT(p.position.norm(), 4.5);
}

TEST(GrowingRule, FollowsTheCurvatureOfTheNeighborhood) {
  // The rim of a spherical cap grows. New particles stay near the sphere although their neighbours are on one side only. Flat
  // growth would leave it by r0^2 / 2R = 0.005.
  const TestSurface all = cloud::makeSphere(1600);
  const double spacing = measureSpacing(all);
  TestSurface cap;
  for (Index i = 0; i < all.size(); ++i) {
    if (all.positions[i].z() > 0.7) cap.add(all.positions[i], all.normals[i]);
  }
  const std::vector<NewParticle> added = grow(cap, spacing, {}, kFillsGaps | kExtendsEdge);
  EXPECT_GT(added.size(), 20u);
  double largest = 0.0;
  for (const NewParticle& p : added) {
    largest = std::max(largest, std::abs(p.position.norm() - 1.0));
    EXPECT_LT((normalOf(p) - p.position.normalized()).norm(), 0.25 * spacing);
  }
  EXPECT_LT(largest, 0.25 * 0.5 * spacing * spacing);
}

TEST(GrowingRule, GrowsTowardsTheOtherSideOfAGapOnly) {
  // Two half sheets, three spacings apart: the edges between them grow if they can see across, the others do not.
  TestSurface halves;
  for (const Vec3& p : makeHexagons(0.1, 1.0).positions) {
    if (std::abs(p.x()) > 0.15) halves.add(p, Vec3::UnitZ());
  }
  GrowthParams params;
  params.max_gap = 2.5;
  EXPECT_TRUE(grow(halves, 0.1, params).empty());
  params.max_gap = 4.0;
  const std::vector<NewParticle> added = grow(halves, 0.1, params);
  EXPECT_GT(added.size(), 15u);
  for (const NewParticle& p : added) {
    EXPECT_LT(std::abs(p.position.x()), 0.15);
    EXPECT_LT(p.position.norm(), 1.0);
  }
}

TEST(GrowingRule, KeepsClearOfWhatIsThere) {
  const TestSurface sheet = cloud::makeSheet(15, 0.35, 3);
  GrowthParams params;
  params.max_gap = 3.0;
  const double spacing = 0.8 / 14.0;
  std::vector<NewParticle> added = grow(sheet, spacing, params, kFillsGaps | kExtendsEdge);
  EXPECT_FALSE(added.empty());
  for (std::size_t a = 0; a < added.size(); ++a) {
    for (const Vec3& p : sheet.positions) EXPECT_GT((p - added[a].position).norm(), 0.69 * spacing);
    for (std::size_t b = 0; b < a; ++b) EXPECT_GT((added[b].position - added[a].position).norm(), 0.69 * spacing);
  }
}

TEST(Growth, KeepsTheFramesOfTheNeighborhood) {
  // All x axes have one direction, and so has the new one. The z axis depends on the surface only.
  const TestSurface pair = makePair(2.2);
  const Eigen::Quaterniond turned(Eigen::AngleAxisd(0.7, Vec3::UnitZ()));
  const std::vector<NewParticle> added = proposeStretched(pair.positions, {turned, turned}, {kFillsGaps, kFillsGaps}, 1.0, {});
  ASSERT_EQ(added.size(), 1u);
  EXPECT_LT((added[0].orientation * Vec3::UnitX() - turned * Vec3::UnitX()).norm(), 1e-14);
  // If the x axes cancel, that of the first parent is used.
  const Eigen::Quaterniond opposite(Eigen::AngleAxisd(0.7 + kPi, Vec3::UnitZ()));
  const std::vector<NewParticle> torn = proposeStretched(pair.positions, {turned, opposite}, {kFillsGaps, kFillsGaps}, 1.0, {});
  EXPECT_LT((torn.at(0).orientation * Vec3::UnitX() - turned * Vec3::UnitX()).norm(), 1e-14);
}

TEST(Growth, ChainsStayInTheirPlane) {
  std::vector<double> angles;
  for (int i = 0; i < 12; ++i) angles.push_back(0.2 * i + (i > 5 ? 0.25 : 0.0));
  const TestSurface arc = makeArc(1.0, angles);
  GrowthParams params;
  params.chain = true;
  const std::vector<NewParticle> between = stretch(arc, 0.2, params);
  ASSERT_EQ(between.size(), 1u);
  EXPECT_EQ(between[0].position.y(), 0.0);
  EXPECT_NEAR(between[0].position.norm(), 1.0, 1e-12);  // on the circle by symmetry
  EXPECT_TRUE(grow(arc, 0.2, params).empty() || grow(arc, 0.2, params)[0].position.y() == 0.0);

  const TestSurface piece = makeArc(1.0, {0.0, 0.2, 0.4, 0.6});
  const std::vector<NewParticle> ends = grow(piece, 0.2, params, kFillsGaps | kExtendsEdge);
  ASSERT_EQ(ends.size(), 2u);
  for (const NewParticle& p : ends) {
    EXPECT_EQ(p.position.y(), 0.0);
    EXPECT_NEAR(normalOf(p).y(), 0.0, 1e-15);
    // The straight continuation would miss the circle by r0^2 / 2R = 0.02. Two particles in line determine their slope, except
    // for the few per cent by which the fit is regularised. These count twice: in the normal and in the height.
    EXPECT_NEAR(p.position.norm(), 1.0, 0.15 * 0.02);
  }
}

TEST(Growth, DoesNotDependOnTheNumberOfThreads) {
  const TestSurface sheet = cloud::makeSheet(40, 0.4, 2);
  GrowthParams params;
  params.max_gap = 3.0;
  const auto both = [&] {
    std::vector<NewParticle> all = stretch(sheet, 0.6 / 39.0, params);
    const std::vector<NewParticle> grown = grow(sheet, 0.8 / 39.0, params, kFillsGaps | kExtendsEdge);
    EXPECT_FALSE(all.empty() || grown.empty());
    all.insert(all.end(), grown.begin(), grown.end());
    return all;
  };
  setNumThreads(1);
  const std::vector<NewParticle> one = both();
  for (int threads : {2, 3}) {
    setNumThreads(threads);
    expectTheSame(both(), one);
  }
  setNumThreads(0);
}

TEST(Growth, RulesLookAgainOnlyAroundWhatHasChangedAndFindTheSame) {
  // An uneven torus, on which a particle has moved, is new or has turned since the last look.
  TestSurface torus = cloud::makeTorus(72, 30, 0.4);
  GrowthParams params;
  params.min_gap = 1.6;
  params.max_gap = 5.0;
  params.witnessed = true;
  const double spacing = 0.09;
  const auto propose = [&](bool is_stretching, const Orientations& orientations, ProposalMemory* memory) {
    const std::vector<char> flags(torus.size(), kFillsGaps);
    return is_stretching ? proposeStretched(torus.positions, orientations, flags, spacing, params, {}, {}, memory)
                         : proposeGrown(torus.positions, orientations, flags, spacing, params, {}, {}, memory);
  };
  for (const bool is_stretching : {true, false}) {
    ProposalMemory memory;
    Orientations orientations = orientTo(torus.normals);
    ASSERT_GT(propose(is_stretching, orientations, &memory).size(), 20u);
    EXPECT_EQ(memory.looked_at, torus.size());
    for (int change = 0; change < 3; ++change) {
      if (change == 0) torus.positions[700] += Vec3(0.02, 0.03, 0.01);
      if (change == 1) torus.add(torus.positions[300] + Vec3(0.04, 0.0, 0.03), torus.normals[300]);
      orientations = orientTo(torus.normals);
      if (change == 2) orientations[1500] = Quaternion::FromTwoVectors(Vec3::UnitZ(), torus.normals[1501]);
      expectTheSame(propose(is_stretching, orientations, &memory), propose(is_stretching, orientations, nullptr));
      EXPECT_GT(memory.looked_at, 0);
      EXPECT_LT(memory.looked_at, torus.size() / 2);
    }
  }
}

// A valley whose floor is filled: the two rims see each other across it.
TEST(Growth, ValleysThatAreClosedBelowAreNotBridged) {
  constexpr double kSpacing = 0.5;
  GrowthParams params;
  params.max_gap = 10.0;
  params.witnessed = true;
  const auto isBridged = [&](bool has_floor) {
    TestSurface valley;
    for (int j = -4; j <= 4; ++j)
      for (int i = -6; i <= 6; ++i) {
        const double x = kSpacing * i, slope = -0.6 * std::sin(x);
        const bool is_floor = std::abs(i) <= 2;
        if (is_floor && !has_floor) continue;
        valley.add(Vec3(x, kSpacing * j, 0.6 * std::cos(x) * -1.0), Vec3(slope, 0.0, 1.0).normalized());
      }
    const std::vector<NewParticle> born = proposeStretched(valley.positions, orientTo(valley.normals),
                                                           std::vector<char>(valley.size(), kFillsGaps), kSpacing, params);
    return !born.empty();
  };
  EXPECT_FALSE(isBridged(true));
  EXPECT_TRUE(isBridged(false));
}

TEST(Growth, SamplesCloseNoWiderGapsThanTheyMay) {
  const TestSurface pair = makePair(2.2);
  const std::vector<char> flags(2, kFillsGaps);
  const auto count = [&](double other) {
    return proposeStretched(pair.positions, orientTo(pair.normals), flags, 1.0, {}, {3.0, other}).size();
  };
  EXPECT_EQ(count(2.3), 1u);
  EXPECT_EQ(count(2.1), 0u);
}

// A particle that has come off the surface would grow a separate sheet.
TEST(Growth, NobodyIsBornBesideTheSurface) {
  const auto count = [](double height, bool witnessed) {
    TestSurface sheet;
    sheet.add(Vec3(0.0, 0.0, height), Vec3::UnitZ());
    const TestSurface all = makeHexagons(1.0, 4.2);
    const double hole = height > 0.0 ? 0.0 : 1.1;
    for (Index i = 0; i < all.size(); ++i)
      if (all.positions[i].norm() >= hole) sheet.add(all.positions[i], all.normals[i]);
    std::vector<char> flags(sheet.size(), kGrowsNothing);
    flags[0] = kFillsGaps | kExtendsEdge;
    GrowthParams params;
    params.witnessed = witnessed;
    return proposeGrown(sheet.positions, orientTo(sheet.normals), flags, 1.0, params).size();
  };
  EXPECT_EQ(count(0.0, true), 6u);
  EXPECT_GT(count(1.4, false), 0u);
  EXPECT_EQ(count(1.4, true), 0u);
}

TEST(Growth, InputThatCannotBeUsedIsRefused) {
  const TestSurface pair = makePair(2.2);
  const Orientations orientations = orientTo(pair.normals);
  const std::vector<char> flags(2, kFillsGaps);
  for (const auto& rule : {proposeStretched, proposeGrown}) {
    EXPECT_THROW(rule(pair.positions, {orientations[0]}, flags, 1.0, {}, {}, {}, nullptr), InputError);
    EXPECT_THROW(rule(pair.positions, orientations, {kFillsGaps}, 1.0, {}, {}, {}, nullptr), InputError);
    EXPECT_THROW(rule(pair.positions, orientations, flags, 0.0, {}, {}, {}, nullptr), InputError);
    EXPECT_THROW(rule(pair.positions, orientations, flags, std::nan(""), {}, {}, {}, nullptr), InputError);
    EXPECT_THROW(rule({Vec3::Zero(), Vec3(std::nan(""), 0.0, 0.0)}, orientations, flags, 1.0, {}, {}, {}, nullptr), InputError);
    EXPECT_THROW(rule(pair.positions, {orientations[0], Eigen::Quaterniond(2.0, 0.0, 0.0, 0.0)}, flags, 1.0, {}, {}, {}, nullptr),
                 InputError);
    GrowthParams params;
    params.max_gap = 1.5;
    EXPECT_THROW(rule(pair.positions, orientations, flags, 1.0, params, {}, {}, nullptr), InputError);
    EXPECT_THROW(rule(pair.positions, orientations, flags, 1.0, {}, {3.0}, {}, nullptr), InputError);
    EXPECT_TRUE(rule({}, {}, {}, 1.0, {}, {}, {}, nullptr).empty());
  }
}

}  // namespace
}  // namespace deformable_surface::model
