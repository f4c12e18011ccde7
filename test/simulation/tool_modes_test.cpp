// The table of tool modes. Fields that a mode does not use are refused.
#include "clouds.h"

#include <gtest/gtest.h>

#include <cstring>
#include <string>

namespace deformable_surface::test {
namespace {

using tool::Mode;

constexpr const char* kModels[] = {"mass_spring", "oriented_particles", "elastic_solid"};

tool::ToolParams makeTool(Mode mode) {
  tool::ToolParams tool;
  tool.id = "tool";
  tool.mode = mode;
  tool.path = {{0.0, Vec3(0.0, 0.0, 5.0), Vec4(0.0, 0.0, 0.0, 1.0)}};
  if (mode == Mode::kAttract || mode == Mode::kHeat) tool.strength = 1.0;
  if (mode == Mode::kAttract) tool.reach = 0.1;
  return tool;
}

/// The field of the first problem; empty: none.
std::string problemOf(const std::string& model, const tool::ToolParams& tool) {
  const std::vector<simulation::ToolProblem> problems = simulation::findToolProblems(model, tool);
  return problems.empty() ? "" : problems[0].field;
}

TEST(ToolModes, StandInTheTableInTheirOrderWithCodesOfTheirOwn) {
  for (int k = 0; k < static_cast<int>(std::size(tool::kModes)); ++k) {
    EXPECT_EQ(static_cast<int>(tool::kModes[k].mode), k);
    EXPECT_EQ(tool::findMode(tool::kModes[k].code), &tool::kModes[k]);
  }
  EXPECT_EQ(tool::findMode(6), nullptr);
  EXPECT_EQ(tool::messageName(tool::infoOf(Mode::kAttract)), "ATTRACT");
}

TEST(ToolModes, WhatAModeDoesNotUseIsRefusedInSentencesThatNameIt) {
  // Field, mode, models that use it.
  struct Use {
    const char* field;
    double tool::ToolParams::*value;
    bool (*is_used)(const std::string&, Mode);
  };
  const Use uses[] = {
      {"friction", &tool::ToolParams::friction, [](const std::string&, Mode mode) { return mode == Mode::kSolid; }},
      {"strength", &tool::ToolParams::strength,
       [](const std::string& model, Mode mode) {
         return mode == Mode::kAttract || mode == Mode::kMove || mode == Mode::kHeat ||
                (mode == Mode::kCut && model == "oriented_particles");
       }},
      {"reach", &tool::ToolParams::reach, [](const std::string&, Mode mode) { return mode == Mode::kAttract; }}};
  int refused = 0;
  for (const std::string model : kModels)
    for (const tool::ModeInfo& info : tool::kModes) {
      const tool::ToolParams good = makeTool(info.mode);
      if (problemOf(model, good) == "mode") continue;
      EXPECT_EQ(problemOf(model, good), "");
      for (const Use& use : uses) {
        tool::ToolParams given = good;
        given.*use.value = 0.7;
        const std::vector<simulation::ToolProblem> problems = simulation::findToolProblems(model, given);
        ASSERT_EQ(problems.size(), use.is_used(model, info.mode) ? 0u : 1u) << info.name << " " << use.field;
        if (problems.empty()) continue;
        EXPECT_EQ(problems[0].field, use.field);
        EXPECT_NE(problems[0].sentence.find(std::string("found 0.7, which mode ") + info.name), std::string::npos);
        ++refused;
      }
    }
  EXPECT_GT(refused, 15);
}

TEST(ToolModes, ModesThatAModelDoesNotHaveAreNamed) {
  const std::vector<simulation::ToolProblem> problems = simulation::findToolProblems("mass_spring", makeTool(Mode::kErase));
  ASSERT_EQ(problems.size(), 1u);
  EXPECT_EQ(problems[0].sentence, "found erase, which mass_spring does not have; accepted: solid, attract, move, cut");
}

TEST(ToolModes, APlaneIsNoKnife) {
  tool::ToolParams knife = makeTool(Mode::kCut);
  EXPECT_EQ(problemOf("mass_spring", knife), "");
  knife.shape.kind = geometry::Solid::Kind::kPlane;
  EXPECT_EQ(problemOf("mass_spring", knife), "shape");
  EXPECT_EQ(problemOf("oriented_particles", knife), "shape");
  knife.strength = 700.0;
  EXPECT_EQ(problemOf("oriented_particles", knife), "");  // a hot floor
  knife.friction = 0.5;
  EXPECT_EQ(problemOf("oriented_particles", knife), "");  // which is solid
}

TEST(ToolModes, ScenesAndCommandsAreRefusedAlike) {
  simulation::SceneParams p = hangingSheet();
  simulation::Simulation s(p, sheetCloud(10));
  tool::ToolParams magnet = makeTool(Mode::kAttract);
  s.setTool(magnet);
  magnet.friction = 5.0;
  EXPECT_THROW(s.setTool(magnet), InputError);
  EXPECT_EQ(s.tools()[0].friction, 0.0);
  p.tools = {magnet};
  const std::vector<std::string> problems = checkParams(p);
  ASSERT_EQ(problems.size(), 1u);
  EXPECT_EQ(problems[0], "tools[0].friction: found 5.0, which mode attract of mass_spring does not use; accepted: 0, or none");
}

}  // namespace
}  // namespace deformable_surface::test
