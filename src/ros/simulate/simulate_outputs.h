// The files that `simulate` writes while it runs: statistics, numbered clouds, a bag. Each gets its name only
// when it is complete; tables also when the run is interrupted.
#pragma once

#include "deformable_surface/base/step_time.h"
#include "deformable_surface/io/pending_file.h"
#include "deformable_surface/ros/convert/encode.h"
#include "deformable_surface/ros/convert/markers.h"
#include "deformable_surface/ros/convert/surface_output.h"
#include "deformable_surface/simulation/simulation.h"

#include <rosbag/bag.h>

#include <cstdint>
#include <fstream>
#include <memory>
#include <set>
#include <string>

namespace deformable_surface::node {

/// All digits of a number, as CSV files and --measure have them.
std::string formatExactly(double value);

/// When the next output of a rate is due: at the first step at or after each multiple of its period, and at most once per step.
class Pace {
 public:
  Pace(double rate, double time_step) : rate_(rate), tolerance_(kTimeRounding * time_step) {}
  bool isDue(double time);

 private:
  double rate_;       // Hz
  double tolerance_;  // s; rounding of the time must not move an output to the next step
  std::uint64_t count_ = 0;
};

/// A table of lines. Each is written at once: also the temporary file of a run that was killed has the lines until then.
class CsvFile {
 public:
  CsvFile(const std::string& file, const std::string& header);
  void add(const std::string& line);
  void finish();

 private:
  void check() const;

  std::string name_;
  io::PendingFile file_;
  std::ofstream stream_;
};

/// One CSV row per step.
class StatisticsFile {
 public:
  explicit StatisticsFile(const std::string& file);
  void add(const simulation::Statistics& statistics);
  void finish() { file_.finish(); }

 private:
  CsvFile file_;
};

/// One CSV row per step and tool or pin: its contact wrench.
class WrenchesFile {
 public:
  explicit WrenchesFile(const std::string& file);
  void add(const simulation::Simulation& simulation);
  void finish() { file_.finish(); }

 private:
  CsvFile file_;
};

/// frame_000000.ply, frame_000001.ply, ...
bool isFrameName(const std::string& name);
class FrameFiles {
 public:
  /// Makes the folder if it does not exist. Throws InputError if it cannot, or if the folder holds frames: the frames of two runs
  /// would look like those of one.
  FrameFiles(const std::string& directory, double rate, double time_step);
  void add(double time, simulation::Simulation& simulation);

 private:
  std::string directory_;
  Pace pace_;
  int count_ = 0;
};

/// The topics that the node would publish. Wall times are NaN, so that equal input gives equal bytes.
class OutputBag {
 public:
  OutputBag(const std::string& file, double rate, double time_step);
  /// For a new surface, at rest.
  void begin(const std::string& frame_id, const CloudId& cloud, const simulation::Simulation& simulation);
  /// time: s since the run began; stamp: ns on the clock of the bag, >= 0; silent: ids of the silent tools.
  void add(double time, std::int64_t stamp, const std::set<std::string>& silent, simulation::Simulation& simulation);
  void finish();

 private:
  // A bag that cannot be written ends the program in its own destructor; therefore it is not destroyed.
  struct CloseOrLeave {
    void operator()(rosbag::Bag* bag) const noexcept;
  };

  std::string name_;
  io::PendingFile file_;
  std::unique_ptr<rosbag::Bag, CloseOrLeave> bag_;
  Pace pace_;
  std::string frame_id_;
  CloudId cloud_;
  std::unique_ptr<SurfaceEncoder> encoder_;
  std::unique_ptr<SimulationMarkers> markers_;
};

}  // namespace deformable_surface::node
