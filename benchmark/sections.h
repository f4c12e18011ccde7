// The parts of the benchmark, one table each. Every part is a file of its own that states what it measures and against which
// reference.
#pragma once

#include "report.h"

namespace deformable_surface::benchmark {

struct Options {
  bool large = false;        // clouds of a million points, and rows that take long
  double budget = 0.2;       // s of repetitions per row
  std::string folder = ".";  // where CSV files go
  std::string scene;         // accuracy, simplification, camera, growth, peers, physics: names begin so; empty = all
  Index first_scene = 0;     // calibration, varied targets: seeds of the scenes
  Index num_scenes = 0;      // 0: those that the part names
  bool varied = false;       // calibration, targets: scenes of the families of test/support/varied_scene.h
};

void runSetupSection(const Options& options, Report& report);
void runTable1Section(const Options& options, Report& report);
void runTransferSection(const Options& options, Report& report);
void runIntegratorsSection(const Options& options, Report& report);
void runExplicitSection(const Options& options, Report& report);
void runAllocationsSection(const Options& options, Report& report);
void runMemorySection(const Options& options, Report& report);
void runFactorizationSection(const Options& options, Report& report);
void runAccuracySection(const Options& options, Report& report);
void runSimplificationSection(const Options& options, Report& report);
void runStaticsSection(const Options& options, Report& report);
void runStabilitySection(const Options& options, Report& report);
void runPhysicsSection(const Options& options, Report& report);
void runSolidsSection(const Options& options, Report& report);
void runParticlesSection(const Options& options, Report& report);
void runActivitySection(const Options& options, Report& report);
void runScaleSection(const Options& options, Report& report);
void runPeersSection(const Options& options, Report& report);
void runTargetsSection(const Options& options, Report& report);
void runGeodesicsSection(const Options& options, Report& report);
void runCameraSection(const Options& options, Report& report);
void runGrowthSection(const Options& options, Report& report);
void runCalibrationSection(const Options& options, Report& report);

}  // namespace deformable_surface::benchmark
