// Choices kept from run to run: they come back with all their bits, for the same scene only, and change nothing but the time.
#include "../../src/simulation/accuracy_memory.h"

#include "deformable_surface/simulation/simulation.h"
#include "sagging_strip.h"
#include "support/comma_locale.h"

#include <gtest/gtest.h>

#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <sstream>
#include <string>

namespace deformable_surface::test {
namespace {

namespace fs = std::filesystem;
using simulation::AccuracyChoice;
using simulation::SceneParams;
using simulation::Simulation;

// A folder of its own for each test.
class ChoiceMemory : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::temp_directory_path() / ("choices_" + std::to_string(::getpid()));
    fs::remove_all(folder_);
    setenv("DEFORMABLE_SURFACE_CACHE", folder_.c_str(), 1);
  }
  void TearDown() override {
    fs::remove_all(folder_);
    unsetenv("DEFORMABLE_SURFACE_CACHE");
  }
  int countFiles() const {
    return fs::exists(folder_) ? static_cast<int>(std::distance(fs::directory_iterator(folder_), fs::directory_iterator())) : 0;
  }
  fs::path folder_;
};

SceneParams stiffStrip() {
  SceneParams p = saggingStrip(solve::IntegratorType::kVerlet);
  p.accuracy.position_error = 0.1;
  p.accuracy.remember = true;
  return p;
}

bool isRecalled(const Simulation& simulation) {
  const std::vector<std::string> notes = simulation.buildNotes();
  return std::any_of(notes.begin(), notes.end(), [](const std::string& note) { return note.find("no trials") == 0; });
}

// What a run has that searched for its equilibrium has one that took it over from its trial.
void expectTheSame(Simulation& a, Simulation& b) {
  EXPECT_EQ(a.stateHash(), b.stateHash());
  const simulation::Statistics of_a = a.statistics(), of_b = b.statistics();
  EXPECT_EQ(of_a.error_estimate, of_b.error_estimate);
  EXPECT_EQ(of_a.error_bounded, of_b.error_bounded);
  EXPECT_EQ(of_a.may_buckle, of_b.may_buckle);
  EXPECT_EQ(of_a.solver_iterations, of_b.solver_iterations);
  EXPECT_EQ(of_a.solver_residual, of_b.solver_residual);
  EXPECT_EQ(of_a.elastic_energy, of_b.elastic_energy);
}

TEST_F(ChoiceMemory, AnEquilibriumIsTakenOverFromItsTrialWithAllBits) {
  SceneParams p = saggingStrip(solve::IntegratorType::kStatic);
  p.accuracy.position_error = 0.1;
  p.accuracy.remember = true;
  p.duration = 3.0 * p.integrator.time_step;
  Simulation tried(p, strip()), recalled(p, strip());
  ASSERT_LT(tried.accuracyChoice().points, strip().size());
  ASSERT_TRUE(isRecalled(recalled));
  for (int attempt = 0; attempt < 2; ++attempt) {
    for (int k = 0; k < 3; ++k) {
      const simulation::StepOutcome a = tried.step(), b = recalled.step();
      EXPECT_TRUE(a.ok);
      EXPECT_EQ(a.notice, b.notice);
      expectTheSame(tried, recalled);
      if (k > 0) continue;
      EXPECT_EQ(tried.statistics().time_forces, 0.0);  // it was not searched for
      EXPECT_GT(recalled.statistics().time_forces, 0.0);
    }
    tried.reset();
    recalled.reset();
  }
  // A fork takes it over, too. After a command it would be another equilibrium.
  Simulation fork = tried.fork();
  fork.step();
  EXPECT_EQ(fork.statistics().time_forces, 0.0);
  for (Simulation* s : {&tried, &recalled}) {
    simulation::ForceParams pull;
    pull.id = "pull";
    pull.point = Vec3(0.5, 0.0, 0.0);
    pull.force = Vec3(0.0, 0.0, 0.01);
    s->setForce(pull);
    s->step();
  }
  EXPECT_GT(tried.statistics().time_forces, 0.0);
  expectTheSame(tried, recalled);
  EXPECT_NE(tried.stateHash(), fork.stateHash());
}

