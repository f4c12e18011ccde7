#include "deformable_surface/ros/convert/color_scale.h"

#include "deformable_surface/base/types.h"

#include <Eigen/Core>
#include <Eigen/LU>

#include <algorithm>
#include <array>
#include <cmath>

namespace deformable_surface::node {
namespace {

// The colours of the configurations in rviz/, in sRGB: visible on a dark ground, and distinguishable without red and green.
const Vec3 kRest(201.0 / 255.0, 209.0 / 255.0, 218.0 / 255.0), kFull(228.0 / 255.0, 87.0 / 255.0, 46.0 / 255.0);
// A colour that is not between the two.
const Vec3 kUnknown(0.35, 0.45, 0.65);

// As many as a byte per colour channel can distinguish.
constexpr int kSteps = 256;

/// XYZ of linear sRGB (IEC 61966-2-1), white at D65.
Eigen::Matrix3d makeXyz() {
  Eigen::Matrix3d m;
  m << 0.4124, 0.3576, 0.1805, 0.2126, 0.7152, 0.0722, 0.0193, 0.1192, 0.9505;
  return m;
}
const Eigen::Matrix3d kXyz = makeXyz();
const Vec3 kWhite = kXyz * Vec3::Ones();

// CIE 15: f is the cube root, and near black a line that meets it with the same slope.
constexpr double kBend = 6.0 / 29.0;
double f(double t) { return t > kBend * kBend * kBend ? std::cbrt(t) : t / (3.0 * kBend * kBend) + 4.0 / 29.0; }
double invertF(double t) { return t > kBend ? t * t * t : 3.0 * kBend * kBend * (t - 4.0 / 29.0); }

Vec3 toLab(const Vec3& srgb) {
  const Vec3 linear = srgb.unaryExpr([](double c) { return c > 0.04045 ? std::pow((c + 0.055) / 1.055, 2.4) : c / 12.92; });
  const Vec3 xyz = (kXyz * linear).cwiseQuotient(kWhite).unaryExpr(&f);
  return {116.0 * xyz.y() - 16.0, 500.0 * (xyz.x() - xyz.y()), 200.0 * (xyz.y() - xyz.z())};
}

Vec3 fromLab(const Vec3& lab) {
  const double y = (lab.x() + 16.0) / 116.0;
  const Vec3 xyz = Vec3(y + lab.y() / 500.0, y, y - lab.z() / 200.0).unaryExpr(&invertF).cwiseProduct(kWhite);
  const Vec3 linear = kXyz.inverse() * xyz;
  return linear.unaryExpr([](double c) { return c > 0.0031308 ? 1.055 * std::pow(c, 1.0 / 2.4) - 0.055 : 12.92 * c; });
}

std_msgs::ColorRGBA toMessage(const Vec3& srgb) {
  return makeColor(static_cast<float>(srgb.x()), static_cast<float>(srgb.y()), static_cast<float>(srgb.z()));
}

std::array<std_msgs::ColorRGBA, kSteps + 1> makeScale() {
  std::array<std_msgs::ColorRGBA, kSteps + 1> scale;
  const Vec3 from = toLab(kRest), way = toLab(kFull) - from;
  for (int k = 0; k <= kSteps; ++k) scale[k] = toMessage(fromLab(from + (static_cast<double>(k) / kSteps) * way));
  return scale;
}

}  // namespace

std_msgs::ColorRGBA makeColor(float r, float g, float b, float a) {
  std_msgs::ColorRGBA color;
  color.r = r;
  color.g = g;
  color.b = b;
  color.a = a;
  return color;
}

std_msgs::ColorRGBA colorOf(double value) {
  static const std::array<std_msgs::ColorRGBA, kSteps + 1> kScale = makeScale();
  if (std::isnan(value)) return toMessage(kUnknown);
  return kScale[static_cast<std::size_t>(std::lround(kSteps * std::min(1.0, std::max(0.0, value))))];
}

}  // namespace deformable_surface::node
