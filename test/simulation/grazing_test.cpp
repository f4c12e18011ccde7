// The notice of a tool that slides over a surface on a table without pushing it.
#include "../../src/simulation/grazing.h"

#include "clouds.h"

#include <gtest/gtest.h>

#include <string>

namespace deformable_surface::test {
namespace {

constexpr double kThickness = 2e-3;  // m

// A sheet lies on a table. A box comes from beside, or from above, and goes along a way.
std::string findNotice(const Vec3& from, const Vec3& to) {
  simulation::SceneParams p = hangingSheet();
  p.pins.clear();
  p.material.thickness = kThickness;
  p.accuracy.estimate = false;
  p.sleep.mode = simulation::Sleep::kNever;
  tool::ToolParams table;
  table.id = "table";
  table.shape.kind = geometry::Solid::Kind::kPlane;
  table.path.resize(1);
  tool::ToolParams box;
  box.id = "box";
  box.shape.kind = geometry::Solid::Kind::kBox;
  box.shape.size = Vec3(0.1, 0.5, 0.1);
  box.path.resize(2);
  box.path[0].position = from + 0.05 * Vec3::UnitZ();
  box.path[1].position = to + 0.05 * Vec3::UnitZ();
  box.path[1].time = 0.2;
  p.tools = {table, box};
  simulation::Simulation s(p, sheetCloud());
  std::string notices;
  for (int k = 0; k < 30; ++k) notices += s.step().notice;
  return notices;
}

TEST(Grazing, IsToldOfABoxThatSlidesOverALyingSheet) {
  for (const double gap : {0.0, 0.5 * kThickness}) {
    const std::string notice = findNotice(Vec3(-0.2, 0.5, gap), Vec3(0.3, 0.5, gap));
    EXPECT_NE(notice.find("tool 'box' slides over the surface on tool 'table'"), std::string::npos) << gap << ": " << notice;
  }
}

TEST(Grazing, IsNotToldOfBoxesThatPushStayAboveOrComeDown) {
  const Vec3 below(0.0, 0.0, -5e-3), above(0.0, 0.0, 2.0 * kThickness);
  for (const auto& [from, to] : {std::pair<Vec3, Vec3>{Vec3(-0.2, 0.5, 0.0) + below, Vec3(-0.02, 0.5, 0.0) + below},
                                 {Vec3(-0.2, 0.5, 0.0) + above, Vec3(0.3, 0.5, 0.0) + above},
                                 {Vec3(0.5, 0.5, 0.02), Vec3(0.5, 0.5, 0.0)}}) {
    const std::string notice = findNotice(from, to);
    EXPECT_EQ(notice.find("slides over"), std::string::npos) << from.transpose() << ": " << notice;
  }
}

}  // namespace
}  // namespace deformable_surface::test
