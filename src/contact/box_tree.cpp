#include "deformable_surface/contact/box_tree.h"

#include <algorithm>
#include <utility>

namespace deformable_surface::contact {

Index splitAtMedian(std::vector<std::pair<Vec3, Index>>& points, Index begin, Index end) {
  using Item = std::pair<Vec3, Index>;
  Box all;
  for (Index i = begin; i < end; ++i) all.extend(points[i].first);
  int axis = 0;
  all.sizes().maxCoeff(&axis);
  const Index half = begin + (end - begin) / 2;
  std::nth_element(points.begin() + begin, points.begin() + half, points.begin() + end,
                   [axis](const Item& one, const Item& other) {
                     return std::make_pair(one.first[axis], one.second) < std::make_pair(other.first[axis], other.second);
                   });
  return half;
}

BoxTree::BoxTree(const std::vector<Box>& boxes) {
  std::vector<std::pair<Vec3, Index>> middles;
  for (std::size_t i = 0; i < boxes.size(); ++i) middles.emplace_back(boxes[i].center(), static_cast<Index>(i));
  if (boxes.empty()) return;
  nodes_.reserve(2 * boxes.size() - 1);
  build(middles, 0, static_cast<Index>(middles.size()));
  refit(boxes);
}

void BoxTree::build(std::vector<std::pair<Vec3, Index>>& middles, Index begin, Index end) {
  const std::size_t self = nodes_.size();
  nodes_.push_back({{}, 0, end - begin == 1 ? middles[begin].second : Index{-1}});
  if (end - begin > 1) {
    const Index half = splitAtMedian(middles, begin, end);
    build(middles, begin, half);
    build(middles, half, end);
  }
  nodes_[self].behind = static_cast<Index>(nodes_.size());
}

void BoxTree::refit(const std::vector<Box>& boxes) {
  for (Index node = static_cast<Index>(nodes_.size()) - 1; node >= 0; --node) {
    Node& at = nodes_[node];
    if (at.item >= 0) {
      at.box = boxes[at.item];
    } else {
      const Index first = node + 1, second = nodes_[first].behind;
      at.box = nodes_[first].box;
      at.box.extend(nodes_[second].box);
    }
  }
}

}  // namespace deformable_surface::contact
