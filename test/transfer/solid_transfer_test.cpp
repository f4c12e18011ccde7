#include "deformable_surface/transfer/solid_transfer.h"
#include "../model/solids.h"

#include <gtest/gtest.h>

namespace deformable_surface::test {
namespace {

struct Followers {
  Points dense, normals, simulation;
  transfer::SolidTransfer transfer;
};

Followers makeFollowers(Index n, Index k = 16) {
  Followers f;
  f.simulation = makeBox(n, n, n, 1.0 / (n - 1), 0.2);
  f.dense = makeBox(13, 13, 13, 1.0 / 12.0, 0.3, 9);
  f.dense.insert(f.dense.end(), f.simulation.begin(), f.simulation.end());
  f.normals.assign(f.dense.size(), Vec3(0.0, 0.6, 0.8));
  f.normals[0].setZero();
  const cloud::KdTree tree(f.simulation);
  Lists followed;
  std::vector<cloud::Neighbor> near;
  for (const Vec3& x : f.dense) {
    tree.nearest(x, k, near);
    for (const cloud::Neighbor& other : near) followed.items.push_back(other.index);
    followed.offsets.push_back(static_cast<Index>(followed.items.size()));
  }
  f.transfer = transfer::SolidTransfer(f.dense, f.normals, f.simulation, followed);
  return f;
}

TEST(SolidTransfer, IsExactForLinearMotions) {
  const Followers f = makeFollowers(5);
  Mat3 map = someRotation();
  map.col(1) *= 1.2;
  Points moved = f.simulation, now;
  for (Vec3& p : moved) p = map * p + Vec3(1.0, 2.0, 3.0);
  std::vector<Eigen::Vector3f> normals;
  f.transfer.apply(moved, now, &normals);
  const Vec3 expected = (map.inverse().transpose() * Vec3(0.0, 0.6, 0.8)).normalized();
  for (std::size_t i = 0; i < now.size(); ++i) {
    EXPECT_LT((now[i] - (map * f.dense[i] + Vec3(1.0, 2.0, 3.0))).norm(), 1e-11) << i;
    if (i > 0) {
      EXPECT_LT((normals[i].cast<double>() - expected).norm(), 1e-6) << i;
    }
  }
  EXPECT_EQ(normals[0], Eigen::Vector3f::Zero());  // a point without a normal gets none
}

TEST(SolidTransfer, IsTheRestAtRestToTheBit) {
  const Followers f = makeFollowers(5);
  Points now;
  f.transfer.apply(f.simulation, now, nullptr);
  EXPECT_EQ(now, f.dense);
}

TEST(SolidTransfer, MovesSimulationPointsAsTheyMove) {
  const Followers f = makeFollowers(5);
  Points moved = f.simulation, now;
  std::mt19937 generator(4);
  for (Vec3& p : moved) p += 0.1 * randomVector(generator);
  f.transfer.apply(moved, now, nullptr);
  const std::size_t first = f.dense.size() - f.simulation.size();
  for (std::size_t i = 0; i < f.simulation.size(); ++i) EXPECT_LT((now[first + i] - moved[i]).norm(), 1e-9);
}

// A quadratic motion: twice as many points along each edge, a quarter of the error.
TEST(SolidTransfer, IsOfSecondOrder) {
  const auto errorOf = [](Index n) {
    const Followers f = makeFollowers(n);
    const auto bend = [](const Vec3& p) { return Vec3(p.x() - p.x() * p.z(), p.y(), p.z() + 0.5 * p.x() * p.x()); };
    Points moved = f.simulation, now;
    for (Vec3& p : moved) p = bend(p);
    f.transfer.apply(moved, now, nullptr);
    double sum = 0.0;
    for (std::size_t i = 0; i < now.size(); ++i) sum += (now[i] - bend(f.dense[i])).squaredNorm();
    return std::sqrt(sum / static_cast<double>(now.size()));
  };
  const double coarse = errorOf(5), fine = errorOf(9);
  EXPECT_GT(coarse / fine, 3.0);
  EXPECT_LT(coarse, 0.01);  // of a metre: h^2 / 2 of the curvature of one is 0.03
}

}  // namespace
}  // namespace deformable_surface::test
