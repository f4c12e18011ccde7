#include "points_between.h"

#include "deformable_surface/cloud/kd_tree.h"

#include <algorithm>
#include <limits>
#include <set>
#include <utility>

#include "contact_skin.h"

namespace deformable_surface::simulation {
namespace {

constexpr int kReach = 4;  // links: farther than any simulation point that a point of an uncut cell follows
constexpr int kParts = 4;  // of the sides of triangles
constexpr Index kFew = 8;  // dense points in a cell: fewer are farther apart than places on triangles

using transfer::PlaceOnTriangle;

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

std::vector<model::WeightedTriangle> listTriangles(const RestSurface& surface) {
  std::vector<model::WeightedTriangle> triangles;
  for (const cloud::Triangle& t : surface.rings.triangles)
    triangles.push_back({{t.corner[0], t.corner[1], t.corner[2]}, t.weight});
  return triangles;
}

// All places on the triangles between the simulation points, kParts to a side, without the corners.
std::vector<PlaceOnTriangle> listPlaces(const std::vector<model::WeightedTriangle>& given) {
  std::set<std::pair<Index, Index>> sides;
  std::vector<PlaceOnTriangle> places;
  constexpr double kPart = 1.0 / kParts;
  for (const auto& [a, b, c] : chooseTriangulation(given)) {
    // Sides of neighbours once.
    const bool is_new[3] = {sides.insert(std::minmax(b, c)).second, sides.insert(std::minmax(c, a)).second,
                            sides.insert(std::minmax(a, b)).second};
    for (int i = 0; i <= kParts; ++i)
      for (int j = 0; i + j <= kParts; ++j) {
        const std::array<int, 3> parts{i, j, kParts - i - j};
        const auto side = std::find(parts.begin(), parts.end(), 0);
        const bool is_corner = std::find(parts.begin(), parts.end(), kParts) != parts.end();
        if (is_corner || (side != parts.end() && !is_new[side - parts.begin()])) continue;
        places.push_back({{a, b, c}, {kPart * parts[0], kPart * parts[1], kPart * parts[2]}});
      }
  }
  return places;
}

// Points between simulation points, by cells.
class Sample {
 public:
  using Use = transfer::SampledPoints::Use;

  Sample(const cloud::CleanCloud& dense, const RestSurface& surface, const std::vector<std::vector<Index>>& cells)
      : dense_(dense), surface_(surface), cells_(cells) {}

  /// At most `most` dense points of each cell, spread over it, and spare ones.
  void addDense(Index most, Index most_spare) {
    for (Index i = 0; i < static_cast<Index>(cells_.size()); ++i) {
      std::vector<Index> chosen = spread(dense_.positions, surface_.points[i], cells_[i], most + most_spare);
      const auto spare = chosen.begin() + std::min(most, static_cast<Index>(chosen.size()));
      std::sort(chosen.begin(), spare);
      for (auto d = chosen.begin(); d != chosen.end(); ++d)
        add(i, dense_.positions[*d], dense_.normals[*d], d < spare ? Use::kAlways : Use::kSpare);
      const bool has_center = most_spare > 0 && !surface_.dense_index.empty();
      if (has_center) add(i, dense_.positions[surface_.dense_index[i]], dense_.normals[surface_.dense_index[i]], Use::kSpare);
    }
  }
  /// Spare places on the triangles, where cells have few dense points: moved to the tangent plane of the nearest one.
  void addPlaces() {
    const auto isFew = [](const std::vector<Index>& cell) { return static_cast<Index>(cell.size()) < kFew; };
    if (std::none_of(cells_.begin(), cells_.end(), isFew)) return;
    for (const PlaceOnTriangle& place : listPlaces(listTriangles(surface_))) {
      const Index i = place.nearest();
      if (!isFew(cells_[i])) continue;
      const Vec3 p = place.interpolate(surface_.points);
      Vec3 near = surface_.points[i], normal = surface_.normals[i];
      for (const Index d : cells_[i]) {
        if (!((dense_.positions[d] - p).squaredNorm() < (near - p).squaredNorm())) continue;
        near = dense_.positions[d];
        normal = dense_.normals[d];
      }
      add(i, p - (p - near).dot(normal) * normal, place.interpolate(surface_.normals).normalized(), Use::kSparePlace);
    }
  }
  std::shared_ptr<const transfer::SampledPoints> finish(const SceneParams& params) {
    if (points_.empty()) return nullptr;
    std::stable_sort(points_.begin(), points_.end(), [](const Point& a, const Point& b) { return a.cell < b.cell; });
    Points positions, normals;
    std::vector<Index> cell;
    std::vector<Use> use;
    for (const Point& point : points_) {
      positions.push_back(point.position);
      normals.push_back(point.normal);
      cell.push_back(point.cell);
      use.push_back(point.use);
    }
    const bool is_euclidean = params.neighbors.areEuclidean();
    const Lists followed = is_euclidean ? Lists{} : cloud::findChosenNear(surface_.cells, cell, positions, params.transfer.k);
    const transfer::Transfer rows(positions, normals, surface_.points, std::vector<char>(surface_.points.size(), 1),
                                  params.transfer, is_euclidean ? nullptr : &followed);
    return std::make_shared<transfer::SampledPoints>(rows, surface_.points, cell, std::move(use));
  }

