// Part 7: coverage of the error estimate. On random scenes the published cloud is compared with that of the full surface in
// stable steps (the truth). A scene is chaotic, and counted separately, if a twin of the truth, disturbed by a thousandth of the
// spacing, departs from it. Steps as large as stability allows can cause that by themselves. Such a truth and its twin run again
// in finer steps, and these runs count.
#include "../src/simulation/dynamics.h"
#include "../test/support/random_scene.h"
#include "../test/support/varied_scene.h"
#include "deformable_surface/base/parallel.h"
#include "deformable_surface/base/value.h"
#include "deformable_surface/simulation/rest_surface.h"
#include "deformable_surface/simulation/simulation.h"
#include "sections.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <map>
#include <sstream>
#include <stdexcept>

namespace deformable_surface::benchmark {
namespace {

using simulation::SceneParams;
using simulation::Simulation;
using solve::IntegratorType;

constexpr Index kFirstScene = 4000, kNumScenes = 240;  // by default: those that the method was not tuned on
constexpr int kLooks = 8;                              // at the errors of a dynamic run, at equal times
constexpr double kDisturbance = 1e-3;                  // of the truth's twin, over the spacing
constexpr double kGrowth = 50.0;                       // of the disturbance from which on a scene counts as chaotic
constexpr Index kFineness = 4;                         // of the truth, if only the steps cause the error or if its twin departs
constexpr Index kSample = 8;                           // one of this many scenes has its truth run again in finer steps
constexpr double kIsTruth = 0.1;                       // of the error: limit of the truth's motion in twice as many sub-steps

// What the tables below do not read is for others in docs/accuracy_control.md: points by their number, parts of the estimate, and
// the estimate over the motion. Of the errors of all points: the share that their own estimates cover, the median of these over
// the errors, and that of the estimate of the largest error over them.
const char* const kColumns[] = {"seed",         "scene",          "points",       "simulated",    "look",
                                "true_error",   "estimate",       "space",        "transfer",     "time",
                                "displacement", "twin_growth",    "sound",        "truth_moved",  "may_buckle",
                                "unbounded",    "points_covered", "points_ratio", "largest_ratio"};

double findLargestDistance(const Points& a, const Points& b) {
  double largest = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) largest = std::max(largest, (a[i] - b[i]).norm());
  return largest;
}

// The full cloud at every look; false if a step was not sound.
bool runTruth(SceneParams params, const cloud::PointCloud& cloud, int steps, int looks, double disturbance, Index fineness,
              std::vector<Points>& shapes) {
  params.accuracy.estimate = false;
  params.output.error = false;
  params.simplification = cloud::SimplificationParams();
  params.simplification.method = cloud::SimplificationMethod::kNone;
  if (params.integrator.type != IntegratorType::kStatic) params.integrator.type = IntegratorType::kVerlet;
  Simulation truth(params, cloud);
  truth.dynamics().setFineness(fineness);
  truth.dynamics().disturb(disturbance);
  for (int k = 1; k <= steps; ++k) {
    const simulation::StepOutcome outcome = truth.step();
    if (!outcome.ok || !outcome.has_converged || outcome.was_retried || !outcome.notice.empty()) return false;
    if (k == static_cast<int>(shapes.size() + 1) * steps / looks) shapes.push_back(truth.surface(false).positions);
  }
  return true;
}

double findQuantile(std::vector<double> values, double share) {
  if (values.empty()) return std::nan("");
  std::sort(values.begin(), values.end());
  return values[std::min(values.size() - 1, static_cast<std::size_t>(share * static_cast<double>(values.size())))];
}

// The last columns, of all points that move. largest: the estimate of the largest error, m.
void writePlaces(const simulation::Surface& made, const Points& truth, double largest, std::ostringstream& line) {
  std::vector<double> ratios, largest_ratios;
  double covered = 0.0;
  for (std::size_t i = 0; i < truth.size(); ++i) {
    const double error = (made.positions[i] - truth[i]).norm();
    if (!(error > 0.0)) continue;  // also of holes
    covered += error <= made.error[i];
    ratios.push_back(made.error[i] / error);
    largest_ratios.push_back(largest / error);
  }
  line << ',' << covered / static_cast<double>(ratios.size()) << ',' << findQuantile(ratios, 0.5) << ','
       << findQuantile(largest_ratios, 0.5) << "\n";
}

// One line of numbers per look.
std::string runScene(Index seed, bool varied) {
  const auto number = static_cast<std::uint32_t>(seed);
  test::RandomScene scene = varied ? test::makeVariedScene(number) : test::makeRandomScene(number);
  const int steps = static_cast<int>(std::lround(scene.params.duration / scene.params.integrator.time_step));
  const int looks = std::min(kLooks, steps);
  const bool is_simplified = scene.params.simplification.method == cloud::SimplificationMethod::kDelaunay;
  scene.params.output.error = true;
  Simulation simulation(scene.params, scene.cloud);

  double area = 0.0;
  for (const model::WeightedTriangle& t : trianglesOf(simulation.model())) {
    const Points& x = simulation.state().positions;
    area += 0.5 * t.weight * (x[t.corner[1]] - x[t.corner[0]]).cross(x[t.corner[2]] - x[t.corner[0]]).norm();
  }
  const double disturbance = kDisturbance * std::sqrt(area / scene.cloud.size());
  std::vector<Points> truth, twin;
  Index fineness = is_simplified ? 1 : kFineness;
  const auto runTruths = [&] {
    truth.clear();
    twin.clear();
    return runTruth(scene.params, scene.cloud, steps, looks, 0.0, fineness, truth) &&
           runTruth(scene.params, scene.cloud, steps, looks, disturbance, fineness, twin);
  };
  bool is_sound = runTruths();
  double growth = 0.0;
  for (int k = 0; k < looks && is_sound; ++k) growth = std::max(growth, findLargestDistance(truth[k], twin[k]) / disturbance);
  if (growth > kGrowth && scene.params.integrator.type != IntegratorType::kStatic) {
    fineness *= kFineness;
    is_sound = runTruths();
  }
  // The error of the truth itself, on a sample.
  std::vector<Points> finer;
  const bool is_sampled = is_sound && seed % kSample == 0 && scene.params.integrator.type != IntegratorType::kStatic;
  if (is_sampled) is_sound = runTruth(scene.params, scene.cloud, steps, looks, 0.0, 2 * fineness, finer);
  std::ostringstream lines;
  int look = 0;
  for (int k = 1; k <= steps && is_sound; ++k) {
    is_sound = simulation.step().ok;
    if (k != (look + 1) * steps / looks) continue;
    const simulation::Statistics s = simulation.statistics();
    lines << seed << ',' << scene.name << ',' << s.points << ',' << s.simulation_points << ',' << look + 1;
    for (double value : {findLargestDistance(simulation.surface(false).positions, truth[look]), s.error_estimate, s.error_space,
                         s.error_transfer, s.error_time, findLargestDistance(truth[look], scene.cloud.positions),
                         findLargestDistance(truth[look], twin[look]) / disturbance})
      lines << ',' << value;
    const double moved = is_sampled ? findLargestDistance(truth[look], finer[look]) : std::nan("");
    lines << ",1," << moved << ',' << s.may_buckle << ',' << !s.error_bounded;
    writePlaces(simulation.surface(false), truth[look], s.error_estimate, lines);
    ++look;
  }
  if (is_sound) return lines.str();
  std::ostringstream line;
  line << seed << ',' << scene.name << ',' << scene.cloud.size() << ",0,0,0,0,0,0,0,0,0,0,nan,0,0,nan,nan,nan\n";
  return line.str();
}

struct Row {
  std::map<std::string, std::string> cells;
  double number(const char* column) const { return std::strtod(cells.at(column).c_str(), nullptr); }
};

std::string listColumns() {
  std::string all;
  for (const char* column : kColumns) all += (all.empty() ? "" : ",") + std::string(column);
  return all;
}

// Throws std::runtime_error if the file has other columns, as files of other versions do.
std::map<Index, std::vector<Row>> readScenes(const std::string& path) {
  std::map<Index, std::vector<Row>> scenes;
  std::ifstream file(path);
  bool is_first = true;
  for (std::string line; std::getline(file, line); is_first = false) {
    if (is_first && line != listColumns())
      throw std::runtime_error(path + ": found the columns '" + line + "'; accepted: '" + listColumns() +
                               "', or another folder than that of another version's scenes");
    Row row;
    std::istringstream cells(line);
    for (const char* column : kColumns) std::getline(cells, row.cells[column], ',');
    if (is_first || row.cells["sound"].empty()) continue;
    scenes[static_cast<Index>(row.number("seed"))].push_back(row);
  }
  return scenes;
}

// Results of a group of scenes.
struct Tally {
  int scenes = 0, covered_at_end = 0, covered_always = 0, looks = 0, looks_covered = 0;
  std::vector<double> ratio_at_end, ratios;  // estimate over true error
  // Of the looks: see the columns.
  std::vector<double> points_covered, points_ratios, largest_ratios;

