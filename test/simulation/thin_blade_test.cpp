#include "../../src/simulation/models/oriented_particles/thin_blade.h"

#include <gtest/gtest.h>

namespace deformable_surface::test {
namespace {

using simulation::findBlades;
using simulation::ThinBlade;
using tool::ToolParams;

constexpr double kSpacing = 0.1;

struct Setting {
  ToolParams knife;
  Points before, after;
  Orientations orientations;

  Setting() {
    knife.id = "knife";
    knife.mode = tool::Mode::kCut;
    knife.path = {{0.0, Vec3(0.0, 0.0, 0.0)}, {1.0, Vec3(0.0, 1.0, 0.0)}};
    for (int i = 0; i < 10; ++i)
      for (int j = 0; j < 10; ++j) before.emplace_back(kSpacing * (i - 4.5), kSpacing * j, 0.0);
    after = before;
    orientations.assign(before.size(), Quaternion::Identity());
  }
  std::vector<ThinBlade> find() const {
    return findBlades(knife, 0.0, 1.0, before, after, orientations, 2.0 * kSpacing, kSpacing);
  }
};

TEST(ThinBlade, ABoxCutsAlongItsMiddlePlane) {
  Setting s;
  s.knife.shape.kind = geometry::Solid::Kind::kBox;
  s.knife.shape.size = Vec3(0.3, 1.0, 0.7);
  const std::vector<ThinBlade> blades = s.find();
  ASSERT_EQ(blades.size(), 1u);
  EXPECT_LT(blades[0].tool.shape.size.x(), 0.1 * kSpacing);
  EXPECT_EQ(blades[0].tool.shape.size.tail<2>(), Vec2(1.0, 0.7));
  s.knife.shape.size.x() = 1e-6;
  EXPECT_EQ(s.find()[0].tool.shape.size.x(), 1e-6);
}

TEST(ThinBlade, ANeedleCutsAlongItsWayPieceByPiece) {
  Setting s;
  s.knife.shape.kind = geometry::Solid::Kind::kCylinder;
  s.knife.shape.radius = 0.05;
  s.knife.shape.height = 0.5;
  s.knife.path = {{0.0, Vec3(0.0, 0.0, 0.0)}, {0.5, Vec3(0.0, 0.5, 0.0)}, {1.0, Vec3(0.5, 0.5, 0.0)}};
  const std::vector<ThinBlade> blades = s.find();
  ASSERT_EQ(blades.size(), 2u);
  for (const ThinBlade& blade : blades) {
    EXPECT_EQ(blade.step, 0.5);
    EXPECT_EQ(blade.tool.shape.kind, geometry::Solid::Kind::kBox);
    EXPECT_EQ(blade.tool.shape.size.z(), 0.5);
    const tool::Pose pose = tool::interpolate(blade.tool.path, blade.begin);
    const Vec3 way = blade.begin == 0.0 ? Vec3::UnitY() : Vec3::UnitX();
    EXPECT_LT((pose.orientation * Vec3::UnitX() - way).norm(), 1e-12);
    EXPECT_LT((pose.orientation * Vec3::UnitZ() - Vec3::UnitZ()).norm(), 1e-12);
  }
}

TEST(ThinBlade, ANeedleThatStaysBesideItsParticlesCutsNothing) {
  Setting s;
  s.knife.shape.kind = geometry::Solid::Kind::kCylinder;
  s.knife.shape.height = 0.5;
  s.knife.path = {{0.0, Vec3(0.0, 0.5, 0.5)}, {1.0, Vec3(0.0, 0.5, 0.0)}};  // comes down
  EXPECT_TRUE(s.find().empty());
  for (Vec3& p : s.after) p.x() += 0.1;  // the sheet moves sideways against it
  EXPECT_EQ(s.find().size(), 1u);
}

TEST(ThinBlade, ASphereIsUprightOnTheSurface) {
  Setting s;
  s.knife.shape.radius = 0.08;
  for (Quaternion& q : s.orientations) q = Quaternion::FromTwoVectors(Vec3::UnitZ(), Vec3::UnitX());
  const std::vector<ThinBlade> blades = s.find();
  ASSERT_EQ(blades.size(), 1u);
  EXPECT_LT((tool::interpolate(blades[0].tool.path, 0.0).orientation * Vec3::UnitZ() - Vec3::UnitX()).norm(), 1e-12);
}

}  // namespace
}  // namespace deformable_surface::test
