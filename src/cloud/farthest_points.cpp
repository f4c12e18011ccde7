#include "deformable_surface/cloud/farthest_points.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <queue>
#include <utility>

namespace deformable_surface::cloud {
namespace {

constexpr Index kSteps = 16;  // listed neighbours that a step may lead to: enough to reach whatever is connected

}  // namespace

Simplification orderByDistance(const Points& positions, const Lists& neighbors, Index min_points,
                               const std::vector<Index>& protected_points) {
  const Index n = static_cast<Index>(positions.size());
  std::vector<double> squared(n, std::numeric_limits<double>::infinity());
  std::vector<char> is_chosen(n, 0);
  std::vector<Index> chosen, front;
  std::vector<double> at_choice;
  const auto choose = [&](Index from) {
    chosen.push_back(from);
    at_choice.push_back(squared[from]);
    is_chosen[from] = 1;
    squared[from] = 0.0;
    front.assign(1, from);
    while (!front.empty()) {
      const Index u = front.back();
      front.pop_back();
      for (const Index* v = neighbors.begin(u); v != neighbors.begin(u) + std::min(kSteps, neighbors.count(u)); ++v) {
        const double to = (positions[*v] - positions[from]).squaredNorm();
        if (!(to < squared[*v])) continue;
        squared[*v] = to;
        front.push_back(*v);
      }
    }
  };

  for (Index i : protected_points)
    if (!is_chosen[i]) choose(i);
  const Index num_protected = static_cast<Index>(chosen.size());
  if (chosen.empty() && n > 0) {
    Vec3 middle = Vec3::Zero();
    for (const Vec3& p : positions) middle += p / static_cast<double>(n);
    Index first = 0;
    for (Index i = 1; i < n; ++i)
      if ((positions[i] - middle).squaredNorm() > (positions[first] - middle).squaredNorm()) first = i;
    choose(first);
  }
  // The farthest first, of equal ones the smallest index. Entries that have come nearer meanwhile are put back.
  using Entry = std::pair<double, Index>;
  std::priority_queue<Entry> farthest;
  for (Index i = 0; i < n; ++i) farthest.emplace(squared[i], -i);
  while (!farthest.empty()) {
    const auto [distance, minus] = farthest.top();
    farthest.pop();
    const Index i = -minus;
    if (is_chosen[i]) continue;
    if (distance == squared[i])
      choose(i);
    else
      farthest.emplace(squared[i], minus);
  }

  Simplification order;
  order.num_points = n;
  for (Index k = n - 1; k >= std::max(num_protected, std::max(min_points, Index{1})); --k) {
    order.removed.push_back(chosen[k]);
    const double diameter = 2.0 * std::sqrt(at_choice[k]);
    order.diameter.push_back(std::max(order.diameter.empty() ? 0.0 : order.diameter.back(), diameter));
  }
  return order;
}

}  // namespace deformable_surface::cloud
