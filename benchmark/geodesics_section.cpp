// Geodesic neighbourhoods: how well they separate parts, against the width of the gap, for the published exponent and without a
// parameter; and their cost in a set-up.
#include "../test/support/gaps.h"
#include "deformable_surface/base/parallel.h"
#include "deformable_surface/cloud/geodesics.h"
#include "deformable_surface/cloud/kd_tree.h"
#include "deformable_surface/cloud/normals.h"
#include "deformable_surface/simulation/rest_surface.h"
#include "sections.h"
#include "wavy_sheet.h"

#include <algorithm>
#include <cmath>

namespace deformable_surface::benchmark {
namespace {

constexpr double kRadius = 3.0;    // spacings: pairs of bars and bodies
constexpr Index kListed = 32;      // neighbours: sheets, as in a set-up
constexpr unsigned kNumSeeds = 2;  // jittered clouds per row

struct Form {
  const char* name;
  OrAuto<double> geodesic_exponent;
};
const Form kForms[] = {{"auto", {}}, {"4", 4.0}, {"8", 8.0}, {"15", 15.0}, {"25", 25.0}};

Lists findWithin(const Points& points, double radius) {
  const cloud::KdTree tree(points);
  std::vector<cloud::Neighbor> found;
  Lists lists;
  for (Index i = 0; i < tree.size(); ++i) {
    tree.withinRadius(points[i], radius, found);
    for (const cloud::Neighbor& other : found)
      if (other.index != i) lists.items.push_back(other.index);
    lists.offsets.push_back(static_cast<Index>(lists.items.size()));
  }
  return lists;
}

template <int Layers>
test::Gapped makeBars(double gap, double jitter, unsigned seed) {
  return test::makeTwoBars(gap, jitter, Layers, seed);
}
template <int Sheets>
test::Gapped makeSheets(double gap, double jitter, unsigned seed) {
  return test::makeStack(Sheets, gap, jitter, false, seed);
}
test::Gapped makeBarsWithHoles(double gap, double jitter, unsigned seed) {
  return test::dropPoints(test::makeTwoBars(gap, jitter, 1, seed), 0.1, seed);
}
test::Gapped makeSheetsWithHoles(double gap, double jitter, unsigned seed) {
  return test::dropPoints(test::makeStack(2, gap, jitter, false, seed), 0.1, seed);
}
test::Gapped makeBody(double gap, double jitter, unsigned seed) { return test::makeStack(2, gap, jitter, true, seed); }

struct Kind {
  const char* name;
  test::Gapped (*make)(double gap, double jitter, unsigned seed);
  bool is_wide;  // gaps beside the spacing, else below it
  bool with_normals, oriented;
};
const Kind kKinds[] = {{"bars", makeBars<1>, true, false, false},
                       {"bars with normals", makeBars<1>, true, true, false},
                       {"bars, a tenth missing", makeBarsWithHoles, true, false, false},
                       {"thick bars", makeBars<3>, true, false, false},
                       {"two sheets", makeSheets<2>, false, true, false},
                       {"two sheets, a tenth missing", makeSheetsWithHoles, false, true, false},
                       {"four sheets", makeSheets<4>, false, true, false},
                       {"thin body", makeBody, false, true, true},
                       {"fold", test::makeFold, false, true, false}};

void sweepGaps(Report& report) {
  report.begin("geodesics_gaps", "Coupling left within a part (should be 1) and across the gap (should be 0)",
               {"cloud", "jitter", "gap", "geodesic_exponent", "within", "across"});
  const double gaps_of_sheets[] = {0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.75, 1.0};
  const double gaps_of_bars[] = {1.0, 1.1, 1.2, 1.3, 1.4, 1.5, 1.6, 1.75, 2.0, 2.5};
  for (const Kind& kind : kKinds) {
    const auto sweep = [&](const auto& gaps) {
      for (double jitter : {0.0, 0.1, 0.2, 0.3}) {
        for (double gap : gaps) {
          for (const Form& form : kForms) {
            // The exponent takes no normals.
            if (!form.geodesic_exponent.is_auto && kind.with_normals) continue;
            test::Coupling mean;
            const unsigned num_seeds = jitter > 0.0 ? kNumSeeds : 1;
            for (unsigned seed = 1; seed <= num_seeds; ++seed) {
              const test::Gapped cloud = kind.make(gap, jitter, seed);
              const Lists listed = cloud::nearestNeighbors(cloud.positions, kListed);
              const Lists links = kind.is_wide ? findWithin(cloud.positions, kRadius) : listed;
              cloud::SurfaceSides sides;
              if (kind.oriented) {
                sides = {cloud.normals, true};
              } else if (kind.with_normals) {
                sides = {cloud::estimateNormals(cloud.positions, listed), false};
              }
              const cloud::GeodesicGraph graph = cloud::buildGeodesicGraph(cloud.positions, sides, links, form.geodesic_exponent);
              const test::Coupling one =
                  test::measureCoupling(cloud, links, cloud::geodesicWeights(graph, cloud.positions, links));
              mean.within += one.within / num_seeds;
              mean.across += one.across / num_seeds;
            }
            report.add({kind.name, show(jitter), show(gap), form.name, show(mean.within), show(mean.across)});
          }
        }
      }
    };
    if (kind.is_wide) {
      sweep(gaps_of_bars);
    } else {
      sweep(gaps_of_sheets);
    }
  }
  report.end();
  report.note(
      "lengths in spacings; kernel-weighted shares over pairs within three spacings (bars) or the 32 nearest (others), mean "
      "of two jittered clouds; normals estimated from the positions but for the thin body, whose sides are given");
}

void measureTimes(const Options& options, Report& report) {
  report.begin("geodesics", "Time of geodesic neighbourhoods on the wavy sheet, 50 points to one simulation point",
               {"points", "threads", "what", "cpu_ms", "wall_ms", "ns_per_point", "share_of_setup_%", "lists_changed"});
  std::vector<Index> sizes{10000, 30000, 100000};
  if (options.large) sizes.insert(sizes.end(), {300000, 1000000});
  double sum_x = 0.0, sum_y = 0.0, sum_xx = 0.0, sum_xy = 0.0;
  for (Index n : sizes) {
    for (int threads : {1, 2}) {
      setNumThreads(threads);
      const cloud::PointCloud scan = makeWavySheet(n, PointOrder::kScan);
      const Lists listed = cloud::nearestNeighbors(scan.positions, kListed);
      const cloud::SurfaceSides sides{cloud::estimateNormals(scan.positions, listed), false};
      cloud::GeodesicGraph graph;
      cloud::GeodesicNeighbors kept;
      const Timing building =
          measure([&] { graph = cloud::buildGeodesicGraph(scan.positions, sides, listed, {}); }, options.budget, 2);
      const Timing keeping =
          measure([&] { kept = cloud::keepGeodesicNeighbors(graph, scan.positions, sides, listed); }, options.budget, 2);
      Index changed = 0;
      for (Index i = 0; i < listed.size(); ++i) {
        changed += !std::equal(listed.begin(i), listed.end(i), kept.lists.begin(i), kept.lists.end(i));
      }
      // Set-ups in turn, so that other work on the machine slows both.
      double euclidean = cloud::kNoLimit, geodesic = cloud::kNoLimit;
      for (int repetition = 0; repetition < (n > 100000 ? 1 : 3); ++repetition) {
        for (const bool is_euclidean : {true, false}) {
          simulation::SceneParams scene;
          scene.simplification.target_points = countKept(n);
          if (is_euclidean) scene.neighbors.geodesic_exponent = 1.0;
          const double before = processorSeconds();
          simulation::buildRestSurface(scene, scan);
          double& best = is_euclidean ? euclidean : geodesic;
          best = std::min(best, processorSeconds() - before);
        }
      }
      const auto addRow = [&](const std::string& what, double cpu, double wall) {
        report.add({std::to_string(scan.size()), std::to_string(threads), what, showMilliseconds(cpu), showMilliseconds(wall),
                    show(1e9 * cpu / n), showPercent(cpu / geodesic), std::to_string(changed)});
      };
      addRow("graph", building.cpu, building.wall);
      addRow("lists", keeping.cpu, keeping.wall);
      addRow("set-up in excess of the Euclidean one", geodesic - euclidean, 0.0);
      addRow("set-up", geodesic, 0.0);
      if (threads > 1) continue;
      const double x = std::log(static_cast<double>(n)), y = std::log(building.cpu + keeping.cpu);
      sum_x += x;
      sum_y += y;
      sum_xx += x * x;
      sum_xy += x * y;
    }
  }
  setNumThreads(0);
  report.end();
  const double count = static_cast<double>(sizes.size());
  report.note("exponent of graph and lists over the points, least squares: " +
              show((count * sum_xy - sum_x * sum_y) / (count * sum_xx - sum_x * sum_x)));
  report.note("wall 0: not measured; set-ups are least processor times of three runs in turn (one above 100000 points)");
}

}  // namespace

void runGeodesicsSection(const Options& options, Report& report) {
  sweepGaps(report);
  measureTimes(options, report);
}

}  // namespace deformable_surface::benchmark
