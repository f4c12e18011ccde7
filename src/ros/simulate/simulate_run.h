// One run of `simulate`: surfaces from the scene or the bag, one after the other, and the outputs.
#pragma once

#include "kept_surfaces.h"
#include "progress_bar.h"
#include "simulate.h"
#include "simulate_bag.h"
#include "simulate_options.h"
#include "simulate_outputs.h"

#include "deformable_surface/base/error.h"
#include "deformable_surface/base/timer.h"
#include "deformable_surface/ros/convert/surface_output.h"
#include "deformable_surface/ros/convert/tool_commands.h"
#include "deformable_surface/simulation/simulation.h"

#include <cmath>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace deformable_surface::node {

/// Exit statuses of `simulate`, see simulate.h.
constexpr int kDone = 0, kWrongInput = 2, kNoSoundStep = 3, kNotAsExpected = 4, kInterrupted = 128;

/// The scene of a run. Throws InputError.
simulation::SceneParams loadScene(const SimulateOptions& options);
/// Throws InputError if these options cannot be used for the scene. Opens no file.
void checkOptions(const SimulateOptions& options, const simulation::SceneParams& params);

class Run {
 public:
  /// All are kept by reference; kept: prepared surfaces that it may use, or null. Throws InputError for what is wrong with the
  /// options, the scene or a file.
  Run(const SimulateOptions& options, const Terminal& terminal, KeptSurfaces* kept);
  /// Returns the exit status.
  int run();

 private:
  // Surfaces and steps: simulate_run.cpp.
  std::vector<std::string> filter(cloud::PointCloud& cloud);
  std::unique_ptr<simulation::Simulation> buildOfScene();
  std::unique_ptr<simulation::Simulation> build(cloud::PointCloud cloud, const std::string& cloud_frame, std::int64_t stamp);
  std::unique_ptr<simulation::Simulation> place(std::unique_ptr<simulation::Simulation> simulation,
                                                const std::string& cloud_frame, std::int64_t stamp);
  void begin(std::unique_ptr<simulation::Simulation> simulation, const std::string& cloud_frame, std::int64_t stamp);
  std::string findFrame(const std::string& cloud_frame) const;
  Vec3 findGravity(const std::string& frame, std::int64_t stamp) const;
  void updateGravity();
  void moveTools();
  void stepUntil(std::int64_t stamp);
  bool canStep() const;
  void step();
  bool isInterrupted();
  std::string keepTables();
  void writeState();

  // The bag: simulate_run_bag.cpp.
  void playBag();
  void takeCloud(DecodedCloud decoded, std::int64_t stamp);
  void track(DecodedCloud& decoded, std::int64_t stamp);
  void takeCommand(const InputBag::Event& event);
  void bringInto(const std::string& frame, std::int64_t stamp, DecodedCloud& decoded) const;
  void noteBag();

  // The end, and what is said: simulate_run_report.cpp.
  void finish();
  void measure();
  void writeMesh();
  void checkExpectations();
  void noteIdleForces();
  void warn(const std::string& line);
  void note(const std::string& line);
  void report(const std::string& line);
  void reportRefusal(const std::string& what, std::int64_t stamp, const InputError& error);

  /// Stamp of the state, ns, and time since the run began, s.
  std::int64_t now() const { return timeOf(simulation_->stepCount()); }
  double runTime() const { return static_cast<double>(start_ - run_start_) * 1e-9 + simulation_->time(); }
  /// When a step begins, as in the node.
  std::int64_t timeOf(std::uint64_t step) const {
    return start_ + toNanoseconds(static_cast<double>(step) * params_.integrator.time_step);
  }
  static std::int64_t toNanoseconds(double seconds) { return std::llround(seconds * 1e9); }

  const SimulateOptions& options_;
  const Terminal& terminal_;
  KeptSurfaces* const kept_;
  simulation::SceneParams params_;
  ProgressBar progress_;
  std::optional<StatisticsFile> statistics_;
  std::optional<WrenchesFile> wrenches_file_;
  std::optional<FrameFiles> frames_;
  std::optional<OutputBag> output_bag_;

  std::optional<InputBag> bag_;
  std::optional<ToolCommands> tool_commands_;  // with the bag
  std::unique_ptr<simulation::Simulation> simulation_;
  std::vector<std::string> filter_notices_;  // of its cloud
  bool is_filtered_written_ = false;
  CloudId cloud_;
  std::string frame_;
  std::int64_t run_start_ = 0, start_ = 0, end_ = 0;  // ns: time 0 of the run and of this surface, and the end
  unsigned long long steps_ = 0, clouds_ = 0, forces_ = 0, wrenches_ = 0, tools_ = 0;  // taken; all but the first from the bag
  unsigned long long followed_ = 0;                                                    // later clouds, that the surface tracked
  std::size_t not_taken_ = 0;                                                          // of the bag, since the run ended before
  std::int64_t first_not_taken_ = 0;                                                   // ns
  int status_ = kDone;
  std::string last_note_;
  double set_up_seconds_ = 0.0;  // wall time of reading, filtering and building surfaces
  Timer timer_;
};

}  // namespace deformable_surface::node
