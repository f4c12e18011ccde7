// Which patches of a surface are in a chart together.
#include "deformable_surface/contact/atlas.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "deformable_surface/contact/pair_list.h"
#include "folded_sheets.h"

namespace deformable_surface::contact {
namespace {

constexpr double kDistance = 0.001;

bool isIn(const std::vector<Index>& patches, Index p) { return std::binary_search(patches.begin(), patches.end(), p); }

TEST(Atlas, HasNeighborsInAChartOfEachLevel) {
  const test::Sheets sheet = test::makeSheets(1, 24, 0.0, 0.0005);
  const PairList list(sheet.points, sheet.triangles, kDistance);
  const Patches& patches = list.patches();
  std::vector<Index> patch_of(sheet.points.size());
  for (Index p = 0; p < patches.size(); ++p) patches.visitVertices(p, [&](Index v) { patch_of[v] = p; });
  std::set<std::array<Index, 2>> neighbors;
  for (const Triangle& t : sheet.triangles)
    for (const Index v : t)
      for (const Index w : t) neighbors.insert({patch_of[v], patch_of[w]});
  Atlas atlas(sheet.points, sheet.triangles, patches, kDistance);
  ASSERT_GT(atlas.size(), 16);
  // Each way down the tree ends with a chart of both: the smallest charts hold all neighbours together.
  std::set<std::array<Index, 2>> in_smallest, in_largest;
  for (Index k = 0; k < atlas.size(); ++k)
    if (atlas.behind(k) == k + 1)
      for (const Index p : atlas.patchesIn(k))
        for (const Index q : atlas.patchesIn(k)) in_smallest.insert({p, q});
  for (Index k = 0; k < atlas.size(); k = atlas.behind(k))
    for (const Index p : atlas.patchesIn(k))
      for (const Index q : atlas.patchesIn(k)) in_largest.insert({p, q});
  for (const std::array<Index, 2>& couple : neighbors) {
    EXPECT_EQ(in_smallest.count(couple), 1u);
    EXPECT_EQ(in_largest.count(couple), 1u);
  }
  EXPECT_LT(in_smallest.size(), in_largest.size());
  // Charts are parts of those above them.
  for (Index k = 0; k < atlas.size(); ++k)
    for (Index below = k + 1; below < atlas.behind(k); ++below)
      for (const Index p : atlas.patchesIn(below)) EXPECT_TRUE(isIn(atlas.patchesIn(k), p));
}

TEST(Atlas, LeavesOutPatchesWithAPointWithoutTriangles) {
  test::Sheets sheet = test::makeSheets(1, 16, 0.0, 0.0);
  sheet.points.emplace_back(0.03, 0.03, 0.01);
  const PairList list(sheet.points, sheet.triangles, kDistance);
  Index lone = -1;
  for (Index p = 0; p < list.patches().size(); ++p) list.patches().visitVertices(p, [&](Index v) { lone = v == 256 ? p : lone; });
  ASSERT_GE(lone, 0);
  Atlas atlas(sheet.points, sheet.triangles, list.patches(), kDistance);
  for (Index k = 0; k < atlas.size(); ++k) EXPECT_FALSE(isIn(atlas.patchesIn(k), lone)) << k;
}

TEST(Atlas, IsEmptyForFewPatches) {
  const test::Sheets sheet = test::makeSheets(1, 5, 0.0, 0.0);
  const PairList list(sheet.points, sheet.triangles, kDistance);
  EXPECT_EQ(Atlas(sheet.points, sheet.triangles, list.patches(), kDistance).size(), 0);
}

}  // namespace
}  // namespace deformable_surface::contact
