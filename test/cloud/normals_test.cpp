// Normals against shapes whose normals are known, the rules for their side, and clouds that are no surface.
#include "deformable_surface/cloud/normals.h"

#include "deformable_surface/base/error.h"
#include "deformable_surface/base/parallel.h"
#include "deformable_surface/cloud/kd_tree.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

namespace deformable_surface::cloud {
namespace {

struct Shape {
  Points positions, normals;
  std::vector<char> is_boundary;

  void add(const Vec3& position, const Vec3& normal, bool boundary) {
    positions.push_back(position);
    normals.push_back(normal);
    is_boundary.push_back(boundary);
  }
};

void addSphere(Shape& shape, Index n, const Vec3& center, double radius) {
  for (Index i = 0; i < n; ++i) {
    const double z = 1.0 - (2.0 * i + 1.0) / n, turn = kPi * (3.0 - std::sqrt(5.0)) * i, s = std::sqrt(1.0 - z * z);
    const Vec3 normal(s * std::cos(turn), s * std::sin(turn), z);
    shape.add(center + radius * normal, normal, false);
  }
}

void addSheet(Shape& shape, Index side, const Mat3& rotation, const Vec3& center) {
  for (Index i = 0; i < side; ++i) {
    for (Index j = 0; j < side; ++j) {
      const bool edge = i == 0 || j == 0 || i == side - 1 || j == side - 1;
      const Vec3 flat((i + 0.5) / side - 0.5, (j + 0.5) / side - 0.5, 0.0);
      shape.add(center + rotation * flat, rotation.col(2), edge);
    }
  }
}

Shape makeTorus(Index around, Index across) {
  Shape shape;
  for (Index i = 0; i < around; ++i) {
    for (Index j = 0; j < across; ++j) {
      const double a = 2.0 * kPi * i / around, b = 2.0 * kPi * j / across;
      const Vec3 out(std::cos(a), std::sin(a), 0.0), normal = std::cos(b) * out + std::sin(b) * Vec3::UnitZ();
      shape.add(out + 0.35 * normal, normal, false);
    }
  }
  return shape;
}

// A rotation that is special to no axis.
Mat3 makeTilt() { return Eigen::AngleAxisd(0.7, Vec3(1.0, -2.0, 0.5).normalized()).toRotationMatrix(); }

// Estimated normals with random signs, as from an estimator that does not know the side.
Points estimateWithRandomSigns(const Shape& shape, const Lists& neighbors) {
  Points normals = estimateNormals(shape.positions, neighbors);
  std::mt19937 random(1);
  for (Vec3& n : normals) n = random() % 2 ? n : Vec3(-n);
  return normals;
}

struct Oriented {
  Points normals;
  OrientationRule rule;
};

Oriented orient(const Shape& shape, const Points& reference = {}, const std::optional<Vec3>& viewpoint = {}) {
  const Lists neighbors = nearestNeighbors(shape.positions, 12);
  Oriented result{estimateWithRandomSigns(shape, neighbors), OrientationRule::kUp};
  result.rule = orientNormals(shape.positions, neighbors, shape.is_boundary, reference, viewpoint, result.normals);
  return result;
}

// The smallest cosine between found and true normals.
double findWorstCosine(const Points& expected, const Points& found) {
  double worst = 1.0;
  for (std::size_t i = 0; i < expected.size(); ++i) worst = std::min(worst, expected[i].dot(found[i]));
  return worst;
}

TEST(EstimateNormals, AreExactOnTiltedPlanesAtEveryScaleAndPlace) {
  for (const double scale : {1e-20, 1e-3, 1.0, 1e5}) {
    Shape shape;
    addSheet(shape, 20, makeTilt(), Vec3(0.3, -0.2, 0.1));
    for (Vec3& p : shape.positions) p *= scale;
    const Points normals = estimateNormals(shape.positions, nearestNeighbors(shape.positions, 16));
    for (const Vec3& n : normals) {
      EXPECT_NEAR(1.0, n.norm(), 1e-14);
      EXPECT_LT(n.cross(makeTilt().col(2)).norm(), 1e-12) << "scale " << scale;
    }
  }
}

TEST(EstimateNormals, KeepTheirDigitsFarFromTheOrigin) {
  Shape shape;
  addSheet(shape, 20, makeTilt(), Vec3(1e6, -1e6, 1e6));
  for (const Vec3& n : estimateNormals(shape.positions, nearestNeighbors(shape.positions, 16))) {
    EXPECT_LT(n.cross(makeTilt().col(2)).norm(), 1e-7);  // the coordinates themselves are rounded to 1e-10, 1e-9 of the spacing
  }
}

TEST(EstimateNormals, ConvergeOnSphere) {
  double error[2];
  for (int level = 0; level < 2; ++level) {
    Shape shape;
    addSphere(shape, level == 0 ? 500 : 8000, Vec3::Zero(), 1.0);
    const Points normals = estimateNormals(shape.positions, nearestNeighbors(shape.positions, 12));
    error[level] = 0.0;
    for (std::size_t i = 0; i < normals.size(); ++i) error[level] += normals[i].cross(shape.normals[i]).norm() / normals.size();
  }
  EXPECT_LT(error[0], 0.03);            // far below the 0.16 between neighbouring points
  EXPECT_LT(error[1], 0.3 * error[0]);  // a quarter of the spacing; a quarter of the error at first order
}

TEST(EstimateNormals, ArePerpendicularToLinesAndSlivers) {
  const Vec3 along = makeTilt().col(0);
  for (const double width : {0.0, 1e-9, 1e-5}) {
    Points points;
    for (int i = 0; i < 60; ++i) points.push_back(along * (0.1 * i) + makeTilt().col(1) * (width * ((i * i) % 7)));
    for (const Vec3& n : estimateNormals(points, nearestNeighbors(points, 8))) {
      EXPECT_NEAR(1.0, n.norm(), 1e-14);
      EXPECT_LT(std::abs(n.dot(along)), 1e-4);
      if (width == 1e-5) {
        EXPECT_GT(std::abs(n.dot(makeTilt().col(2))), 0.999);
      }
    }
  }
}

// Two sheets whose points are displaced in their plane; the spacing is 1.
Shape makeLayers(double gap, double jitter, std::uint32_t seed) {
  Shape shape;
  std::mt19937 random(seed);
  const auto draw = [&] { return jitter * (2.0 * random() / 4294967296.0 - 1.0); };
  for (int layer = 0; layer < 2; ++layer)
    for (Index i = 0; i < 10; ++i)
      for (Index j = 0; j < 6; ++j) shape.add(Vec3(i + draw(), j + draw(), gap * layer), Vec3::UnitZ(), true);
  return shape;
}

// Neighbourhoods of 32 points at the edge of one sheet reach to the other one.
TEST(EstimateNormalsInSpace, AreThoseOfEachLayer) {
  double tilted_before = 1.0;
  for (const double gap : {1.5, 2.0, 2.5, 3.0, 4.0})
    for (const double jitter : {0.0, 0.15, 0.3}) {
      const Shape shape = makeLayers(gap, jitter, 1);
      const Lists neighbors = nearestNeighbors(shape.positions, 32);
      for (const Vec3& n : estimateNormalsInSpace(shape.positions, neighbors).normals) {
        ASSERT_GT(std::abs(n.z()), jitter > 0.2 && gap < 2.0 ? 0.9 : 0.9999) << gap << ' ' << jitter;
      }
      for (const Vec3& n : estimateNormals(shape.positions, neighbors)) tilted_before = std::min(tilted_before, std::abs(n.z()));
    }
  EXPECT_LT(tilted_before, 0.1);  // 84 degrees
}

// The sides of a simulation are found once: only lists that change later need other normals.
TEST(EstimateNormalsInSpace, TellWhichComeFromAPartOfTheNeighboursAlone) {
  const Shape shape = makeLayers(3.5, 0.15, 1);
  const Lists neighbors = nearestNeighbors(shape.positions, 32);
  const NormalsInSpace found = estimateNormalsInSpace(shape.positions, neighbors);
  const Points all = estimateNormals(shape.positions, neighbors);
  ASSERT_EQ(shape.positions.size(), found.is_own.size());
  const auto num_own = std::count(found.is_own.begin(), found.is_own.end(), 1);
  EXPECT_GT(num_own, 0);
  EXPECT_LT(num_own, static_cast<std::ptrdiff_t>(all.size()));
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (found.is_own[i]) continue;
    EXPECT_EQ(all[i], found.normals[i]) << i;
  }
  Points completed = found.normals;
  estimateNormals(shape.positions, neighbors, found.is_own, completed);
  EXPECT_EQ(all, completed);
}

// Two half planes of 10 x 12 points at a right angle; the crease is a quarter of a spacing from a row. At it, the plane of all
// neighbours is neither.
TEST(EstimateNormalsInSpace, TellTheSidesOfACrease) {
  Shape shape;
  for (Index i = 0; i < 10; ++i)
    for (Index j = 0; j < 12; ++j) {
      shape.add(Vec3(-0.25 - i, j, 0.0), Vec3::UnitZ(), true);
      shape.add(Vec3(0.0, j, 0.75 + i), Vec3::UnitX(), true);
    }
  const NormalsInSpace found = estimateNormalsInSpace(shape.positions, nearestNeighbors(shape.positions, 32));
  ASSERT_EQ(shape.positions.size(), found.at_creases.size());
  double steepest = 1.0;
  for (std::size_t i = 0; i < shape.positions.size(); ++i) {
    EXPECT_GT(std::abs(found.at_creases[i].dot(shape.normals[i])), 0.97) << i;
    steepest = std::min(steepest, std::abs(found.normals[i].dot(shape.normals[i])));
  }
  EXPECT_LT(steepest, 0.9);
}

// The rings of a tube lie farther apart than their points: each is flatter than the tube, and is no layer.
TEST(EstimateNormalsInSpace, TakeRowsOfATubeForOneSurface) {
  for (const double along : {1.0, 1.4, 1.8, 2.2}) {
    Shape tube;
    const Index around = 20;
    const double radius = around / (2.0 * kPi);
    for (Index ring = 0; ring < 10; ++ring)
      for (Index i = 0; i < around; ++i) {
        const double angle = 2.0 * kPi * i / around;
        const Vec3 normal(std::cos(angle), std::sin(angle), 0.0);
        tube.add(radius * normal + along * ring * Vec3::UnitZ(), normal, ring == 0 || ring == 9);
      }
    const Lists neighbors = nearestNeighbors(tube.positions, 32);
    const Points expected = estimateNormals(tube.positions, neighbors),
                 found = estimateNormalsInSpace(tube.positions, neighbors).normals;
    for (std::size_t i = 0; i < found.size(); ++i) ASSERT_EQ(found[i], expected[i]) << along << ' ' << i;
  }
}

TEST(EstimateNormalsInSpace, AreThoseOfAllNeighboursOnASurface) {
  Shape shape = makeTorus(40, 14);
  addSphere(shape, 150, Vec3(5.0, 0.0, 0.0), 1.0);
  const Lists neighbors = nearestNeighbors(shape.positions, 32);
  EXPECT_EQ(estimateNormalsInSpace(shape.positions, neighbors).normals, estimateNormals(shape.positions, neighbors));
}

TEST(Normals, AreUnitOnCloudsWithoutSurface) {
  const std::vector<Points> clouds = {
      {},
      {{1, 2, 3}},
      {{1, 2, 3}, {1, 2, 4}},
      {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}},
      Points(100, Vec3(1, 1, 1)),
      {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1e20, 1e20, 1e20}, {-1e20, 0, 0}},
      {{1e-25, 0, 0}, {0, 1e-25, 0}, {0, 0, 0}, {1e-25, 1e-25, 0}},
      {{1e6, 1e6, 1e6}, {1e6 + 1e-3, 1e6, 1e6}, {1e6, 1e6 + 1e-3, 1e6}, {1e6, 1e6, 1e6 + 1e-3}},
  };
  for (std::size_t c = 0; c < clouds.size(); ++c) {
    Shape shape;
    for (const Vec3& p : clouds[c]) shape.add(p, Vec3::UnitZ(), false);
    for (const std::optional<Vec3>& viewpoint : {std::optional<Vec3>(), std::optional<Vec3>(Vec3(1, 2, 3))}) {
      for (const Vec3& n : orient(shape, {}, viewpoint).normals) EXPECT_NEAR(1.0, n.norm(), 1e-12) << "cloud " << c;
    }
  }
}

