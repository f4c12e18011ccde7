// Volumes: linear fields, turned axes, borders, and distances from iso-surfaces.
#include "deformable_surface/geometry/volume.h"

#include "deformable_surface/base/error.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>

namespace deformable_surface::test {
namespace {

using geometry::Volume;

Volume makeVolume(const std::array<Index, 3>& size, const Vec3& origin, const Mat3& axes,
                  const std::function<double(const Vec3&)>& field) {
  std::vector<float> values;
  for (Index k = 0; k < size[2]; ++k)
    for (Index j = 0; j < size[1]; ++j)
      for (Index i = 0; i < size[0]; ++i) values.push_back(static_cast<float>(field(origin + axes * Vec3(i, j, k))));
  return {size, origin, axes, values};
}

Mat3 makeTurnedAxes() {
  return Eigen::AngleAxisd(0.7, Vec3(1.0, 2.0, 3.0).normalized()).toRotationMatrix() * Vec3(0.1, 0.2, 0.05).asDiagonal();
}

TEST(Volume, ALinearFieldIsExactOnTurnedAxes) {
  const Vec3 origin(1.0, -2.0, 0.5), slope(3.0, -1.0, 2.0);
  const Mat3 axes = makeTurnedAxes();
  const Volume volume = makeVolume({7, 5, 9}, origin, axes, [&](const Vec3& p) { return slope.dot(p); });
  for (const Vec3& at : {Vec3(0.0, 0.0, 0.0), Vec3(6.0, 4.0, 8.0), Vec3(2.3, 3.9, 0.1), Vec3(5.5, 0.5, 7.9)}) {
    const Vec3 place = origin + axes * at;
    const Volume::Sample s = volume.sample(place);
    EXPECT_NEAR(s.value, slope.dot(place), 1e-5);
    EXPECT_NEAR((s.gradient - slope).norm(), 0.0, 1e-4);
  }
}

TEST(Volume, BordersEndTheFieldAndTheDistanceTellsThem) {
  const Volume volume = makeVolume({5, 5, 5}, Vec3::Zero(), Mat3::Identity(), [](const Vec3& p) { return p.x(); });
  EXPECT_NEAR(volume.sample(Vec3(1.0, 2.0, 2.0)).distance, 1.0, 1e-12);
  const Volume::Sample beyond = volume.sample(Vec3(6.5, 2.0, 2.0));
  EXPECT_NEAR(beyond.distance, -2.5, 1e-12);
  EXPECT_NEAR(beyond.value, 4.0, 1e-12);
  EXPECT_TRUE(std::isfinite(volume.sample(Vec3::Constant(std::numeric_limits<double>::quiet_NaN())).value));
}

TEST(Volume, TheDistanceFromAnIsoSurfaceIsThatOfNewtonsMethod) {
  const auto ball = [](const Vec3& p) { return 1000.0 - 200.0 * (p - Vec3::Constant(1.0)).norm(); };
  const Volume volume = makeVolume({41, 41, 41}, Vec3::Zero(), 0.05 * Mat3::Identity(), ball);
  for (const double r : {0.3, 0.5, 0.7}) {
    const Vec3 place = Vec3::Constant(1.0) + r * Vec3(1.0, 2.0, -2.0) / 3.0;
    EXPECT_NEAR(geometry::findIsoDistance(volume, 900.0, 1.0, place), 0.5 - r, 0.002) << r;   // bright inside
    EXPECT_NEAR(geometry::findIsoDistance(volume, 900.0, -1.0, place), r - 0.5, 0.002) << r;  // dark inside
  }
  // The border of the grid is one of the inside as well.
  EXPECT_NEAR(geometry::findIsoDistance(volume, 900.0, -1.0, Vec3(1.9, 1.0, 1.0)), 0.1, 1e-6);
  EXPECT_NEAR(geometry::findIsoDistance(volume, 900.0, -1.0, Vec3(2.2, 1.0, 1.0)), -0.2, 1e-6);
  const Volume flat = makeVolume({3, 3, 3}, Vec3::Zero(), Mat3::Identity(), [](const Vec3&) { return 1.0; });
  EXPECT_EQ(geometry::findIsoDistance(flat, 0.5, -1.0, Vec3::Constant(1.0)), -std::numeric_limits<double>::infinity());
}

TEST(Volume, RefusesWhatIsNoGrid) {
  const Mat3 axes = Mat3::Identity();
  const std::vector<float> eight(8, 0.0f);
  EXPECT_NO_THROW(Volume({2, 2, 2}, Vec3::Zero(), axes, eight));
  EXPECT_THROW(Volume({1, 2, 4}, Vec3::Zero(), axes, eight), InputError);
  EXPECT_THROW(Volume({2, 2, 3}, Vec3::Zero(), axes, eight), InputError);
  Mat3 sheared = axes, none = axes;
  sheared(0, 1) = 0.1;
  none.col(2).setZero();
  EXPECT_THROW(Volume({2, 2, 2}, Vec3::Zero(), sheared, eight), InputError);
  EXPECT_THROW(Volume({2, 2, 2}, Vec3::Zero(), none, eight), InputError);
  for (const float bad : {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity()}) {
    std::vector<float> values = eight;
    values[3] = bad;
    EXPECT_THROW(Volume({2, 2, 2}, Vec3::Zero(), axes, values), InputError);
  }
}

}  // namespace
}  // namespace deformable_surface::test
