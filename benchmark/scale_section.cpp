// Part 13: growth of set-up and a frame with the points of the cloud, up to ten millions, with the limits of the machine in the
// same run. A part of its own, because here only sizes change. Growth of models with the simulation points: scale_models.cpp.
#include "deformable_surface/base/parallel.h"
#include "deformable_surface/base/timer.h"
#include "deformable_surface/simulation/simulation.h"
#include "heap_counter.h"
#include "machine_limits.h"
#include "scale_models.h"
#include "scale_scans.h"
#include "sections.h"
#include "wavy_sheet.h"

#include <algorithm>
#include <cmath>
#include <map>

namespace deformable_surface::benchmark {
namespace {

using simulation::Simulation;

constexpr Index kSimulationPoints = 2000;
constexpr Index kFewestPerSimulationPoint = 5;  // of small clouds
constexpr Index kFirstFitted = 10000;           // points: below, what a stage costs once is a part of its time
constexpr int kFrames = 12;
// Of a point with the usual eight neighbours, counted in src/transfer/transfer.cpp and DeformedSurface::expand().
constexpr double kFrameOperations = 218.0;

struct Growth {
  std::vector<double> sizes, seconds;
};

class Scaling {
 public:
  Scaling(const Options& options, Report& report) : options_(options), report_(report) {}

  std::vector<CountedStage> run(const std::vector<Index>& sizes) {
    report_.begin(
        "scale_setup",
        "13a. Set-up of a wavy sheet for " + std::to_string(kSimulationPoints) + " simulation points (a fifth of smaller clouds)",
        {"stage", "points", "threads", "wall_ms", "cpu_ms", "cores", "cpu_ns_per_point", "kept_bytes_per_point",
         "peak_bytes_per_point", "runs", "error", "error_is"});
    for (const Index n : sizes) measureSize(n);
    report_.end();
    report_.note("kept and peak: of the heap, beside what was there before the stage, in its first run");
    reportFrames();
    reportExponents();
    return std::move(counted_);
  }

 private:
  void measureSize(Index n) {
    setNumThreads(0);
    const cloud::PointCloud sheet = makeWavySheet(n, PointOrder::kScan);
    const Index target = std::min(kSimulationPoints, sheet.size() / kFewestPerSimulationPoint);
    {
      Preparation p;
      p.cloud = sheet;
      p.target = target;
      for (const Stage& stage : listStages())
        addRow(
            stage.name, sheet.size(), [&] { stage.run(p); }, [&] { return stage.error(p); }, stage.error_name);
    }
    simulation::SceneParams scene;
    scene.simplification.target_points = target;
    const std::int64_t resident = residentBytes();
    std::unique_ptr<Simulation> built;
    const auto build = [&] {
      built.reset();
      built = std::make_unique<Simulation>(scene, sheet);
    };
    const auto massError = [&] {
      double mass = 0.0;
      for (const double m : built->model().masses()) mass += m;
      return std::abs(mass / (scene.material.arealDensity() * findWavyArea()) - 1.0);
    };
    addRow("all (Simulation)", sheet.size(), build, massError, "relative error of mass");
    measureFrames(sheet, *built, resident);
  }

  void addRow(const std::string& name, Index points, const std::function<void()>& body, const std::function<double()>& error,
              const std::string& error_name) {
    Timing timing;
    const double cpu_before = processorSeconds();
    const Timer timer;
    HeapCounter heap;
    body();
    heap.stop();
    timing.wall = timer.seconds();
    timing.cpu = processorSeconds() - cpu_before;
    timing.repetitions = 1;
    // Long stages are not repeated: the content of the caches at their start does not matter.
    if (timing.wall < options_.budget) timing = measure(body, options_.budget, 2);
    report_.add({name, std::to_string(points), std::to_string(numThreads()), showMilliseconds(timing.wall),
                 showMilliseconds(timing.cpu), show(timing.cpu / timing.wall), show(1e9 * timing.cpu / points),
                 show(static_cast<double>(heap.liveBytes()) / points), show(static_cast<double>(heap.peakBytes()) / points),
                 std::to_string(timing.repetitions), show(error()), error_name});
    if (growths_.find(name) == growths_.end()) names_.push_back(name);
    growths_[name].sizes.push_back(points);
    growths_[name].seconds.push_back(timing.cpu);
  }