TEST(OrientNormals, PointOutwardOnClosedSurfacesOfEveryGenus) {
  Shape sphere;
  addSphere(sphere, 2000, Vec3(3, 4, 5), 0.5);
  const Oriented on_sphere = orient(sphere);
  EXPECT_GT(findWorstCosine(sphere.normals, on_sphere.normals), 0.99);
  EXPECT_EQ(OrientationRule::kOutward, on_sphere.rule);

  const Shape torus = makeTorus(80, 28);
  const Oriented on_torus = orient(torus);
  EXPECT_GT(findWorstCosine(torus.normals, on_torus.normals), 0.95);
  EXPECT_EQ(OrientationRule::kOutward, on_torus.rule);
}

TEST(OrientNormals, PointUpOnOpenSheets) {
  Shape sheet;
  addSheet(sheet, 25, makeTilt(), Vec3(0, 0, -7));
  const Oriented result = orient(sheet);
  EXPECT_GT(findWorstCosine(sheet.normals, result.normals), 0.999);
  EXPECT_EQ(OrientationRule::kUp, result.rule);
}

TEST(OrientNormals, PointAlongYOnSheetsThatStandUpright) {
  Shape sheet;
  Mat3 upright;
  upright.col(0) = Vec3(0.6, -0.8, 0.0);
  upright.col(1) = Vec3::UnitZ();
  upright.col(2) = Vec3(0.8, 0.6, 0.0);
  upright.col(0) = upright.col(1).cross(upright.col(2));
  addSheet(sheet, 15, upright, Vec3::Zero());
  EXPECT_GT(findWorstCosine(sheet.normals, orient(sheet).normals), 0.999);
}

