#include "deformable_surface/model/elastic_solid/point_rooms.h"

#include <gtest/gtest.h>

#include <random>

namespace deformable_surface::test {
namespace {

using model::PointRooms;

// Every point with some others, near and far, once or more than once.
Lists makePairs(Index n) {
  std::mt19937 generator(3);
  Lists pairs;
  for (Index i = 0; i < n; ++i) {
    for (int k = 0; k < 7; ++k) pairs.items.push_back(static_cast<Index>(generator() % static_cast<unsigned>(n)));
    pairs.items.push_back((i + 1) % n);
    pairs.offsets.push_back(static_cast<Index>(pairs.items.size()));
  }
  return pairs;
}

class PointRoomsOf : public testing::TestWithParam<Index> {};

TEST_P(PointRoomsOf, AddUpWhatEveryPairDoes) {
  const Index n = GetParam();
  const Lists pairs = makePairs(n);
  std::vector<double> positions(4 * n), forces(3 * n, 1.0), expected(3 * n, 1.0);
  for (Index i = 0; i < 4 * n; ++i) positions[i] = i % 4 == 3 ? 0.0 : i;
  PointRooms rooms(pairs);
  for (Index begin = 0; begin < n; begin += PointRooms::kPoints) {
    double* room = rooms.fill(begin, std::min(n, begin + PointRooms::kPoints), positions.data());
    for (Index i = begin; i < std::min(n, begin + PointRooms::kPoints); ++i) {
      EXPECT_EQ(room[PointRooms::kNumbers * (i - begin)], positions[4 * i]);
      for (Index k = pairs.offsets[i]; k < pairs.offsets[i + 1]; ++k) {
        double* place = room + PointRooms::kNumbers * rooms.places()[k];
        for (int c = 0; c < 3; ++c) {
          ASSERT_EQ(place[c], positions[4 * pairs.items[k] + c]) << i;
          place[4 + c] += i + c;  // whole numbers: sums are exact in any order
          expected[3 * pairs.items[k] + c] += i + c;
        }
      }
    }
  }
  rooms.addForces(0, n / 3, forces.data());
  rooms.addForces(n / 3, n, forces.data());
  EXPECT_EQ(forces, expected);
}

INSTANTIATE_TEST_SUITE_P(Sizes, PointRoomsOf,
                         testing::Values(1, 5, PointRooms::kPoints, PointRooms::kPoints + 1, 3 * PointRooms::kPoints + 100));

TEST(PointRoomsAgain, ForcesOfThePassBeforeAreForgotten) {
  constexpr Index kCount = 700;
  const Lists pairs = makePairs(kCount);
  const std::vector<double> positions(4 * kCount, 0.0);
  PointRooms rooms(pairs);
  std::vector<double> forces[2];
  for (std::vector<double>& sums : forces) {
    for (Index begin = 0; begin < kCount; begin += PointRooms::kPoints) {
      double* room = rooms.fill(begin, std::min(kCount, begin + PointRooms::kPoints), positions.data());
      for (Index k = pairs.offsets[begin]; k < pairs.offsets[begin + 1]; ++k)  // of itself and of others
        room[PointRooms::kNumbers * rooms.places()[k] + 4] += 1.0;
      room[4] += 1.0;
    }
    sums.assign(3 * kCount, 0.0);
    rooms.addForces(0, kCount, sums.data());
  }
  EXPECT_GT(forces[0][0], 0.0);
  EXPECT_EQ(forces[0], forces[1]);
}

}  // namespace
}  // namespace deformable_surface::test
