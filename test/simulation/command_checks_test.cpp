#include "../../src/simulation/command_checks.h"

#include "../../src/simulation/dynamics.h"
#include "clouds.h"

#include <gtest/gtest.h>

#include <limits>

namespace deformable_surface::test {
namespace {

using simulation::Command;
namespace command = simulation::command;

const double kNaN = std::numeric_limits<double>::quiet_NaN();

// Each with a part of the message that refuses it.
std::vector<std::pair<Command, std::string>> badCommands(const simulation::Dynamics& sheet) {
  tool::ToolParams unread;
  unread.id = "mesh";
  unread.shape.kind = geometry::Solid::Kind::kMesh;
  unread.path.resize(1);
  model::State torn = sheet.state();
  torn.positions.pop_back();
  simulation::SceneParams other = sheet.params();
  other.integrator.time_step *= 0.5;
  simulation::SceneParams moved = sheet.params();
  moved.pins[0].region.max.x() = 0.5;
  simulation::MaterialChangeParams negative;
  negative.young_modulus = -1.0;
  tool::ToolParams odd = unread;
  odd.shape = {};
  odd.mode = static_cast<tool::Mode>(1000000000);
  geometry::Region nowhere, shapeless;
  nowhere.min.x() = kNaN;
  shapeless.kind = static_cast<geometry::Region::Kind>(7);
  return {{command::SetForce{{"pull", Vec3(kNaN, 0.0, 0.0)}}, "force 'pull' "},
          {command::SetTool{unread}, "tool 'mesh' "},
          {command::SetTool{odd}, "tool 'mesh' mode: found 1000000000; accepted: solid, attract, "},
          {command::MoveTool{"none", {{}}}, "there is none"},
          {command::MovePin{"none", {}}, "pin 'none' path: "},
          {command::MovePin{"none", {{}}}, "pin 'none': there is none"},
          {command::Pin{nowhere}, "region box.min[0]: found "},
          {command::Unpin{shapeless}, "region found neither of box and sphere"},
          {command::PinAlong{"held", nowhere, {{}}}, "pin 'held' box.min[0]: found "},
          {command::SetMaterial{nowhere, negative}, "region box.min[0]: found "},
          {command::SetGravity{Vec3(0.0, kNaN, 0.0)}, "gravity[1]: "},
          {command::SetGravity{Vec3(0.0, 0.0, 1e9)}, "gravity[2]: found 1.0e+09; accepted: -1e6 to 1e6 (m/s^2)"},
          {command::Observe{}, "cloud: found none"},
          {command::SetMaterial{}, "found none of young_modulus"},
          {command::SetMaterial{{}, negative}, "young_modulus"},
          {command::SetDamping{-1.0}, "damping"},
          {command::SetParams{other},
           "integrator.time_step: found 0.005 instead of 0.01, which cannot change while a surface runs; accepted"},
          {command::SetParams{moved}, "pins[0].box.max[0]: found 0.5 instead of 0.001, which cannot change"},
          {command::SetState{torn}, "positions"},
          {command::EditParticles{}, "no particles"},
          {command::GrowSurface{}, "no particles"}};
}

TEST(CommandChecks, RefuseWhatCannotBeDoneAndChangeNothing) {
  const simulation::SceneParams params = hangingSheet();
  const simulation::Dynamics sheet(params, simulation::buildRestSurface(params, sheetCloud(15)));
  const std::uint64_t revision = sheet.revision();
  for (const auto& [given, said] : badCommands(sheet)) {
    SCOPED_TRACE(given.index());
    try {
      simulation::check(given, sheet);
      ADD_FAILURE() << "accepted";
    } catch (const InputError& problem) {
      EXPECT_NE(std::string(problem.what()).find(said), std::string::npos) << problem.what();
      EXPECT_NE(problem.what()[0], ':') << problem.what();
    }
  }
  EXPECT_EQ(sheet.revision(), revision);
  simulation::check(command::Unpin{}, sheet);
  simulation::check(command::RemoveTool{"none"}, sheet);
}

// No region is named, so none is spoken of.
TEST(CommandChecks, TellWhichMaterialOfParticlesAndSolidsChangesWhileTheyRun) {
  simulation::SceneParams params;
  params.model = "oriented_particles";
  params.material.bending_rigidity = 1e-2;
  const simulation::Dynamics particles(params, simulation::buildRestSurface(params, sheetCloud(15)));
  simulation::SceneParams stiffer = particles.params();
  stiffer.material.young_modulus *= 2.0;
  simulation::MaterialChangeParams heavier;
  heavier.density = 500.0;
  const std::string reason =
      ": found a change, but of the material of oriented_particles only the damping changes while a surface runs; accepted: "
      "changes of damping, or model: mass_spring";
  const std::vector<std::pair<Command, std::string>> refused = {{command::SetParams{stiffer}, "material.young_modulus" + reason},
                                                                {command::SetMaterial{{}, heavier}, "density" + reason}};
  for (const auto& [given, said] : refused) {
    try {
      simulation::check(given, particles);
      ADD_FAILURE() << "accepted: " << said;
    } catch (const InputError& problem) {
      EXPECT_EQ(std::string(problem.what()), said);
    }
  }
  simulation::check(command::SetDamping{3.0}, particles);
}

}  // namespace
}  // namespace deformable_surface::test
