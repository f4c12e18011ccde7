// The progress bar of `simulate` for a terminal.
#pragma once

#include "deformable_surface/base/timer.h"

#include <cstdio>
#include <ostream>

namespace deformable_surface::node {

/// A bar that is redrawn a few times a second.
class ProgressBar {
 public:
  /// show: whether there is a bar at all.
  ProgressBar(std::ostream& err, bool show) : err_(err), show_(show) {}
  ~ProgressBar() { clear(); }

  void update(double time, double duration) {
    constexpr double kPeriod = 0.1;  // s: smooth to the eye and nothing to the processor
    if (!show_ || timer_.seconds() < drawn_ + kPeriod) return;
    drawn_ = timer_.seconds();
    const int percent = static_cast<int>(100.0 * time / duration);
    char line[100];
    std::snprintf(line, sizeof line, "\r[%-40.*s] %3d %%  %.2f / %.2f s  %.2f x real time ", percent * 40 / 100,
                  "########################################", percent, time, duration, time / drawn_);
    err_ << line << std::flush;
  }
  void clear() {
    if (show_ && drawn_ > 0.0) err_ << "\r\033[K" << std::flush;
    drawn_ = 0.0;
  }

 private:
  std::ostream& err_;
  bool show_;
  Timer timer_;
  double drawn_ = 0.0;  // s
};

}  // namespace deformable_surface::node