TEST(OrientNormals, PointTowardsTheViewpointOfOpenScans) {
  Shape sheet;
  addSheet(sheet, 25, Mat3::Identity(), Vec3::Zero());
  const Oriented from_below = orient(sheet, {}, Vec3(0.5, 0.0, -2.0));
  EXPECT_LT(from_below.normals[0].z(), -0.999);
  EXPECT_LT(findWorstCosine(from_below.normals, sheet.normals), -0.999);
  EXPECT_EQ(OrientationRule::kViewpoint, from_below.rule);
}

TEST(OrientNormals, FollowTheMajorityOfReferenceNormals) {
  Shape sphere;
  addSphere(sphere, 1000, Vec3::Zero(), 1.0);
  Points reference(1000, Vec3::Zero());
  for (Index i = 0; i < 1000; i += 10) reference[i] = -sphere.normals[i];
  for (Index i = 0; i < 1000; i += 30) reference[i] = sphere.normals[i];  // a third of the votes is wrong
  const Oriented result = orient(sphere, reference, Vec3(0, 0, 10));
  for (Index i = 0; i < 1000; ++i) ASSERT_LT(result.normals[i].dot(sphere.normals[i]), -0.99);
  EXPECT_EQ(OrientationRule::kInputNormals, result.rule);
}

