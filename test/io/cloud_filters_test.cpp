// What filters remove from frames whose truth is known, and which parameters they refuse.
#include "support/depth_picture.h"

#include "deformable_surface/base/error.h"
#include "deformable_surface/base/parallel.h"
#include "deformable_surface/cloud/equal_clouds.h"
#include "deformable_surface/io/cloud_filters.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include <algorithm>

using namespace deformable_surface;
using cloud::PointCloud;
using io::filterCloud;
using io::FilterReport;
using io::RemovedBy;
using simulation::InputFilterParams;
using Keep = simulation::PlaneFilterParams::Keep;
using Method = simulation::OutlierParams::Method;
using test::Camera;
using test::kNothing;

namespace {

enum class Thing { kTable, kTowel, kBox, kFloor };

constexpr double kTowelHeight = 0.005, kBoxHeight = 0.1, kFloorDepth = -0.7;  // m, of the table's plane

/// A camera 1 m above a table, tilted, with a towel and a box on it and the floor behind.
struct Table {
  Camera camera;
  Vec3 normal = Vec3(0.05, -0.3, -1.0).normalized();  // up from the table
  Vec3 middle{0.0, 0.0, 1.0};
  std::vector<Thing> things;  // (n) the object that the pixel shows
  PointCloud cloud;

  explicit Table(double noise = 0.0) {
    camera.width = 200;
    camera.height = 150;
    camera.focal = 280.0;
    camera.noise = noise;
    camera.step = noise > 0.0 ? 0.125 / 2.0 : 0.0;
    cloud = test::takeFrame(camera, [&](int row, int column) {
      const Vec3 ray = camera.direction(row, column);
      const auto meet = [&](double height) { return test::meetPlane(ray, normal, normal.dot(middle) + height); };
      const auto at = [&](double height) { return Vec3(meet(height) * ray - middle); };
      Thing thing = Thing::kTable;
      double height = 0.0;
      const Vec3 on_box = at(kBoxHeight), on_towel = at(kTowelHeight), on_table = at(0.0);
      if (on_box.head<2>().cwiseAbs().maxCoeff() < 0.06) {
        thing = Thing::kBox;
        height = kBoxHeight;
      } else if (std::abs(on_towel.x() + 0.2) < 0.1 && std::abs(on_towel.y()) < 0.15) {
        thing = Thing::kTowel;
        height = kTowelHeight;
      } else if (on_table.x() > 0.25) {
        thing = Thing::kFloor;
        height = kFloorDepth;
      }
      things.push_back(thing);
      return meet(height);
    });
  }