 private:
  struct Point {
    Index cell;
    Vec3 position, normal;
    Use use;
  };
  void add(Index cell, const Vec3& position, const Vec3& normal, Use use) { points_.push_back({cell, position, normal, use}); }

  const cloud::CleanCloud& dense_;
  const RestSurface& surface_;
  const std::vector<std::vector<Index>>& cells_;
  std::vector<Point> points_;
};

}  // namespace

std::shared_ptr<const transfer::SampledPoints> choosePointsBetween(const SceneParams& params, const cloud::CleanCloud& dense,
                                                                   const RestSurface& surface, bool with_spare) {
  const Index most = params.contact.cloud_points;
  if (most == 0 || dense.positions.size() <= surface.points.size()) return nullptr;
  const std::vector<std::vector<Index>> cells = listCells(dense, surface);
  Sample sample(dense, surface, cells);
  sample.addDense(most, with_spare ? std::max<Index>(kMostPoints - most, 1) : 0);
  if (with_spare) sample.addPlaces();
  return sample.finish(params);
}

std::shared_ptr<const transfer::SampledPoints> choosePlacesOnTriangles(const SceneParams& params, const RestSurface& surface) {
  return choosePlacesOnTriangles(params, listTriangles(surface), surface.points);
}

std::shared_ptr<const transfer::SampledPoints> choosePlacesOnTriangles(const SceneParams& params,
                                                                       const std::vector<model::WeightedTriangle>& triangles,
                                                                       const Points& rest) {
  if (params.contact.cloud_points == 0 || triangles.empty()) return nullptr;
  return std::make_shared<transfer::SampledPoints>(listPlaces(triangles), rest);
}

std::shared_ptr<const LoadPoints> chooseLoadPoints(const SceneParams& params, const cloud::CleanCloud& dense,
                                                   const RestSurface& surface, Index most,
                                                   std::shared_ptr<const transfer::SampledPoints> between) {
  if (dense.positions.size() <= surface.points.size()) return nullptr;
  const std::vector<std::vector<Index>> cells = listCells(dense, surface);
  if (!between || params.contact.cloud_points != most) {
    Sample sample(dense, surface, cells);
    sample.addDense(most, 0);
    between = sample.finish(params);
  }
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
  if (between.areLinear()) {
    const auto isLinked = [&](Index a, Index b) {
      return a == b || std::find(ring[a].begin(), ring[a].end(), b) != ring[a].end();
    };
    for (Index s = 0; s < between.size(); ++s)
      between.visitWeights(s, [&](Index a, double) {
        between.visitWeights(s, [&](Index b, double) { is_severed[s] = is_severed[s] || !isLinked(a, b); });
      });
    return is_severed;
  }
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
