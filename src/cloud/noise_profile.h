// The noise of a cloud's values as a function of the values: inverse depths of a camera, or heights over planes. Private.
#pragma once

#include "deformable_surface/base/types.h"

#include <cmath>
#include <vector>

namespace deformable_surface::cloud {

/// A value and its place in the window: the smoother the surface, the better a quadratic of the place explains it.
struct Sample {
  Vec2 place;
  double value;
};

/// Residuals of a window's best quadratic.
struct Leftover {
  // Unbiased variance, in the square of the values' unit; negative: too few samples, or samples on a curve.
  double variance = -1.0;
  double kurtosis = 0.0;  // 3 for normal noise
  // Kurtosis less the square of the skewness: 3 for normal noise. The least is 1, for two layers of any densities [Pearson 1916].
  double spread = 0.0;
};
Leftover measureLeftover(const std::vector<Sample>& window);

constexpr double kSurprise = 3.0;  // standard deviations of the variance of noise
constexpr double kOutlier = 4.0;   // standard deviations of a value
/// The largest variance of a window with this many degrees of freedom that noise explains, over the variance of the noise.
inline double findMostVariance(double freedom) { return 1.0 + kSurprise * std::sqrt(2.0 / freedom); }

class NoiseProfile {
 public:
  NoiseProfile() = default;
  /// windows: of samples, the central one first. Standard deviations are medians, over windows of similar values, of the
  /// residuals of the best quadratic. They are at least those of the steps of the values: a variance of a twelfth of the square
  /// of a step.
  explicit NoiseProfile(const std::vector<std::vector<Sample>>& windows);

  /// The same deviation at every value.
  explicit NoiseProfile(double deviation) : values_{0.0}, deviations_{deviation} {}

  /// Standard deviation at a value, in its unit.
  double at(double value) const;
  void scale(double factor);
  bool isEmpty() const { return values_.empty(); }
  /// Number of levels, if the values have too few to separate sensor steps from flat parts; else 0.
  std::size_t numFewLevels() const { return num_few_levels_; }
  /// The median step between these levels.
  double fewLevelsStep() const { return few_levels_step_; }

 private:
  std::vector<double> values_, deviations_;  // ascending values, with linear interpolation
  std::size_t num_few_levels_ = 0;
  double few_levels_step_ = 0.0;
};

}  // namespace deformable_surface::cloud
