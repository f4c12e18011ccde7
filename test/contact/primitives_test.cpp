// Near pairs of primitives, against a look at all.
#include "deformable_surface/contact/primitives.h"

#include "deformable_surface/contact/closest_points.h"

#include <gtest/gtest.h>

#include <set>

#include "folded_sheets.h"

namespace deformable_surface::contact {
namespace {

using Found = std::vector<std::array<Index, 2>>;

Box grow(const Points& points, double by) {
  Box box;
  for (const Vec3& p : points) box.extend(p);
  return {box.min() - Vec3::Constant(by), box.max() + Vec3::Constant(by)};
}

// Random primitives of n in all; some are degenerate.
template <std::size_t kCorners>
struct Some {
  Points points;
  std::vector<std::array<Index, kCorners>> corners;
  Primitives primitives{static_cast<int>(kCorners)};

  Some(Index n, double aside, std::mt19937& generator) {
    for (Index i = 0; i < n; ++i) {
      const Vec3 at = test::randomVector(generator) + aside * Vec3::UnitX();
      std::array<Index, kCorners> own;
      for (Index& c : own) {
        c = static_cast<Index>(points.size());
        points.push_back(at + (i % 7 == 6 ? Vec3::Zero() : Vec3(0.5 * test::randomVector(generator))));
      }
      if (i % 5 == 4) points.back() = 2.0 * points[own[kCorners / 2]] - points[own[0]];  // a triangle becomes a line
      corners.push_back(own);
    }
    make();
  }
  void make() {
    primitives.clear();
    for (std::size_t i = 0; i < corners.size(); ++i) primitives.add(static_cast<Index>(i), corners[i].data(), points);
    primitives.end();
  }
};

double findDistance(const Some<1>& one, Index i, const Some<3>& other, Index j) {
  const auto& [a, b, c] = other.corners[j];
  return findClosestToTriangle(one.points[one.corners[i][0]], other.points[a], other.points[b], other.points[c]).gap.norm();
}

double findDistance(const Some<2>& one, Index i, const Some<2>& other, Index j) {
  const auto& [p, q] = one.corners[i];
  const auto& [a, b] = other.corners[j];
  return findClosestOfEdges(one.points[p], one.points[q], other.points[a], other.points[b]).gap.norm();
}

template <class One, class Other>
Index compare(const One& one, const Other& other, double reach, Primitives::Scratch& scratch) {
  Found found;
  one.primitives.visitNear(grow(one.points, reach), other.primitives, grow(other.points, reach), reach, scratch,
                           [&](Index i, Index j) {
                             found.push_back({i, j});
                           });
  EXPECT_TRUE(std::is_sorted(found.begin(), found.end()));
  const std::set<std::array<Index, 2>> all(found.begin(), found.end());
  EXPECT_EQ(all.size(), found.size());
  const bool is_same = static_cast<const void*>(&one) == &other;
  Index num = 0;
  for (Index i = 0; i < one.primitives.size(); ++i)
    for (Index j = is_same ? i + 1 : 0; j < other.primitives.size(); ++j) {
      const double distance = findDistance(one, i, other, j);
      const bool is_found = all.count({i, j}) > 0;
      EXPECT_TRUE(is_found || !(distance < reach)) << i << " " << j << " " << distance;
      EXPECT_TRUE(!is_found || distance < 1.00001 * reach) << i << " " << j << " " << distance;
      num += is_found;
    }
  EXPECT_EQ(num, static_cast<Index>(found.size()));
  return num;
}

TEST(Primitives, AreFoundWhereTheyAreNear) {
  std::mt19937 generator(4);
  Primitives::Scratch scratch;
  Index num_of_triangles = 0, num_of_edges = 0;
  for (int trial = 0; trial < 200; ++trial) {
    const double reach = 0.02 + 0.003 * trial, aside = 0.02 * (trial % 50);
    const Some<1> vertices(1 + trial % 43, 0.0, generator);
    const Some<3> triangles(1 + trial % 30, aside, generator);
    num_of_triangles += compare(vertices, triangles, reach, scratch);
    const Some<2> edges(1 + trial % 37, 0.0, generator), others(1 + trial % 11, aside, generator);
    num_of_edges += compare(edges, others, reach, scratch) + compare(edges, edges, reach, scratch);
  }
  EXPECT_GT(num_of_triangles, 1000);
  EXPECT_GT(num_of_edges, 1000);
}

TEST(Primitives, MayBeMadeAgain) {
  std::mt19937 generator(8);
  Primitives::Scratch scratch;
  Some<2> edges(40, 0.0, generator);
  const Some<2> others(20, 0.5, generator);
  compare(edges, others, 0.3, scratch);
  edges.corners.resize(3);
  edges.make();
  EXPECT_EQ(edges.primitives.size(), 3);
  compare(edges, others, 0.3, scratch);
  edges.corners.clear();
  edges.make();
  EXPECT_EQ(compare(edges, others, 0.3, scratch), 0);
}

}  // namespace
}  // namespace deformable_surface::contact
