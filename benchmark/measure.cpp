#include "measure.h"

#include "deformable_surface/base/timer.h"

#include <algorithm>
#include <cmath>
#include <ctime>

namespace deformable_surface::benchmark {
namespace {

constexpr double kBatchSeconds = 2e-3;  // far above what reading the clocks costs
constexpr int kMaxRepetitions = 100;    // more do not move the median
constexpr double kLongRuns = 3.0;       // budgets: bodies longer than this run once

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
  std::vector<double> walls, cpus;
  const auto repeat = [&](int batch) {
    const double cpu_before = processorSeconds();
    const Timer timer;
    for (int i = 0; i < batch; ++i) body();
    walls.push_back(timer.seconds() / batch);
    cpus.push_back((processorSeconds() - cpu_before) / batch);
  };

  // The first run fills caches and buffers and does not count, unless the body is so long that this does not matter.
  repeat(1);
  if (walls[0] < kLongRuns * budget) {
    walls.clear();
    cpus.clear();
    repeat(1);  // says how many make a batch
    const int batch = static_cast<int>(std::max(1.0, std::min(1e6, kBatchSeconds / std::max(walls[0], 1e-9))));
    if (batch > 1) {
      walls.clear();
      cpus.clear();
    }
    const Timer all;
    while (static_cast<int>(walls.size()) < min_repetitions ||
           (all.seconds() < budget && static_cast<int>(walls.size()) < kMaxRepetitions))
      repeat(batch);
  }

  const Quartiles quartiles = findQuartiles(walls);
  Timing timing;
  timing.wall = quartiles.median;
  timing.spread = (quartiles.high - quartiles.low) / quartiles.median;
  timing.least = *std::min_element(walls.begin(), walls.end());
  timing.cpu = *std::min_element(cpus.begin(), cpus.end());
  timing.repetitions = static_cast<int>(walls.size());
  return timing;
}

double fitExponent(const std::vector<double>& sizes, const std::vector<double>& values) {
  double x = 0.0, y = 0.0, xx = 0.0, xy = 0.0;
  for (std::size_t k = 0; k < sizes.size(); ++k) {
    const double a = std::log(sizes[k]), b = std::log(values[k]);
    x += a;
    y += b;
    xx += a * a;
    xy += a * b;
  }
  const double n = static_cast<double>(sizes.size());
  return (n * xy - x * y) / (n * xx - x * x);
}

std::uint64_t hashBytes(const void* data, std::size_t size, std::uint64_t start) {
  const unsigned char* const bytes = static_cast<const unsigned char*>(data);
  std::uint64_t h = start;
  for (std::size_t i = 0; i < size; ++i) h = mixHash(h, bytes[i]);
  return h;
}

double rmsDistance(const Points& a, const Points& b) {
  double sum = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += (a[i] - b[i]).squaredNorm();
  return std::sqrt(sum / static_cast<double>(a.size()));
}

}  // namespace deformable_surface::benchmark
