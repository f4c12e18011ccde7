// The benchmark: describes the machine, then runs every part with its table. The options are those of scripts/benchmark.
#include "sections.h"

#include "deformable_surface/base/parallel.h"
#include "deformable_surface/base/timer.h"

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <fstream>

namespace deformable_surface::benchmark {
namespace {

struct Part {
  const char* name;
  void (*run)(const Options&, Report&);
  bool on_demand = false;  // takes minutes: only if named
};
constexpr Part kParts[] = {{"setup", runSetupSection},
                           {"table_1", runTable1Section},
                           {"transfer", runTransferSection},
                           {"integrators", runIntegratorsSection},
                           {"explicit", runExplicitSection},
                           {"allocations", runAllocationsSection},
                           {"memory", runMemorySection},
                           {"factorization", runFactorizationSection},
                           {"particles", runParticlesSection},
                           {"solids", runSolidsSection, true},
                           {"activity", runActivitySection, true},
                           {"scale", runScaleSection, true},
                           {"peers", runPeersSection, true},
                           {"targets", runTargetsSection, true},
                           {"geodesics", runGeodesicsSection, true},
                           {"camera", runCameraSection, true},
                           {"growth", runGrowthSection, true},
                           {"accuracy", runAccuracySection, true},
                           {"simplification", runSimplificationSection, true},
                           {"statics", runStaticsSection, true},
                           {"physics", runPhysicsSection, true},
                           {"calibration", runCalibrationSection, true},
                           {"stability", runStabilitySection, true}};

const Part* findPart(const std::string& name) {
  const Part* part = std::find_if(std::begin(kParts), std::end(kParts), [&](const Part& p) { return name == p.name; });
  return part == std::end(kParts) ? nullptr : part;
}

std::string listParts() {
  std::string names;
  for (const Part& part : kParts) names += (names.empty() ? "" : ", ") + std::string(part.name);
  return names;
}

std::string findProcessor() {
  std::ifstream file("/proc/cpuinfo");
  for (std::string line; std::getline(file, line);)
    if (line.rfind("model name", 0) == 0) return line.substr(line.find(':') + 2);
  return "unknown";
}

void printHeader(const std::string& commit) {
  double load[3] = {0.0, 0.0, 0.0};
  getloadavg(load, 3);
  std::printf("machine   %s, %d cores, load %.1f %.1f %.1f\n", findProcessor().c_str(), numThreads(), load[0], load[1], load[2]);
  std::printf("compiler  g++ %s, %s\n", __VERSION__, DEFORMABLE_SURFACE_FLAGS);
  std::printf("commit    %s\n", commit.c_str());
  std::printf(
      "wall: median of the runs after a warm-up; spread: interquartile range over median\n"
      "cpu: least processor time of all threads, which other work on the machine disturbs least\n"
      "cores: cpu over wall, how many the machine gave\n");
}

int fail(const std::string& problem) {
  std::fprintf(stderr, "benchmark: %s\n", problem.c_str());
  return 2;
}

int run(int argc, char** argv) {
  Options options;
  std::string commit = "unknown";
  std::vector<std::string> wanted;
  for (int i = 1; i < argc; ++i) {
    const std::string argument = argv[i];
    if (argument == "--large") {
      options.large = true;
    } else if (argument == "--quick") {
      options.large = false;
    } else if (argument.rfind("--", 0) == 0 && findPart(argument.substr(2)) && findPart(argument.substr(2))->on_demand) {
      wanted.push_back(argument.substr(2));
    } else if (argument == "--scenes" && i + 2 < argc) {
      options.first_scene = std::atoi(argv[++i]);
      options.num_scenes = std::atoi(argv[++i]);
      if (options.first_scene < 0 || options.num_scenes < 1) return fail("--scenes: accepted: a seed and a count");
    } else if (argument == "--varied") {
      options.varied = true;
    } else if (argument == "--scene" && i + 1 < argc) {
      options.scene = argv[++i];
    } else if ((argument == "--output" || argument == "--commit" || argument == "--only") && i + 1 < argc) {
      const std::string value = argv[++i];
      if (argument == "--output") options.folder = value;
      if (argument == "--commit") commit = value;
      if (argument == "--only") wanted.push_back(value);
    } else {
      return fail(
          "found '" + argument +
          "'; accepted: --quick, --large, --solids, --activity, --scale, --peers, --targets, --geodesics, --camera, --growth, "
          "--accuracy, --simplification, --scene NAME, --statics, --physics, --calibration, --scenes FIRST COUNT, --varied, "
          "--stability, "
          "--only PART, --output FOLDER, --commit TEXT");
    }
  }
  for (const std::string& name : wanted)
    if (!findPart(name)) return fail("--only: found '" + name + "'; accepted: " + listParts());

  printHeader(commit);
  const Timer timer;
  Report report(options.folder);
  for (const Part& part : kParts)
    if (wanted.empty() ? !part.on_demand : std::find(wanted.begin(), wanted.end(), part.name) != wanted.end())
      part.run(options, report);
  std::printf("\n%.0f s\n", timer.seconds());
  return 0;
}

}  // namespace
}  // namespace deformable_surface::benchmark

int main(int argc, char** argv) {
  setenv("DEFORMABLE_SURFACE_CACHE", "", 1);  // what an earlier run has chosen would hide the time of choosing
  try {
    return deformable_surface::benchmark::run(argc, argv);
  } catch (const std::exception& problem) {
    std::fprintf(stderr, "benchmark: %s\n", problem.what());
    return 1;
  }
}
