// The page of topics and services is the one that the program prints, and describes every entry.
#include "../../../src/ros/node/interface_page.h"

#include <gtest/gtest.h>

#include <fstream>
#include <set>
#include <sstream>

namespace deformable_surface::node {
namespace {

TEST(InterfacePage, IsTheOneInTheRepository) {
  std::ifstream file(DEFORMABLE_SURFACE_SOURCE_DIR "/docs/interface.md");
  std::ostringstream text;
  text << file.rdbuf();
  EXPECT_EQ(text.str(), interfacePage()) << "make it anew with: interface_page > docs/interface.md";
}

TEST(InterfacePage, SaysOfEveryEntryWhatItIs) {
  std::set<std::string> names;
  for (const InterfaceEntry& entry : interfaceTable()) {
    EXPECT_TRUE(names.insert(entry.name).second) << entry.name;
    EXPECT_FALSE(entry.meaning.empty()) << entry.name;
    EXPECT_NE(entry.type.find('/'), std::string::npos) << entry.name;
  }
}

TEST(InterfacePage, HasTheFieldsOfMessagesWithTheirComments) {
  const std::string page = interfacePage();
  EXPECT_NE(page.find("geometry_msgs/Vector3 force # N, the total; zero removes the force of that id"), std::string::npos);
  // Fields of a message inside a message, too.
  EXPECT_NE(page.find("uint32 contacts             # number of simulation points"), std::string::npos);
  EXPECT_EQ(page.find("MSG: "), std::string::npos);
}

TEST(InterfacePage, PrintsNoMessageTwice) {
  const std::string page = interfacePage();
  for (const char* field : {"uint8 DELETEALL=3 ", "# over the bits of the simulation points",
                            "geometry_msgs/Vector3 force # N, the total", "float64 penetration  "}) {
    const std::size_t first = page.find(field);
    ASSERT_NE(first, std::string::npos) << field;
    EXPECT_EQ(page.find(field, first + 1), std::string::npos) << field;
  }
  EXPECT_NE(page.find("# Statistics: see ~statistics"), std::string::npos);
  EXPECT_NE(page.find("# Tool: see ~tools"), std::string::npos);
  EXPECT_EQ(page.find("feedback are."), std::string::npos);
}

}  // namespace
}  // namespace deformable_surface::node
