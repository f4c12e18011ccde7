#include "measure.h"

#include "deformable_surface/base/timer.h"

#include <algorithm>
#include <cmath>
#include <ctime>

namespace deformable_surface::benchmark {
namespace {

constexpr double kBatchSeconds = 2e-3;  // far above what reading the clocks costs
constexpr int kMaxRepetitions = 100;    // more do not move the median

}  // namespace

double processorSeconds() {
  timespec t;
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

Quartiles findQuartiles(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  const std::size_t last = values.size() - 1;
  return {values[last / 4], values[last / 2], values[last - last / 4]};
}

Timing measure(const std::function<void()>& body, double budget, int min_repetitions) {
  // The first run fills caches and buffers, the second says how many make a batch.
  body();
  const Timer once;
  body();
  const int batch = static_cast<int>(std::max(1.0, std::min(1e6, kBatchSeconds / std::max(once.seconds(), 1e-9))));

  Timing timing;
  std::vector<double> walls, cpus;
  if (batch == 1 && once.seconds() > budget) --min_repetitions;  // long ones: the second run has cost enough
  const Timer all;
  while (timing.repetitions < std::max(1, min_repetitions) ||
         (all.seconds() < budget && timing.repetitions < kMaxRepetitions)) {
    const double cpu_before = processorSeconds();
    const Timer timer;
    for (int i = 0; i < batch; ++i) body();
    walls.push_back(timer.seconds() / batch);
    cpus.push_back((processorSeconds() - cpu_before) / batch);
    ++timing.repetitions;
  }
  const Quartiles quartiles = findQuartiles(walls);
  timing.wall = quartiles.median;
  timing.spread = (quartiles.high - quartiles.low) / quartiles.median;
  timing.cpu = *std::min_element(cpus.begin(), cpus.end());
  return timing;
}

std::uint64_t hashBytes(const void* data, std::size_t size, std::uint64_t start) {
  const unsigned char* const bytes = static_cast<const unsigned char*>(data);
  std::uint64_t h = start;
  for (std::size_t i = 0; i < size; ++i) h = (h ^ bytes[i]) * 1099511628211ull;
  return h;
}

double rmsDistance(const Points& a, const Points& b) {
  double sum = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += (a[i] - b[i]).squaredNorm();
  return std::sqrt(sum / static_cast<double>(a.size()));
}

}  // namespace deformable_surface::benchmark
