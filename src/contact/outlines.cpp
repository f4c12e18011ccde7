#include "deformable_surface/contact/outlines.h"

#include "deformable_surface/base/disjoint_sets.h"
#include "deformable_surface/base/median.h"

#include <algorithm>
#include <limits>
#include <map>
#include <set>
#include <utility>

namespace deformable_surface::contact {
namespace {

using Triangle = std::array<Index, 3>;
using Loop = std::vector<Index>;

// Of the median edge: loops are filled up where the triangles of their edges with their middles are lower at rest. Higher than
// the lowest triangles of most surfaces (0.2 to 0.35), which limit the proof anyway.
constexpr double kLow = 0.35;
// Points of a hole that is filled up as a whole. Its own triangles are higher than those with its middle.
constexpr std::size_t kSmallHole = 6;
constexpr std::size_t kLongLoop = 4000;  // points of a loop that is not filled up: that takes a time of their square
constexpr Index kManyParts = 64;         // are not worth the proof: their boxes are compared with each other

// Twice the area vector.
Vec3 areaOf(const Loop& loop, const Points& rest) {
  Vec3 sum = Vec3::Zero();
  for (std::size_t k = 0; k < loop.size(); ++k)
    sum += (rest[loop[k]] - rest[loop[0]]).cross(rest[loop[(k + 1) % loop.size()]] - rest[loop[0]]);
  return sum;
}

Vec3 middleOf(const Loop& loop, const Points& rest) {
  Vec3 sum = Vec3::Zero();
  for (const Index i : loop) sum += rest[i];
  return sum / static_cast<double>(loop.size());
}

// Loops of the edges without a triangle beyond. None passes a point twice: there the loop is closed. Returns whether no two
// triangles pass an edge in the same direction; else there are no such loops.
bool findLoops(const std::vector<Triangle>& triangles, std::vector<Loop>& loops) {
  std::vector<std::pair<Index, Index>> edges;
  for (const Triangle& t : triangles)
    for (int k = 0; k < 3; ++k) edges.emplace_back(t[k], t[(k + 1) % 3]);
  std::sort(edges.begin(), edges.end());
  if (std::adjacent_find(edges.begin(), edges.end()) != edges.end()) return false;
  std::set<std::pair<Index, Index>> boundary;
  for (const auto& [from, to] : edges)
    if (!std::binary_search(edges.begin(), edges.end(), std::make_pair(to, from)))
      boundary.emplace_hint(boundary.end(), from, to);
  while (!boundary.empty()) {
    Loop way{boundary.begin()->first};
    do {
      const auto edge = boundary.lower_bound({way.back(), 0});
      const Index next = edge->second;
      boundary.erase(edge);
      const auto passed = std::find(way.begin(), way.end(), next);
      if (passed != way.end()) {
        loops.emplace_back(passed, way.end());
        way.erase(passed, way.end());
      }
      way.push_back(next);
    } while (way.size() > 1);
  }
  return true;
}

// Of the triangle of an edge with the middle: its altitude on the longer of its sides, m; negative where the loop runs back.
// direction: from which the loop runs anticlockwise.
double altitudeAt(const Loop& loop, std::size_t k, const Vec3& middle, const Points& rest, const Vec3& direction) {
  const Vec3 p = rest[loop[k]] - middle, q = rest[loop[(k + 1) % loop.size()]] - middle;
  return direction.dot(p.cross(q)) / std::max(p.norm(), q.norm());
}

// The best triangle between three points in a row outside of the surface: its altitude is the highest, of those at a point
// that may be cut off.
struct Ear {
  std::size_t at = 0;
  double altitude = 0.0;  // m; zero: there is none
};

Ear findEar(const Loop& loop, const Points& rest, const Vec3& direction, const std::vector<char>& may_be_cut) {
  const auto areaBetween = [&](Index a, Index b, Index c) { return direction.dot((rest[b] - rest[a]).cross(rest[c] - rest[a])); };
  const std::size_t n = loop.size();
  Ear best;
  for (std::size_t k = 0; k < n; ++k) {
    if (!may_be_cut[k]) continue;
    const Index before = loop[(k + n - 1) % n], at = loop[k], after = loop[(k + 1) % n];
    const double longest =
        std::max({(rest[before] - rest[at]).norm(), (rest[after] - rest[at]).norm(), (rest[after] - rest[before]).norm()});
    const double altitude = areaBetween(at, before, after) / longest;
    if (!(altitude > best.altitude)) continue;
    const bool is_free = std::none_of(loop.begin(), loop.end(), [&](Index i) {
      return i != before && i != at && i != after && areaBetween(at, before, i) >= 0.0 && areaBetween(before, after, i) >= 0.0 &&
             areaBetween(after, at, i) >= 0.0;
    });
    if (is_free) best = {k, altitude};
  }
  return best;
}

void cutOff(const Ear& ear, Loop& loop, std::vector<Triangle>& triangles) {
  const std::size_t n = loop.size(), k = ear.at;
  triangles.push_back({loop[k], loop[(k + n - 1) % n], loop[(k + 1) % n]});
  loop.erase(loop.begin() + static_cast<std::ptrdiff_t>(k));
}

// Fills the loop up where it runs towards its middle or back, as long as the triangles that fill it are higher than those of its
// edges with its middle.
void straighten(Loop& loop, const Points& rest, const Vec3& direction, double least, std::vector<Triangle>& triangles) {
  while (loop.size() > 3 && loop.size() < kLongLoop) {
    const Vec3 middle = middleOf(loop, rest);
    double lowest = least;
    std::vector<char> may_be_cut(loop.size(), 0);
    for (std::size_t k = 0; k < loop.size(); ++k) {
      const double altitude = altitudeAt(loop, k, middle, rest, direction);
      if (altitude < least) may_be_cut[k] = may_be_cut[(k + 1) % loop.size()] = 1;
      lowest = std::min(lowest, altitude);
    }
    const Ear ear = findEar(loop, rest, direction, may_be_cut);
    if (!(lowest < least) || !(ear.altitude > lowest) || ear.altitude == 0.0) return;
    cutOff(ear, loop, triangles);
  }
}

// The connected parts, each known by its first point.
class Parts {
 public:
  Parts(std::size_t num_points, const std::vector<Triangle>& triangles) : is_lone_(num_points, 1) {
    makeSingleSets(static_cast<Index>(num_points), root_);
    for (const Triangle& t : triangles)
      for (int k = 0; k < 3; ++k) {
        joinSets(root_, t[k], t[(k + 1) % 3]);
        is_lone_[t[k]] = 0;
      }
  }