TEST(OrientNormals, DecideEachComponentForItself) {
  Shape two;
  addSphere(two, 600, Vec3(0, 0, 0), 1.0);
  addSheet(two, 20, makeTilt(), Vec3(0, 0, 8));
  addSphere(two, 900, Vec3(9, 0, 0), 1.0);
  const Oriented result = orient(two);
  EXPECT_GT(findWorstCosine(two.normals, result.normals), 0.98);
  EXPECT_EQ(OrientationRule::kOutward, result.rule);
}

// A lens whose sides are less than a spacing apart: in space most neighbours are on the other side.
TEST(OrientNormals, GivenNormalsTellTheSidesOfAThinBodyAndAWrongOneIsTurned) {
  Shape lens;
  addSphere(lens, 600, Vec3::Zero(), 1.0);
  constexpr double kFlatness = 0.04;
  for (std::size_t i = 0; i < lens.positions.size(); ++i) {
    lens.positions[i].z() *= kFlatness;
    lens.normals[i].z() /= kFlatness;
    lens.normals[i].normalize();
  }
  const Lists neighbors = nearestNeighbors(lens.positions, 16);
  Points given = lens.normals, normals = lens.normals;
  given[300] = -given[300];
  for (std::size_t i = 0; i < normals.size(); i += 3) normals[i] = -normals[i];  // as an estimate leaves them
  orientNormals(lens.positions, neighbors, std::vector<char>(600, 0), given, {}, normals);
  for (std::size_t i = 0; i < normals.size(); ++i) EXPECT_GT(normals[i].dot(lens.normals[i]), 0.0) << i;
}

