#include "deformable_surface/contact/patches.h"

#include "deformable_surface/base/parallel.h"
#include "deformable_surface/base/simd.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace deformable_surface::contact {
namespace {

constexpr Index kBlock = 128;  // patches per task: few, so that small surfaces wake no thread

using Item = std::pair<Vec3, Index>;

// Sorts the vertices so that those of a patch follow each other, and appends where each patch begins.
void split(std::vector<Item>& vertices, Index begin, Index end, std::vector<Index>& begins) {
  if (end - begin <= Patches::kMostVertices) {
    begins.push_back(begin);
    std::sort(vertices.begin() + begin, vertices.begin() + end,
              [](const Item& one, const Item& other) { return one.second < other.second; });
    return;
  }
  const Index half = splitAtMedian(vertices, begin, end);
  split(vertices, begin, half, begins);
  split(vertices, half, end, begins);
}

// The items by the patch of their lowest vertex.
template <std::size_t N>
std::vector<std::vector<Index>> sortByPatch(const std::vector<std::array<Index, N>>& items, const std::vector<Index>& patch_of,
                                            std::size_t num_patches) {
  std::vector<std::vector<Index>> of_patch(num_patches);
  for (std::size_t i = 0; i < items.size(); ++i)
    of_patch[patch_of[*std::min_element(items[i].begin(), items[i].end())]].push_back(static_cast<Index>(i));
  return of_patch;
}

}  // namespace

Patches::Patches(const Points& rest, const std::vector<Index>& given, const std::vector<Edge>& edges,
                 const std::vector<Triangle>& triangles) {
  std::vector<Item> vertices;
  for (const Index i : given) vertices.emplace_back(rest[i], i);
  std::vector<Index> begins;
  if (!vertices.empty()) split(vertices, 0, static_cast<Index>(vertices.size()), begins);
  const std::size_t num = begins.size();
  begins.push_back(static_cast<Index>(vertices.size()));

  std::vector<Index> patch_of(rest.size());
  for (std::size_t p = 0; p < num; ++p)
    for (Index k = begins[p]; k < begins[p + 1]; ++k) patch_of[vertices[k].second] = static_cast<Index>(p);
  const std::vector<std::vector<Index>> edges_of = sortByPatch(edges, patch_of, num);
  const std::vector<std::vector<Index>> triangles_of = sortByPatch(triangles, patch_of, num);
  const auto beginPatch = [&] {
    const auto end = static_cast<Index>(corners_.size());
    patches_.push_back({end, end, static_cast<Index>(edges_.size()), static_cast<Index>(triangles_.size())});
  };
  std::vector<Index> outside;
  for (std::size_t p = 0; p < num; ++p) {
    beginPatch();
    for (Index k = begins[p]; k < begins[p + 1]; ++k) corners_.push_back(vertices[k].second);
    patches_.back().outside = static_cast<Index>(corners_.size());
    outside.clear();
    const auto addOutside = [&](Index v) {
      if (patch_of[v] != static_cast<Index>(p)) outside.push_back(v);
    };
    for (const Index e : edges_of[p]) std::for_each(edges[e].begin(), edges[e].end(), addOutside);
    for (const Index t : triangles_of[p]) std::for_each(triangles[t].begin(), triangles[t].end(), addOutside);
    std::sort(outside.begin(), outside.end());
    corners_.insert(corners_.end(), outside.begin(), std::unique(outside.begin(), outside.end()));
    edges_.insert(edges_.end(), edges_of[p].begin(), edges_of[p].end());
    triangles_.insert(triangles_.end(), triangles_of[p].begin(), triangles_of[p].end());
  }
  beginPatch();
}

Box Patches::boundOf(Index patch, const Points& positions) const {
  Box box;
  for (Index k = patches_[patch].vertices; k < patches_[patch + 1].vertices; ++k) box.extend(positions[corners_[k]]);
  return box;
}

