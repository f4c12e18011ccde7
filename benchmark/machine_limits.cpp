#include "machine_limits.h"

#include "deformable_surface/base/parallel.h"
#include "deformable_surface/base/simd.h"
#include "measure.h"

#include <stdexcept>
#include <vector>

namespace deformable_surface::benchmark {
namespace {

constexpr double kMemoryBytes = 512e6;  // far more than any cache holds
constexpr double kNearBytes = 256e3;    // a part of a core's own cache
constexpr Index kBlock = 8192;          // elements: many blocks per thread, each far longer than its start costs

// Twelve chains: as many as hide how long an operation takes, and as fit in registers. Returns something of all of them.
DEFORMABLE_SURFACE_WIDE double runChains(long rounds) {
  Double4 a0{1, 2, 3, 4}, a1 = a0 + 1, a2 = a0 + 2, a3 = a0 + 3, a4 = a0 + 4, a5 = a0 + 5;
  Double4 b0 = a0, b1 = a1, b2 = a2, b3 = a3, b4 = a4, b5 = a5;
  const Double4 shrink = a0 * 0.0 + 0.999, shift = a0 * 0.0 + 1e-3;
  for (long k = 0; k < rounds; ++k) {
    a0 = a0 * shrink;
    a1 = a1 * shrink;
    a2 = a2 * shrink;
    a3 = a3 * shrink;
    a4 = a4 * shrink;
    a5 = a5 * shrink;
    b0 = b0 + shift;
    b1 = b1 + shift;
    b2 = b2 + shift;
    b3 = b3 + shift;
    b4 = b4 + shift;
    b5 = b5 + shift;
  }
  const Double4 sum = a0 + a1 + a2 + a3 + a4 + a5 + b0 + b1 + b2 + b3 + b4 + b5;
  return sum[0] + sum[1] + sum[2] + sum[3];
}

}  // namespace

double measureTriad(double bytes, double budget) {
  const Index n = static_cast<Index>(bytes / (3 * sizeof(double)));
  std::vector<double> a(n, 0.0), b(n, 1.0), c(n, 2.0);
  const double s = 3.0;
  const Timing timing = measure(
      [&] {
        parallelFor(n, kBlock, [&](Index begin, Index end) {
          double* const to = a.data();
          const double *const x = b.data(), *const y = c.data();
          for (Index i = begin; i < end; ++i) to[i] = x[i] + s * y[i];
        });
      },
      budget);
  if (a[n / 2] != 7.0) throw std::logic_error("triad: wrong sum");
  return n * kTriadBytes / (numThreads() == 1 ? timing.cpu : timing.least);
}

double measureArithmetic(double budget) {
  constexpr long kRounds = 100000;
  constexpr double kOperations = 12.0 * 4.0;  // of a round
  double sum = 0.0;
  const Timing timing = measure([&] { sum += runChains(kRounds); }, budget);
  if (!(sum > 0.0)) throw std::logic_error("arithmetic: wrong sum");
  return kRounds * kOperations / timing.cpu;
}

MachineLimits measureMachine(const Options& options, Report& report) {
  MachineLimits limits;
  report.begin("scale_machine", "13. What the machine gives", {"what", "threads", "value", "unit"});
  for (const int threads : {1, 0}) {
    setNumThreads(threads);
    const double near = measureTriad(kNearBytes, options.budget), far = measureTriad(kMemoryBytes, options.budget);
    const std::string number = std::to_string(numThreads());
    report.add({"triad in memory", number, show(1e-9 * far), "GB/s"});
    if (threads != 1) continue;
    report.add({"triad in the core's own cache", number, show(1e-9 * near), "GB/s"});
    limits.near_bandwidth = near;
    limits.bandwidth = far;
    limits.arithmetic = measureArithmetic(options.budget);
    report.add({"sums and products of doubles", number, show(1e-9 * limits.arithmetic), "1e9/s"});
  }
  report.end();
  return limits;
}

}  // namespace deformable_surface::benchmark
