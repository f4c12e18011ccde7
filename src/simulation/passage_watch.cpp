#include "passage_watch.h"

#include <algorithm>
#include <utility>

namespace deformable_surface::simulation {
namespace {

std::vector<contact::Box> boundAll(const Points& positions, const std::vector<contact::Triangle>& triangles) {
  std::vector<contact::Box> boxes;
  for (const contact::Triangle& t : triangles) boxes.push_back(contact::boundOf(positions, t));
  return boxes;
}

}  // namespace

PassageWatch::PassageWatch(const Points& rest, std::shared_ptr<const ContactSkin> skin)
    : skin_(std::move(skin)),
      edges_(contact::listEdges(static_cast<Index>(rest.size()), skin_->triangles)),
      boxes_(boundAll(rest, skin_->triangles)),
      tree_(boxes_) {
  contact::visitCrossings(rest, edges_, skin_->triangles, tree_, [&](const contact::Crossing& crossing) {
    for (const Index i : edges_[crossing.edge])
      for (const Index j : skin_->triangles[crossing.triangle]) at_rest_.push_back({i, j});
  });
  std::sort(at_rest_.begin(), at_rest_.end());
}

bool PassageWatch::isAtRest(const contact::Crossing& crossing) const {
  for (const Index i : edges_[crossing.edge])
    for (const Index j : skin_->triangles[crossing.triangle])
      if (std::binary_search(at_rest_.begin(), at_rest_.end(), std::array<Index, 2>{i, j})) return true;
  return false;
}

std::optional<PassageWatch::Found> PassageWatch::look(const Points& positions, const std::vector<model::WeightedTriangle>* now) {
  for (std::size_t t = 0; t < boxes_.size(); ++t) boxes_[t] = contact::boundOf(positions, skin_->triangles[t]);
  tree_.refit(boxes_);
  std::vector<contact::Crossing> found;
  contact::visitCrossings(positions, edges_, skin_->triangles, tree_, [&](const contact::Crossing& crossing) {
    if (!isAtRest(crossing)) found.push_back(crossing);
  });
  if (now && !found.empty()) dropCut(static_cast<Index>(positions.size()), *now, found);
  if (found.empty()) return std::nullopt;
  std::vector<Index> crossed;
  for (const contact::Crossing& crossing : found) crossed.push_back(crossing.triangle);
  std::sort(crossed.begin(), crossed.end());
  const contact::Edge& edge = edges_[found.front().edge];
  return Found{static_cast<Index>(std::unique(crossed.begin(), crossed.end()) - crossed.begin()),
               0.5 * (positions[edge[0]] + positions[edge[1]])};
}

// Leaves out cut triangles, and edges of which all triangles are cut.
void PassageWatch::dropCut(Index n, const std::vector<model::WeightedTriangle>& now,
                           std::vector<contact::Crossing>& found) const {
  const std::vector<char> is_whole = skin_->findWhole(now);
  std::vector<contact::Triangle> whole;
  for (std::size_t t = 0; t < is_whole.size(); ++t)
    if (is_whole[t] != 0) whole.push_back(skin_->triangles[t]);
  const std::vector<contact::Edge> edges = contact::listEdges(n, whole);
  const auto isCut = [&](const contact::Crossing& crossing) {
    return is_whole[crossing.triangle] == 0 || !std::binary_search(edges.begin(), edges.end(), edges_[crossing.edge]);
  };
  found.erase(std::remove_if(found.begin(), found.end(), isCut), found.end());
}

}  // namespace deformable_surface::simulation
