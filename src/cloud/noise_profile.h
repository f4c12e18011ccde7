// How noisy the values of a cloud are, as a function of the values: inverse depths of a camera, or heights over planes. Private.
#pragma once

#include "deformable_surface/base/types.h"

#include <cmath>
#include <vector>

namespace deformable_surface::cloud {

/// A value and where it stands in its window: the smoother the surface, the better a quadratic of the place explains it.
struct Sample {
  Vec2 place;
  double value;
};

/// What the best quadratic leaves of a window.
struct Leftover {
  // Of as many degrees of freedom, in the square of the values' unit; negative: too few samples, or they lie on a curve.
  double variance = -1.0;
  double kurtosis = 0.0;  // 3 of normal noise, 1 of two layers
};
Leftover measureLeftover(const std::vector<Sample>& window);

constexpr double kSurprise = 3.0;  // standard deviations of a variance that noise makes
constexpr double kOutlier = 4.0;   // and of a value
/// The largest variance of a window with so many degrees of freedom that noise explains, over the variance of the noise.
inline double findMostVariance(double freedom) { return 1.0 + kSurprise * std::sqrt(2.0 / freedom); }

class NoiseProfile {
 public:
  NoiseProfile() = default;
  /// windows: of samples, the middle one first. Standard deviations are medians, over windows of similar values, of what the
  /// best quadratic leaves, and at least what the steps of the values make: a twelfth of the square of a step.
  explicit NoiseProfile(const std::vector<std::vector<Sample>>& windows);

  /// The same at every value.
  explicit NoiseProfile(double deviation) : values_{0.0}, deviations_{deviation} {}

  /// Standard deviation at a value, in its unit.
  double at(double value) const;
  void scale(double factor);
  bool isEmpty() const { return values_.empty(); }
  /// Of values that take too few levels to tell steps of the sensor from flat parts: how many; else 0.
  std::size_t numFewLevels() const { return num_few_levels_; }
  /// And from one of these to the next, the median.
  double fewLevelsStep() const { return few_levels_step_; }

 private:
  std::vector<double> values_, deviations_;  // ascending values, between which it is linear
  std::size_t num_few_levels_ = 0;
  double few_levels_step_ = 0.0;
};

}  // namespace deformable_surface::cloud