  double heightOf(const Vec3& p) const { return normal.dot(p - middle); }
  long count(Thing thing) const { return std::count(things.begin(), things.end(), thing); }
  /// The number of these pixels that the filter removed.
  long count(Thing thing, RemovedBy filter, const FilterReport& report) const {
    long sum = 0;
    for (std::size_t i = 0; i < things.size(); ++i) sum += things[i] == thing && report.removed_by[i] == filter;
    return sum;
  }
};

InputFilterParams makeCrop(const Vec3& min, const Vec3& max, bool outside = false) {
  InputFilterParams params;
  params.crop.resize(1);
  params.crop[0].region.min = min;
  params.crop[0].region.max = max;
  params.crop[0].region.outside = outside;
  return params;
}

InputFilterParams makePlane(double distance, double radius = 0.0, Keep keep = Keep::kBoth) {
  InputFilterParams params;
  params.plane = {distance, radius, 0.1, keep};
  return params;
}

InputFilterParams makeOutliers(Method method, Index neighbors, double radius, double deviations) {
  InputFilterParams params;
  params.outliers = {method, neighbors, radius, deviations};
  return params;
}

long count(const FilterReport& report, RemovedBy filter) {
  return std::count(report.removed_by.begin(), report.removed_by.end(), filter);
}

bool contains(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

PointCloud makeRow(const Points& points) {
  PointCloud cloud;
  cloud.positions = points;
  cloud.width = static_cast<std::uint32_t>(points.size());
  return cloud;
}

/// A sheet of points 0.01 m apart in z = 0.
PointCloud makeSheet(int columns = 30, int rows = 30) {
  Points points;
  for (int row = 0; row < rows; ++row)
    for (int column = 0; column < columns; ++column) points.emplace_back(0.01 * column, 0.01 * row, 0.0);
  return makeRow(points);
}

}  // namespace

TEST(FilterCloud, WithoutFiltersACloudKeepsItsBits) {
  const Table table(0.05);
  PointCloud cloud = table.cloud;
  const FilterReport report = filterCloud(InputFilterParams(), cloud);
  EXPECT_TRUE(cloud::areEqual(cloud, table.cloud));
  EXPECT_TRUE(report.notices.empty() && report.problem.empty() && report.removed_by.empty());
}

TEST(FilterCloud, PointsThatGoBecomeHolesInTheirPlaceAndTheOthersKeepTheirBits) {
  Table table(0.05);
  table.cloud.positions[7].setConstant(kNothing);
  const std::vector<std::uint8_t> fives(table.things.size(), 5);
  table.cloud.extra_fields.push_back({"intensity", cloud::ScalarType::kUint8, 1, fives});
  PointCloud cloud = table.cloud;
  const FilterReport report = filterCloud(makeCrop(Vec3(-0.1, -0.1, 0.0), Vec3(0.1, 0.1, 2.0)), cloud);
  ASSERT_EQ(cloud.size(), table.cloud.size());
  EXPECT_EQ(cloud.width, table.cloud.width);
  EXPECT_EQ(cloud.height, table.cloud.height);
  EXPECT_EQ(cloud.extra_fields.size(), 1u);
  EXPECT_EQ(report.removed_by[7], RemovedBy::kNone);
  for (Index i = 0; i < cloud.size(); ++i) {
    const Vec3& before = table.cloud.positions[i];
    const bool is_inside = std::abs(before.x()) <= 0.1 && std::abs(before.y()) <= 0.1;
    ASSERT_EQ(cloud.positions[i].allFinite(), is_inside) << i;
    if (is_inside) {
      ASSERT_EQ(cloud.positions[i], before) << i;
    } else if (i != 7) {
      ASSERT_EQ(report.removed_by[i], RemovedBy::kCrop) << i;
    }
  }
}

TEST(FilterCloud, WhatStaysLiesInEveryRegionOfTheCrop) {
  PointCloud cloud = makeSheet();
  InputFilterParams params = makeCrop(Vec3(0.0, 0.0, -1.0), Vec3(0.095, 1.0, 1.0));
  params.crop.resize(2);
  params.crop[1].region.kind = geometry::Region::Kind::kSphere;
  params.crop[1].region.radius = 0.055;
  params.crop[1].region.outside = true;
  filterCloud(params, cloud);
  const PointCloud before = makeSheet();
  for (Index i = 0; i < cloud.size(); ++i) {
    const Vec3& p = before.positions[i];
    ASSERT_EQ(cloud.positions[i].allFinite(), p.x() <= 0.095 && p.norm() > 0.055) << i;
  }
}

TEST(FilterCloud, RangeIsTheDistanceFromTheEye) {
  InputFilterParams params;
  params.range = {1.0, 1.02};
  const PointCloud before = makeSheet();
  for (const bool has_viewpoint : {true, false}) {
    PointCloud cloud = before;
    const Vec3 eye(0.15, 0.15, 1.0);
    if (has_viewpoint) {
      cloud.viewpoint = eye;
    } else {
      cloud.origin = eye;
    }
    const FilterReport report = filterCloud(params, cloud);
    long inside = 0;
    for (Index i = 0; i < cloud.size(); ++i) {
      const double distance = (before.positions[i] - eye).norm();
      ASSERT_EQ(cloud.positions[i].allFinite(), distance >= 1.0 && distance <= 1.02) << i;
      inside += cloud.positions[i].allFinite();
    }
    EXPECT_GT(inside, 100);
    EXPECT_EQ(count(report, RemovedBy::kRange), before.size() - inside);
  }
}

TEST(FilterCloud, ATableGoesAndWhatStandsOnItStays) {
  const Table table;
  PointCloud cloud = table.cloud;
  const FilterReport report = filterCloud(makePlane(0.002), cloud);
  EXPECT_EQ(table.count(Thing::kTable, RemovedBy::kPlane, report), table.count(Thing::kTable));
  for (const Thing thing : {Thing::kTowel, Thing::kBox, Thing::kFloor}) {
    ASSERT_GT(table.count(thing), 200);
    EXPECT_EQ(table.count(thing, RemovedBy::kNone, report), table.count(thing));
  }
}

TEST(FilterCloud, OneSideOfATableStaysAlone) {
  const Table table;
  PointCloud near = table.cloud, far = table.cloud;
  const FilterReport near_report = filterCloud(makePlane(0.002, 0.0, Keep::kNearSide), near);
  EXPECT_EQ(table.count(Thing::kFloor, RemovedBy::kOtherSide, near_report), table.count(Thing::kFloor));
  EXPECT_EQ(table.count(Thing::kTowel, RemovedBy::kNone, near_report), table.count(Thing::kTowel));
  const FilterReport far_report = filterCloud(makePlane(0.002, 0.0, Keep::kFarSide), far);
  EXPECT_EQ(table.count(Thing::kFloor, RemovedBy::kNone, far_report), table.count(Thing::kFloor));
  EXPECT_EQ(table.count(Thing::kTowel, RemovedBy::kOtherSide, far_report), table.count(Thing::kTowel));
  // Seen from a point in the plane, no side is near or far.
  PointCloud within = table.cloud;
  within.viewpoint = Vec3(table.middle);
  EXPECT_THROW(filterCloud(makePlane(0.002, 0.0, Keep::kNearSide), within), InputError);
  EXPECT_EQ(within.size(), table.cloud.size());
}

TEST(FilterCloud, MediansTellATowelFromTheTableUnderItWhereSinglePointsCannot) {
  const Table table(0.06);
  double sum = 0.0;
  for (std::size_t i = 0; i < table.things.size(); ++i)
    if (table.things[i] == Thing::kTable) sum += std::pow(table.heightOf(table.cloud.positions[i]), 2);
  const double noise = std::sqrt(sum / static_cast<double>(table.count(Thing::kTable)));
  ASSERT_GT(noise, 0.5 * kTowelHeight);
  ASSERT_LT(noise, kTowelHeight);

  const auto findErrors = [&](double radius) {
    PointCloud cloud = table.cloud;
    const FilterReport report = filterCloud(makePlane(0.5 * kTowelHeight, radius, Keep::kNearSide), cloud);
    const double lost = 1.0 - static_cast<double>(table.count(Thing::kTowel, RemovedBy::kNone, report)) /
                                  static_cast<double>(table.count(Thing::kTowel));
    const double left = static_cast<double>(table.count(Thing::kTable, RemovedBy::kNone, report)) /
                        static_cast<double>(table.count(Thing::kTable));
    return std::max(lost, left);
  };
  EXPECT_GT(findErrors(0.0), 0.15);
  EXPECT_LT(findErrors(0.025), 0.07);  // those at the hem
}

TEST(FilterCloud, APlaneThatFewPointsLieOnStaysWhichTheNotesSay) {
  const Table table;
  PointCloud cloud = table.cloud;
  InputFilterParams params = makePlane(0.002);
  params.plane.min_share = 0.9;
  const FilterReport report = filterCloud(params, cloud);
  EXPECT_TRUE(cloud::areEqual(cloud, table.cloud));
  ASSERT_EQ(report.notices.size(), 2u);
  EXPECT_TRUE(contains(report.notices[1], "min_share")) << report.notices[1];
  // The same plane is found, whatever number of points is requested.
  const auto beforeAccepted = [](const std::string& notice) { return notice.substr(0, notice.find("; accepted")); };
  params.plane.min_share = 1.0;
  const FilterReport all = filterCloud(params, cloud);
  ASSERT_EQ(all.notices.size(), 2u);
  EXPECT_EQ(beforeAccepted(all.notices[1]), beforeAccepted(report.notices[1]));
}

TEST(FilterCloud, PointsThatAreAloneGo) {
  const Points alone{{0.15, 0.15, 0.05}, {-0.1, 0.0, 0.0}, {0.5, 0.5, 0.0}};
  PointCloud before = makeSheet();
  before.positions.insert(before.positions.end(), alone.begin(), alone.end());
  before.width = static_cast<std::uint32_t>(before.positions.size());
  for (const InputFilterParams& params :
       {makeOutliers(Method::kRadius, 3, 0.025, 0.0), makeOutliers(Method::kStatistical, 8, 0.0, 3.0)}) {
    PointCloud cloud = before;
    const FilterReport report = filterCloud(params, cloud);
    EXPECT_EQ(count(report, RemovedBy::kOutliers), 3);
    for (Index i = 0; i < cloud.size(); ++i) ASSERT_EQ(report.removed_by[i] == RemovedBy::kOutliers, i >= cloud.size() - 3) << i;
  }
}

TEST(FilterCloud, FlyingPixelsGoOnlyInOrganisedClouds) {
  Table table;
  // Between the towel and the box, above both.
  const std::size_t pixel = 75 * 200 + 70;
  table.cloud.positions[pixel] *= 0.7;
  InputFilterParams params;
  params.flying_pixels = 0.02;
  PointCloud spike = table.cloud;
  EXPECT_EQ(count(filterCloud(params, spike), RemovedBy::kFlyingPixels), 0);  // in front of everything, not between two surfaces

  // The outline of the box, 100 mm above the table: pixels in the middle of the jump.
  long made = 0;
  for (std::size_t i = 1; i < table.things.size(); ++i) {
    if (table.things[i] == Thing::kTable && table.things[i - 1] == Thing::kBox) {
      table.cloud.positions[i] *= 0.95;
      ++made;
    }
  }
  ASSERT_GT(made, 10);
  PointCloud cloud = table.cloud;
  EXPECT_EQ(count(filterCloud(params, cloud), RemovedBy::kFlyingPixels), made);
  cloud = makeRow(table.cloud.positions);
  try {
    filterCloud(params, cloud);
    ADD_FAILURE() << "accepted";
  } catch (const InputError& error) {
    EXPECT_TRUE(contains(error.what(), "input.filter.flying_pixels: found a cloud of 30000 x 1 points")) << error.what();
  }
}

TEST(FilterCloud, FlyingPixelsGoAlsoWhereOtherFiltersTakeTheBackground) {
  Table table;
  std::vector<std::size_t> made;  // pixels between the box and the table
  double farthest = 0.0;          // of them
  for (std::size_t i = 1; i < table.things.size(); ++i) {
    if (table.things[i] != Thing::kTable || table.things[i - 1] != Thing::kBox) continue;
    table.cloud.positions[i] *= 0.95;
    farthest = std::max(farthest, table.cloud.positions[i].norm());
    made.push_back(i);
  }
  ASSERT_GT(made.size(), 10u);
  InputFilterParams alone;
  alone.flying_pixels = 0.02;
  InputFilterParams ranged = alone, cropped = alone;
  ranged.range.max = farthest + 1e-6;
  cropped.crop.resize(1);
  cropped.crop[0].region.kind = geometry::Region::Kind::kSphere;
  cropped.crop[0].region.radius = farthest + 1e-6;
  for (const InputFilterParams& params : {alone, ranged, cropped}) {
    PointCloud cloud = table.cloud;
    const FilterReport report = filterCloud(params, cloud);
    EXPECT_EQ(count(report, RemovedBy::kFlyingPixels), static_cast<long>(made.size()));
    for (const std::size_t i : made) EXPECT_EQ(report.removed_by[i], RemovedBy::kFlyingPixels) << i;
  }
}

TEST(FilterCloud, FiltersFollowOneAnotherAndTheNotesCountWhatEachTook) {
  const Table table(0.03);
  InputFilterParams params = makePlane(0.0025, 0.02, Keep::kNearSide);
  params.crop = makeCrop(Vec3(-0.28, -2.0, 0.0), Vec3(2.0, 2.0, 5.0)).crop;
  params.range.max = 1.6;
  params.flying_pixels = 0.05;
  params.outliers = {Method::kRadius, 6, 0.02, 0.0};
  PointCloud cloud = table.cloud;
  const FilterReport report = filterCloud(params, cloud);
  const std::string& note = report.notices.at(0);
  for (const auto& [filter, name] : std::vector<std::pair<RemovedBy, std::string>>{
           {RemovedBy::kCrop, "crop "}, {RemovedBy::kRange, "range "}, {RemovedBy::kPlane, "plane "}}) {
    EXPECT_GT(count(report, filter), 0) << name;
    EXPECT_TRUE(contains(note, name + std::to_string(count(report, filter)))) << note;
  }
  EXPECT_TRUE(contains(note, "before: " + std::to_string(cloud.size()) + " points, ")) << note;
  EXPECT_TRUE(contains(note, "after: " + std::to_string(count(report, RemovedBy::kNone)) + " points, ")) << note;
  // The remaining part of the scene: the towel and the box.
  EXPECT_LT(table.count(Thing::kTable, RemovedBy::kNone, report), 0.02 * static_cast<double>(table.count(Thing::kTable)));
  EXPECT_EQ(table.count(Thing::kFloor, RemovedBy::kNone, report), 0);
  EXPECT_EQ(table.count(Thing::kBox, RemovedBy::kNone, report), table.count(Thing::kBox));
}

TEST(FilterCloud, TheSameCloudGivesTheSameBitsWithAnyNumberOfThreadsAndFarFromTheOrigin) {
  const Table table(0.05);
  InputFilterParams params = makePlane(0.0025, 0.02);
  params.outliers = {Method::kStatistical, 8, 0.0, 2.0};
  params.flying_pixels = 0.01;
  std::vector<RemovedBy> first;
  for (const int threads : {1, 2, 3}) {
    setNumThreads(threads);
    PointCloud cloud = table.cloud;
    const FilterReport report = filterCloud(params, cloud);
    if (threads == 1) first = report.removed_by;
    EXPECT_EQ(report.removed_by, first) << threads;
  }
  setNumThreads(0);
  const Vec3 far(2e5, -3e5, 1e5);
  PointCloud moved = table.cloud;
  for (Vec3& p : moved.positions) p += far;
  moved.origin += far;
  const FilterReport report = filterCloud(params, moved);
  long others = 0;
  for (std::size_t i = 0; i < first.size(); ++i) others += report.removed_by[i] != first[i];
  EXPECT_LT(others, 0.001 * static_cast<double>(first.size()));  // rounding of points at a limit
}

TEST(FilterCloud, WhatLeavesTooFewPointsIsRefusedWithTheCounts) {
  PointCloud cloud = makeSheet();
  const FilterReport none = filterCloud(makePlane(0.001), cloud);
  EXPECT_TRUE(contains(none.problem, "found 900 points, of which 0 stay (taken away: plane 900); accepted: ")) << none.problem;
  cloud = makeSheet();
  const FilterReport two = filterCloud(makeCrop(Vec3(-1, -1, -1), Vec3(0.015, 0.005, 1)), cloud);
  EXPECT_TRUE(contains(two.problem, "of which 2 stay (taken away: crop 898)")) << two.problem;
  cloud = makeSheet();
  EXPECT_TRUE(filterCloud(makeCrop(Vec3(-1, -1, -1), Vec3(0.025, 0.005, 1)), cloud).problem.empty());
}

TEST(FilterCloud, OddCloudsNeitherCrashNorLoop) {
  const Vec3 nothing = Vec3::Constant(kNothing), infinite = Vec3::Constant(std::numeric_limits<double>::infinity());
  const std::vector<Points> clouds{{},
                                   {nothing},
                                   {nothing, infinite, Vec3(0, 0, kNothing)},
                                   {Vec3::Zero()},
                                   {Vec3::Zero(), Vec3::Ones()},
                                   Points(50, Vec3::Ones()),
                                   {Vec3::Zero(), Vec3(1, 0, 0), Vec3(2, 0, 0), Vec3(3, 0, 0), Vec3(4, 0, 0)},
                                   {Vec3::Zero(), Vec3(1, 0, 0), Vec3(0, 1, 0)},
                                   {Vec3::Constant(1e300), Vec3::Constant(-1e300), Vec3(1e300, 0, 0), Vec3(0, 1e-300, 0)}};
  for (const Points& points : clouds) {
    for (InputFilterParams params : {makePlane(0.01), makePlane(1e6, 1e6), makeOutliers(Method::kRadius, 1000, 1e-9, 0.0),
                                     makeOutliers(Method::kStatistical, 1000, 0.0, 0.0), makeCrop(Vec3::Zero(), Vec3::Zero())}) {
      PointCloud cloud = makeRow(points);
      params.range.max = 1e8;
      const FilterReport report = filterCloud(params, cloud);
      ASSERT_EQ(cloud.positions.size(), points.size());
      ASSERT_EQ(report.removed_by.size(), points.size());
      for (std::size_t i = 0; i < points.size(); ++i)
        ASSERT_EQ(points[i].allFinite() && !cloud.positions[i].allFinite(), report.removed_by[i] != RemovedBy::kNone);
    }
  }
}

TEST(FilterCloud, AFileCanSayByWhichFilterEachPointWent) {
  const Table table;
  PointCloud cloud = table.cloud;
  const FilterReport report = filterCloud(makePlane(0.002), cloud);
  PointCloud before = table.cloud;
  before.extra_fields.push_back({"removed_by", cloud::ScalarType::kUint8, 1, std::vector<std::uint8_t>(table.things.size(), 99)});
  const PointCloud told = io::withRemovedBy(report, before);
  EXPECT_EQ(told.positions.size(), table.cloud.positions.size());
  ASSERT_EQ(told.extra_fields.size(), 2u);
  EXPECT_EQ(told.extra_fields[0].name, "removed_by");
  for (std::size_t i = 0; i < table.things.size(); ++i)
    ASSERT_EQ(told.extra_fields[0].bytes[i], table.things[i] == Thing::kTable ? 4 : 0);
  // Without a filter no point is removed.
  EXPECT_EQ(io::withRemovedBy(FilterReport(), table.cloud).extra_fields[0].bytes,
            std::vector<std::uint8_t>(table.things.size(), 0));
}