TEST_F(ChoiceMemory, RecallsInEveryLocaleWhatWasKeptInAnother) {
  const Simulation first(stiffStrip(), strip());
  const CommaLocale locale;
  if (!locale.isThere()) GTEST_SKIP() << CommaLocale::kNone;
  const Simulation second(stiffStrip(), strip());
  EXPECT_TRUE(isRecalled(second));
  EXPECT_EQ(second.accuracyChoice().error, first.accuracyChoice().error);
}

TEST_F(ChoiceMemory, GivesTheSameChoiceAndTheSameBitsAgain) {
  Simulation first(stiffStrip(), strip()), second(stiffStrip(), strip());
  const AccuracyChoice& tried = first.accuracyChoice();
  const AccuracyChoice& recalled = second.accuracyChoice();
  EXPECT_EQ(countFiles(), 1);
  ASSERT_FALSE(isRecalled(first));
  ASSERT_TRUE(isRecalled(second));
  EXPECT_EQ(recalled.sentence, tried.sentence);
  EXPECT_EQ(recalled.is_met, tried.is_met);
  EXPECT_EQ(recalled.points, tried.points);
  EXPECT_EQ(recalled.membrane_share, tried.membrane_share);
  EXPECT_LT(recalled.membrane_share, 1.0);  // it has what was learnt of a softer membrane, too
  EXPECT_EQ(recalled.softening, tried.softening);
  EXPECT_EQ(recalled.integrator, tried.integrator);
  EXPECT_EQ(recalled.error, tried.error);
  EXPECT_EQ(recalled.work, tried.work);
  EXPECT_EQ(recalled.why_integrator, tried.why_integrator);
  ASSERT_EQ(recalled.candidates.size(), tried.candidates.size());
  for (std::size_t i = 0; i < tried.candidates.size(); ++i) {
    EXPECT_EQ(recalled.candidates[i].points, tried.candidates[i].points);
    EXPECT_EQ(recalled.candidates[i].error, tried.candidates[i].error);
  }
  run(first, 20);
  run(second, 20);
  EXPECT_EQ(first.stateHash(), second.stateHash());
  EXPECT_EQ(first.statistics().error_estimate, second.statistics().error_estimate);
}

TEST_F(ChoiceMemory, IsOfOneSceneAndOneCloud) {
  const Simulation first(stiffStrip(), strip());
  SceneParams denser = stiffStrip();
  denser.material.density *= 1.01;
  EXPECT_FALSE(isRecalled(Simulation(denser, strip())));
  SceneParams longer = stiffStrip();
  longer.duration += 0.01;
  EXPECT_FALSE(isRecalled(Simulation(longer, strip())));
  cloud::PointCloud moved = strip();
  moved.positions[300].z() += 1e-9;
  EXPECT_FALSE(isRecalled(Simulation(stiffStrip(), moved)));
  EXPECT_EQ(countFiles(), 4);
  // The mirror image: the sign of every third number differs.
  cloud::PointCloud mirrored = moved;
  for (Vec3& p : moved.positions) p.z() = 0.01 * p.x() * p.x();
  for (std::size_t i = 0; i < moved.positions.size(); ++i)
    mirrored.positions[i] = moved.positions[i].cwiseProduct(Vec3(1.0, 1.0, -1.0));
  EXPECT_FALSE(isRecalled(Simulation(stiffStrip(), moved)));
  EXPECT_FALSE(isRecalled(Simulation(stiffStrip(), mirrored)));
  // What a run is measured by does not matter.
  SceneParams expected = stiffStrip();
  expected.expect = {{"max_speed", 0.0, 1.0}};
  expected.threads = 2;
  EXPECT_TRUE(isRecalled(Simulation(expected, strip())));
}

