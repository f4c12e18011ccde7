// Wall time for statistics; no result ever depends on it.
#pragma once

#include <chrono>

namespace deformable_surface {

class Timer {
 public:
  double seconds() const { return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count(); }

 private:
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

}  // namespace deformable_surface
