#include "deformable_surface/contact/quick_look.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

namespace deformable_surface::contact {
namespace {

// Points that are so many edges apart do not count, nor those of one more for each edge of the reach: in thick shells these are
// near at rest. For a reach beyond three edges they would be too many, and all is near.
constexpr double kRings = 3.0, kMostRings = 6.0;
// Of the reach of two points: nor do they count if a path along edges between them was no longer at rest. In uneven triangles
// three edges may be shorter than the reach.
constexpr double kPath = 2.0;
// Of the longest edge at either of two points: layers whose points are farther apart do not touch. A place in a triangle is
// within 0.58 of its longest side of a corner. The middles of two edges that cross are within 0.71 of one of their ends.
constexpr double kOfEdge = 0.75;
constexpr double kSharp = 0.0;   // cosine of the angle between the normals of two triangles: a right angle
constexpr double kBeyond = 0.3;  // less than the cosine at rest, for folds that are sharp there

void boundVertices(const Patches& patches, const Points& positions, double larger, std::vector<Box>& boxes) {
  boxes.assign(patches.size(), Box());
  for (Index p = 0; p < patches.size(); ++p) {
    patches.visitVertices(p, [&](Index v) { boxes[p].extend(positions[v]); });
    boxes[p] = grow(boxes[p], larger);
  }
}

std::vector<Box> boundVertices(const Patches& patches, const Points& positions) {
  std::vector<Box> boxes;
  boundVertices(patches, positions, 0.0, boxes);
  return boxes;
}

// m, of the edges at each point (n), overwritten. Returns the longest of all.
double findLongest(const Points& positions, const std::vector<Edge>& edges, std::vector<double>& of_points) {
  of_points.assign(positions.size(), 0.0);
  double longest = 0.0;
  for (const auto& [a, b] : edges) {
    const double length = (positions[a] - positions[b]).norm();
    of_points[a] = std::max(of_points[a], length);
    of_points[b] = std::max(of_points[b], length);
    longest = std::max(longest, length);
  }
  return longest;
}

using Neighbourhood = std::vector<std::vector<Index>>;  // of each point: the others at its edges

// The points so many edges from a point, or nearer.
void listWithinRings(const Neighbourhood& next, Index from, std::size_t rings, std::vector<Index>& found) {
  found = {from};
  for (std::size_t begin = 0, ring = 0; ring < rings; ++ring)
    for (const std::size_t end = found.size(); begin < end; ++begin)
      for (const Index j : next[found[begin]])
        if (std::find(found.begin(), found.end(), j) == found.end()) found.push_back(j);
}

// The points to which a path along edges is no longer than most, m; some more than once. path: (n), infinite before and after.
void listWithinPath(const Points& rest, const Neighbourhood& next, Index from, double most, std::vector<double>& path,
                    std::vector<Index>& found) {
  found = {from};
  path[from] = 0.0;
  for (std::size_t k = 0; k < found.size(); ++k)
    for (const Index j : next[found[k]]) {
      const Index i = found[k];
      const double longer = path[i] + (rest[i] - rest[j]).norm();
      if (!(longer <= most && longer < path[j])) continue;
      path[j] = longer;
      found.push_back(j);
    }
  for (const Index i : found) path[i] = std::numeric_limits<double>::infinity();
}

// Pairs of points, either first, that are neighbours along the surface.
std::vector<Edge> listAlong(const Points& rest, const std::vector<Edge>& edges, double reach) {
  const auto n = static_cast<Index>(rest.size());
  Neighbourhood next(n);
  double sum = 0.0;
  for (const auto& [a, b] : edges) {
    next[a].push_back(b);
    next[b].push_back(a);
    sum += (rest[a] - rest[b]).norm();
  }
  const double mean = edges.empty() ? 0.0 : sum / edges.size(), in_reach = std::min(reach, (kMostRings - kRings) * mean);
  const auto rings = static_cast<std::size_t>(mean > 0.0 ? kRings + in_reach / mean : kRings);
  std::vector<double> longest, path(n, std::numeric_limits<double>::infinity());
  findLongest(rest, edges, longest);
  std::vector<Edge> pairs;
  std::vector<Index> found;
  for (Index i = 0; i < n; ++i) {
    listWithinRings(next, i, rings, found);
    for (const Index j : found) pairs.push_back({i, j});
    listWithinPath(rest, next, i, kPath * (kOfEdge * longest[i] + in_reach), path, found);
    for (const Index j : found) {
      pairs.push_back({i, j});
      pairs.push_back({j, i});
    }
  }
  return pairs;
}

void findNormals(const Points& positions, const std::vector<Triangle>& triangles, std::vector<Vec3>& normals) {
  normals.resize(triangles.size());
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    const auto& [a, b, c] = triangles[t];
    normals[t] = (positions[b] - positions[a]).cross(positions[c] - positions[a]).normalized();
  }
}

// Whether the corners of a triangle go from the first vertex of the edge to the second.
bool goesAlong(const Triangle& triangle, const Edge& edge) {
  for (int k = 0; k < 3; ++k)
    if (triangle[k] == edge[0]) return triangle[(k + 1) % 3] == edge[1];
  return false;
}

}  // namespace

QuickLook::QuickLook(const Points& rest, const std::vector<Triangle>& triangles, const std::vector<Edge>& edges,
                     const Patches& patches, double reach, bool is_body)
    : triangles_(triangles),
      edges_(edges),
      patches_(patches),
      reach_(reach),
      num_points_(static_cast<Index>(rest.size())),
      boxes_(boundVertices(patches, rest)),
      tree_(boxes_) {
  listFolds(rest);
  of_one_.reserve(Patches::kMostVertices);
  of_other_.reserve(Patches::kMostVertices);
  std::vector<Edge> pairs = listAlong(rest, edges_, reach_);
  if (is_body) {
    const std::vector<Edge> opposite = listOpposite(rest);
    pairs.insert(pairs.end(), opposite.begin(), opposite.end());
  }
  setNeighbours(pairs);
}

