// A log of warnings that is shared by all parts of the node: counted by kind, limited in rate, and reported in the diagnostics.
#pragma once

#include <array>
#include <chrono>
#include <map>
#include <mutex>
#include <string>

namespace deformable_surface::node {

enum class Warning {
  kCloudRefused,
  kCommandRefused,
  kToolsRefused,
  kCallRefused,
  kWaiting,
  kBehind,
  kClock,
  kNotice,
  kStep,
  kInternal
};
constexpr int kNumWarnings = 10;

/// May be used from any thread.
class WarningLog {
 public:
  /// name: of the node, which begins each line.
  explicit WarningLog(std::string name) : name_(std::move(name)) {}

  /// Counts, and writes one line unless one of the same cause was written a short while ago. The next line then says how many
  /// were left out. Sentences of a kind that differ only in numbers have the same cause.
  void report(Warning kind, const std::string& sentence);

  const std::string& name() const { return name_; }
  int count(Warning kind) const;
  /// The last sentence; empty if there was none.
  std::string last() const;
  /// True for a while after the last report.
  bool isRecent() const;

 private:
  using Clock = std::chrono::steady_clock;
  struct Cause {
    bool was_logged = false;
    int left_out = 0;  // since the last line
    Clock::time_point last_line;
  };

  Cause& findCause(Warning kind, const std::string& sentence);

  const std::string name_;
  mutable std::mutex mutex_;
  std::array<int, kNumWarnings> counts_{};
  std::map<std::string, Cause> causes_;  // by kind and sentence without numbers
  std::string last_;
  Clock::time_point last_time_;
};

}  // namespace deformable_surface::node
