#include "deformable_surface/model/elastic_solid/point_rooms.h"

#include "deformable_surface/base/simd.h"

#include <algorithm>

namespace deformable_surface::model {
namespace {

constexpr std::ptrdiff_t kNumbers = PointRooms::kNumbers;

DEFORMABLE_SURFACE_WIDE void fillRoom(Index begin, Index end, const Index* others, Index num_others, const double* positions,
                                      double* room) {
  const Double4 zero{};
  Double4 position;
  for (Index i = begin; i < end; ++i, room += kNumbers) {
    load(positions + 4 * static_cast<std::ptrdiff_t>(i), position);
    store(position, room);
    store(zero, room + 4);
  }
  for (Index k = 0; k < num_others; ++k, room += kNumbers) {
    load(positions + 4 * static_cast<std::ptrdiff_t>(others[k]), position);
    store(position, room);
    store(zero, room + 4);
  }
}

// own: the force on the first of the points in the memory of their block.
DEFORMABLE_SURFACE_WIDE void addCopies(Index begin, Index end, const double* own, const Index* offsets, const Index* places,
                                       const double* room, double* forces) {
  for (Index i = begin; i < end; ++i, own += kNumbers) {
    Double4 sum, copy;
    load(own, sum);
    for (Index k = offsets[i]; k < offsets[i + 1]; ++k) {
      load(room + kNumbers * static_cast<std::ptrdiff_t>(places[k]) + 4, copy);
      sum += copy;
    }
    for (int c = 0; c < 3; ++c) forces[3 * static_cast<std::ptrdiff_t>(i) + c] += sum[c];
  }
}

}  // namespace

PointRooms::PointRooms(const Lists& pairs) {
  const Index n = pairs.size();
  std::vector<Index> place(n), seen_by(n, -1);
  places_.resize(pairs.items.size());
  Index block = 0, total = 0;
  for (Index begin = 0; begin < n; begin += kPoints, ++block) {
    const Index end = std::min(n, begin + kPoints);
    const std::size_t first = others_.items.size();
    for (Index k = pairs.offsets[begin]; k < pairs.offsets[end]; ++k) {
      const Index j = pairs.items[k];
      if (j >= begin && j < end) {
        places_[k] = j - begin;
        continue;
      }
      if (seen_by[j] != block) {
        seen_by[j] = block;
        place[j] = end - begin + static_cast<Index>(others_.items.size() - first);
        others_.items.push_back(j);
      }
      places_[k] = place[j];
    }
    others_.offsets.push_back(static_cast<Index>(others_.items.size()));
    begin_.push_back(total);
    total += end - begin + static_cast<Index>(others_.items.size() - first);
  }
  room_.resize(static_cast<std::size_t>(kNumbers) * total);

  // The copies of each point, block by block.
  copies_.offsets.assign(n + 1, 0);
  for (const Index j : others_.items) ++copies_.offsets[j + 1];
  for (Index i = 0; i < n; ++i) copies_.offsets[i + 1] += copies_.offsets[i];
  copies_.items.resize(others_.items.size());
  std::vector<Index> next(copies_.offsets.begin(), copies_.offsets.end() - 1);
  for (Index b = 0; b < others_.size(); ++b) {
    const Index own = std::min(n, (b + 1) * kPoints) - b * kPoints;
    for (Index k = others_.offsets[b]; k < others_.offsets[b + 1]; ++k)
      copies_.items[next[others_.items[k]]++] = begin_[b] + own + k - others_.offsets[b];
  }
}

double* PointRooms::fill(Index begin, Index end, const double* positions) {
  const Index block = begin / kPoints;
  double* room = room_.data() + kNumbers * begin_[block];
  fillRoom(begin, end, others_.begin(block), others_.count(block), positions, room);
  return room;
}

void PointRooms::addForces(Index begin, Index end, double* forces) const {
  while (begin < end) {
    const Index block = begin / kPoints, last = std::min(end, (block + 1) * kPoints);
    const double* own = room_.data() + kNumbers * (begin_[block] + begin - block * kPoints) + 4;
    addCopies(begin, last, own, copies_.offsets.data(), copies_.items.data(), room_.data(), forces);
    begin = last;
  }
}

}  // namespace deformable_surface::model