TEST_F(ChoiceMemory, RemovesWhatWasUsedLongestAgoFromAFullFolder) {
  const Simulation first(stiffStrip(), strip());
  const fs::path used = fs::directory_iterator(folder_)->path();
  // Others, of the last minutes; the two oldest are the choice above and number 0. A file of somebody else stays.
  const fs::file_time_type now = fs::file_time_type::clock::now();
  const auto pathOf = [&](int number) { return folder_ / ("choice_other" + std::to_string(number)); };
  const int others = simulation::kMostKeptChoices - 1;
  for (int i = 0; i < others; ++i) {
    std::ofstream(pathOf(i)) << i;
    fs::last_write_time(pathOf(i), now - std::chrono::seconds(others - i + 10));
  }
  std::ofstream(folder_ / "notes.txt") << "mine";
  fs::last_write_time(folder_ / "notes.txt", now - std::chrono::hours(1));
  fs::last_write_time(used, now - std::chrono::hours(1));
  EXPECT_TRUE(isRecalled(Simulation(stiffStrip(), strip())));  // which makes it the newest
  SceneParams denser = stiffStrip();
  denser.material.density *= 1.01;
  EXPECT_FALSE(isRecalled(Simulation(denser, strip())));
  EXPECT_EQ(countFiles(), simulation::kMostKeptChoices + 1);
  EXPECT_TRUE(fs::exists(used));
  EXPECT_FALSE(fs::exists(pathOf(0)));
  EXPECT_TRUE(fs::exists(pathOf(1)));
  EXPECT_TRUE(fs::exists(folder_ / "notes.txt"));
}

TEST_F(ChoiceMemory, ReadsNothingOutOfADamagedFileAndReplacesIt) {
  const Simulation first(stiffStrip(), strip());
  const fs::path file = fs::directory_iterator(folder_)->path();
  fs::resize_file(file, fs::file_size(file) - 6);
  EXPECT_FALSE(isRecalled(Simulation(stiffStrip(), strip())));
  EXPECT_TRUE(isRecalled(Simulation(stiffStrip(), strip())));
  // One digit changed, wherever it is.
  std::ostringstream all;
  all << std::ifstream(file).rdbuf();
  const std::string text = all.str();
  for (const std::size_t at : {text.find('\n') + 5, text.size() / 2, text.size() - 4}) {
    std::string changed = text;
    changed[at] = changed[at] == '7' ? '8' : '7';
    std::ofstream(file) << changed;
    EXPECT_FALSE(isRecalled(Simulation(stiffStrip(), strip()))) << at;
  }
  std::ofstream(file) << "something else\n";
  EXPECT_FALSE(isRecalled(Simulation(stiffStrip(), strip())));
}

TEST_F(ChoiceMemory, IsOffWhereTheSceneOrTheFolderSaysSo) {
  SceneParams p = stiffStrip();
  p.accuracy.remember = false;
  const Simulation first(p, strip());
  EXPECT_EQ(countFiles(), 0);
  setenv("DEFORMABLE_SURFACE_CACHE", "", 1);
  EXPECT_EQ(simulation::findCacheFolder(), "");
  EXPECT_FALSE(isRecalled(Simulation(stiffStrip(), strip())));
  EXPECT_FALSE(isRecalled(Simulation(stiffStrip(), strip())));
  unsetenv("DEFORMABLE_SURFACE_CACHE");
  EXPECT_NE(simulation::findCacheFolder().find("deformable_surface"), std::string::npos);
  // A folder that cannot be made keeps nothing, and nothing is wrong.
  std::ofstream(folder_) << "a file\n";
  setenv("DEFORMABLE_SURFACE_CACHE", (folder_ / "below").c_str(), 1);
  const Simulation last(stiffStrip(), strip());
  EXPECT_TRUE(last.accuracyChoice().is_met);
  const std::string note = last.buildNotes()[last.buildNotes().size() - 2];
  EXPECT_EQ(note.find("what trials chose cannot be kept in "), 0u) << note;
}

}  // namespace
}  // namespace deformable_surface::test
