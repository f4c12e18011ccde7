// Measurement of times: warm-up, repetitions, median and spread of wall time, least processor time. And a hash that shows whether
// a faster version changed the result.
#pragma once

#include "deformable_surface/base/hash.h"
#include "deformable_surface/base/types.h"

#include <functional>
#include <vector>

namespace deformable_surface::benchmark {

struct Timing {
  double wall = 0.0;    // s, median of the repetitions
  double least = 0.0;   // s of wall time, the least of them
  double spread = 0.0;  // interquartile range over median
  double cpu = 0.0;     // s of processor time of all threads, the least of the repetitions
  int repetitions = 0;
};

/// Processor time of this process so far, s.
double processorSeconds();

/// Runs body once as a warm-up and then repeatedly, for about budget seconds and at least min_repetitions times. Short bodies run
/// in batches that the clocks can resolve. Bodies far longer than the budget run once.
Timing measure(const std::function<void()>& body, double budget, int min_repetitions = 3);

/// The values in the middle and at the two quarters.
struct Quartiles {
  double low, median, high;
};
Quartiles findQuartiles(std::vector<double> values);

/// The exponent of a power law through values over sizes, by least squares of the logarithms.
double fitExponent(const std::vector<double>& sizes, const std::vector<double>& values);

/// FNV-1a over the bytes of trivially copyable values without padding.
std::uint64_t hashBytes(const void* data, std::size_t size, std::uint64_t start = kHashBegin);
template <class T>
std::uint64_t hashValues(const std::vector<T>& values) {
  return hashBytes(values.data(), values.size() * sizeof(T));
}

/// Root of the mean squared distance, m.
double rmsDistance(const Points& a, const Points& b);

}  // namespace deformable_surface::benchmark
