// Tables of results: aligned on the terminal, and the same cells as CSV.
#pragma once

#include "measure.h"

#include <string>
#include <vector>

namespace deformable_surface::benchmark {

class Report {
 public:
  /// CSV files go to this folder, which exists.
  explicit Report(std::string folder) : folder_(std::move(folder)) {}

  /// Starts a table; file: name of its CSV file without ending.
  void begin(const std::string& file, const std::string& title, std::vector<std::string> columns);
  void add(std::vector<std::string> cells);
  /// Prints the table and writes its file. Throws std::runtime_error if it cannot be written.
  void end();
  /// A line below a table: how to read it.
  void note(const std::string& line);

 private:
  std::string folder_, file_;
  std::vector<std::vector<std::string>> rows_;
};

/// Three significant digits.
std::string show(double value);
std::string showPercent(double share);
std::string showHash(std::uint64_t hash);
std::string showMilliseconds(double seconds);

}  // namespace deformable_surface::benchmark
