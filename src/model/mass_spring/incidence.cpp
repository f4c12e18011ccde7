#include "deformable_surface/model/mass_spring/incidence.h"

#include <cmath>

namespace deformable_surface::model {

Lists groupByPoint(Index num_points, const std::vector<std::pair<Index, Index>>& point_items) {
  Lists lists;
  lists.offsets.assign(num_points + 1, 0);
  for (const auto& [point, item] : point_items) ++lists.offsets[point + 1];
  for (Index p = 0; p < num_points; ++p) lists.offsets[p + 1] += lists.offsets[p];
  lists.items.resize(point_items.size());
  std::vector<Index> next(lists.offsets.begin(), lists.offsets.end() - 1);
  for (const auto& [point, item] : point_items) lists.items[next[point]++] = item;
  return lists;
}

Vec3 fixedDirection(Index i, Index j) {
  // Three small integers from a multiplicative hash; never all zero since the middle one is odd.
  std::uint32_t h = static_cast<std::uint32_t>(i) * 2654435761u + static_cast<std::uint32_t>(j) * 2246822519u;
  h ^= h >> 15;
  const Vec3 v(static_cast<int>(h & 255u) - 128, static_cast<int>((h >> 8) & 255u) * 2 - 255,
               static_cast<int>((h >> 16) & 255u) - 128);
  return v.normalized();
}

}  // namespace deformable_surface::model
