// Wrong parameters end the node at its start, with a message that names each of them.
#include "../node_client.h"

namespace deformable_surface::node::test {
namespace {

void expectRefusal(const std::string& scene, const std::vector<std::string>& words) {
  NodeProcess process("/surface", scene);
  const auto exit_code = process.waitForExit();
  ASSERT_TRUE(exit_code) << "still running with " << scene;
  EXPECT_EQ(*exit_code, 2) << scene;
  const std::string output = process.output();
  for (const std::string& word : words) EXPECT_NE(output.find(word), std::string::npos) << word << " in:\n" << output;
}

TEST(NodeParameters, ThatAreWrongAreAllNamed) {
  expectRefusal("{model: mass_spring, materiel: {thickness: 1.0}, integrator: {time_step: fast}, gravity: [0, 0]}",
                {"materiel", "material", "integrator.time_step", "fast", "gravity"});
}

TEST(NodeParameters, WithoutAModelAreRefused) { expectRefusal("{threads: 1}", {"model", "mass_spring"}); }

TEST(NodeParameters, RefuseASaveDirectoryThatIsNotThere) {
  expectRefusal("{model: mass_spring, save_directory: somewhere}", {"save_directory", "somewhere", "absolute"});
}

TEST(NodeParameters, OfSimulateAreAcceptedAndNumbersMayBeText) {
  NodeProcess process("/surface", R"({model: mass_spring, cloud: {shape: sheet}, duration: 3.0, expect: {max_speed: [0, 1]},
                                      material: {young_modulus: "1e5"}})");
  NodeClient client("/surface");
  EXPECT_TRUE(client.waitForNode()) << process.output();
}

}  // namespace
}  // namespace deformable_surface::node::test

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  ros::init(argc, argv, "node_parameters_rostest");
  ros::NodeHandle keep_alive;
  return RUN_ALL_TESTS();
}
