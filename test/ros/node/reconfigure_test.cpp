// dynamic_reconfigure: the description of the parameters for clients, and the effect of their requests.
#include "../../../src/ros/node/reconfigure.h"

#include "deformable_surface/base/error.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace deformable_surface::node {
namespace {

using dynamic_reconfigure::Config;
using simulation::SceneParams;

double* findNumber(Config& config, const std::string& name) {
  const auto found = std::find_if(config.doubles.begin(), config.doubles.end(), [&](const auto& p) { return p.name == name; });
  return found == config.doubles.end() ? nullptr : &found->value;
}

Config makeNumber(const std::string& name, double value) {
  Config config;
  config.doubles.resize(1);
  config.doubles[0].name = name;
  config.doubles[0].value = value;
  return config;
}

TEST(Reconfigure, EveryRunTimeKeyOfTheSchemaIsDescribed) {
  const dynamic_reconfigure::ConfigDescription description = describeRunTimeParams();
  ASSERT_EQ(description.groups.size(), 1u);
  std::vector<std::string> names;
  for (const auto& parameter : description.groups[0].parameters) {
    names.push_back(parameter.name);
    EXPECT_FALSE(parameter.description.empty()) << parameter.name;
  }
  for (const std::string& key : simulation::runTimeKeys()) {
    const bool is_vector = key == "gravity";
    for (const char* part : {".x", ".y", ".z"})
      EXPECT_EQ(std::count(names.begin(), names.end(), is_vector ? key + part : key), 1) << key;
  }
  EXPECT_EQ(names.size(), simulation::runTimeKeys().size() + 2);
  Config low = description.min, high = description.max, standard = description.dflt;
  EXPECT_EQ(*findNumber(low, "material.young_modulus"), 1e-6);
  EXPECT_EQ(*findNumber(high, "material.young_modulus"), 1e15);
  EXPECT_EQ(*findNumber(standard, "gravity.z"), SceneParams().gravity.z());
}

TEST(Reconfigure, WhatIsPrintedIsReadBack) {
  SceneParams params;
  params.gravity = Vec3(0.1, 0.2, -1.6);
  params.material.young_modulus = 123456.789;
  params.output.normals = false;
  const SceneParams read = readRunTimeParams(printRunTimeParams(params), SceneParams());
  EXPECT_EQ(read.gravity, params.gravity);
  EXPECT_EQ(read.material.young_modulus, params.material.young_modulus);
  EXPECT_FALSE(read.output.normals);
}

TEST(Reconfigure, OnlyWhatIsNamedChanges) {
  SceneParams params;
  params.pressure = 2.0;
  const SceneParams read = readRunTimeParams(makeNumber("gravity.y", 3.0), params);
  EXPECT_EQ(read.gravity, Vec3(0.0, 3.0, params.gravity.z()));
  EXPECT_EQ(read.pressure, 2.0);
}

TEST(Reconfigure, WhatTheSchemaRefusesIsRefusedWithItsSentence) {
  const auto refusal = [](const Config& config) {
    try {
      readRunTimeParams(config, SceneParams());
    } catch (const InputError& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  EXPECT_NE(refusal(makeNumber("material.young_modulus", -1.0)).find("material.young_modulus: found -1"), std::string::npos);
  EXPECT_FALSE(refusal(makeNumber("pressure", std::nan(""))).empty());
  EXPECT_NE(refusal(makeNumber("integrator.time_step", 0.1)).find("'integrator.time_step'"), std::string::npos);
  EXPECT_FALSE(refusal(makeNumber("output.normals", 1.0)).empty());
}

}  // namespace
}  // namespace deformable_surface::node
