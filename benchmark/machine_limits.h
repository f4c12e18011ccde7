// Limits of the machine, measured in the same run: bytes per second of a triad, operations per second of sums and products in
// registers.
#pragma once

#include "sections.h"

namespace deformable_surface::benchmark {

/// Bytes per element of the triad a = b + s c of doubles: a line of memory that is written is read first, unless the program
/// takes special care, which neither the triad nor the library does.
constexpr double kTriadBytes = 4.0 * sizeof(double);

/// Bandwidth in bytes/s of a triad on arrays that take `bytes` together, by as many threads as are set; the best run of `budget`
/// s, on one thread by processor time, which other work disturbs least, else by wall time.
double measureTriad(double bytes, double budget);

/// Additions and multiplications of doubles per second on one thread, as many of either, without memory: in the widest
/// instructions that the library takes (base/simd.h), which fuse none. The best run of `budget` s.
double measureArithmetic(double budget);

struct MachineLimits {
  double near_bandwidth = 0.0;  // bytes/s of one thread, in its core's own cache
  double bandwidth = 0.0;       // bytes/s of one thread, in memory
  double arithmetic = 0.0;      // 1/s, of one thread
};

/// A table of them all, on one and on all threads.
MachineLimits measureMachine(const Options& options, Report& report);

}  // namespace deformable_surface::benchmark
