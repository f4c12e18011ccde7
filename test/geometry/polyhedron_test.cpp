#include "deformable_surface/geometry/polyhedron.h"

#include "deformable_surface/base/error.h"
#include "deformable_surface/base/params.h"
#include "deformable_surface/geometry/solid.h"
#include "support/meshes.h"

#include <gtest/gtest.h>

#include <random>

namespace deformable_surface::test {
namespace {

using geometry::findSignedDistance;
using geometry::Polyhedron;
using geometry::SignedDistance;
using geometry::Solid;

Vec3 randomPoint(std::mt19937& random, double size) {
  std::uniform_real_distribution<double> u(-size, size);
  const double x = u(random), y = u(random), z = u(random);
  return Vec3(x, y, z);
}

double distanceToSegment(const Vec3& p, const Vec3& a, const Vec3& b) {
  const double t = std::min(1.0, std::max(0.0, (b - a).dot(p - a) / (b - a).squaredNorm()));
  return (p - a - t * (b - a)).norm();
}

// A reference without the tree: the distance over all triangles, the sign by the solid angle that the mesh fills.
double findPlainly(const Mesh& mesh, const Vec3& p) {
  double nearest = 1e300, angle = 0.0;
  for (const auto& t : mesh.triangles) {
    const Vec3 a = mesh.vertices[t[0]], b = mesh.vertices[t[1]], c = mesh.vertices[t[2]];
    const Vec3 n = (b - a).cross(c - a).normalized();
    const Vec3 foot = p - n.dot(p - a) * n;
    const bool is_over =
        n.dot((b - a).cross(foot - a)) >= 0.0 && n.dot((c - b).cross(foot - b)) >= 0.0 && n.dot((a - c).cross(foot - c)) >= 0.0;
    if (is_over) nearest = std::min(nearest, std::abs(n.dot(p - a)));
    nearest = std::min({nearest, distanceToSegment(p, a, b), distanceToSegment(p, b, c), distanceToSegment(p, c, a)});
    const Vec3 x = a - p, y = b - p, z = c - p;
    angle += 2.0 * std::atan2(x.dot(y.cross(z)),
                              x.norm() * y.norm() * z.norm() + x.dot(y) * z.norm() + y.dot(z) * x.norm() + z.dot(x) * y.norm());
  }
  return std::abs(angle) > 2.0 * M_PI ? -nearest : nearest;
}

TEST(Polyhedron, HasTheDistanceAndSideThatALookAtEveryTriangleGives) {
  std::mt19937 random(5);
  for (const Mesh& mesh : {makeBoxMesh(Vec3(0.4, 0.6, 1.0)), makeSphereMesh(0.7, 2), makeNotchedMesh()}) {
    const Polyhedron solid(mesh.vertices, mesh.triangles);
    for (int k = 0; k < 2000; ++k) {
      const Vec3 p = randomPoint(random, 1.3);
      EXPECT_NEAR(solid.findSignedDistance(p).distance, findPlainly(mesh, p), 1e-12) << p.transpose();
    }
  }
}

TEST(Polyhedron, ABoxOfTrianglesIsTheBox) {
  Solid box;
  box.kind = Solid::Kind::kBox;
  box.size = Vec3(0.4, 0.6, 1.0);
  const Mesh mesh = makeBoxMesh(box.size);
  const Polyhedron solid(mesh.vertices, mesh.triangles);
  EXPECT_NEAR(solid.volume(), 0.24, 1e-15);
  std::mt19937 random(6);
  for (int k = 0; k < 2000; ++k) {
    const Vec3 p = randomPoint(random, 1.0);
    const SignedDistance expected = findSignedDistance(box, p), found = solid.findSignedDistance(p);
    EXPECT_NEAR(found.distance, expected.distance, 1e-14);
    EXPECT_LT((found.normal - expected.normal).norm(), 1e-9) << p.transpose();
  }
}

TEST(Polyhedron, OnEdgesAndCornersTheNormalPointsOut) {
  for (const Mesh& mesh : {makeBoxMesh(Vec3(1.0, 1.0, 1.0)), makeNotchedMesh()}) {
    const Polyhedron solid(mesh.vertices, mesh.triangles);
    for (const auto& t : solid.triangles())
      for (int c = 0; c < 3; ++c) {
        const Vec3 corner = solid.vertices()[t[c]], middle = 0.5 * (corner + solid.vertices()[t[(c + 1) % 3]]);
        for (const Vec3& p : {corner, middle}) {
          const SignedDistance d = solid.findSignedDistance(p);
          EXPECT_NEAR(d.distance, 0.0, 1e-15);
          EXPECT_NEAR(d.normal.norm(), 1.0, 1e-12);
          EXPECT_GT(solid.findSignedDistance(p + 1e-3 * d.normal).distance, 0.0);
          EXPECT_LT(solid.findSignedDistance(p - 1e-3 * d.normal).distance, 0.0);
        }
      }
  }
}

TEST(Polyhedron, WindingEitherWayAndCornersGivenTwiceAreTheSameSolid) {
  const Mesh mesh = makeNotchedMesh();
  const Polyhedron solid(mesh.vertices, mesh.triangles);
  // As in STL files: three corners for every triangle. And inside out.
  Mesh soup;
  for (const auto& t : mesh.triangles) {
    const Index first = static_cast<Index>(soup.vertices.size());
    for (Index v : t) soup.vertices.push_back(mesh.vertices[v]);
    soup.triangles.push_back({first, first + 2, first + 1});
  }
  const Polyhedron other(soup.vertices, soup.triangles);
  EXPECT_EQ(other.vertices().size(), mesh.vertices.size());
  std::mt19937 random(7);
  for (int k = 0; k < 500; ++k) {
    const Vec3 p = randomPoint(random, 1.3);
    EXPECT_EQ(other.findSignedDistance(p).distance, solid.findSignedDistance(p).distance);
  }
}

std::string refusalOf(const Mesh& mesh) {
  try {
    Polyhedron(mesh.vertices, mesh.triangles);
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

TEST(Polyhedron, MeshesThatHaveNoInsideAreRefusedWithAReason) {
  const Mesh good = makeBoxMesh(Vec3(1.0, 1.0, 1.0));
  EXPECT_EQ(refusalOf(good), "");
  Mesh open = good, turned = good, flat = good, wild = good, nan = good, doubled = good;
  open.triangles.pop_back();
  EXPECT_NE(refusalOf(open).find("open mesh: 3 edges"), std::string::npos) << refusalOf(open);
  std::swap(turned.triangles[0][0], turned.triangles[0][1]);
  EXPECT_NE(refusalOf(turned).find("same direction"), std::string::npos) << refusalOf(turned);
  for (Vec3& v : flat.vertices) v.z() = 0.0;
  EXPECT_NE(refusalOf(flat), "");
  wild.triangles[3][1] = 8;
  EXPECT_NE(refusalOf(wild).find("found the corner 8 of 8 vertices"), std::string::npos) << refusalOf(wild);
  nan.vertices[2].y() = std::nan("");
  EXPECT_NE(refusalOf(nan).find("vertex 2"), std::string::npos) << refusalOf(nan);
  for (const auto& t : good.triangles) doubled.triangles.push_back(t);
  EXPECT_NE(refusalOf(doubled).find("same direction"), std::string::npos) << refusalOf(doubled);
  EXPECT_NE(refusalOf(Mesh{}), "");
}

TEST(Polyhedron, IsPrintedAndReadBackAsTheSameSolid) {
  const Mesh mesh = makeSphereMesh(0.3, 1);
  Solid solid;
  solid.kind = Solid::Kind::kMesh;
  ASSERT_EQ(geometry::setMesh(mesh.vertices, geometry::toRows(mesh.triangles), solid), "");
  Solid read;
  EXPECT_EQ(readParams(printParams(solid), read), std::vector<std::string>());
  ASSERT_TRUE(read.mesh);
  EXPECT_EQ(read.kind, Solid::Kind::kMesh);
  EXPECT_EQ(read.mesh->triangles().size(), mesh.triangles.size());
  EXPECT_EQ(findSignedDistance(read, Vec3(0.1, 0.2, 0.0)).distance, findSignedDistance(solid, Vec3(0.1, 0.2, 0.0)).distance);
  EXPECT_NEAR(geometry::findLargestExtent(read), 0.6, 0.01);
}

TEST(Polyhedron, ASceneWithAnOpenMeshOrNoneIsRefused) {
  const auto read = [](const Value& mesh) {
    Solid solid;
    Value root{Value::Map{}};
    root.set("mesh", mesh);
    return readParams(root, solid);
  };
  Value both{Value::Map{}};
  EXPECT_EQ(read(both).size(), 1u);
  const Mesh box = makeBoxMesh(Vec3(1.0, 1.0, 1.0));
  Value::List vertices, triangles;
  for (const Vec3& v : box.vertices) vertices.push_back(Value::List(v.data(), v.data() + 3));
  for (const auto& t : box.triangles) triangles.push_back(Value::List(t.begin(), t.end()));
  Value good{Value::Map{}};
  good.set("vertices", vertices);
  good.set("triangles", triangles);
  EXPECT_EQ(read(good), std::vector<std::string>());
  triangles.pop_back();
  Value open{Value::Map{}};
  open.set("vertices", vertices);
  open.set("triangles", triangles);
  ASSERT_EQ(read(open).size(), 1u);
  EXPECT_NE(read(open)[0].find("mesh: found an open mesh"), std::string::npos) << read(open)[0];
}

TEST(Polyhedron, FarPointsMayBeToldByTheirBoxAlone) {
  const Mesh mesh = makeSphereMesh(0.3, 2);
  Solid solid;
  solid.kind = Solid::Kind::kMesh;
  geometry::setMesh(mesh.vertices, geometry::toRows(mesh.triangles), solid);
  std::mt19937 random(8);
  for (int k = 0; k < 2000; ++k) {
    const Vec3 p = randomPoint(random, 0.6);
    const double exact = findSignedDistance(solid, p).distance, bounded = findSignedDistance(solid, p, 0.1).distance;
    if (exact <= 0.1)
      EXPECT_EQ(bounded, exact);
    else
      EXPECT_GT(bounded, 0.1);
  }
}

Mesh move(Mesh mesh, const Quaternion& turn, const Vec3& shift, double scale) {
  for (Vec3& v : mesh.vertices) v = scale * (turn * v + shift);
  return mesh;
}

TEST(Polyhedron, AxisPointsOfAForkAreInItsArms) {
  const double thickness = 0.01;
  const Mesh mesh = makeForkMesh(0.1, 0.2, thickness);
  const Polyhedron fork(mesh.vertices, mesh.triangles);
  ASSERT_EQ(fork.axisPoints().size(), 3u);
  for (const Vec3& p : fork.axisPoints()) EXPECT_LT(fork.findSignedDistance(p).distance, -0.45 * thickness) << p.transpose();
  EXPECT_GT(fork.findSignedDistance(Vec3::Zero()).distance, 0.0);
  EXPECT_NEAR(std::abs(fork.axisPoints()[0].x()), 0.045, 0.001);
}

TEST(Polyhedron, AxisPointsLieInANeedleWhoseOriginIsFarAndThatIsObliqueToItsFrame) {
  const double length = 0.15, radius = 0.0015;
  const Mesh mesh = makeCylinderMesh(radius, length, 12);
  const Quaternion oblique = Quaternion::FromTwoVectors(Vec3::UnitZ(), Vec3(1.0, 0.0, 1.0));
  const double end = 0.5 * length - radius;
  for (const Quaternion& turn : {Quaternion(Quaternion::Identity()), oblique})
    for (double scale : {1e-6, 1.0, 1e3}) {
      const Vec3 shift(0.3, 0.2, -0.4);
      const Mesh moved = move(mesh, turn, shift, scale);
      const Polyhedron needle(moved.vertices, moved.triangles);
      ASSERT_EQ(needle.axisPoints().size(), 3u);
      double along[3];
      for (int k = 0; k < 3; ++k) {
        const Vec3 p = turn.conjugate() * (needle.axisPoints()[k] / scale - shift);
        EXPECT_LT(p.head<2>().norm(), 0.1 * radius);
        along[k] = p.z();
      }
      EXPECT_NEAR(along[0], 0.0, radius);
      EXPECT_NEAR(std::abs(along[1]), end, radius);
      EXPECT_NEAR(along[2], -along[1], radius);
    }
}

TEST(Polyhedron, ABallOrCubeHasOneAxisPoint) {
  for (const Mesh& mesh : {makeSphereMesh(0.7, 2), makeBoxMesh(Vec3(1.0, 1.0, 1.0))}) {
    const Mesh moved = move(mesh, Quaternion::Identity(), Vec3(2.0, 3.0, 4.0), 1.0);
    const Polyhedron solid(moved.vertices, moved.triangles);
    ASSERT_EQ(solid.axisPoints().size(), 1u);
    EXPECT_LT((solid.axisPoints()[0] - Vec3(2.0, 3.0, 4.0)).norm(), 0.05);
  }
}

TEST(Polyhedron, AxisPointsLieInWedgesThatAreSharpOrThin) {
  // A long wedge whose edge is turned to every side, and a plate bent to a channel with walls of a thousandth of its width.
  for (const Mesh& mesh :
       {makePrismMesh({{0.0, 0.0}, {1.0, -0.01}, {1.0, 0.01}}, {{0, 1, 2}}, 0.3), makeForkMesh(1.0, 2.0, 1e-3)})
    for (double angle : {0.0, 0.3, 1.0, 2.0}) {
      const Quaternion turn(Eigen::AngleAxisd(angle, Vec3(1.0, 2.0, 3.0).normalized()));
      const Mesh moved = move(mesh, turn, Vec3(1.0, 1.0, 1.0), 1.0);
      const Polyhedron solid(moved.vertices, moved.triangles);
      for (const Vec3& p : solid.axisPoints()) EXPECT_LT(solid.findSignedDistance(p).distance, -1e-5) << angle;
    }
}

}  // namespace
}  // namespace deformable_surface::test
