// The rows of a plate with cuts are those of the cut plate alone, but for the balance of moments far from the cuts.
#include "../../src/model/mass_spring/balanced_plate.h"
#include "deformable_surface/model/mass_spring/mass_spring.h"
#include "model_checks.h"
#include "plates.h"

#include <gtest/gtest.h>

#include <random>
#include <set>

namespace deformable_surface::test {
namespace {

using model::BalancedPlate;
using model::PlateRest;
using Link = std::pair<Index, Index>;

// Without the links, the triangles at them, and the links of which no triangle is left.
PlateRest cutLinks(const PlateRest& plate, const std::set<Link>& links) {
  PlateRest cut = plate;
  cut.triangles.clear();
  std::set<Link> left;
  for (const model::WeightedTriangle& t : plate.triangles) {
    const std::set<Link> edges{std::minmax(t.corner[0], t.corner[1]), std::minmax(t.corner[1], t.corner[2]),
                               std::minmax(t.corner[2], t.corner[0])};
    if (std::any_of(edges.begin(), edges.end(), [&](const Link& edge) { return links.count(edge) > 0; })) continue;
    cut.triangles.push_back(t);
    left.insert(edges.begin(), edges.end());
  }
  cut.ring = Lists{};
  for (Index i = 0; i < plate.ring.size(); ++i) {
    for (const Index* j = plate.ring.begin(i); j != plate.ring.end(i); ++j)
      if (left.count(std::minmax(i, *j)) > 0) cut.ring.items.push_back(*j);
    cut.ring.offsets.push_back(static_cast<Index>(cut.ring.items.size()));
  }
  return cut;
}

// Those that cross x = 0.503 beyond y = from.
std::set<Link> findCrossing(const Surface& s, double from) {
  std::set<Link> crossing;
  for (Index i = 0; i < s.rings.ring.size(); ++i)
    for (const Index* j = s.rings.ring.begin(i); j != s.rings.ring.end(i); ++j) {
      const Vec3 &a = s.points[i], &b = s.points[*j];
      if ((a.x() < 0.503) != (b.x() < 0.503) && 0.5 * (a.y() + b.y()) > from) crossing.insert(std::minmax(i, *j));
    }
  return crossing;
}

TEST(BalancedPlate, FitsOfACutPlateAreThoseOfThePlateAlone) {
  std::mt19937 generator(5);
  for (int run = 0; run < 12; ++run) {
    const Surface s = makeScattered(run % 2 == 0 ? Scatter::kJittered : Scatter::kPoisson, 20, 1.0, 0.5, run + 1);
    const PlateRest plate = plateOf(s, 1.0, 0.3);
    // Every third one is held at an end or in the middle. Links at the clamp are cut as well.
    std::vector<char> held(s.points.size(), 0);
    for (std::size_t i = 0; i < held.size(); ++i)
      held[i] = run % 3 == 1 ? s.points[i].x() < 0.21 : run % 3 == 2 && (s.points[i] - Vec3(0.5, 0.0, 0.0)).norm() < 0.13;
    const std::vector<model::ClampEdge> edges = edgesAtPoints(s, held);
    const BalancedPlate whole = model::balancePlate(model::clampPlate(plate, held, edges));
    const Vec3 middle(0.5 + 0.5 * uniform(generator), 0.25 * uniform(generator), 0.0);
    std::set<Link> links;
    for (Index i = 0; i < plate.ring.size(); ++i)
      for (const Index* j = plate.ring.begin(i); j != plate.ring.end(i); ++j)
        if ((s.points[i] - middle).norm() < 0.15 && uniform(generator) > 0.7) links.insert(std::minmax(i, *j));
    const model::ClampedPlate cut = model::clampPlate(cutLinks(plate, links), held, edges);
    const BalancedPlate alone = model::balancePlate(cut), near = model::balanceNearCuts(whole, cut);
    EXPECT_EQ(near.fits.points.offsets, alone.fits.points.offsets) << run;
    EXPECT_EQ(near.fits.points.items, alone.fits.points.items) << run;
    EXPECT_EQ(near.fits.reach, alone.fits.reach) << run;
    EXPECT_EQ(near.areas, alone.areas) << run;
    ASSERT_EQ(near.rows.size(), alone.rows.size());
    for (std::size_t r = 0; r < near.rows.size(); ++r) EXPECT_EQ(near.rows[r].first, alone.rows[r].first) << run << ' ' << r;
  }
}

TEST(BalancedPlate, FarFromCutsItsRowsAreThoseOfTheWholeOneToTheBit) {
  const Surface s = makeScattered(Scatter::kJittered, 40, 1.0, 0.4);
  const PlateRest plate = plateOf(s, 1.0, 0.3);
  const BalancedPlate whole = model::balancePlate(model::clampPlate(plate, {}, {}));
  const PlateRest cut = cutLinks(plate, findCrossing(s, 0.1));
  const BalancedPlate near = model::balanceNearCuts(whole, model::clampPlate(cut, {}, {}));
  const auto rowsAt = [&](const BalancedPlate& balanced, Index i) {
    std::vector<Vec3> rows;
    for (Index item = balanced.fits.points.offsets[i]; item < balanced.fits.points.offsets[i + 1]; ++item)
      rows.push_back(balanced.rows[item].second);
    return rows;
  };
  Index equal = 0, changed = 0;
  for (Index i = 0; i < static_cast<Index>(s.points.size()); ++i) {
    const double distance = std::abs(s.points[i].x() - 0.503);
    const bool is_equal = rowsAt(near, i) == rowsAt(whole, i);
    if (distance > 0.35) EXPECT_TRUE(is_equal) << i;
    (is_equal ? equal : changed) += 1;
  }
  EXPECT_GT(equal, changed);
  EXPECT_GT(changed, 0);
}

class CutPlates : public testing::TestWithParam<Scatter> {};

TEST_P(CutPlates, SagAsThoseThatAreBalancedAnew) {
  const Surface s = makeScattered(GetParam(), 30, 1.0, 0.4);
  const PlateRest plate = plateOf(s, 1.0, 0.3);
  const BalancedPlate whole = model::balancePlate(model::clampPlate(plate, {}, {}));
  const Index n = static_cast<Index>(s.points.size());
  // A slit as deep as half of the width.
  const PlateRest cut = cutLinks(plate, findCrossing(s, 0.0));
  std::vector<char> held(n, 0);
  Eigen::VectorXd weight(n);
  for (Index i = 0; i < n; ++i) {
    held[i] = s.points[i].x() < 0.04;
    weight[i] = -s.rings.area[i];
  }
  const auto sag = [&](const model::CurvatureBending& bending) {
    return solveHeld(stiffnessAcross(s, bending), held, weight).minCoeff();
  };
  const double alone = sag(model::CurvatureBending(cut));
  EXPECT_GT(sag(model::CurvatureBending(plate)) / alone, 0.0);
  EXPECT_LT(sag(model::CurvatureBending(plate)) / alone, 0.9);
  EXPECT_NEAR(sag(model::CurvatureBending(whole, cut, {}, {})) / alone, 1.0, 0.003);
}

INSTANTIATE_TEST_SUITE_P(BalancedPlate, CutPlates,
                         testing::Values(Scatter::kGrid, Scatter::kJittered, Scatter::kPoisson, Scatter::kSimplified));

// Snapshots rely on it: they set all cuts at once.
TEST(BalancedPlate, CutsInAnyOrderGiveTheSameSurfaceToTheBit) {
  const Surface s = makeSheet(21, 11, 1.0, 0.5, 0.3);
  const auto makeModel = [&] {
    return model::MassSpring(s.points, s.normals, s.rings, s.area, false, model::MaterialParams{}, {});
  };
  const std::set<Link> found = findCrossing(s, 0.0);
  const std::vector<Link> all(found.begin(), found.end());
  const model::State bent = stateAt(perturb(s.points, 0.01));
  std::vector<char> held(s.points.size(), 0);
  for (std::size_t i = 0; i < held.size(); ++i) held[i] = s.points[i].x() > 0.8;
  model::MassSpring at_once = makeModel(), one_by_one = makeModel();
  at_once.setHeld(held, edgesAtPoints(s, held));
  at_once.setCuts(all);
  for (std::size_t k = 1; k <= all.size(); k += 3) one_by_one.setCuts({all.end() - k, all.end()});
  one_by_one.setHeld(held, edgesAtPoints(s, held));
  one_by_one.setCuts(at_once.cuts());
  EXPECT_EQ(forcesAt(one_by_one, bent), forcesAt(at_once, bent));
  at_once.setCuts({});
  model::MassSpring never_cut = makeModel();
  never_cut.setHeld(held, edgesAtPoints(s, held));
  EXPECT_EQ(forcesAt(at_once, bent), forcesAt(never_cut, bent));
}

}  // namespace
}  // namespace deformable_surface::test
