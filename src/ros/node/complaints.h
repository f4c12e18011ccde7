// What went wrong, counted by kind and told in the log without flooding it. In a file of its own because every part of the node
// complains, and the diagnostics report what they said.
#pragma once

#include <array>
#include <chrono>
#include <map>
#include <mutex>
#include <string>

namespace deformable_surface::node {

enum class Complaint {
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
constexpr int kNumComplaints = 10;

/// May be used from any thread.
class Complaints {
 public:
  /// name: of the node, which begins each line.
  explicit Complaints(std::string name) : name_(std::move(name)) {}

  /// Counts, and writes one line unless one of the same cause was written a short while ago; the next then says how many were
  /// left out. Sentences of a kind that differ in numbers only have the same cause.
  void report(Complaint kind, const std::string& sentence);

  const std::string& name() const { return name_; }
  int count(Complaint kind) const;
  /// The last sentence; empty if there was none.
  std::string last() const;
  /// True for a while after the last report.
  bool isRecent() const;

 private:
  using Clock = std::chrono::steady_clock;
  struct Cause {
    bool was_told = false;
    int left_out = 0;  // since the last line
    Clock::time_point last_line;
  };

  Cause& findCause(Complaint kind, const std::string& sentence);

  const std::string name_;
  mutable std::mutex mutex_;
  std::array<int, kNumComplaints> counts_{};
  std::map<std::string, Cause> causes_;  // by kind and sentence without numbers
  std::string last_;
  Clock::time_point last_time_;
};

}  // namespace deformable_surface::node
