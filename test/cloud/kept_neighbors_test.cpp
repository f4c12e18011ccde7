// Neighbours of places that move, beside those of a tree of the present places: the same, in the same order, to the bit.
#include "deformable_surface/cloud/kept_neighbors.h"

#include "deformable_surface/base/error.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace deformable_surface::cloud {
namespace {

class Moves {
 public:
  explicit Moves(unsigned seed) : generator_(seed) {}
  double number(double most) { return most * (2.0 * (generator_() / 4294967295.0) - 1.0); }
  Vec3 vector(double most) {
    const double x = number(most), y = number(most);
    return {x, y, number(most)};
  }
  Index index(std::size_t n) { return static_cast<Index>(generator_() % n); }

 private:
  std::mt19937 generator_;
};

// A lattice, so that many distances are equal, then random places, with a few in one place.
Points makePlaces(Moves& moves) {
  Points places;
  for (Index x = 0; x < 12; ++x)
    for (Index y = 0; y < 12; ++y) places.emplace_back(x, y, 0.0);
  for (Index i = 0; i < 150; ++i) places.push_back(Vec3(6.0, 6.0, 3.0) + moves.vector(4.0));
  for (Index i = 0; i < 3; ++i) places.push_back(places[7]);
  return places;
}

void expectSame(const std::vector<Neighbor>& expected, const std::vector<Neighbor>& found) {
  ASSERT_EQ(expected.size(), found.size());
  for (std::size_t m = 0; m < found.size(); ++m) {
    EXPECT_EQ(expected[m].index, found[m].index);
    EXPECT_EQ(expected[m].squared_distance, found[m].squared_distance);
  }
}

void expectSameAsTree(const Points& places, double radius, KeptNeighborhoods& kept) {
  kept.update(places);
  const KdTree tree(places);
  std::vector<Neighbor> expected, found;
  for (std::size_t i = 0; i < places.size(); ++i) {
    tree.withinRadius(places[i], radius, expected);
    kept.find(static_cast<Index>(i), found);
    expectSame(expected, found);
  }
}

TEST(KeptNeighborhoods, AreThoseOfATreeOfThePresentPlaces) {
  Moves moves(3);
  Points places = makePlaces(moves);
  constexpr double kRadius = 2.0;
  KeptNeighborhoods kept(kRadius, 0.4);
  expectSameAsTree(places, kRadius, kept);
  for (int k = 0; k < 40; ++k) {
    for (Vec3& p : places) p += moves.vector(0.03);
    expectSameAsTree(places, kRadius, kept);
  }
}

TEST(KeptNeighborhoods, AFewMayMoveFar) {
  Moves moves(5);
  Points places = makePlaces(moves);
  constexpr double kRadius = 2.0;
  KeptNeighborhoods kept(kRadius, 0.4);
  expectSameAsTree(places, kRadius, kept);
  for (int k = 0; k < 25; ++k) {  // at the end more than a few have gone, and all are found anew
    places[moves.index(places.size())] += moves.vector(5.0);
    places[3] = places[moves.index(places.size())];
    expectSameAsTree(places, kRadius, kept);
  }
}

TEST(KeptNeighborhoods, TakeAnotherNumberOfPlaces) {
  Moves moves(7);
  Points places = makePlaces(moves);
  constexpr double kRadius = 1.5;
  KeptNeighborhoods kept(kRadius, 0.4);
  expectSameAsTree(places, kRadius, kept);
  places.emplace_back(1.0, 2.0, 0.5);
  expectSameAsTree(places, kRadius, kept);
  places.resize(20);
  expectSameAsTree(places, kRadius, kept);
  expectSameAsTree({}, kRadius, kept);
}

TEST(KeptNeighborhoods, RefuseWhatIsNotFinite) {
  Moves moves(17);
  Points places = makePlaces(moves);
  KeptNeighborhoods kept(1.5, 0.4);
  kept.update(places);
  places[2].y() = std::nan("");
  EXPECT_THROW(kept.update(places), InputError);
}

TEST(KeptNearest, AreThoseOfTheTree) {
  Moves moves(11);
  for (const std::size_t size : {300u, 12u, 5u, 0u}) {
    Points points = makePlaces(moves);
    points.resize(size);
    const KdTree tree(points);
    constexpr Index kNearest = 8, kPlaces = 40;
    KeptNearest kept(tree, points, kNearest, kPlaces);
    Points at(kPlaces);
    for (Vec3& p : at) p = Vec3(6.0, 6.0, 0.0) + moves.vector(7.0);
    std::vector<Neighbor> expected, found;
    for (int k = 0; k < 60; ++k) {
      for (Index place = 0; place < kPlaces; ++place) {
        at[place] += moves.vector(k % 20 == 19 ? 5.0 : 0.1);
        tree.nearest(at[place], kNearest, expected);
        kept.find(place, at[place], found);
        expectSame(expected, found);
      }
    }
  }
}

TEST(KeptNearest, StayInOrderOnALatticeAndAtItsPoints) {
  Moves moves(13);
  const Points points = makePlaces(moves);
  const KdTree tree(points);
  KeptNearest kept(tree, points, 8, 1);
  std::vector<Neighbor> expected, found;
  for (int k = 0; k < 120; ++k) {  // ten steps from point to point: equal distances on the way
    const Vec3 at(1.0 + 0.1 * (k % 100), 5.0, 0.0);
    tree.nearest(at, 8, expected);
    kept.find(0, at, found);
    expectSame(expected, found);
  }
}

}  // namespace
}  // namespace deformable_surface::cloud