  Index find(Index i) { return findRoot(root_, i); }
  bool isLone(Index i) const { return is_lone_[i] != 0; }  // has no triangle
  void join(Index lone, Index part) { root_[lone] = part; }

 private:
  std::vector<Index> root_;
  std::vector<char> is_lone_;
};

// What the boundary of a part tells.
struct Rim {
  Vec3 area = Vec3::Zero();  // m^2, twice that of the part
  std::size_t around = 0;    // the loop around it
};

std::map<Index, Rim> findRims(const Points& rest, const std::vector<Loop>& loops, Parts& parts) {
  std::map<Index, Rim> rims;
  for (std::size_t l = 0; l < loops.size(); ++l) {
    Rim& rim = rims.emplace(parts.find(loops[l][0]), Rim{Vec3::Zero(), l}).first->second;
    rim.area += areaOf(loops[l], rest);
  }
  for (std::size_t l = 0; l < loops.size(); ++l) {
    Rim& rim = rims[parts.find(loops[l][0])];
    if (areaOf(loops[l], rest).dot(rim.area) > areaOf(loops[rim.around], rest).dot(rim.area)) rim.around = l;
  }
  return rims;
}

// By loop: the point without triangles in its hole, or -1; nothing if a point has no hole of its own. These points join the
// parts.
std::vector<Index> placeLonePoints(const Points& rest, const std::vector<Loop>& loops, const std::map<Index, Rim>& rims,
                                   Parts& parts) {
  std::vector<Index> middle(loops.size(), -1);
  for (Index i = 0; i < static_cast<Index>(rest.size()); ++i) {
    if (!parts.isLone(i)) continue;
    std::size_t nearest = loops.size();
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t l = 0; l < loops.size(); ++l)
      for (const Index j : loops[l]) {
        const double squared = (rest[i] - rest[j]).squaredNorm();
        if (!(squared < least)) continue;
        least = squared;
        nearest = l;
      }
    if (nearest == loops.size() || middle[nearest] >= 0) return {};
    const Index part = parts.find(loops[nearest][0]);
    if (rims.at(part).around == nearest) return {};
    middle[nearest] = i;
    parts.join(i, part);
  }
  return middle;
}

// Fills a small hole without a point in it. Returns whether nothing of it is left.
bool fillHole(Loop& loop, const Points& rest, const Vec3& direction, std::vector<Triangle>& triangles) {
  if (loop.size() > kSmallHole) return false;
  while (loop.size() > 3) {
    const Ear ear = findEar(loop, rest, direction, std::vector<char>(loop.size(), 1));
    if (ear.altitude == 0.0) return false;
    cutOff(ear, loop, triangles);
  }
  triangles.push_back({loop[0], loop[2], loop[1]});
  return true;
}

}  // namespace

