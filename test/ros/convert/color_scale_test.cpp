// The colours of strain are neutral at rest and in even steps for the eye, by the formulas of CIE 15 (CIELAB 1976) and IEC
// 61966-2-1 (sRGB).
#include "deformable_surface/ros/convert/color_scale.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace deformable_surface::node {
namespace {

struct Lab {
  double l, a, b;
};

Lab measure(const std_msgs::ColorRGBA& color) {
  const auto linear = [](double c) { return c <= 0.04045 ? c / 12.92 : std::pow((c + 0.055) / 1.055, 2.4); };
  const double r = linear(color.r), g = linear(color.g), b = linear(color.b);
  const auto f = [](double t) { return t > 216.0 / 24389.0 ? std::cbrt(t) : (24389.0 / 27.0 * t + 16.0) / 116.0; };
  const double x = f((0.4124 * r + 0.3576 * g + 0.1805 * b) / 0.9505), y = f(0.2126 * r + 0.7152 * g + 0.0722 * b),
               z = f((0.0193 * r + 0.1192 * g + 0.9505 * b) / 1.089);
  return {116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)};
}

double chroma(const Lab& lab) { return std::hypot(lab.a, lab.b); }
double distance(const Lab& p, const Lab& q) { return std::hypot(std::hypot(p.l - q.l, p.a - q.a), p.b - q.b); }

TEST(ColorScale, IsNeutralAtRestAndFullAtTheEnd) {
  const Lab rest = measure(colorOf(0.0)), full = measure(colorOf(1.0));
  EXPECT_LT(chroma(rest), 10.0);
  EXPECT_GT(rest.l, 70.0);  // seen on a dark ground
  EXPECT_GT(chroma(full), 60.0);
}

TEST(ColorScale, TakesStepsThatLookEqual) {
  constexpr int kSteps = 32;  // divides those that are kept
  double smallest = std::numeric_limits<double>::infinity(), largest = 0.0;
  for (int k = 0; k < kSteps; ++k) {
    const Lab from = measure(colorOf(static_cast<double>(k) / kSteps)), to = measure(colorOf((k + 1.0) / kSteps));
    EXPECT_LT(to.l, from.l) << k;
    EXPECT_GT(to.a, from.a) << k;
    smallest = std::min(smallest, distance(from, to));
    largest = std::max(largest, distance(from, to));
  }
  EXPECT_LT(largest, 1.02 * smallest);
}

TEST(ColorScale, EndsAtItsEnds) {
  EXPECT_EQ(colorOf(7.0), colorOf(1.0));
  EXPECT_EQ(colorOf(std::numeric_limits<double>::infinity()), colorOf(1.0));
  EXPECT_EQ(colorOf(-1e-12), colorOf(0.0));
}

TEST(ColorScale, ShowsWhatHasNoValueInAColourOfItsOwn) {
  const Lab unknown = measure(colorOf(std::nan("")));
  for (int k = 0; k <= 100; ++k) EXPECT_GT(distance(unknown, measure(colorOf(0.01 * k))), 25.0) << k;
}

}  // namespace
}  // namespace deformable_surface::node
