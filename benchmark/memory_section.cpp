// Part 6: memory per point, stage by stage and for the whole simulation, to show that it is linear in the points.
#include "deformable_surface/base/parallel.h"
#include "deformable_surface/simulation/simulation.h"
#include "heap_counter.h"
#include "sections.h"
#include "wavy_sheet.h"

namespace deformable_surface::benchmark {

void runMemorySection(const Options& options, Report& report) {
  report.begin("memory", "6. Bytes of memory per point",
               {"what", "points", "kept_per_point", "peak_per_point", "resident_growth_per_point"});
  std::vector<Index> sizes{10000, 30000, 100000};
  if (options.large) sizes.insert(sizes.end(), {300000, 1000000});
  setNumThreads(0);
  for (Index n : sizes) {
    Preparation p;
    p.cloud = makeWavySheet(n, PointOrder::kScan);
    p.target = countKept(p.cloud.size());
    const auto count = [&](const std::string& name, const std::function<void()>& call) {
      const std::int64_t resident = residentBytes();
      HeapCounter heap;
      call();
      heap.stop();
      const double per_point = 1.0 / p.cloud.size();
      report.add({name, std::to_string(p.cloud.size()), show(heap.liveBytes() * per_point), show(heap.peakBytes() * per_point),
                  show((residentBytes() - resident) * per_point)});
    };
    for (const Stage& stage : listStages()) count(stage.name, [&] { stage.run(p); });

    simulation::SceneParams scene;
    scene.simplification.target_points = p.target;
    std::unique_ptr<simulation::Simulation> built;
    count("all (Simulation)", [&] { built = std::make_unique<simulation::Simulation>(scene, p.cloud); });
    count("first step", [&] { built->step(); });
    count("first surface with normals", [&] { built->surface(true); });
  }
  report.end();
  report.note(
      "kept and peak are counted at malloc; resident is what the system sees, in pages, after the heap gave back the rest");
}

}  // namespace deformable_surface::benchmark
