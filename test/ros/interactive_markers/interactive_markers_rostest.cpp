// The test takes the part of RViz: it sends the feedback that RViz sends when a person drags a marker or chooses from a menu, and
// checks the surface.
#include "../bad_clouds.h"
#include "../node_client.h"
#include "fake_rviz.h"

#include "deformable_surface/ToolWrenchArray.h"

#include <algorithm>
#include <cmath>

namespace deformable_surface::node::test {
namespace {

constexpr char kScene[] = R"(
model: mass_spring
material: {young_modulus: 1.0e5, thickness: 0.001, bending_rigidity: 0.01, damping: 20.0}
gravity: [0, 0, 0]
pins: [{box: {min: [-1, -1, -1], max: [0.011, 1, 1]}}]
output: {publish_rate: 50.0, stamp: simulation}
)";
constexpr int kColumns = 21, kRows = 11;  // of a flat sheet of this spacing that begins at the origin
constexpr double kSpacing = 0.01;

sensor_msgs::PointCloud2 makeFlatSheet() {
  PointCloud2 cloud = makeCloud(kColumns, kRows, 16, [](std::uint32_t column, std::uint32_t row) {
    return Point3f{static_cast<float>(kSpacing * column), static_cast<float>(kSpacing * row), 0.0f};
  });
  cloud.header.stamp = ros::Time::now();
  cloud.header.frame_id = "table";
  return cloud;
}

class InteractiveMarkersTest : public ::testing::Test {
 protected:
  void start(const std::string& scene, const std::string& more = "") {
    process_ = std::make_unique<NodeProcess>("/surface", scene);
    markers_ = std::make_unique<NodeProcess>("/hand", "{surface: /surface, rate: 20.0" + more + "}",
                                             "deformable_surface_interactive_markers");
    client_ = std::make_unique<NodeClient>("/surface");
    points_subscriber_ = client_->handle().subscribe<PointCloud2>(
        "simulation_points", 1, [this](const sensor_msgs::PointCloud2ConstPtr& m) { points_ = *m; });
    wrenches_subscriber_ =
        client_->handle().subscribe<ToolWrenchArray>("tool_wrenches", 1, [this](const ToolWrenchArrayConstPtr& m) {
          contacts_.clear();
          for (const ToolWrench& wrench : m->wrenches) contacts_[wrench.id] = wrench.contacts;
        });
    ASSERT_TRUE(client_->waitForNode()) << process_->output();
    ASSERT_TRUE(client_->exchange(makeFlatSheet())) << process_->output();
    for (const char* name : {"surface", "spot", "panel"}) ASSERT_TRUE(rviz_.waitForMarker(name)) << name << markers_->output();
  }

  Vec3 lastPosition(int column, int row) const { return readPosition(*client_->frames.back(), row * kColumns + column); }
  int countPinned() const {
    int count = 0;
    for (std::size_t i = 0; i < points_.width; ++i) {
      const auto field = std::find_if(points_.fields.begin(), points_.fields.end(), [](auto& f) { return f.name == "pinned"; });
      count += points_.data[i * points_.point_step + field->offset] != 0;
    }
    return count;
  }