// A tube about a trefoil knot: its parts pass each other at about two distances of the samples, too few to tell them apart by the
// normals of neighbours alone.
Shape makeKnot(int along, int around, double radius, double shake) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> shift(-shake, shake);
  const auto at = [](double t) {
    return Vec3((2.0 + std::cos(3.0 * t)) * std::cos(2.0 * t), (2.0 + std::cos(3.0 * t)) * std::sin(2.0 * t), std::sin(3.0 * t));
  };
  Shape knot;
  for (int i = 0; i < along; ++i) {
    for (int j = 0; j < around; ++j) {
      const double t = 2.0 * kPi * (i + shift(random)) / along, angle = 2.0 * kPi * (j + shift(random)) / around;
      const Vec3 tangent = (at(t + 1e-4) - at(t - 1e-4)).normalized();
      const Vec3 side = (Vec3::UnitZ() - tangent.z() * tangent).normalized();
      const Vec3 normal = std::cos(angle) * side + std::sin(angle) * tangent.cross(side);
      knot.add(at(t) + radius * normal, normal, false);
    }
  }
  return knot;
}

// Thin: a tenth of its width, two rows of samples across each rim.
Shape makePlate(int side) {
  Shape plate;
  const double thickness = 2.0 / side;
  for (int i = 0; i <= side; ++i) {
    for (int j = 0; j <= side; ++j)
      for (const double up : {-1.0, 1.0})
        plate.add(Vec3(double(i) / side, double(j) / side, 0.5 * up * thickness), up * Vec3::UnitZ(), false);
    for (const double out : {-1.0, 1.0}) {
      plate.add(Vec3(double(i) / side, 0.5 + 0.5 * out, 0.0), out * Vec3::UnitY(), false);
      if (i > 0 && i < side) plate.add(Vec3(0.5 + 0.5 * out, double(i) / side, 0.0), out * Vec3::UnitX(), false);
    }
  }
  return plate;
}

Index countTurned(const Shape& shape, const Points& normals) {
  Index turned = 0;
  for (std::size_t i = 0; i < normals.size(); ++i) turned += normals[i].dot(shape.normals[i]) < 0.0;
  return std::min(turned, static_cast<Index>(normals.size()) - turned);
}

TEST(OrientNormals, MirroredLinksTellTheSidesOfSparseKnotsAndPlatesFlatOnesDoNot) {
  Index flat = 0, mirrored = 0;
  for (const Shape& shape : {makeKnot(60, 10, 0.4, 0.2), makeKnot(80, 12, 0.4, 0.3), makePlate(14), makePlate(20)}) {
    Index turned[2];
    for (const SideLinks links : {SideLinks::kFlat, SideLinks::kMirrored}) {
      Points normals = estimateNormals(shape.positions, nearestNeighbors(shape.positions, 6));
      orientNormals(shape.positions, nearestNeighbors(shape.positions, 12), shape.is_boundary, {}, {}, normals, links);
      turned[links == SideLinks::kMirrored] = countTurned(shape, normals);
    }
    EXPECT_LE(turned[1], static_cast<Index>(shape.positions.size()) / 100);
    flat += turned[0];
    mirrored += turned[1];
  }
  EXPECT_GT(flat, 50 * mirrored);
}

TEST(FitNormals, AreBetterThanThoseOfFewNeighboursAndKeepTheirSide) {
  const auto findAngle = [](const Shape& shape, const Points& normals) {
    double sum = 0.0;
    for (std::size_t i = 0; i < normals.size(); ++i) sum += std::acos(std::clamp(normals[i].dot(shape.normals[i]), -1.0, 1.0));
    return sum / static_cast<double>(normals.size());
  };
  for (const Shape& shape : {makeKnot(60, 10, 0.4, 0.2), makeKnot(90, 14, 0.4, 0.3)}) {
    Points normals = estimateNormals(shape.positions, nearestNeighbors(shape.positions, 6));
    for (std::size_t i = 0; i < normals.size(); ++i)
      if (normals[i].dot(shape.normals[i]) < 0.0) normals[i] = -normals[i];
    const Points fitted = fitNormals(shape.positions, nearestNeighbors(shape.positions, 12), normals);
    EXPECT_LT(findAngle(shape, fitted), 0.6 * findAngle(shape, normals));
  }
}

