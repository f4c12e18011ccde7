// The scene and the target are drawn by the seed. One run of all points is the reference of both, the time and the error: its
// target is a share of the diagonal of the cloud, times each of several factors, so that nothing is tuned to one value.
#include "varied_targets.h"

#include "../test/support/varied_scene.h"
#include "deformable_surface/base/parallel.h"
#include "deformable_surface/base/timer.h"
#include "deformable_surface/base/value.h"
#include "deformable_surface/simulation/simulation.h"

#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <csignal>
#include <cstdio>

namespace deformable_surface::benchmark {
namespace {

using simulation::SceneParams;
using simulation::Simulation;

constexpr Index kFirstScene = 3000, kNumScenes = 30;
constexpr Index kSizes[] = {400, 600, 1000, 1500, 2500, 4000, 7000, 15000, 40000, 100000};  // about the points of a cloud
constexpr double kShares[] = {0.03, 0.01, 0.003};                                           // target over diagonal
constexpr double kFactors[] = {0.5, 1.0, 2.0, 5.0};                                         // of the target
constexpr unsigned kMostSeconds = 90;  // s of wall time: a scene whose run of all points takes longer is left out
constexpr int kLooks = 8;              // at the error of a run, at equal times

std::atomic<bool> has_expired{false};
void expire(int) { has_expired = true; }

struct Run {
  double set_up = 0.0, steps = 0.0;  // s of processor time
  std::vector<Points> looks;
  bool is_sound = true;
  std::unique_ptr<Simulation> simulation;
};

Run run(const SceneParams& params, const cloud::PointCloud& cloud) {
  Run result;
  double before = processorSeconds();
  result.simulation = std::make_unique<Simulation>(params, cloud);
  result.simulation->setInterrupt(&has_expired);
  result.set_up = processorSeconds() - before;
  const int steps = std::max(1, static_cast<int>(std::lround(params.duration / params.integrator.time_step)));
  const int looks = std::min(kLooks, steps);
  for (int k = 1; k <= steps && result.is_sound; ++k) {
    before = processorSeconds();
    result.is_sound = result.simulation->step().ok;
    result.steps += processorSeconds() - before;
    if (k == static_cast<int>(result.looks.size() + 1) * steps / looks)
      result.looks.push_back(result.simulation->surface(false).positions);
  }
  return result;
}

double findLargestError(const Run& of, const Run& truth) {
  double largest = 0.0;
  for (std::size_t k = 0; k < std::min(of.looks.size(), truth.looks.size()); ++k)
    for (std::size_t i = 0; i < truth.looks[k].size(); ++i)
      largest = std::max(largest, (of.looks[k][i] - truth.looks[k][i]).norm());
  return largest;
}

std::string listTrials(const simulation::AccuracyChoice& choice) {
  std::string all;
  for (const simulation::AccuracyChoice::Candidate& c : choice.candidates)
    all += (all.empty() ? "" : " ") + std::to_string(c.points) + (c.membrane_share < 1.0 ? "s" : "") + ":" + show(c.error);
  return all;
}

double findMedian(std::vector<double> values) {
  if (values.empty()) return std::nan("");
  std::sort(values.begin(), values.end());
  return values[values.size() / 2];
}

struct Tally {
  std::vector<double> ratios;  // of time
  int won = 0, kept = 0;