  FakeRviz rviz_{"/hand", "table"};
  std::unique_ptr<NodeProcess> process_, markers_;
  std::unique_ptr<NodeClient> client_;
  PointCloud2 points_;
  std::map<std::string, std::uint32_t> contacts_;
  ros::Subscriber points_subscriber_, wrenches_subscriber_;
};

TEST_F(InteractiveMarkersTest, TakesTheSurfaceAlongWhileTheButtonIsDownAndLetsGo) {
  start(kScene);
  const Vec3 corner(kSpacing * (kColumns - 1), 0.05, 0.0);
  // A click alone moves nothing, but the spot moves there.
  rviz_.press("surface", Vec3::Zero(), corner);
  rviz_.release("surface", Vec3::Zero());
  EXPECT_TRUE(waitUntil([&] { return std::abs(rviz_.markers["spot"].pose.position.x - corner.x()) < 1e-6; }));
  EXPECT_EQ(contacts_.count("hand"), 0u);

  rviz_.press("surface", Vec3::Zero(), corner);
  for (int i = 1; i <= 10; ++i) rviz_.drag("surface", Vec3(0.0, 0.0, 0.002 * i));
  EXPECT_TRUE(waitUntil([&] { return std::abs(lastPosition(kColumns - 1, 5).z() - 0.02) < 1e-4; })) << markers_->output();
  EXPECT_LT(lastPosition(0, 5).norm() - 0.05, 1e-6);
  EXPECT_TRUE(waitUntil([&] { return contacts_["hand"] > 0; }));
  rviz_.release("surface", Vec3(0.0, 0.0, 0.02));
  EXPECT_TRUE(waitUntil([&] { return contacts_.count("hand") == 0; }));
  EXPECT_TRUE(waitUntil([&] { return std::abs(lastPosition(kColumns - 1, 5).z()) < 0.01; }));
}

TEST_F(InteractiveMarkersTest, LetsGoWhenRvizIsGone) {
  start(kScene);
  rviz_.press("surface", Vec3::Zero(), Vec3(0.2, 0.05, 0.0));
  rviz_.drag("surface", Vec3(0.0, 0.0, 0.005));
  ASSERT_TRUE(waitUntil([&] { return contacts_.count("hand") > 0; }));
  EXPECT_TRUE(waitUntil([&] { return contacts_.count("hand") == 0; }));
}

TEST_F(InteractiveMarkersTest, SlipsWhereThePullTakesMoreThanItsStrength) {
  start(kScene, ", strength: 1.0");
  const Vec3 corner(kSpacing * (kColumns - 1), 0.05, 0.0);
  rviz_.press("surface", Vec3::Zero(), corner);
  double way = 0.0;
  const auto pull = [&] {
    rviz_.drag("surface", Vec3(way += 0.0002, 0.0, 0.0));
    return waitUntil([] { return false; }, 0.02);
  };
  ASSERT_TRUE(waitUntil([&] { return pull() || contacts_["hand"] > 0; })) << markers_->output();
  ASSERT_TRUE(waitUntil([&] { return pull() || contacts_.count("hand") == 0; })) << markers_->output();
  EXPECT_TRUE(waitUntil([&] { return rviz_.findAnswer().text.find("at most 1 N") != std::string::npos; })) << markers_->output();
  // The button is still down.
  EXPECT_TRUE(waitUntil([&] { return pull() || std::abs(lastPosition(kColumns - 1, 5).x() - corner.x()) < 1e-4; }));
  EXPECT_EQ(contacts_.count("hand"), 0u);
}

TEST_F(InteractiveMarkersTest, PinsAndFreesWhatIsAtTheSpot) {
  start(kScene);
  ASSERT_TRUE(waitUntil([&] { return points_.width > 0; }));
  const int before = countPinned();
  rviz_.press("surface", Vec3::Zero(), Vec3(0.2, 0.05, 0.0));
  rviz_.release("surface", Vec3::Zero());
  rviz_.choose("spot", "Pin here");
  ASSERT_TRUE(waitUntil([&] { return countPinned() > before; })) << markers_->output();
  rviz_.choose("spot", "Unpin here");
  ASSERT_TRUE(waitUntil([&] { return countPinned() == before; })) << markers_->output();
  EXPECT_FALSE(rviz_.offers("spot", "Take away here"));  // springs cannot
  EXPECT_FALSE(rviz_.offers("spot", "Knife"));
}

TEST_F(InteractiveMarkersTest, MovesAToolThatOutlastsAReset) {
  start(kScene);
  rviz_.press("surface", Vec3::Zero(), Vec3(0.1, 0.05, 0.0));
  rviz_.release("surface", Vec3::Zero());
  rviz_.choose("spot", "Ball");
  ASSERT_TRUE(rviz_.waitForMarker("hand_1")) << markers_->output();
  ASSERT_TRUE(waitUntil([&] { return contacts_.count("hand_1") > 0; }));
  EXPECT_EQ(contacts_["hand_1"], 0u);  // beside the surface
  const double z = rviz_.markers["hand_1"].pose.position.z;
  EXPECT_GT(std::abs(z), 0.01);
  for (int i = 1; i <= 10; ++i) {
    rviz_.drag("hand_1", Vec3(0.1, 0.05, z * (1.0 - 0.06 * i)));
    waitUntil([] { return false; }, 0.03);  // at the rate of RViz
  }
  ASSERT_TRUE(waitUntil([&] { return contacts_["hand_1"] > 0; })) << markers_->output() << process_->output();

  ASSERT_TRUE(client_->reset().success);
  ASSERT_TRUE(waitUntil([&] { return contacts_.count("hand_1") == 0; }));
  EXPECT_TRUE(waitUntil([&] { return contacts_.count("hand_1") > 0; })) << markers_->output();

  rviz_.choose("hand_1", "Attract");
  rviz_.choose("hand_1", "Larger");
  rviz_.choose("hand_1", "Delete");
  EXPECT_TRUE(waitUntil([&] { return contacts_.count("hand_1") == 0 && rviz_.markers.count("hand_1") == 0; }));
}

TEST_F(InteractiveMarkersTest, TheMenuOfADeletedToolDoesNothingWhileTheSurfaceIsAway) {
  start(kScene);
  rviz_.choose("spot", "Ball");
  ASSERT_TRUE(rviz_.waitForMarker("hand_1")) << markers_->output();
  process_.reset();
  // The marker stays as long as there is no surface.
  for (const char* title : {"Delete", "Delete", "Larger", "Attract"}) rviz_.choose("hand_1", title);
  process_ = std::make_unique<NodeProcess>("/surface", kScene);
  ASSERT_TRUE(client_->waitForNode()) << process_->output();
  ASSERT_TRUE(client_->exchange(makeFlatSheet())) << process_->output();
  EXPECT_TRUE(waitUntil([&] { return rviz_.markers.count("hand_1") == 0; })) << markers_->output();
  EXPECT_TRUE(markers_->isRunning()) << markers_->output();
}

TEST_F(InteractiveMarkersTest, PausesStepsAndResets) {
  start(kScene);
  rviz_.choose("panel", "Pause");
  ASSERT_TRUE(waitUntil([&] { return client_->diagnosticText("state") == "paused"; })) << markers_->output();
  // Letters large enough to be read while the whole surface is in view.
  ASSERT_TRUE(waitUntil([&] { return rviz_.findAnswer().text.find("paused") != std::string::npos; }));
  EXPECT_GT(rviz_.findAnswer().scale.z, 0.03 * Vec3(kSpacing * kColumns, kSpacing * kRows, 0.0).norm());
  EXPECT_TRUE(rviz_.markers["panel"].description.empty());
  const ros::Time stamp = client_->frames.back()->header.stamp;
  rviz_.choose("panel", "Ten steps");
  ASSERT_TRUE(waitUntil([&] { return client_->frames.back()->header.stamp >= stamp + ros::Duration(0.099); }));
  const ros::Time later = client_->frames.back()->header.stamp;
  rviz_.choose("panel", "Reset");
  ASSERT_TRUE(waitUntil([&] { return client_->frames.back()->header.stamp < later; }));
  rviz_.choose("panel", "Go on");
  ASSERT_TRUE(waitUntil([&] { return client_->diagnosticText("state") == "running"; }));
}

TEST_F(InteractiveMarkersTest, SaysNothingWhileNothingMoves) {
  start(kScene);
  waitUntil([] { return false; }, 0.3);
  const int before = rviz_.num_updates;
  const double step = client_->diagnostic("step");
  ASSERT_TRUE(waitUntil([&] { return client_->diagnostic("step") >= step + 50; }));
  EXPECT_EQ(rviz_.num_updates, before);
}

TEST_F(InteractiveMarkersTest, SpraysTakesAwayAndFreezesParticles) {
  start("{model: oriented_particles, gravity: [0, 0, 0], simplification: {method: none}, material: {damping: 20.0}}");
  ASSERT_TRUE(waitUntil([&] { return points_.width == kColumns * kRows; }));
  rviz_.press("surface", Vec3::Zero(), Vec3(0.1, 0.05, 0.0));
  rviz_.release("surface", Vec3::Zero());
  rviz_.choose("spot", "Take away here");
  ASSERT_TRUE(waitUntil([&] { return points_.width < kColumns * kRows; })) << markers_->output();
  const std::uint32_t left = points_.width;
  rviz_.choose("spot", "Spray points here");
  ASSERT_TRUE(waitUntil([&] { return points_.width > left; })) << markers_->output();
  // Only points that the program has received: the newest may reach it later than this test.
  const auto is_frozen = [&] { return countPinned() == static_cast<int>(points_.width); };
  bool all_frozen = false;
  for (int k = 0; k < 5 && !all_frozen; ++k) {
    rviz_.choose("panel", "Freeze");
    all_frozen = waitUntil(is_frozen, 3.0);
  }
  ASSERT_TRUE(all_frozen) << markers_->output();
  rviz_.choose("panel", "Melt");
  ASSERT_TRUE(waitUntil([&] { return countPinned() == 0; })) << markers_->output();
}

TEST(InteractiveMarkers, RefuseUnknownParametersAlsoUnderTheirOldName) {
  NodeProcess markers("/markers", "{surface: /surface, rate: -1.0, raduis: 0.1}", "deformable_surface_hand");
  EXPECT_EQ(markers.waitForExit(), std::optional<int>(2));
  EXPECT_NE(markers.output().find("raduis"), std::string::npos) << markers.output();
  EXPECT_NE(markers.output().find("rate"), std::string::npos) << markers.output();
  EXPECT_NE(markers.output().find("deformable_surface_interactive_markers"), std::string::npos) << markers.output();
}

}  // namespace
}  // namespace deformable_surface::node::test

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  ros::init(argc, argv, "interactive_markers_rostest");
  ros::NodeHandle keep_alive;
  return RUN_ALL_TESTS();
}
