// Part 5: heap calls of a step after the first. The target is none.
#include "deformable_surface/base/parallel.h"
#include "heap_counter.h"
#include "sections.h"
#include "swinging_sheet.h"
#include "wavy_sheet.h"

#include <algorithm>

namespace deformable_surface::benchmark {
namespace {

using simulation::Simulation;
using solve::IntegratorType;

constexpr int kSteps = 20;

struct Named {
  const char* name;
  IntegratorType type;
  double time_step;  // s: long enough for the sheet to swing, except for the unstable scheme
};
constexpr Named kIntegrators[] = {{"auto", IntegratorType::kAuto, 0.01},
                                  {"verlet", IntegratorType::kVerlet, 0.01},
                                  {"symplectic_euler", IntegratorType::kSymplecticEuler, 0.01},
                                  {"explicit_euler", IntegratorType::kExplicitEuler, 1e-5},
                                  {"implicit", IntegratorType::kImplicit, 0.01},
                                  {"static", IntegratorType::kStatic, 0.01}};

}  // namespace

void runAllocationsSection(const Options&, Report& report) {
  report.begin("allocations", "5. Heap allocations after the first step",
               {"call", "points", "simulation_points", "threads", "calls", "allocations_per_call", "most_in_one_call",
                "calls_without_any", "hash"});
  const auto countCalls = [&](const std::string& name, Simulation& sheet, const std::function<void()>& prepare,
                              const std::function<void()>& call) {
    prepare();
    call();
    std::int64_t sum = 0, most = 0;
    int without = 0;
    for (int i = 0; i < kSteps; ++i) {
      prepare();
      HeapCounter heap;
      call();
      heap.stop();
      sum += heap.allocations();
      most = std::max(most, heap.allocations());
      if (heap.allocations() == 0) ++without;
    }
    report.add({name, std::to_string(sheet.input().size()), std::to_string(sheet.state().size()), std::to_string(numThreads()),
                std::to_string(kSteps), show(static_cast<double>(sum) / kSteps), std::to_string(most), std::to_string(without),
                showHash(sheet.stateHash())});
  };
  const auto nothing = [] {};

  for (const Named& integrator : kIntegrators) {
    simulation::SceneParams scene = makeSwingingScene(integrator.type, integrator.time_step);
    scene.accuracy.estimate = true;  // its copies take part
    setNumThreads(1);
    Simulation sheet(scene, makeSwingingSheet(324));
    countCalls(std::string("step, ") + integrator.name, sheet, nothing, [&] { sheet.step(); });
  }
  // Large enough to be shared among threads.
  setNumThreads(2);
  Simulation large(makeSwingingScene(IntegratorType::kVerlet, 1e-4), makeSwingingSheet(20000));
  countCalls("step, verlet", large, nothing, [&] { large.step(); });
  for (int threads : {1, 2}) {
    setNumThreads(threads);
    simulation::SceneParams scene;
    scene.simplification.target_points = 300;
    Simulation sheet(scene, makeWavySheet(20000, PointOrder::kScan));
    countCalls(
        "surface", sheet, [&] { sheet.step(); }, [&] { sheet.surface(false); });
    countCalls(
        "surface with normals", sheet, [&] { sheet.step(); }, [&] { sheet.surface(true); });
    countCalls(
        "statistics", sheet, [&] { sheet.step(); }, [&] { sheet.statistics(); });
  }
  report.end();
  report.note("target: none; a step whose matrix has blocks it never had before asks for memory");
  report.note("counted at malloc, so what Eigen and the standard library take is in it");
}

}  // namespace deformable_surface::benchmark