  void add(const std::vector<Row>& rows) {
    bool always = true;
    for (const Row& row : rows) {
      const double error = row.number("true_error"), estimate = row.number("estimate");
      const bool covered = error <= estimate;
      always = always && covered;
      ++looks;
      looks_covered += covered;
      ratios.push_back(estimate / error);
      points_covered.push_back(row.number("points_covered"));
      points_ratios.push_back(row.number("points_ratio"));
      largest_ratios.push_back(row.number("largest_ratio"));
      if (&row == &rows.back()) {
        covered_at_end += covered;
        ratio_at_end.push_back(estimate / error);
      }
    }
    ++scenes;
    covered_always += always;
  }

  void report(const std::string& name, Report& report) const {
    if (scenes == 0) return;
    std::vector<std::string> cells{name,
                                   std::to_string(scenes),
                                   showPercent(covered_at_end / double(scenes)),
                                   showPercent(looks_covered / double(looks)),
                                   showPercent(covered_always / double(scenes)),
                                   show(findQuantile(ratio_at_end, 0.5))};
    for (double share : {0.05, 0.25, 0.5, 0.75, 0.95}) cells.push_back(show(findQuantile(ratios, share)));
    double sum = 0.0;
    for (const double covered : points_covered) sum += covered;
    cells.push_back(showPercent(sum / looks));
    for (const std::vector<double>* of : {&points_ratios, &largest_ratios}) cells.push_back(show(findQuantile(*of, 0.5)));
    report.add(cells);
  }
};

bool hasWord(const std::string& text, const std::string& word) {
  return (" " + text + " ").find(" " + word + " ") != std::string::npos;
}

}  // namespace

