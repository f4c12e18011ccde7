// Two sheets that meet become one surface with a tube, whichever way they face, and nothing else is joined.
#include "deformable_surface/model/oriented_particles/sheet_joint.h"

#include "model/particle_relaxation.h"
#include "model/particle_surfaces.h"

#include <gtest/gtest.h>

#include <random>

namespace deformable_surface::model {
namespace {

constexpr double kSpacing = 0.1;

bool mayAll(Index, Index) { return true; }

std::optional<SheetJoint> join(const TestSurface& surface, const std::function<bool(Index, Index)>& may_join = mayAll,
                               double reach = 1.6 * kSpacing, double meeting = 2.0 * kSpacing) {
  std::vector<Index> all;
  for (Index i = 0; i < surface.size(); ++i) all.push_back(i);
  return joinSheets(surface.positions, orientTo(surface.normals), std::vector<char>(surface.size(), 0), kSpacing, reach, meeting,
                    meeting, all, may_join);
}

// What is left, with the tube.
TestSurface apply(const TestSurface& surface, const SheetJoint& joint) {
  TestSurface joined;
  for (Index i = 0; i < surface.size(); ++i)
    if (!joint.is_gone[i]) joined.add(surface.positions[i], surface.normals[i]);
  for (const NewParticle& particle : joint.tube) joined.add(particle.position, particle.orientation * Vec3::UnitZ());
  return joined;
}

// Growth closes what is wide between tube and rims, as in a run.
TestSurface fill(TestSurface surface) {
  GrowthParams growth;
  growth.min_gap = 1.6;
  for (int pass = 0; pass < 5; ++pass) {
    const std::vector<char> flags(surface.size(), kFillsGaps);
    std::vector<NewParticle> added = proposeStretched(surface.positions, orientTo(surface.normals), flags, kSpacing, growth);
    leaveOutCrowded(surface.positions, growth.clearance * kSpacing, added);
    if (added.empty()) break;
    for (const NewParticle& particle : added) surface.add(particle.position, particle.orientation * Vec3::UnitZ());
  }
  return surface;
}

ParticleTopology measure(const TestSurface& surface) {
  return measureTopology(surface.size(), triangulateParticles(surface.positions, surface.normals, 2.4 * kSpacing));
}

// Two round sheets of seven spacings' radius, bent like dents of the stated radius (0: flat). side: 1, their backs face each
// other; -1, their fronts do. Turned about the axis, shifted, and their particles displaced, by random amounts.
TestSurface makeSheets(double distance, double bend, double side, double jitter, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  const TestSurface flat = makeHexagons(kSpacing, 7.0 * kSpacing);
  TestSurface sheets;
  for (const double up : {1.0, -1.0}) {
    const Eigen::AngleAxisd turn(unit(random), Vec3::UnitZ());
    const Vec3 shift = 0.5 * kSpacing * Vec3(unit(random), unit(random), 0.0);
    for (const Vec3& at : flat.positions) {
      const Vec3 p = turn * at + shift + jitter * kSpacing * Vec3(unit(random), unit(random), 0.0);
      const double rho = p.norm(), angle = bend > 0.0 ? rho / bend : 0.0;
      const Vec3 outwards = rho > 0.0 ? Vec3(p / rho) : Vec3::UnitX();
      const double wide = bend > 0.0 ? bend * std::sin(angle) : rho, high = bend > 0.0 ? bend * (1.0 - std::cos(angle)) : 0.0;
      const Vec3 normal = std::cos(angle) * Vec3::UnitZ() - std::sin(angle) * outwards;
      const Vec3 place = wide * outwards + (0.5 * distance + high) * Vec3::UnitZ();
      sheets.add(Vec3(place.x(), place.y(), up * place.z()), side * Vec3(normal.x(), normal.y(), up * normal.z()));
    }
  }
  return sheets;
}

TEST(SheetJoint, TwoSheetsBecomeOneTubeWithoutAHoleOrAParticleAlone) {
  for (const double side : {1.0, -1.0}) {
    for (const double bend : {0.0, 10.0, 5.0}) {
      for (const double distance : {1.9, 1.6}) {
        for (unsigned seed = 1; seed <= 5; ++seed) {
          const TestSurface sheets = makeSheets(distance * kSpacing, bend * kSpacing, side, 0.1, seed);
          ASSERT_EQ(measure(sheets).components, 2);
          const std::optional<SheetJoint> joint = join(sheets);
          ASSERT_TRUE(joint);
          const ParticleTopology found = measure(fill(apply(sheets, *joint)));
          EXPECT_EQ(found.components, 1);
          EXPECT_EQ(found.boundary_loops, 2);
          EXPECT_EQ(found.euler_characteristic, 0);
          EXPECT_EQ(found.isolated, 0);
        }
      }
    }
  }
}

// Sheets that are joined from afar, and whose bonds reach beyond first neighbours.
TEST(SheetJoint, SheetsFiveSpacingsApartAreJoinedByALongTube) {
  for (const double side : {1.0, -1.0}) {
    for (unsigned seed = 1; seed <= 2; ++seed) {
      const TestSurface sheets = makeSheets(5.0 * kSpacing, 0.0, side, 0.1, seed);
      const std::optional<SheetJoint> joint = join(sheets, mayAll, 2.6 * kSpacing, 5.2 * kSpacing);
      ASSERT_TRUE(joint);
      const TestSurface joined = fill(apply(sheets, *joint));
      const ParticleTopology found = measure(joined);
      EXPECT_EQ(found.components, 1);
      EXPECT_EQ(found.boundary_loops, 2);
      EXPECT_EQ(found.euler_characteristic, 0);
      EXPECT_EQ(found.isolated, 0);
      EXPECT_FALSE(join(joined, mayAll, 2.6 * kSpacing, 5.4 * kSpacing)) << "the same sheets are pressed further";
    }
  }
}

// Tools that press on flatten the tube: the normals of its rings turn towards the axis, away from each other.
TEST(SheetJoint, SheetsWhoseTubeIsFlattenedAreNotJoinedAgain) {
  for (unsigned seed = 1; seed <= 5; ++seed) {
    const TestSurface sheets = makeSheets(1.8 * kSpacing, 0.0, 1.0, 0.1, seed);
    const std::optional<SheetJoint> joint = join(sheets);
    ASSERT_TRUE(joint);
    TestSurface joined = apply(sheets, *joint);
    const Index first = joined.size() - static_cast<Index>(joint->tube.size());
    for (Index i = first; i < joined.size(); ++i) {
      const Vec3 up = joined.positions[i].z() > joint->middle.z() ? Vec3::UnitZ() : Vec3(-Vec3::UnitZ());
      Vec3 outwards = joined.positions[i] - joint->middle;
      outwards.z() = 0.0;
      joined.normals[i] = 0.8 * up - 0.6 * outwards.normalized();
    }
    EXPECT_FALSE(join(joined)) << seed;
  }
}

TEST(SheetJoint, FlatSheetsAreJoinedInTheMiddleOfWhatIsPressed) {
  const TestSurface sheets = makeSheets(1.8 * kSpacing, 0.0, -1.0, 0.1, 1);
  std::vector<char> is_pressed;
  for (const Vec3& p : sheets.positions) is_pressed.push_back((p - Vec3(2.0 * kSpacing, 0.0, p.z())).norm() < 3.0 * kSpacing);
  const std::optional<SheetJoint> joint = join(sheets, [&](Index i, Index j) { return is_pressed[i] && is_pressed[j]; });
  ASSERT_TRUE(joint);
  EXPECT_NEAR(joint->middle.x(), 2.0 * kSpacing, 0.3 * kSpacing);
  EXPECT_NEAR(joint->middle.y(), 0.0, 0.3 * kSpacing);
}

TEST(SheetJoint, TheTubeFacesItsAxisBetweenBacksAndAwayFromItBetweenFronts) {
  for (const double side : {1.0, -1.0}) {
    const std::optional<SheetJoint> joint = join(makeSheets(1.8 * kSpacing, 0.0, side, 0.0, 1));
    ASSERT_TRUE(joint);
    Vec3 middle = Vec3::Zero();
    for (const NewParticle& particle : joint->tube) middle += particle.position / joint->tube.size();
    EXPECT_NEAR(middle.z(), 0.0, 1e-12);
    for (const NewParticle& particle : joint->tube) {
      const Vec3 offset = middle - particle.position, inwards(offset.x(), offset.y(), 0.0);
      // Two rings 1.06 spacings apart on a half circle of a radius of one spacing.
      EXPECT_NEAR(side * inwards.normalized().dot(particle.orientation * Vec3::UnitZ()), std::cos(0.53), 1e-12);
    }
  }
}

TEST(SheetJoint, SheetsThatAreFarFaceTheSameWayOrMayNotBeJoinedStayAsTheyAre) {
  EXPECT_FALSE(join(makeSheets(2.05 * kSpacing, 0.0, 1.0, 0.0, 1)));
  EXPECT_FALSE(join(makeSheets(1.8 * kSpacing, 0.0, 1.0, 0.0, 1), [](Index, Index) { return false; }));
  TestSurface same_way = makeSheets(1.8 * kSpacing, 0.0, 1.0, 0.0, 1);
  for (Vec3& normal : same_way.normals) normal = Vec3::UnitZ();
  EXPECT_FALSE(join(same_way));
}

// Its sides are as near, but one surface.
TEST(SheetJoint, ANarrowTubeStaysOpen) {
  TestSurface tube;
  for (int ring = 0; ring < 20; ++ring) {
    for (int k = 0; k < 6; ++k) {
      const double angle = (k + 0.5 * (ring % 2)) * kPi / 3.0;
      const Vec3 outwards(std::cos(angle), std::sin(angle), 0.0);
      tube.add(0.96 * kSpacing * outwards + ring * std::sqrt(0.75) * kSpacing * Vec3::UnitZ(), outwards);
    }
  }
  EXPECT_FALSE(join(tube));
}

}  // namespace
}  // namespace deformable_surface::model
