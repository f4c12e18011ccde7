// The number of a thousand difficult scenes that each method completes soundly: --stability. Not part of a plain benchmark,
// because it takes minutes and measures no speed.
#include "sections.h"

#include "../test/support/stability_judge.h"
#include "deformable_surface/base/parallel.h"
#include "deformable_surface/base/timer.h"

#include <algorithm>

namespace deformable_surface::benchmark {
namespace {

using solve::IntegratorType;
using test::StabilityVerdict;

constexpr unsigned kSeeds = 84;       // per family of the default method: a thousand cases and a few
constexpr unsigned kOtherSeeds = 12;  // of the others, of which some take millions of sub-steps

struct Method {
  const char* name;
  IntegratorType type;
  unsigned seeds;
};
constexpr Method kMethods[] = {
    {"auto", IntegratorType::kAuto, kSeeds},          {"implicit", IntegratorType::kImplicit, kOtherSeeds},
    {"verlet", IntegratorType::kVerlet, kOtherSeeds}, {"symplectic_euler", IntegratorType::kSymplecticEuler, kOtherSeeds},
    {"static", IntegratorType::kStatic, kOtherSeeds}, {"explicit_euler", IntegratorType::kExplicitEuler, kOtherSeeds}};

StabilityVerdict judge(const std::string& family, unsigned seed, IntegratorType type) {
  try {
    return test::StabilityJudge::judge(test::StabilityGenerator::make(family, seed), type);
  } catch (const std::exception& problem) {
    return {StabilityVerdict::kFailed, std::string("threw: ") + problem.what(), 0.0, 0};
  }
}

// A sheet swings without damping for a million steps: the mean energy over the last tenth against the first, and its range.
void runLongSwing(Report& report) {
  test::StabilityCase scene = test::StabilityGenerator::make("time_step", 0);
  simulation::SceneParams& p = scene.params;
  p = simulation::SceneParams();
  p.simplification.method = cloud::SimplificationMethod::kNone;
  p.integrator.type = IntegratorType::kVerlet;
  p.material.bending_rigidity = 1e-4;
  simulation::PinParams pin;
  pin.region.min = Vec3(-0.001, -1.0, -1.0);
  pin.region.max = Vec3(0.001, 1.0, 1.0);
  p.pins.push_back(pin);
  simulation::Simulation s(p, scene.cloud);
  constexpr int kSteps = 1000000, kTenth = kSteps / 10, kEvery = 10;
  double first = 0.0, last = 0.0, lowest = 0.0, highest = 0.0, exchanged = 0.0;
  int steps = 0, retries = 0;
  for (; steps < kSteps; ++steps) {
    const simulation::StepOutcome outcome = s.step();
    retries += outcome.was_retried;
    if (!outcome.ok) {
      report.note("long swing: " + outcome.problem);
      break;
    }
    if (steps % kEvery != 0) continue;
    const simulation::Statistics now = s.statistics();
    // Zero at the start: all points at z = 0.
    const double energy = now.kinetic_energy + now.elastic_energy + now.potential_energy;
    lowest = std::min(lowest, energy);
    highest = std::max(highest, energy);
    exchanged = std::max(exchanged, now.kinetic_energy + now.elastic_energy);
    if (steps < kTenth) first += energy * kEvery / kTenth;
    if (steps >= kSteps - kTenth) last += energy * kEvery / kTenth;
  }
  report.begin("stability_long", "A million steps of a swinging sheet without damping, verlet; energy over the largest exchanged",
               {"steps", "points", "retried", "mean of first tenth", "mean of last tenth", "lowest", "highest"});
  report.add({std::to_string(steps), std::to_string(s.state().size()), std::to_string(retries), show(first / exchanged),
              show(last / exchanged), show(lowest / exchanged), show(highest / exchanged)});
  report.end();
}

}  // namespace

void runStabilitySection(const Options&, Report& report) {
  report.begin("stability", "Generated scenes, by method and family (docs/stability.md)",
               {"method", "family", "cases", "passed", "refused", "failed", "gain", "notices", "cpu s"});
  std::vector<std::string> failures;
  for (const Method& method : kMethods) {
    int all[3] = {0, 0, 0}, all_notices = 0;
    double all_gain = 0.0, all_seconds = 0.0;
    const auto add = [&](const std::string& family, const int* kinds, double gain, int notices, double seconds) {
      report.add({method.name, family, std::to_string(kinds[0] + kinds[1] + kinds[2]), std::to_string(kinds[0]),
                  std::to_string(kinds[1]), std::to_string(kinds[2]), show(gain), std::to_string(notices), show(seconds)});
    };
    for (const std::string& family : test::stabilityFamilies()) {
      int kinds[3] = {0, 0, 0}, notices = 0;
      double gain = 0.0;
      const double begin = processorSeconds();
      for (unsigned seed = 0; seed < method.seeds; ++seed) {
        const StabilityVerdict verdict = judge(family, seed, method.type);
        ++kinds[verdict.kind];
        gain = std::max(gain, verdict.gain);
        notices += verdict.notices;
        const bool expected = verdict.kind != StabilityVerdict::kFailed && method.type != IntegratorType::kAuto;
        if (verdict.kind != StabilityVerdict::kPassed && !expected)
          failures.push_back(std::string(method.name) + " " + family + " " + std::to_string(seed) + ": " + verdict.reason);
      }
      const double seconds = processorSeconds() - begin;
      add(family, kinds, gain, notices, seconds);
      for (int kind = 0; kind < 3; ++kind) all[kind] += kinds[kind];
      all_gain = std::max(all_gain, gain);
      all_notices += notices;
      all_seconds += seconds;
    }
    add("all", all, all_gain, all_notices, all_seconds);
  }
  report.end();
  for (const std::string& failure : failures) report.note(failure);
  runLongSwing(report);
}

}  // namespace deformable_surface::benchmark
