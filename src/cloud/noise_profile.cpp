#include "noise_profile.h"

#include <Eigen/QR>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "deformable_surface/base/median.h"

namespace deformable_surface::cloud {
namespace {

constexpr int kUnknowns = 6;         // of a quadratic
constexpr int kFreedom = 4;          // least number of samples beyond that
constexpr std::size_t kFewest = 40;  // windows per part of the profile
constexpr std::size_t kMostParts = 6;
// Values with few levels (many values per level), but at least kFewestLevels of them, are quantised. Two levels may be two flat
// parts.
constexpr std::size_t kFewestLevels = 8, kRepeats = 4;
// Bounds on the residual variance of a window over that of steps, a twelfth of their square, and the least share of windows
// within them. The other windows have edges of parts or level rows.
constexpr double kLeastStepped = 0.2, kMostStepped = 1.5, kSteppedShare = 0.01;
constexpr double kSameLevel = 2e-6;  // relative: differences from rounding to single precision

// Steps between neighbouring levels. sorted: values, ascending.
std::vector<double> findSteps(const std::vector<double>& sorted) {
  std::vector<double> steps;
  for (std::size_t i = 1; i < sorted.size(); ++i)
    if (sorted[i] - sorted[i - 1] > kSameLevel * std::abs(sorted[i])) steps.push_back(sorted[i] - sorted[i - 1]);
  return steps;
}

}  // namespace

Leftover measureLeftover(const std::vector<Sample>& window) {
  const int n = static_cast<int>(window.size());
  if (n < kUnknowns + kFreedom) return {};
  double largest = 0.0;
  for (const Sample& s : window) largest = std::max(largest, s.place.squaredNorm());
  if (!(largest > 0.0)) return {};
  const double scale = 1.0 / std::sqrt(largest);
  Eigen::Matrix<double, Eigen::Dynamic, kUnknowns> rows(n, kUnknowns);
  Eigen::VectorXd values(n);
  for (int k = 0; k < n; ++k) {
    const double x = scale * window[k].place.x(), y = scale * window[k].place.y();
    rows.row(k) << 1.0, x, y, x * x, x * y, y * y;
    values[k] = window[k].value - window[0].value;
  }
  const Eigen::ColPivHouseholderQR<decltype(rows)> qr(rows);
  if (qr.rank() < kUnknowns) return {};
  const Eigen::ArrayXd residuals = (values - rows * qr.solve(values)).array(), squares = residuals.square();
  const double sum = squares.sum();
  if (!(sum > 0.0)) return {0.0, 0.0, 0.0};
  const double cubes = (squares * residuals).sum(), kurtosis = n * squares.square().sum() / (sum * sum);
  return {sum / (n - kUnknowns), kurtosis, kurtosis - n * cubes * cubes / (sum * sum * sum)};
}

NoiseProfile::NoiseProfile(const std::vector<std::vector<Sample>>& windows) {
  struct Fit {
    double value, variance;
    std::size_t window;
  };
  std::vector<Fit> fits;
  for (std::size_t w = 0; w < windows.size(); ++w) {
    const double variance = measureLeftover(windows[w]).variance;
    if (variance >= 0.0) fits.push_back({windows[w][0].value, variance, w});
  }
  std::sort(fits.begin(), fits.end(),
            [](const Fit& a, const Fit& b) { return a.value != b.value ? a.value < b.value : a.window < b.window; });
  if (fits.empty()) return;
  std::vector<double> all;
  for (const Fit& fit : fits) all.push_back(fit.value);
  std::vector<double> all_steps = findSteps(all);
  const bool repeats = kRepeats * all_steps.size() <= all.size(), has_levels = repeats && all_steps.size() >= kFewestLevels;
  if (repeats && !has_levels && !all_steps.empty()) {
    num_few_levels_ = all_steps.size() + 1;
    few_levels_step_ = findMedian(all_steps);
  }
  const double usual = has_levels ? findMedian(std::move(all_steps)) : 0.0;
  const std::size_t parts = std::clamp(fits.size() / kFewest, std::size_t{1}, kMostParts);
  for (std::size_t p = 0; p < parts; ++p) {
    const std::size_t begin = p * fits.size() / parts, end = (p + 1) * fits.size() / parts;
    std::vector<double> variances, levels;
    for (std::size_t f = begin; f < end; ++f) {
      variances.push_back(fits[f].variance);
      levels.push_back(fits[f].value);
    }
    std::vector<double> steps = findSteps(levels);
    const double step = !has_levels ? 0.0 : steps.empty() ? usual : findMedian(std::move(steps));
    const double stepped = step / std::sqrt(12.0);
    const auto isStepped = [&](double variance) {
      return variance >= std::pow(kLeastStepped * stepped, 2) && variance <= std::pow(kMostStepped * stepped, 2);
    };
    const double with_steps = static_cast<double>(std::count_if(variances.begin(), variances.end(), isStepped));
    const bool is_quantised = with_steps >= kSteppedShare * static_cast<double>(variances.size());
    values_.push_back(fits[(begin + end) / 2].value);
    deviations_.push_back(std::max(std::sqrt(findMedian(std::move(variances))), is_quantised ? stepped : 0.0));
  }
}

double NoiseProfile::at(double value) const {
  const std::size_t above = std::upper_bound(values_.begin(), values_.end(), value) - values_.begin();
  if (above == 0) return deviations_.front();
  if (above == values_.size()) return deviations_.back();
  const double share = (value - values_[above - 1]) / (values_[above] - values_[above - 1]);
  return (1.0 - share) * deviations_[above - 1] + share * deviations_[above];
}

void NoiseProfile::scale(double factor) {
  for (double& deviation : deviations_) deviation *= factor;
}

}  // namespace deformable_surface::cloud