  // All of the surface between two states, one the other turned; giving a state is not timed.
  void measureFrames(const cloud::PointCloud& sheet, Simulation& simulation, std::int64_t resident) {
    const double points = sheet.size();
    const Mat3 rotation = Eigen::AngleAxisd(1.1, Vec3(0.3, -0.5, 0.8).normalized()).toRotationMatrix();
    model::State at_rest = simulation.state(), turned = at_rest;
    for (Vec3& p : turned.positions) p = rotation * p;
    simulation.setState(turned);
    const simulation::Surface& surface = simulation.surface(true);
    double error = 0.0;
    for (std::size_t i = 0; i < sheet.positions.size(); ++i)
      error = std::max(error, (surface.positions[i] - rotation * sheet.positions[i]).norm());
    const double growth = static_cast<double>(residentBytes() - resident) / points;
    // The operator, rest positions, results; a line that is written is read first, as in the triad.
    const double bytes =
        static_cast<double>(transfer::Transfer({Vec3::Zero()}, {Vec3::UnitZ()}, {Vec3::Zero()}, {1}, {}).bytesPerPoint()) +
        2.0 * (sizeof(Vec3) + sizeof(Eigen::Vector3f) + sizeof(float)) + sizeof(Index);
    for (const int threads : {1, 0}) {
      setNumThreads(threads);
      std::vector<double> walls, cpus;
      for (int k = 0; k < kFrames; ++k) {
        simulation.setState(k % 2 == 0 ? at_rest : turned);
        const double cpu_before = processorSeconds();
        const Timer timer;
        simulation.surface(true);
        walls.push_back(timer.seconds());
        cpus.push_back(processorSeconds() - cpu_before);
      }
      const double cpu = *std::min_element(cpus.begin(), cpus.end()), least = *std::min_element(walls.begin(), walls.end());
      const double seconds = numThreads() == 1 ? cpu : least;  // as the triad
      if (threads == 1) counted_.push_back({"frame", sheet.size(), kFrameOperations * points, bytes * points, seconds});
      const double triad = measureTriad(bytes * points, options_.budget);
      frames_.push_back({std::to_string(sheet.size()), std::to_string(numThreads()),
                         showMilliseconds(findQuartiles(walls).median), showMilliseconds(least), showMilliseconds(cpu),
                         show(bytes), show(1e-9 * bytes * points / seconds), show(1e-9 * triad),
                         showPercent(bytes * points / seconds / triad), show(error), show(growth)});
    }
  }

  void reportFrames() {
    report_.begin("scale_frame", "13b. A frame: transfer and normals of all points in the input's order",
                  {"points", "threads", "wall_ms", "least_wall_ms", "cpu_ms", "bytes_per_point", "GB_per_s", "triad_GB_per_s",
                   "share_%", "rotation_error_m", "resident_bytes_per_point"});
    for (const std::vector<std::string>& row : frames_) report_.add(row);
    report_.end();
    report_.note(
        "bytes that cannot be avoided: operator, rest positions, results; written ones count twice, in the triad on as many "
        "bytes, too");
    report_.note("bytes per second: by the least time, of the processor on one thread, of the clock on more");
    report_.note("resident: growth of the process by set-up and first frames, the input apart");
  }

  void reportExponents() {
    report_.begin("scale_exponents",
                  "13c. Processor time of set-up over the points, from " + std::to_string(kFirstFitted) + " points on",
                  {"stage", "exponent", "of_n_log_n", "between_the_last_two"});
    for (const std::string& name : names_) {
      Growth fitted;
      std::vector<double> sorting;
      for (std::size_t k = 0; k < growths_[name].sizes.size(); ++k) {
        const double n = growths_[name].sizes[k];
        if (n < 0.9 * kFirstFitted) continue;
        fitted.sizes.push_back(n);
        fitted.seconds.push_back(growths_[name].seconds[k]);
        sorting.push_back(n * std::log(n));
      }
      const std::size_t n = fitted.sizes.size();
      if (n < 2) continue;
      const double last =
          std::log(fitted.seconds[n - 1] / fitted.seconds[n - 2]) / std::log(fitted.sizes[n - 1] / fitted.sizes[n - 2]);
      report_.add({name, show(fitExponent(fitted.sizes, fitted.seconds)), show(fitExponent(fitted.sizes, sorting)), show(last)});
    }
    report_.end();
  }

  const Options& options_;
  Report& report_;
  std::map<std::string, Growth> growths_;
  std::vector<std::string> names_;  // of stages, in their order
  std::vector<std::vector<std::string>> frames_;
  std::vector<CountedStage> counted_;
};

}  // namespace

void runScaleSection(const Options& options, Report& report) {
  const MachineLimits limits = measureMachine(options, report);
  std::vector<Index> sizes{1000, 10000, 100000, 1000000};
  if (options.large) sizes.push_back(10000000);
  std::vector<CountedStage> counted = Scaling(options, report).run(sizes);
  measureScans(options, report);
  measureModels(options, report, counted);
  reportRoofline(counted, limits, report);
  setNumThreads(0);
}

}  // namespace deformable_surface::benchmark
