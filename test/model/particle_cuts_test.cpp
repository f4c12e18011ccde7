#include "deformable_surface/model/oriented_particles/particle_cuts.h"

#include "deformable_surface/model/oriented_particles/neighbor_list.h"

#include <gtest/gtest.h>

#include <numeric>

namespace deformable_surface::test {
namespace {

using model::ParticleCuts;

constexpr Index kColumns = 8, kRows = 8;

/// A hexagonal sheet of spacing 1, whose ids are not the numbers of its particles.
struct Sheet {
  Points positions;
  std::vector<model::ParticleTraits> traits;
  ParticleCuts::Lengths lengths{1.6, 2.6, 3.0};

  Sheet() {
    for (Index j = 0; j < kRows; ++j)
      for (Index i = 0; i < kColumns; ++i) {
        positions.emplace_back(i + 0.5 * (j % 2), std::sqrt(0.75) * j, 0.0);
        traits.emplace_back();
        traits.back().id = 100 - at(i, j);
      }
  }
  static Index at(Index i, Index j) { return i + kColumns * j; }
  Index idAt(Index i, Index j) const { return traits[at(i, j)].id; }

  /// Between the columns, from the row on.
  ParticleCuts cut(const ParticleCuts& cuts, double x, double from_row = -1.0) const {
    std::vector<Index> all(positions.size());
    std::iota(all.begin(), all.end(), 0);
    return cuts.cut(positions, traits, all, lengths, [&](Index i, Index j) {
      const Vec3 &a = positions[i], &b = positions[j];
      if ((a.x() < x) == (b.x() < x)) return false;
      const double y = a.y() + (x - a.x()) / (b.x() - a.x()) * (b.y() - a.y());
      return y > std::sqrt(0.75) * from_row;
    });
  }
  ParticleCuts follow(const ParticleCuts& cuts) const {
    model::NeighborList lists(lengths.bond, 0.3);
    EXPECT_TRUE(lists.update(positions, traits, cuts));
    ParticleCuts::Scratch scratch;
    return cuts.follow(positions, traits, lists, lengths, 500.0, scratch);
  }
};

TEST(ParticleCuts, AKnifeThatMissesCutsNothing) {
  const Sheet sheet;
  const ParticleCuts cuts = sheet.cut(ParticleCuts(), 100.0);
  EXPECT_TRUE(cuts.isEmpty());
  EXPECT_TRUE(cuts.mayBind(1, 2));
  EXPECT_EQ(cuts.bytes(), 0u);
}

TEST(ParticleCuts, SidesOfACutHaveNoBondsWithEachOtherAndKeepTheirOwn) {
  const Sheet sheet;
  const double x = 3.4;
  const ParticleCuts cuts = sheet.cut(ParticleCuts(), x);
  for (Index i = 0; i < kColumns * kRows; ++i)
    for (Index j = 0; j < i; ++j) {
      if (!((sheet.positions[i] - sheet.positions[j]).norm() < sheet.lengths.bond)) continue;
      const bool is_across = (sheet.positions[i].x() < x) != (sheet.positions[j].x() < x);
      EXPECT_EQ(cuts.mayBind(sheet.traits[i].id, sheet.traits[j].id), !is_across);
      EXPECT_EQ(cuts.isSevered(sheet.traits[i].id, sheet.traits[j].id), is_across);
    }
  EXPECT_FALSE(cuts.isCut(sheet.idAt(0, 0)));
  EXPECT_TRUE(cuts.isCut(sheet.idAt(3, 0)));
  EXPECT_TRUE(sheet.follow(cuts).isSameAs(cuts));  // nothing has moved
}

TEST(ParticleCuts, APairThatMeetsLaterHasABondOnlyIfAThirdJoinsIt) {
  Sheet sheet;
  const ParticleCuts cuts = sheet.cut(ParticleCuts(), 3.4);
  // The left half goes away, and comes back three rows higher.
  const Points before = sheet.positions;
  for (Vec3& p : sheet.positions)
    if (p.x() < 3.4) p.x() -= 100.0;
  const ParticleCuts away = sheet.follow(cuts);
  EXPECT_TRUE(away.isSameAs(cuts));
  sheet.positions = before;
  for (Vec3& p : sheet.positions)
    if (p.x() < 3.4) p.y() += 4.0 * std::sqrt(0.75);
  const ParticleCuts moved = sheet.follow(away);
  EXPECT_FALSE(moved.mayBind(sheet.idAt(3, 0), sheet.idAt(4, 4)));
  // One that moves along its own edge finds new neighbours there.
  sheet.positions = before;
  EXPECT_FALSE(cuts.mayBind(sheet.idAt(3, 0), sheet.idAt(3, 4)));
  sheet.positions[Sheet::at(3, 0)] = before[Sheet::at(3, 3)] + Vec3(0.0, 0.3, 0.2);  // by a path that is longer than a step
  ParticleCuts followed = cuts;
  for (int row = 1; row <= 3; ++row) {
    sheet.positions[Sheet::at(3, 0)] = before[Sheet::at(3, row)] + Vec3(0.0, 0.3, 0.2);
    followed = sheet.follow(followed);
  }
  EXPECT_TRUE(followed.mayBind(sheet.idAt(3, 0), sheet.idAt(3, 4)));
  EXPECT_FALSE(followed.mayBind(sheet.idAt(3, 0), sheet.idAt(4, 3)));
}

// A knife that passes almost along the line of a wide pair may miss it.
TEST(ParticleCuts, AWidePairIsBoundOnlyAsLongAsAThirdJoinsIt) {
  const Sheet sheet;
  std::vector<Index> all(sheet.positions.size());
  std::iota(all.begin(), all.end(), 0);
  const Index lower = Sheet::at(3, 2), upper = Sheet::at(3, 4), left = Sheet::at(2, 3), right = Sheet::at(3, 3);
  const auto cutPair = [&](const ParticleCuts& cuts, const ParticleCuts::Pair& pair) {
    return cuts.cut(sheet.positions, sheet.traits, all, sheet.lengths,
                    [&](Index i, Index j) { return ParticleCuts::Pair(i, j) == pair; });
  };
  const Index a = sheet.traits[lower].id, b = sheet.traits[upper].id;
  const ParticleCuts begun = cutPair(ParticleCuts(), {lower, left});
  EXPECT_TRUE(begun.mayBind(a, b));  // by the right one
  const ParticleCuts ended = cutPair(begun, {right, upper});
  EXPECT_FALSE(ended.mayBind(a, b));
  EXPECT_FALSE(ended.isSevered(a, b));
}

TEST(ParticleCuts, HeatWeldsOnBothSidesOnly) {
  for (const bool both : {true, false}) {
    Sheet sheet;
    ParticleCuts cuts = sheet.cut(ParticleCuts(), 3.4);
    for (std::size_t i = 0; i < sheet.traits.size(); ++i)
      if (both || sheet.positions[i].x() < 3.4) sheet.traits[i].temperature = 500.0;
    cuts = sheet.follow(cuts);
    EXPECT_EQ(cuts.isEmpty(), both);
    EXPECT_EQ(cuts.mayBind(sheet.idAt(3, 0), sheet.idAt(4, 0)), both);
  }
}

TEST(ParticleCuts, NoParticleIsCutOffAlone) {
  Sheet sheet;
  // A knife that goes around a particle: it stays with the side on which it has most bonds.
  std::vector<Index> all(sheet.positions.size());
  std::iota(all.begin(), all.end(), 0);
  const Index lonely = Sheet::at(3, 3);
  const ParticleCuts cuts = ParticleCuts().cut(sheet.positions, sheet.traits, all, sheet.lengths,
                                               [&](Index i, Index j) { return i == lonely || j == lonely; });
  Index bonds = 0;
  for (Index j = 0; j < kColumns * kRows; ++j)
    bonds += j != lonely && (sheet.positions[j] - sheet.positions[lonely]).norm() < sheet.lengths.bond &&
             cuts.mayBind(sheet.traits[lonely].id, sheet.traits[j].id);
  EXPECT_EQ(bonds, 6);  // they are all on one side, its surroundings being whole
}

TEST(ParticleCuts, NewParticlesAreCutFromWhatTheirParentsAreCutFrom) {
  Sheet sheet;
  const ParticleCuts cuts = sheet.cut(ParticleCuts(), 3.4);
  const Index first = static_cast<Index>(sheet.positions.size()), left = Sheet::at(3, 2), below = Sheet::at(2, 2);
  sheet.positions.push_back(0.5 * (sheet.positions[left] + sheet.positions[below]) + Vec3(0.0, 0.0, 0.4));
  sheet.traits.emplace_back();
  sheet.traits.back().id = 101;
  const ParticleCuts born = cuts.inherit(sheet.positions, sheet.traits, first, {{left, below}}, sheet.lengths);
  EXPECT_TRUE(born.isCut(101));
  EXPECT_TRUE(born.mayBind(101, sheet.traits[left].id));
  EXPECT_TRUE(born.mayBind(101, sheet.idAt(2, 3)));
  for (Index j = 0; j < kRows; ++j) EXPECT_FALSE(born.mayBind(101, sheet.idAt(4, j)));
  EXPECT_TRUE(born.isSevered(101, sheet.idAt(4, 2)));
  // And away from cuts nothing is inherited.
  sheet.positions.back() = sheet.positions[0] + Vec3(0.3, 0.3, 0.3);
  EXPECT_FALSE(cuts.inherit(sheet.positions, sheet.traits, first, {{0, 1}}, sheet.lengths).isCut(101));
}

// Several children of one pass, of which later ones have earlier ones beside them: as if every pair were looked at.
TEST(ParticleCuts, ChildrenTakePartInTheCutsOfEachOther) {
  Sheet sheet;
  const ParticleCuts cuts = sheet.cut(ParticleCuts(), 3.75);
  const Index first = static_cast<Index>(sheet.positions.size());
  std::vector<ParticleCuts::Pair> parents;
  for (const Index row : {2, 4})
    for (const Index column : {2, 3, 4, 5}) {
      const Index a = Sheet::at(column, row), b = Sheet::at(column, row + 1);
      parents.emplace_back(a, b);
      sheet.positions.push_back(0.5 * (sheet.positions[a] + sheet.positions[b]));
      sheet.traits.emplace_back();
      sheet.traits.back().id = static_cast<Index>(100 + sheet.positions.size());
    }
  const ParticleCuts born = cuts.inherit(sheet.positions, sheet.traits, first, parents, sheet.lengths);
  const auto idOf = [&](Index k) { return sheet.traits[first + k].id; };
  for (const Index row : {0, 4}) {
    EXPECT_TRUE(born.mayBind(idOf(row), idOf(row + 1)));       // both left of the cut
    EXPECT_FALSE(born.mayBind(idOf(row + 1), idOf(row + 2)));  // across it
    EXPECT_TRUE(born.isSevered(idOf(row + 1), idOf(row + 2)));
    EXPECT_TRUE(born.mayBind(idOf(row + 2), idOf(row + 3)));
  }
  EXPECT_NE(born.addToHash(1), cuts.addToHash(1));
}

TEST(ParticleCuts, AreInTheHashOfAState) {
  const Sheet sheet;
  EXPECT_EQ(ParticleCuts().addToHash(7), 7u);
  const ParticleCuts one = sheet.cut(ParticleCuts(), 3.4), same = sheet.cut(ParticleCuts(), 3.4),
                     other = sheet.cut(ParticleCuts(), 4.4);
  EXPECT_EQ(one.addToHash(7), same.addToHash(7));
  EXPECT_NE(one.addToHash(7), 7u);
  EXPECT_NE(one.addToHash(7), other.addToHash(7));
}

TEST(ParticleCuts, WhatIsGoneIsForgotten) {
  Sheet sheet;
  const ParticleCuts cuts = sheet.cut(ParticleCuts(), 3.4);
  Sheet half = sheet;
  half.positions.clear();
  half.traits.clear();
  for (std::size_t i = 0; i < sheet.positions.size(); ++i) {
    if (sheet.positions[i].x() > 3.4) continue;
    half.positions.push_back(sheet.positions[i]);
    half.traits.push_back(sheet.traits[i]);
  }
  const ParticleCuts left = half.follow(cuts);
  EXPECT_TRUE(left.severed()->empty());
  EXPECT_TRUE(left.isCut(sheet.idAt(3, 0)));  // it still has an edge
  EXPECT_LT(left.bytes(), cuts.bytes());
}

}  // namespace
}  // namespace deformable_surface::test