TEST(FitNormals, StayWhereFewNeighboursAreOnTheSameSide) {
  const Points line{Vec3::Zero(), Vec3(1.0, 0.0, 0.0), Vec3(2.0, 0.0, 0.0)}, normals(3, Vec3::UnitZ());
  EXPECT_EQ(fitNormals(line, nearestNeighbors(line, 2), normals), normals);
}

TEST(OrientNormals, DoNotDependOnTheNumberOfThreads) {
  const Shape torus = makeTorus(90, 40);
  setNumThreads(1);
  const Points one = orient(torus).normals;
  setNumThreads(3);
  const Points three = orient(torus).normals;
  setNumThreads(0);
  EXPECT_EQ(one, three);
}

// No sides agree along all links of a strip with half a turn, so that the flattest decide, in the order of their flatness.
TEST(OrientNormals, DoNotDependOnTheNumberOfThreadsWhereNoSidesAgree) {
  Points positions;
  std::mt19937 random(1);
  std::uniform_real_distribution<double> jitter(-0.2, 0.2);
  constexpr Index kAlong = 1500, kAcross = 12;
  for (Index i = 0; i < kAlong; ++i) {
    for (Index j = 0; j < kAcross; ++j) {
      const double turn = 2.0 * kPi * (i + jitter(random)) / kAlong, across = (j + jitter(random)) / kAlong * 6.0 - 0.02;
      const double radius = 1.0 + across * std::cos(0.5 * turn);
      positions.emplace_back(radius * std::cos(turn), radius * std::sin(turn), across * std::sin(0.5 * turn));
    }
  }
  const Lists neighbors = nearestNeighbors(positions, 16);
  const Points estimated = estimateNormals(positions, neighbors);
  const std::vector<char> is_boundary(positions.size(), 0);
  std::vector<Points> found;
  for (const int threads : {1, 2, 5}) {
    setNumThreads(threads);
    found.push_back(estimated);
    orientNormals(positions, neighbors, is_boundary, {}, std::nullopt, found.back());
  }
  setNumThreads(0);
  EXPECT_EQ(found[0], found[1]);
  EXPECT_EQ(found[0], found[2]);
  Index opposed = 0;
  for (Index i = 0; i < neighbors.size(); ++i)
    for (const Index* j = neighbors.begin(i); j != neighbors.end(i); ++j) opposed += found[0][i].dot(found[0][*j]) < -0.5;
  EXPECT_GT(opposed, 0);
}

TEST(Normals, RefuseArraysOfDifferentSizes) {
  Shape sheet;
  addSheet(sheet, 5, Mat3::Identity(), Vec3::Zero());
  const Lists neighbors = nearestNeighbors(sheet.positions, 6);
  EXPECT_THROW(estimateNormals(Points(24, Vec3::Zero()), neighbors), InputError);
  EXPECT_THROW(orientNormals(sheet.positions, neighbors, {}, {}, {}, sheet.normals), InputError);
  EXPECT_THROW(orientNormals(sheet.positions, neighbors, sheet.is_boundary, Points(3), {}, sheet.normals), InputError);
}

TEST(EstimateNormals, RefusePointsThatAreNotFinite) {
  Points points = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  const Lists neighbors = nearestNeighbors(points, 2);
  points[1].x() = std::nan("");
  EXPECT_THROW(estimateNormals(points, neighbors), InputError);
}

TEST(Normals, FaceTheEyeOneByOne) {
  const Points positions{Vec3(0.0, 0.0, 1.0), Vec3(0.5, 0.0, 2.0)};
  Points normals{Vec3::UnitZ(), -Vec3::UnitZ()};
  faceEye(positions, Vec3::Zero(), normals);
  EXPECT_EQ(normals[0], Vec3(-Vec3::UnitZ()));
  EXPECT_EQ(normals[1], Vec3(-Vec3::UnitZ()));
}

}  // namespace
}  // namespace deformable_surface::cloud