void runCalibrationSection(const Options& asked, Report& report) {
  Options options = asked;
  if (options.num_scenes == 0) {
    options.first_scene = kFirstScene;
    options.num_scenes = kNumScenes;
  }
  setNumThreads(1);
  // Scenes that the file contains are not run again, so that the run can be split.
  const std::string path = options.folder + (options.varied ? "/calibration_varied.csv" : "/calibration_scenes.csv");
  std::map<Index, std::vector<Row>> scenes = readScenes(path);
  {
    std::ofstream file(path, std::ios::app);
    if (file.tellp() == 0) file << listColumns() << "\n";
    for (Index seed = options.first_scene; seed < options.first_scene + options.num_scenes; ++seed) {
      if (scenes.count(seed)) continue;
      try {
        file << runScene(seed, options.varied) << std::flush;
      } catch (const InputError& problem) {
        std::fprintf(stderr, "scene %d: %s\n", seed, problem.what());  // e.g. a pin that holds none of a sparse cloud's points
      }
      if (!file) throw std::runtime_error("cannot write " + path);
    }
  }
  scenes = readScenes(path);

  std::map<std::string, Tally> groups;
  int num = 0, unsound = 0, chaotic = 0, chaotic_flagged = 0, chaotic_told = 0, regular_flagged = 0, regular_told = 0;
  std::vector<std::pair<std::string, double>> apart;
  std::vector<double> truth_moved;  // over the error, of each look of the scenes that are neither chaotic nor flagged
  for (const auto& scene : scenes) {
    if (scene.first < options.first_scene || scene.first >= options.first_scene + options.num_scenes) continue;
    const std::vector<Row>& rows = scene.second;
    ++num;
    if (rows.front().number("sound") == 0.0) {
      ++unsound;
      continue;
    }
    double growth = 0.0;
    bool flagged = false, told = false;
    for (const Row& row : rows) {
      told = told || row.number("may_buckle") != 0.0;
      growth = std::max(growth, row.number("twin_growth"));
      // Files of earlier versions have an infinite estimate there.
      flagged = flagged || std::isinf(row.number("estimate")) || row.number("unbounded") != 0.0;
    }
    const std::string& name = rows.front().cells.at("scene");
    (growth > kGrowth ? chaotic_told : regular_told) += told;
    if (!(growth > kGrowth) && flagged) groups["no bound, not chaotic"].add(rows);
    if (growth > kGrowth || flagged) {
      chaotic += growth > kGrowth;
      chaotic_flagged += growth > kGrowth && flagged;
      regular_flagged += !(growth > kGrowth) && flagged;
      const char* what = flagged ? ", flagged" : told ? ", may buckle" : ", NOT flagged";
      apart.emplace_back(std::to_string(scene.first) + " " + name + what, growth);
      if (growth > kGrowth && !flagged) groups["chaotic, not flagged"].add(rows);
      continue;
    }
    for (const Row& row : rows) {
      const double moved = row.number("truth_moved") / row.number("true_error");
      if (std::isfinite(moved)) truth_moved.push_back(moved);
    }
    groups["all"].add(rows);
    groups[hasWord(name, "static") ? "static" : hasWord(name, "implicit") ? "implicit" : "verlet"].add(rows);
    groups["shape: " + name.substr(0, name.find(' '))].add(rows);
    if (hasWord(name, "all")) groups["nothing simplified"].add(rows);
    if (told) groups["may buckle"].add(rows);
  }

  report.begin("calibration",
               "7. Error estimate against the error, scenes " + std::to_string(options.first_scene) + " to " +
                   std::to_string(options.first_scene + options.num_scenes - 1),
               {"scenes of", "number", "covered_at_end", "covered_looks", "covered_always", "median_at_end", "q05", "q25",
                "median", "q75", "q95", "points_covered", "points_median", "largest_median"});
  for (const auto& group : groups) group.second.report(group.first, report);
  report.end();
  report.note("covered: the true error is under the estimate; the columns up to q95: estimate over true error");
  report.note(
      "points_covered: mean share of the points whose own estimate (output.error) is above their error; points_median: median "
      "over "
      "looks of its median over the errors of the points; largest_median: the same of the estimate of the largest error");
  report.note(std::to_string(num) + " scenes, " + std::to_string(unsound) + " without a sound truth, " + std::to_string(chaotic) +
              " chaotic, of which " + std::to_string(chaotic_flagged) + " flagged; " + std::to_string(regular_flagged) +
              " others flagged; may_buckle: " + std::to_string(chaotic_told) + " chaotic, " + std::to_string(regular_told) +
              " others");
  if (truth_moved.empty()) {
    report.note("the truth is checked in every " + std::to_string(kSample) + "th scene: these have no look of one");
  } else {
    const auto counts = std::count_if(truth_moved.begin(), truth_moved.end(), [](double x) { return x > kIsTruth; });
    report.note("the truth in twice as many sub-steps, " + std::to_string(truth_moved.size()) + " looks of every " +
                std::to_string(kSample) + "th scene: it moves by " + show(findQuantile(truth_moved, 0.5)) +
                " of the error in the median, " + show(findQuantile(truth_moved, 0.95)) +
                " at the 95th percentile, and by more than " + show(kIsTruth) + " at " + std::to_string(counts) + " looks");
  }
  report.begin("calibration_chaotic", "Scenes counted apart, with the growth of a disturbance of the truth", {"scene", "growth"});
  for (const auto& scene : apart) report.add({scene.first, show(scene.second)});
  report.end();
}

}  // namespace deformable_surface::benchmark