void QuickLook::listFolds(const Points& rest) {
  findNormals(rest, triangles_, normals_);
  std::vector<Index> first(edges_.size(), -1);
  for (Index t = 0; t < static_cast<Index>(triangles_.size()); ++t)
    for (int k = 0; k < 3; ++k) {
      const Index a = triangles_[t][k], b = triangles_[t][(k + 1) % 3];
      const Edge edge{std::min(a, b), std::max(a, b)};
      Index& one = first[std::lower_bound(edges_.begin(), edges_.end(), edge) - edges_.begin()];
      if (one < 0) {
        one = t;
        continue;
      }
      const double sense = goesAlong(triangles_[one], edge) == goesAlong(triangles_[t], edge) ? -1.0 : 1.0;
      folds_.push_back({one, t, sense, std::min(kSharp, sense * normals_[one].dot(normals_[t]) - kBeyond)});
    }
}

void QuickLook::setNeighbours(const std::vector<Edge>& pairs) {
  std::vector<Index> patch_of(num_points_, -1), place(num_points_, 0);
  for (Index p = 0; p < patches_.size(); ++p) {
    Index num = 0;
    patches_.visitVertices(p, [&](Index v) {
      patch_of[v] = p;
      place[v] = num++;
    });
  }
  std::map<std::array<Index, 2>, Neighbours> by_couple;
  for (const auto& [i, j] : pairs) {
    const Index one = patch_of[i], other = patch_of[j];
    if (one >= 0 && one <= other) by_couple[{one, other}][place[i]] |= std::uint32_t{1} << place[j];
  }
  for (const auto& [couple, neighbours] : by_couple) {
    couples_.push_back(couple);
    neighbours_.push_back(neighbours);
  }
}

// Pairs of near points, either first, between which a body is, rather than room: it is in the way of their contact. Called before
// there are neighbours, it lists some of these, too.
std::vector<Edge> QuickLook::listOpposite(const Points& rest) {
  Points normals(rest.size(), Vec3::Zero());
  double volume = 0.0;  // times six
  for (const auto& [a, b, c] : triangles_) {
    const Vec3 normal = (rest[b] - rest[a]).cross(rest[c] - rest[a]);
    for (const Index i : {a, b, c}) normals[i] += normal;
    volume += normal.dot(rest[a] - rest[0]);
  }
  for (Vec3& normal : normals) normal = volume > 0.0 ? normal.normalized() : -normal.normalized();
  std::vector<Edge> pairs;
  visitNear(rest, [&](Index i, Index j) {
    if ((rest[j] - rest[i]).dot(normals[j] - normals[i]) > 0.0) {
      pairs.push_back({i, j});
      pairs.push_back({j, i});
    }
    return false;
  });
  return pairs;
}

bool QuickLook::isAnyNear(const Points& positions) {
  return isAnyFoldSharp(positions) || visitNear(positions, [&](Index i, Index j) {
           place_seen_ = 0.5 * (positions[i] + positions[j]);
           return true;
         });
}

// Undefined numbers count as sharp.
bool QuickLook::isAnyFoldSharp(const Points& positions) {
  findNormals(positions, triangles_, normals_);
  const auto sharp = std::find_if(folds_.begin(), folds_.end(), [&](const Fold& fold) {
    return !(fold.sense * normals_[fold.one].dot(normals_[fold.other]) >= fold.least);
  });
  if (sharp == folds_.end()) return false;
  place_seen_ = positions[triangles_[sharp->one][0]];
  return true;
}

template <class Visit>
bool QuickLook::visitNear(const Points& positions, const Visit& visit) {
  const double longest = findLongest(positions, edges_, longest_);
  const double half = 0.5 * (kOfEdge * longest + reach_);
  boundVertices(patches_, positions, half, boxes_);
  tree_.refit(boxes_);
  static constexpr Neighbours kNone{};
  bool is_done = false;
  for (Index p = 0; p < patches_.size() && !is_done; ++p)
    tree_.visitMeeting(boxes_[p], [&](Index q) {
      if (q < p || is_done) return;
      listWithin(p, grow(boxes_[q], half), positions, of_one_);
      if (of_one_.empty()) return;
      listWithin(q, grow(boxes_[p], half), positions, of_other_);
      const auto couple = std::lower_bound(couples_.begin(), couples_.end(), std::array<Index, 2>{p, q});
      const bool is_listed = couple != couples_.end() && *couple == std::array<Index, 2>{p, q};
      const Neighbours& neighbours = is_listed ? neighbours_[couple - couples_.begin()] : kNone;
      for (const Vertex& v : of_one_)
        for (const Vertex& w : of_other_) {
          if ((neighbours[v.place] >> w.place & 1U) != 0) continue;
          const double reach = kOfEdge * std::max(longest_[v.index], longest_[w.index]) + reach_;
          const bool is_near = (positions[v.index] - positions[w.index]).squaredNorm() < reach * reach;
          is_done = is_done || (is_near && visit(v.index, w.index));
        }
    });
  return is_done;
}

void QuickLook::listWithin(Index patch, const Box& box, const Points& positions, std::vector<Vertex>& list) const {
  list.clear();
  Index place = 0;
  patches_.visitVertices(patch, [&](Index v) {
    if (box.contains(positions[v])) list.push_back({v, place});
    ++place;
  });
}

}  // namespace deformable_surface::contact
