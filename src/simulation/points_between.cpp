#include "points_between.h"

#include "deformable_surface/cloud/kd_tree.h"

#include <algorithm>
#include <limits>

namespace deformable_surface::simulation {
namespace {

constexpr int kReach = 4;  // links: farther than any simulation point that a point of an uncut cell follows

// The simulation point in whose cell each dense point lies; -1: in none.
std::vector<Index> findOwners(const cloud::CleanCloud& dense, const RestSurface& surface) {
  if (!surface.cells.owner.empty()) return surface.cells.owner;
  const cloud::KdTree tree(surface.points);
  std::vector<cloud::Neighbor> nearest;
  std::vector<Index> owner;
  for (const Vec3& p : dense.positions) {
    tree.nearest(p, 1, nearest);
    owner.push_back(nearest.front().index);
  }
  return owner;
}

// Farthest point sampling: at most `most` of the candidates, each far from those before it and from the center.
std::vector<Index> spread(const Points& positions, const Vec3& center, const std::vector<Index>& candidates, Index most) {
  std::vector<double> squared;
  for (const Index d : candidates) squared.push_back((positions[d] - center).squaredNorm());
  std::vector<Index> chosen;
  for (Index k = 0; k < std::min(most, static_cast<Index>(candidates.size())); ++k) {
    const Index next = candidates[std::max_element(squared.begin(), squared.end()) - squared.begin()];
    chosen.push_back(next);
    for (std::size_t c = 0; c < candidates.size(); ++c)
      squared[c] = std::min(squared[c], (positions[candidates[c]] - positions[next]).squaredNorm());
  }
  return chosen;
}

// The dense points in the cell of each simulation point, without the latter.
std::vector<std::vector<Index>> listCells(const cloud::CleanCloud& dense, const RestSurface& surface) {
  const std::vector<Index> owner = findOwners(dense, surface);
  std::vector<char> is_simulated(dense.positions.size(), 0);
  for (const Index d : surface.dense_index) is_simulated[d] = 1;
  std::vector<std::vector<Index>> cells(surface.points.size());
  for (std::size_t d = 0; d < dense.positions.size(); ++d)
    if (owner[d] >= 0 && is_simulated[d] == 0) cells[owner[d]].push_back(static_cast<Index>(d));
  return cells;
}

std::shared_ptr<const transfer::SampledPoints> sample(const SceneParams& params, const cloud::CleanCloud& dense,
                                                      const RestSurface& surface, const std::vector<std::vector<Index>>& cells,
                                                      Index most, Index most_spare) {
  const Index m = static_cast<Index>(surface.points.size());
  Points positions, normals;
  std::vector<Index> cell;
  std::vector<char> is_spare;
  const auto add = [&](Index owner, Index d, bool spare) {
    positions.push_back(dense.positions[d]);
    normals.push_back(dense.normals[d]);
    cell.push_back(owner);
    is_spare.push_back(spare);
  };
  for (Index i = 0; i < m; ++i) {
    std::vector<Index> chosen = spread(dense.positions, surface.points[i], cells[i], most + most_spare);
    const auto spare = chosen.begin() + std::min(most, static_cast<Index>(chosen.size()));
    std::sort(chosen.begin(), spare);
    for (auto d = chosen.begin(); d != chosen.end(); ++d) add(i, *d, d >= spare);
    if (most_spare > 0 && !surface.dense_index.empty()) add(i, surface.dense_index[i], true);
  }
  if (cell.empty()) return nullptr;
  const bool is_euclidean = params.neighbors.areEuclidean();
  const Lists followed = is_euclidean ? Lists{} : cloud::findChosenNear(surface.cells, cell, positions, params.transfer.k);
  const transfer::Transfer rows(positions, normals, surface.points, std::vector<char>(m, 1), params.transfer,
                                is_euclidean ? nullptr : &followed);
  return std::make_shared<transfer::SampledPoints>(rows, surface.points, cell, std::move(is_spare));
}

}  // namespace

std::shared_ptr<const transfer::SampledPoints> choosePointsBetween(const SceneParams& params, const cloud::CleanCloud& dense,
                                                                   const RestSurface& surface, bool with_spare) {
  const Index most = params.contact.cloud_points;
  if (most == 0 || dense.positions.size() <= surface.points.size()) return nullptr;
  return sample(params, dense, surface, listCells(dense, surface), most, with_spare ? std::max<Index>(kMostPoints - most, 1) : 0);
}

std::shared_ptr<const LoadPoints> chooseLoadPoints(const SceneParams& params, const cloud::CleanCloud& dense,
                                                   const RestSurface& surface, Index most,
                                                   std::shared_ptr<const transfer::SampledPoints> between) {
  if (dense.positions.size() <= surface.points.size()) return nullptr;
  const std::vector<std::vector<Index>> cells = listCells(dense, surface);
  if (!between || params.contact.cloud_points != most) between = sample(params, dense, surface, cells, most, 0);
  if (!between) return nullptr;
  LoadPoints load;
  load.share.assign(between->size(), 0.0);
  Points places;
  for (Index s = 0; s < between->size(); ++s) places.push_back(between->place(s, surface.points));
  for (std::size_t i = 0; i < cells.size(); ++i) {
    const Index cell = static_cast<Index>(i);
    const double part = 1.0 / static_cast<double>(cells[i].size() + 1);
    load.own_share.push_back(part);
    for (const Index d : cells[i]) {
      Index nearest = -1;
      double squared = (dense.positions[d] - surface.points[i]).squaredNorm();
      for (Index s = between->begin(cell); s < between->end(cell); ++s) {
        const double to_sample = (dense.positions[d] - places[s]).squaredNorm();
        if (to_sample < squared) {
          squared = to_sample;
          nearest = s;
        }
      }
      (nearest < 0 ? load.own_share.back() : load.share[nearest]) += part;
    }
  }
  load.between = std::move(between);
  return std::make_shared<LoadPoints>(std::move(load));
}

std::vector<char> findSevered(const transfer::SampledPoints& between, const std::vector<std::pair<Index, Index>>& links,
                              Index m) {
  std::vector<std::vector<Index>> ring(m);
  for (const auto& [a, b] : links) {
    ring[a].push_back(b);
    ring[b].push_back(a);
  }
  std::vector<char> is_severed(between.size(), 0);
  std::vector<Index> reached, distance(m, -1);
  for (Index cell = 0; cell < m; ++cell) {
    if (between.begin(cell) == between.end(cell)) continue;
    reached.assign(1, cell);
    distance[cell] = 0;
    for (std::size_t k = 0; k < reached.size() && distance[reached[k]] < kReach; ++k)
      for (const Index j : ring[reached[k]])
        if (distance[j] < 0) {
          distance[j] = distance[reached[k]] + 1;
          reached.push_back(j);
        }
    for (Index s = between.begin(cell); s < between.end(cell); ++s)
      between.visitWeights(s, [&](Index j, double) { is_severed[s] = is_severed[s] || distance[j] < 0; });
    for (const Index j : reached) distance[j] = -1;
  }
  return is_severed;
}

}  // namespace deformable_surface::simulation