Outlines findOutlines(const Points& rest, const std::vector<Triangle>& triangles) {
  if (triangles.empty()) return {};
  std::vector<double> lengths;
  for (const Triangle& t : triangles)
    for (int k = 0; k < 3; ++k) lengths.push_back((rest[t[k]] - rest[t[(k + 1) % 3]]).norm());
  const double edge = findMedian(std::move(lengths));
  std::vector<Loop> loops;
  if (!findLoops(triangles, loops)) return {};
  Parts parts(rest.size(), triangles);
  const std::map<Index, Rim> rims = findRims(rest, loops, parts);
  const std::vector<Index> middle = placeLonePoints(rest, loops, rims, parts);
  if (middle.size() < loops.size()) return {};

  Outlines made;
  made.edge = edge;
  const auto beginPart = [&] {
    made.parts.push_back({static_cast<Index>(made.points.size()), static_cast<Index>(made.triangles.size()),
                          static_cast<Index>(made.loops.size())});
  };
  const auto addLoop = [&](const Loop& loop, Index in_the_middle, bool is_hole) {
    made.loops.push_back({static_cast<Index>(made.loop_points.size()), in_the_middle, is_hole});
    made.loop_points.insert(made.loop_points.end(), loop.begin(), loop.end());
  };
  const Index n = static_cast<Index>(rest.size());
  for (Index i = 0; i < n; ++i) {
    if (parts.find(i) != i) continue;
    const auto rim = rims.find(i);
    if (rim == rims.end() || made.numParts() == kManyParts) return {};  // closed, or too many
    beginPart();
    for (Index j = 0; j < n; ++j)
      if (parts.find(j) == i) made.points.push_back(j);
    for (const Triangle& t : triangles)
      if (parts.find(t[0]) == i) made.triangles.push_back(t);
    const Vec3 direction = rim->second.area.normalized();
    for (std::size_t l = 0; l < loops.size(); ++l) {
      if (parts.find(loops[l][0]) != i) continue;
      Loop loop = loops[l];
      const bool is_hole = l != rim->second.around;
      if (is_hole && middle[l] < 0 && fillHole(loop, rest, direction, made.triangles)) continue;
      if (middle[l] < 0) straighten(loop, rest, is_hole ? Vec3(-direction) : direction, kLow * edge, made.triangles);
      addLoop(loop, middle[l], is_hole);
    }
  }
  beginPart();
  addLoop({}, -1, false);
  return made;
}

}  // namespace deformable_surface::contact
