#include "frequent_steps.h"

#include "deformable_surface/base/step_time.h"

#include <utility>

namespace deformable_surface::simulation {
namespace {

constexpr double kPeriod = 1.0;  // s of simulated time
constexpr Index kFewest = 10;    // steps of a period: one in fewer of them is not many
constexpr double kOften = 0.1;   // of the steps of a period

}  // namespace

bool FrequentSteps::endStep(double end, double step, bool happens) {
  if (all_ == 0) begin_ = end - step;
  ++all_;
  happened_ += happens;
  if (all_ < kFewest || end - begin_ < kPeriod - kTimeRounding * step) return false;
  last_steps_ = std::exchange(all_, 0);
  last_count_ = std::exchange(happened_, 0);
  const bool is_often = last_count_ > kOften * last_steps_;
  return is_often && !std::exchange(is_told_, true);
}

}  // namespace deformable_surface::simulation
