#include "deformable_surface/geometry/volume.h"

#include "deformable_surface/base/error.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <utility>

namespace deformable_surface::geometry {
namespace {

constexpr double kRightAngle = 1e-4;  // cosine: files hold directions with few digits

}  // namespace

Volume::Volume(const std::array<Index, 3>& size, const Vec3& origin, const Mat3& axes, std::vector<float> values)
    : size_(size), origin_(origin), axes_(axes), steps_(axes.colwise().norm()), values_(std::move(values)) {
  std::size_t count = 1;
  for (int k = 0; k < 3; ++k) {
    if (size[k] < 2)
      throw InputError("volume: found " + std::to_string(size[k]) + " samples along an axis; accepted: two or more");
    count *= static_cast<std::size_t>(size[k]);
    const int next = (k + 1) % 3;
    const double cosine = axes.col(k).dot(axes.col(next)) / (steps_[k] * steps_[next]);
    if (!(std::abs(cosine) <= kRightAngle))
      throw InputError("volume: found axes that are not at right angles, or have no length; accepted: right angles");
  }
  if (values_.size() != count)
    throw InputError("volume: found " + std::to_string(values_.size()) + " values; accepted: " + std::to_string(count) +
                     ", one per sample");
  const auto bad = std::find_if(values_.begin(), values_.end(), [](float v) { return !std::isfinite(v); });
  if (bad != values_.end())
    throw InputError("volume: found no finite number as value " + std::to_string(bad - values_.begin()) +
                     "; accepted: finite numbers");
  const auto [low, high] = std::minmax_element(values_.begin(), values_.end());
  least_ = *low;
  largest_ = *high;
  to_grid_ = axes_.inverse();
}

double Volume::interpolate(const Vec3& p) const {
  std::size_t first = 0, stride = 1, step[3];
  double share[3];
  for (int k = 0; k < 3; ++k) {
    const Index i = std::min(static_cast<Index>(p[k]), size_[k] - 2);
    share[k] = p[k] - i;
    first += i * stride;
    step[k] = stride;
    stride *= size_[k];
  }
  double sum = 0.0;
  for (int corner = 0; corner < 8; ++corner) {
    double weight = 1.0;
    std::size_t at = first;
    for (int k = 0; k < 3; ++k) {
      const bool is_upper = (corner >> k & 1) != 0;
      weight *= is_upper ? share[k] : 1.0 - share[k];
      at += is_upper ? step[k] : 0;
    }
    sum += weight * values_[at];
  }
  return sum;
}

Volume::Sample Volume::sample(const Vec3& place) const {
  Sample found;
  Vec3 p = to_grid_ * (place - origin_);
  found.distance = std::numeric_limits<double>::infinity();
  for (int k = 0; k < 3; ++k) {
    const double last = size_[k] - 1;
    found.distance = std::min(found.distance, std::min(p[k], last - p[k]) * steps_[k]);
    p[k] = p[k] >= 0.0 ? std::min(p[k], last) : 0.0;  // the first also if it is no number
  }
  found.value = interpolate(p);
  Vec3 slope;
  for (int k = 0; k < 3; ++k) {
    Vec3 before = p, after = p;
    before[k] = std::max(p[k] - 1.0, 0.0);
    after[k] = std::min(p[k] + 1.0, size_[k] - 1.0);
    slope[k] = (interpolate(after) - interpolate(before)) / (after[k] - before[k]);
  }
  found.gradient = to_grid_.transpose() * slope;
  return found;
}

double findIsoDistance(const Volume& volume, double iso_value, double side, const Vec3& place) {
  const Volume::Sample s = volume.sample(place);
  const double above = side * (s.value - iso_value), slope = s.gradient.norm();
  const double newton = slope > 0.0 ? above / slope : std::copysign(std::numeric_limits<double>::infinity(), above);
  return std::min(newton, s.distance);
}

}  // namespace deformable_surface::geometry
