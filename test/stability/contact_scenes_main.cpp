// Runs the scenes in which a surface touches itself, and prints a table: crossings, contacts, energy, threads, time. Not a gtest:
// minutes to hours (scripts/contact_scenes).
#include "deformable_surface/simulation/simulation.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <limits>
#include <string>

#include "../../src/simulation/self_contact_load.h"
#include "../support/contact_scenes.h"
#include "../support/crossings.h"
#include "../support/whole_triangles.h"

namespace deformable_surface::test {
namespace {

using simulation::Simulation;

struct Row {
  Index points = 0, steps = 0, most_touching = 0, most_stopped = 0;
  Index crossed_steps = 0, most_crossings = 0;                      // by the oracle, after each step
  Index skipped_crossings = 0;                                      // at rest: not counted
  double least_distance = std::numeric_limits<double>::infinity();  // m
  double made = 0.0;     // largest excess of energy, of the largest sum of kinetic and elastic energy
  double seconds = 0.0;  // of processor time, steps alone
  std::uint64_t hash = 0;
  std::string refused;
};

Row run(const ContactScene& scene, bool looks) {
  Row row;
  Simulation s(scene.params, scene.cloud);
  row.points = s.state().size();
  const simulation::ContactSkin skin(s.state().positions, trianglesOf(s.model()));
  const auto at_rest = findCrossings(s.state().positions, skin.triangles);
  row.skipped_crossings = static_cast<Index>(at_rest.size());
  const Index steps = std::lround(scene.params.duration / scene.params.integrator.time_step);
  double stored = 0.0;  // J
  for (row.steps = 0; row.steps < steps; ++row.steps) {
    const std::clock_t start = std::clock();
    const simulation::StepOutcome outcome = s.step();
    row.seconds += static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
    if (!outcome.ok) {
      row.refused = outcome.problem;
      break;
    }
    if (!looks) continue;
    Index crossings = 0;
    for (const auto& pair : findCrossings(s.state().positions, listWhole(skin, s.model())))
      crossings += !std::binary_search(at_rest.begin(), at_rest.end(), pair);
    row.crossed_steps += crossings > 0;
    row.most_crossings = std::max(row.most_crossings, crossings);
    const simulation::Statistics& now = s.statistics();
    row.most_touching = std::max(row.most_touching, static_cast<Index>(now.self_contacts));
    row.most_stopped = std::max(row.most_stopped, static_cast<Index>(now.stopped_points));
    row.least_distance = std::min(row.least_distance, now.self_distance);
    stored = std::max(stored, now.kinetic_energy + now.elastic_energy);
    row.made = std::max(row.made, s.energyExcess());
  }
  row.made /= stored > 0.0 ? stored : 1.0;
  row.hash = s.stateHash();
  return row;
}

int main(int argc, char** argv) {
  if (argc < 4) {
    std::fprintf(stderr,
                 "contact_scenes: accepted: SEEDS POINTS_ACROSS METHOD [SCENE ...]; POINTS_ACROSS 0: drawn; METHOD: verlet, "
                 "implicit\n");
    return 2;
  }
  const int seeds = std::atoi(argv[1]);
  const Index across = std::atoi(argv[2]);
  const std::string method = argv[3];
  if (seeds < 1 || across < 0 || (method != "verlet" && method != "implicit")) {
    std::fprintf(stderr, "contact_scenes: found %s %s %s; accepted: 1 or more seeds, 0 or more points, verlet or implicit\n",
                 argv[1], argv[2], argv[3]);
    return 2;
  }
  std::printf(
      "| scene | seed | points | steps | steps with crossings | without contact | most pairs | least distance / thickness | "
      "most stopped | energy in excess | same bits | time ratio |\n");
  std::printf("| --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- |\n");
  bool is_right = true;
  for (const auto& [name, make] : listContactScenes()) {
    if (argc > 4 && std::find(argv + 4, argv + argc, name) == argv + argc) continue;
    for (int seed = 1; seed <= seeds; ++seed) {
      ContactSceneMaker maker(seed, across);
      ContactScene scene = make(maker);
      scene.params.contact.friction = seed % 2 == 0 ? 0.3 : 0.0;
      scene.params.integrator.type = method == "verlet" ? solve::IntegratorType::kVerlet : solve::IntegratorType::kImplicit;
      scene.params.threads = 1;
      const Row row = run(scene, true);
      scene.params.threads = 2;
      const Row two = run(scene, false);
      scene.params.threads = 1;
      scene.params.contact.self = false;
      const Row without = run(scene, true);
      const bool is_same = row.hash == two.hash;
      is_right = is_right && row.crossed_steps == 0 && is_same && row.refused.empty();
      std::printf("| %s | %d | %d | %d | %d | %d | %d | %.2f | %d | %.1e | %s | %.2f |%s%s\n", name.c_str(), seed, row.points,
                  row.steps, row.crossed_steps, without.crossed_steps, row.most_touching,
                  row.least_distance / scene.params.material.thickness, row.most_stopped, row.made, is_same ? "yes" : "NO",
                  row.seconds / without.seconds, row.refused.empty() ? "" : " refused: ", row.refused.c_str());
      std::fflush(stdout);
    }
  }
  return is_right ? 0 : 1;
}

}  // namespace
}  // namespace deformable_surface::test

int main(int argc, char** argv) { return deformable_surface::test::main(argc, argv); }
