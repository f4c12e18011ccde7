// Part "camera": frames of a depth camera with known truth, at several distances and noises: links across true gaps, lost true
// links, and the effect on pieces, normals, simulation points, set-up and motion. And real frames, without truth.
#include "camera_measures.h"

#include "deformable_surface/base/error.h"
#include "scale_scans.h"
#include "sections.h"

#include <algorithm>
#include <optional>

namespace deformable_surface::benchmark {
namespace {

struct Rule {
  const char* name;
  Neighborhoods how;
};
// Neighbours in space and along the surface at the measured points, and along the surface behind the noise.
const Rule kInSpace{"1", {1.0, 0.0}}, kWhereSeen{"auto, noise 0", {{}, 0.0}}, kBehindNoise{"auto", {{}, {}}};

std::vector<Rule> chooseRules(bool are_many_frames) {
  if (are_many_frames) return {kInSpace, kBehindNoise};  // the other takes as long as both
  return {kInSpace, kWhereSeen, kBehindNoise};
}
constexpr const char* kRealFrames[] = {"pcl_scans/five_people.pcd", "pcl_data_kinect/person.pcd"};

std::string showSizes(const std::vector<Index>& sizes) {
  constexpr std::size_t kMost = 4;
  std::string text;
  for (std::size_t k = 0; k < std::min(kMost, sizes.size()); ++k) text += (k > 0 ? " " : "") + std::to_string(sizes[k]);
  return text + (sizes.size() > kMost ? " ..." : "");
}

// The notes of the build, one per line, for a table of their own.
using Sayings = std::vector<std::vector<std::string>>;

void collect(const std::vector<std::string>& name, const SetUp& made, Sayings& sayings) {
  const auto add = [&](const char* kind, const std::vector<std::string>& lines) {
    for (const std::string& line : lines) {
      std::vector<std::string> row = name;
      row.insert(row.end(), {kind, line});
      sayings.push_back(std::move(row));
    }
  };
  add("warning", made.rest.warnings);
  add("note", made.rest.notes);
}

test::DepthCamera makeCamera(double noise, bool is_plain) {
  test::DepthCamera camera;
  camera.noise = noise;
  camera.quantum = noise > 0.0 ? 0.125 : 0.0;
  if (!is_plain) {
    camera.smoothing = 1;
    camera.flying = 0.5;
  }
  return camera;
}

void measureScene(const test::CameraScene& scene, double noise, bool is_plain, const std::vector<Rule>& rules, Report& report,
                  Sayings& sayings) {
  const test::CameraFrame frame = test::takeFrame(test::aimAt(scene, makeCamera(noise, is_plain)), scene.sheets);
  const PullTest pull(scene, frame);
  const std::vector<Index> true_pieces = test::findTruePieces(frame, kPiecePoints);
  double across_before = 0.0;  // of the first rule, in space
  for (const Rule& rule : rules) {
    const SetUp made = setUp(frame.cloud, rule.how);
    const PairCounts pairs = countPairs(frame, made);
    if (&rule == &rules.front()) across_before = pairs.across;
    const std::string error = pull.compare(rule.how);
    const std::vector<std::string> name{scene.name, is_plain ? "white" : "smooth, flying", show(scene.distance), show(noise),
                                        rule.name};
    std::vector<std::string> row = name;
    row.insert(row.end(), {show(1e3 * frame.camera.depthNoise(scene.distance)), std::to_string(made.rest.dense.positions.size()),
                           std::to_string(pairs.across), across_before > 0.0 ? show(100.0 * pairs.across / across_before) : "-",
                           show(100.0 * pairs.refused / pairs.candidates), show(100.0 * pairs.missed / pairs.nearest),
                           std::to_string(true_pieces.size()), std::to_string(made.pieces.size()), showSizes(true_pieces),
                           showSizes(made.pieces), std::to_string(made.parts), show(findNormalError(frame, made)),
                           std::to_string(made.corners), std::to_string(made.numSimulated()), show(made.cpu), error});
    report.add(row);
    collect(name, made, sayings);
  }
}

void measureRealFrames(const std::vector<Rule>& rules, Report& report, Sayings& sayings) {
  report.begin("camera_real", "Real frames",
               {"frame", "rule", "points", "pieces", "sizes", "parts", "corners", "simulated", "cpu_s"});
  for (const char* name : kRealFrames) {
    const std::optional<cloud::PointCloud> scan = readScan(name);
    for (const Rule& rule : rules) {
      if (!scan) continue;
      const SetUp made = setUp(*scan, rule.how);
      report.add({name, rule.name, std::to_string(made.rest.dense.positions.size()), std::to_string(made.pieces.size()),
                  showSizes(made.pieces), std::to_string(made.parts), std::to_string(made.corners),
                  std::to_string(made.numSimulated()), show(made.cpu)});
      collect({name, "", "", "", rule.name}, made, sayings);
    }
  }
  report.end();
  report.note(kScansAreRead);
}

}  // namespace

void runCameraSection(const Options& options, Report& report) {
  const std::vector<double> distances = options.large ? std::vector<double>{0.6, 1.0, 2.0} : std::vector<double>{1.0};
  const std::vector<double> noises = options.large ? std::vector<double>{0.0, 0.05, 0.1, 0.2} : std::vector<double>{0.1};
  Sayings sayings;
  report.begin("camera", "Frames of a depth camera against their truth, " + std::to_string(kTargetPoints) + " points asked for",
               {"scene",  "noise",    "m",           "px",       "rule",        "sigma_mm", "points",
                "across", "across_%", "lost_%",      "missed_%", "true_pieces", "pieces",   "true_sizes",
                "sizes",  "parts",    "normals_deg", "corners",  "simulated",   "cpu_s",    "motion_%"});
  for (const bool is_plain : {true, false})
    for (const double distance : distances)
      for (const double noise : noises)
        for (const test::CameraScene& scene : test::makeCameraScenes(distance))
          if (scene.name.rfind(options.scene, 0) == 0 && (is_plain || noise > 0.0))
            measureScene(scene, noise, is_plain, chooseRules(options.large), report, sayings);
  report.end();
  report.note(
      "across: entries of the lists that lead across a gap of the true surface, per cent of those of rule 1; lost: per cent of "
      "the true ones among the nearest where the rule looks for them; missed: of those to the eight pixels truly nearest. In "
      "frames above 100,000 points both are of every second pixel of every second row, and of the one pair of each other pixel "
      "with the pixel that it follows");
  report.note("pieces of at least " + std::to_string(kPiecePoints) +
              " points; parts: of the simulation points; motion: rms of the difference to the noise-free pixels, per cent of the "
              "largest motion");
  if (options.scene.empty()) measureRealFrames(chooseRules(options.large), report, sayings);
  report.begin("camera_notes", "What the builds said", {"scene", "noise", "m", "px", "rule", "kind", "said"});
  for (const std::vector<std::string>& row : sayings) report.add(row);
  report.end();
}

}  // namespace deformable_surface::benchmark