Patches::Ways Patches::waysOf(Index patch, const Points& from, const Points& to) const {
  Vec3 least = Vec3::Constant(std::numeric_limits<double>::infinity()), largest = -least;
  for (Index k = patches_[patch].vertices; k < patches_[patch + 1].vertices; ++k) {
    const Vec3 way = to[corners_[k]] - from[corners_[k]];
    least = least.cwiseMin(way);
    largest = largest.cwiseMax(way);
  }
  return {least, largest};
}

void Patches::measureWays(const Points& from, const Points& to, std::vector<Ways>& ways) const {
  ways.resize(size());
  parallelFor(size(), kBlock, [&](Index begin, Index end) {
    for (Index p = begin; p < end; ++p) ways[p] = waysOf(p, from, to);
  });
}

void Patches::measureWays(const Points& from, const Points& to, const std::vector<Index>& patches,
                          std::vector<Ways>& ways) const {
  ways.resize(size());
  parallelFor(static_cast<Index>(patches.size()), kBlock, [&](Index begin, Index end) {
    for (Index k = begin; k < end; ++k) ways[patches[k]] = waysOf(patches[k], from, to);
  });
}

// Along one axis, so that the relative way of two patches is the sum of theirs.
void Patches::boundWays(const std::vector<double>& lengths, std::vector<Ways>& ways) const {
  ways.resize(size());
  for (Index p = 0; p < size(); ++p) {
    double longest = 0.0;
    for (Index k = patches_[p].vertices; k < patches_[p + 1].vertices; ++k) longest = std::max(longest, lengths[corners_[k]]);
    ways[p] = {-longest * Vec3::UnitX(), longest * Vec3::UnitX()};
  }
}

namespace {

constexpr Index kLanes = 12;  // coordinates of four points

DEFORMABLE_SURFACE_INLINE void extend(const double* from, const double* to, Double4& least, Double4& largest) {
  Double4 begin, end;
  load(from, begin);
  load(to, end);
  const Double4 way = end - begin;
  least = way < least ? way : least;
  largest = way > largest ? way : largest;
}

// Extends the bounds of the displacements of size coordinates, a multiple of kLanes.
DEFORMABLE_SURFACE_WIDE void boundWays(Index size, const double* from, const double* to, double* least, double* largest) {
  Double4 least_of[3], largest_of[3];
  for (Index k = 0; k < 3; ++k) {
    load(least + 4 * k, least_of[k]);
    load(largest + 4 * k, largest_of[k]);
  }
  for (Index i = 0; i < size; i += kLanes)
    for (Index k = 0; k < 3; ++k) extend(from + i + 4 * k, to + i + 4 * k, least_of[k], largest_of[k]);
  for (Index k = 0; k < 3; ++k) {
    store(least_of[k], least + 4 * k);
    store(largest_of[k], largest + 4 * k);
  }
}

}  // namespace

double findLargestRelativeWay(const Points& from, const Points& to) {
  const Index size = 3 * static_cast<Index>(from.size()), whole = size - size % kLanes;
  std::array<double, kLanes> least, largest;
  least.fill(std::numeric_limits<double>::infinity());
  largest.fill(-std::numeric_limits<double>::infinity());
  const double *begin = from.data()->data(), *end = to.data()->data();
  boundWays(whole, begin, end, least.data(), largest.data());
  for (Index i = whole; i < size; ++i) {
    least[i - whole] = std::min(least[i - whole], end[i] - begin[i]);
    largest[i - whole] = std::max(largest[i - whole], end[i] - begin[i]);
  }
  double squared = 0.0;
  for (Index axis = 0; axis < 3; ++axis) {
    for (Index k = axis + 3; k < kLanes; k += 3) {
      least[axis] = std::min(least[axis], least[k]);
      largest[axis] = std::max(largest[axis], largest[k]);
    }
    squared += (largest[axis] - least[axis]) * (largest[axis] - least[axis]);
  }
  return std::sqrt(squared);
}

}  // namespace deformable_surface::contact
