// How many clouds wait in a row: clouds must not fill the memory.
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>

namespace deformable_surface::node {

// Two seconds of a camera: the largest delay of a working transform, and of input.delay.
constexpr std::size_t kMostClouds = 64;
constexpr std::int64_t kMostCloudPoints = 4'000'000;  // of all together, unless it is one

/// Drops the oldest, which are the first, if there are too many. Returns how many. countPoints: of an entry.
template <class Entry, class CountPoints>
int dropOldestClouds(std::deque<Entry>& clouds, const CountPoints& countPoints) {
  std::int64_t points = 0;
  for (const Entry& entry : clouds) points += static_cast<std::int64_t>(countPoints(entry));
  int num_dropped = 0;
  for (; clouds.size() > kMostClouds || (clouds.size() > 1 && points > kMostCloudPoints); ++num_dropped) {
    points -= static_cast<std::int64_t>(countPoints(clouds.front()));
    clouds.pop_front();
  }
  return num_dropped;
}

}  // namespace deformable_surface::node