  void add(double ratio, bool is_kept) {
    ratios.push_back(ratio);
    won += ratio < 1.0;
    kept += is_kept;
  }
  std::string say() const {
    const int num = static_cast<int>(ratios.size());
    if (num == 0) return "none";
    return std::to_string(num) + " scenes, faster than all points in " + std::to_string(won) + " (" +
           showPercent(won / double(num)) + " %), kept in " + std::to_string(kept) + " (" + showPercent(kept / double(num)) +
           " %), median of the time over that of all points " + show(findMedian(ratios));
  }
};

}  // namespace

void reportVariedTargets(const Options& options, Report& report) {
  const Index first = options.num_scenes > 0 ? options.first_scene : kFirstScene;
  const Index num = options.num_scenes > 0 ? options.num_scenes : kNumScenes;
  report.begin(
      "targets_varied", "15. Scenes of other families with accuracy.position_error, one thread",
      {"seed", "scene", "points", "factor", "target_m", "simulated", "membrane_share", "met", "trials", "all_set_up_cpu_s",
       "all_steps_cpu_s", "choice_and_set_up_cpu_s", "steps_cpu_s", "time_ratio", "error_over_target"});
  setNumThreads(1);
  std::signal(SIGALRM, expire);
  Tally tallies[std::size(kFactors)];
  std::string left_out;
  for (Index seed = first; seed < first + num; ++seed) {
    const test::RandomScene scene =
        test::makeVariedScene(static_cast<std::uint32_t>(seed), kSizes[static_cast<std::size_t>(seed) % std::size(kSizes)]);
    SceneParams all = scene.params;
    all.accuracy.remember = false;
    all.simplification = cloud::SimplificationParams();
    SceneParams asked = all;
    all.simplification.method = cloud::SimplificationMethod::kNone;
    std::string why = "takes longer than " + std::to_string(kMostSeconds) + " s";
    Run truth;
    has_expired = false;
    alarm(kMostSeconds);
    try {
      truth = run(all, scene.cloud);
    } catch (const std::exception& problem) {
      truth.is_sound = false;
      why = problem.what();
    }
    alarm(0);
    if (!truth.is_sound && !has_expired && truth.simulation) why = "no sound step of all points";
    has_expired = false;
    if (!truth.is_sound) {
      left_out += "\n    " + std::to_string(seed) + " " + scene.name + ": " + why;
      continue;
    }
    Vec3 low = scene.cloud.positions.front(), high = low;
    for (const Vec3& p : scene.cloud.positions) {
      low = low.cwiseMin(p);
      high = high.cwiseMax(p);
    }
    const double share = kShares[static_cast<std::size_t>(seed) % std::size(kShares)];
    for (std::size_t f = 0; f < std::size(kFactors); ++f) {
      asked.accuracy.position_error = kFactors[f] * share * (high - low).norm();
      const Run chosen = run(asked, scene.cloud);
      const simulation::AccuracyChoice& choice = chosen.simulation->accuracyChoice();
      const double ratio = (chosen.set_up + chosen.steps) / (truth.set_up + truth.steps);
      const double error = chosen.is_sound ? findLargestError(chosen, truth) : std::numeric_limits<double>::infinity();
      tallies[f].add(ratio, error <= asked.accuracy.position_error);
      report.add({std::to_string(seed), scene.name, std::to_string(scene.cloud.size()), show(kFactors[f]),
                  show(asked.accuracy.position_error), std::to_string(choice.points), show(choice.membrane_share),
                  choice.is_met ? "yes" : "no", listTrials(choice), show(truth.set_up), show(truth.steps), show(chosen.set_up),
                  show(chosen.steps), show(ratio), show(error / asked.accuracy.position_error)});
      std::fprintf(stderr, "%d %s %g: %s, time %s, error %s\n", seed, scene.name.c_str(), kFactors[f], choice.sentence.c_str(),
                   show(ratio).c_str(), show(error / asked.accuracy.position_error).c_str());
    }
  }
  setNumThreads(0);
  report.end();
  report.note("time_ratio: choice, set-up and steps over set-up and steps of all points, both with the estimate; the target is " +
              std::string("kept if no published point is further from the run of all points at eight looks"));
  for (std::size_t f = 0; f < std::size(kFactors); ++f) report.note(show(kFactors[f]) + " of the target: " + tallies[f].say());
  if (!left_out.empty()) report.note("left out:" + left_out);
}

}  // namespace deformable_surface::benchmark
