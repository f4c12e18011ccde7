#include "deformable_surface/contact/pair_list.h"

#include "deformable_surface/base/error.h"
#include "deformable_surface/base/median.h"
#include "deformable_surface/base/parallel.h"
#include "deformable_surface/base/value.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

namespace deformable_surface::contact {
namespace {

// Fraction of the median edge: the cheapest of 0.5 to 0.9 for a shell that snaps; below the rest distance of parts that are not
// neighbours.
constexpr double kUsualRadius = 0.6;
// Factor on a requested radius beyond the usual one, so that the list remains valid for a while.
constexpr double kSpare = 1.5;
// Fraction of the rest distance at which parts begin to repel each other; and neighbours on the surface, which are strained
// elastically before they fold onto each other.
constexpr double kOfRest = 0.9;
constexpr double kOfRestJoined = 0.5;
// Boxes of patches that are nearer make a couple, as a fraction of the median edge.
constexpr double kCoupled = 3.0;
// Visits of pairs, for each listed pair, until all are measured again.
constexpr std::size_t kMostVisits = 1;
constexpr Index kBlock = 4;  // patches or couples per task

std::vector<Box> boundAll(const Patches& patches, const Points& positions) {
  std::vector<Box> boxes;
  for (Index p = 0; p < patches.size(); ++p) boxes.push_back(patches.boundOf(p, positions));
  return boxes;
}

std::vector<Index> listVertices(Index n, const std::vector<Edge>& edges, bool takes_lone_points) {
  std::vector<char> is_listed(n, takes_lone_points ? 1 : 0);
  for (const Edge& edge : edges) is_listed[edge[0]] = is_listed[edge[1]] = 1;
  std::vector<Index> vertices;
  for (Index i = 0; i < n; ++i)
    if (is_listed[i] != 0) vertices.push_back(i);
  return vertices;
}

// Those of some triangles or edges that were whole and no longer are.
template <class Part>
class LostParts {
 public:
  // 1: whole; empty: all are.
  LostParts(const std::vector<Part>& parts, const std::vector<char>& before, const std::vector<char>& now) {
    for (std::size_t i = 0; i < parts.size(); ++i) {
      const bool was_whole = before.empty() || before[i] != 0;
      if (was_whole && now[i] == 0) lost_.push_back(parts[i]);
      comes_back_ = comes_back_ || (!was_whole && now[i] != 0);
    }
    std::sort(lost_.begin(), lost_.end());
  }

  bool holds(const Part& part) const { return std::binary_search(lost_.begin(), lost_.end(), part); }
  bool comesBack() const { return comes_back_; }

 private:
  std::vector<Part> lost_;
  bool comes_back_ = false;  // any that was lost before
};

}  // namespace

PairList::PairList(Points rest, const std::vector<Triangle>& triangles, double thickness, bool takes_lone_points)
    : rest_(std::move(rest)),
      triangles_(triangles),
      thickness_(thickness),
      edges_(listEdges(static_cast<Index>(rest_.size()), triangles_)),
      patches_(rest_, listVertices(static_cast<Index>(rest_.size()), edges_, takes_lone_points), edges_, triangles_),
      boxes_(boundAll(patches_, rest_)),
      tree_(boxes_),
      parts_(patches_.size()) {
  if (!(thickness > 0.0)) throw InputError("contact: thickness: found " + formatShort(thickness) + " m; accepted: above 0");
  std::vector<double> lengths;
  for (const auto& [a, b] : edges_) lengths.push_back((rest_[a] - rest_[b]).norm());
  median_edge_ = lengths.empty() ? 0.0 : findMedian(std::move(lengths));
  usual_radius_ = std::max(kUsualRadius * median_edge_, 2.0 * thickness);
  findCrossed(rest_);
  at_rest_ = crossed_;
}

// Where nothing comes back, the lists only lose pairs: each tear takes a triangle or two.
void PairList::keepWhole(const std::vector<char>& is_whole) {
  const std::vector<char> was_whole = std::exchange(is_whole_, is_whole), was_edge_whole = std::move(is_edge_whole_);
  is_edge_whole_.assign(edges_.size(), 0);
  for (std::size_t t = 0; t < triangles_.size(); ++t) {
    if (!is_whole[t]) continue;
    for (int k = 0; k < 3; ++k) {
      const Index a = triangles_[t][k], b = triangles_[t][(k + 1) % 3];
      const Edge edge{std::min(a, b), std::max(a, b)};
      is_edge_whole_[std::lower_bound(edges_.begin(), edges_.end(), edge) - edges_.begin()] = 1;
    }
  }
  const LostParts<Triangle> lost(triangles_, was_whole, is_whole_);
  const LostParts<Edge> lost_edges(edges_, was_edge_whole, is_edge_whole_);
  const bool comes_back = lost.comesBack() || lost_edges.comesBack();
  for (Couple& couple : couples_) {
    if (comes_back) couple.radius = -1.0;
    std::vector<Listed>& listed = couple.listed;
    const auto isLost = [&](const Listed& at) {
      const auto& [a, b, c, d] = at.pair.vertices;
      return at.pair.is_edges ? lost_edges.holds({a, b}) || lost_edges.holds({c, d}) : lost.holds({b, c, d});
    };
    listed.erase(std::remove_if(listed.begin(), listed.end(), isLost), listed.end());
  }
  nearest_ = -1.0;
  is_enclosed_.clear();
}

bool PairList::findCrossed(const Points& positions) {
  std::vector<std::array<Index, 2>> before;
  before.swap(crossed_);
  crossings_.clear();
  std::vector<Box> boxes;
  for (const Triangle& t : triangles_) boxes.push_back(boundOf(positions, t));
  const BoxTree tree(boxes);
  std::vector<char> crosses(triangles_.size(), 0);
  visitCrossings(positions, edges_, triangles_, tree, [&](const Crossing& crossing) {
    if (!is_whole_.empty() && (is_edge_whole_[crossing.edge] == 0 || is_whole_[crossing.triangle] == 0)) return;
    const Edge& edge = edges_[crossing.edge];
    if (crossings_.empty()) first_crossing_ = 0.5 * (positions[edge[0]] + positions[edge[1]]);
    crossings_.push_back(crossing);
    crosses[crossing.triangle] = 1;
    for (const Index e : edge)
      for (const Index i : triangles_[crossing.triangle]) crossed_.push_back({std::min(e, i), std::max(e, i)});
  });
  std::sort(crossed_.begin(), crossed_.end());
  crossed_.erase(std::unique(crossed_.begin(), crossed_.end()), crossed_.end());
  num_crossed_ = std::count(crosses.begin(), crosses.end(), char{1});
  if (crossed_ == before) return false;
  for (Couple& couple : couples_) couple.radius = -1.0;
  nearest_ = -1.0;
  return true;
}

bool PairList::isAnyIn(const std::vector<std::array<Index, 2>>& couples, const Pair& pair) {
  for (int v = 0; v < pair.numFirst(); ++v)
    for (int w = pair.numFirst(); w < 4; ++w) {
      const Index i = pair.vertices[v], j = pair.vertices[w];
      if (std::binary_search(couples.begin(), couples.end(), std::array<Index, 2>{std::min(i, j), std::max(i, j)})) return true;
    }
  return false;
}

bool PairList::areFar(const Points& positions, const Points& next, const Reach& reach, const Cover* cover) const {
  if (edges_.empty()) return true;
  if (!(nearest_ >= reach.least) || cover_ != cover || (cover && revision_ != cover->revision())) return false;
  const double way = &positions == &next ? 0.0 : findLargestRelativeWay(positions, next);
  return findNearestAt(positions) >= reach.of(way);
}

// m, a bound of the distance of all pairs that the cover does not hold.
double PairList::findNearestAt(const Points& positions) const { return nearest_ - findLargestRelativeWay(seen_at_, positions); }

double PairList::findLargestLocalWay(const Points& from, const Points& to) {
  patches_.measureWays(from, to, next_ways_);
  double largest = 0.0;
  for (const Patches::Ways& ways : next_ways_) largest = std::max(largest, ways.findRelative(ways));
  return largest;
}

void PairList::update(const Points& positions, const Points& next, const Reach& reach, const Cover* cover) {
  are_far_ = areFar(positions, next, reach, cover);
  if (are_far_) {
    apart_now_ = edges_.empty() ? std::numeric_limits<double>::infinity() : findNearestAt(positions);
    return;
  }
  const bool rests = &positions == &next;
  update(positions, reach, cover, rests ? 0.0 : findLargestRelativeWay(positions, next), [&] {
    if (rests)
      next_ways_.assign(patches_.size(), {Vec3::Zero(), Vec3::Zero()});
    else
      patches_.measureWays(positions, next, open_patches_, next_ways_);
  });
}

void PairList::update(const Points& positions, const std::vector<double>& ways, const Reach& reach) {
  are_far_ = edges_.empty();
  if (are_far_) return;
  update(positions, reach, nullptr, 2.0 * *std::max_element(ways.begin(), ways.end()),
         [&] { patches_.boundWays(ways, next_ways_); });
}

template <class MeasureWays>
void PairList::update(const Points& positions, const Reach& reach, const Cover* cover, double largest,
                      const MeasureWays& measureWays) {
  const double farthest = reach.of(largest) + reach.spare, gone = at_.empty() ? 0.0 : findLargestRelativeWay(at_, positions);
  if (at_.empty()) at_ = positions;
  findOpen(cover);
  patches_.measureWays(at_, positions, open_patches_, ways_);
  measureWays();
  const bool are_all_coupled = apart_ - gone >= farthest, are_worn = num_visits_ - measured_after_ > kMostVisits * num_listed_;
  markExpired(reach);
  if (are_all_coupled && expired_.empty() && !are_worn) return rememberNearest(positions, apart_ - gone);

  if (at_ != positions) {
    is_enclosed_.clear();
    has_box_.clear();
  }
  if (open_.size() < couples_.size()) patches_.measureWays(at_, positions, ways_);
  parallelFor(static_cast<Index>(couples_.size()), kCouplesAtOnce, [&](Index begin, Index end) {
    for (Index k = begin; k < end; ++k) couples_[k].used += ways_[couples_[k].one].findRelative(ways_[couples_[k].other]);
  });
  apart_ -= gone;
  at_ = positions;
  ways_.assign(ways_.size(), {Vec3::Zero(), Vec3::Zero()});
  if (are_worn) measureAgain(positions);
  if (!are_all_coupled) {
    findCouples(positions, farthest);
    revision_ = -1;
    findOpen(cover);
    measureWays();
  }
  markExpired(reach);
  if (!expired_.empty()) searchExpired(positions);
  num_listed_ = 0;
  for (const Couple& couple : couples_) num_listed_ += couple.listed.size();
  rememberNearest(positions, apart_);
}

// apart: m, of patches that are no couple.
void PairList::rememberNearest(const Points& positions, double apart) {
  seen_at_ = positions;
  nearest_ = apart_now_ = apart;
  for (const Index open : open_) nearest_ = std::min(nearest_, couples_[open].nearest - couples_[open].gone);
}

void PairList::findOpen(const Cover* cover) {
  const Index revision = cover ? cover->revision() : 0;
  if (cover_ == cover && revision_ == revision) return;
  cover_ = cover;
  revision_ = revision;
  nearest_ = -1.0;
  open_.clear();
  parallelAppend(static_cast<Index>(couples_.size()), kCouplesAtOnce, open_, open_parts_,
                 [&](Index begin, Index end, auto& open) {
                   for (Index k = begin; k < end; ++k)
                     if (!cover || !cover->holds(couples_[k].one, couples_[k].other)) open.push_back(k);
                 });
  is_open_.assign(patches_.size(), 0);
  for (const Index open : open_) is_open_[couples_[open].one] = is_open_[couples_[open].other] = 1;
  open_patches_.clear();
  for (Index p = 0; p < patches_.size(); ++p)
    if (is_open_[p] != 0) open_patches_.push_back(p);
}

// Determines how far the couples have moved, how near their pairs must be to be listed, and which lists may lack some.
void PairList::markExpired(const Reach& reach) {
  expired_.clear();
  parallelAppend(static_cast<Index>(open_.size()), kCouplesAtOnce, expired_, expired_parts_,
                 [&](Index begin, Index end, auto& expired) {
                   for (Index k = begin; k < end; ++k) {
                     Couple& couple = couples_[open_[k]];
                     couple.gone = couple.used + ways_[couple.one].findRelative(ways_[couple.other]);
                     couple.reach = reach.of(next_ways_[couple.one].findRelative(next_ways_[couple.other]));
                     if (!(couple.radius - couple.gone >= couple.reach)) expired.push_back(&couple);
                   }
                 });
}

// The bounds of the distances become loose while the surface moves. Where many pairs are within reach, new ones cost less.
void PairList::measureAgain(const Points& positions) {
  measured_after_ = num_visits_;
  parallelFor(static_cast<Index>(open_.size()), kBlock, [&](Index begin, Index end) {
    for (Index k = begin; k < end; ++k) {
      Couple& couple = couples_[open_[k]];
      couple.radius -= couple.used;
      couple.used = 0.0;
      couple.nearest = couple.radius;
      for (Listed& listed : couple.listed) {
        listed.distance = std::sqrt(findClosest(listed.pair, positions).squaredDistance());
        couple.nearest = std::min(couple.nearest, listed.distance);
      }
    }
  });
}

// Couples that remain keep their lists.
void PairList::findCouples(const Points& positions, double reach) {
  const Index num = patches_.size();
  parallelFor(num, kBlock, [&](Index begin, Index end) {
    for (Index p = begin; p < end; ++p) boxes_[p] = patches_.boundOf(p, positions);
  });
  tree_.refit(boxes_);
  apart_ = std::max(kCoupled * median_edge_, kSpare * reach);
  kept_.swap(couples_);
  couples_.clear();
  auto kept = kept_.begin();
  std::vector<Index>& near = near_patches_;
  for (Index p = 0; p < num; ++p) {
    near.clear();
    tree_.visitMeeting(grow(boxes_[p], apart_), [&](Index q) {
      if (q >= p) near.push_back(q);
    });
    std::sort(near.begin(), near.end());
    for (const Index q : near) {
      while (kept != kept_.end() && std::make_pair(kept->one, kept->other) < std::make_pair(p, q)) ++kept;
      if (kept != kept_.end() && kept->one == p && kept->other == q)
        couples_.push_back(std::move(*kept));
      else
        couples_.push_back({p, q, -1.0, -1.0, 0.0, 0.0, 0.0, {}});
    }
  }
}

// Most expired couples are still far apart: their boxes show it, which cost less than to enclose the parts of patches.
void PairList::searchExpired(const Points& positions) {
  num_searches_ += static_cast<Index>(expired_.size());
  const auto listPatches = [&](std::vector<char>& has_it) {
    patches_of_expired_.clear();
    has_it.resize(patches_.size(), 0);
    for (const Couple* couple : expired_)
      for (const Index patch : {couple->one, couple->other})
        if (std::exchange(has_it[patch], 1) == 0) patches_of_expired_.push_back(patch);
  };
  listPatches(has_box_);
  parallelFor(static_cast<Index>(patches_of_expired_.size()), kBlock, [&](Index begin, Index end) {
    for (Index k = begin; k < end; ++k) boxes_[patches_of_expired_[k]] = patches_.boundOf(patches_of_expired_[k], positions);
  });
  expired_.erase(std::remove_if(expired_.begin(), expired_.end(), [&](Couple* couple) { return areBoxesApart(*couple); }),
                 expired_.end());
  listPatches(is_enclosed_);
  parallelFor(static_cast<Index>(patches_of_expired_.size()), kBlock, [&](Index begin, Index end) {
    for (Index k = begin; k < end; ++k) enclose(patches_of_expired_[k], positions);
  });
  parallelFor(static_cast<Index>(expired_.size()), kBlock, [&](Index begin, Index end) {
    for (Index k = begin; k < end; ++k) search(positions, *expired_[k]);
  });
}

// Begins the couple's list anew, empty. Where the boxes are apart, that is all.
bool PairList::areBoxesApart(Couple& couple) const {
  couple.radius = couple.nearest = std::max(usual_radius_, kSpare * couple.reach);
  couple.used = couple.gone = 0.0;
  couple.listed.clear();
  const double gap = boxes_[couple.one].exteriorDistance(boxes_[couple.other]);
  if (!(gap >= couple.radius)) return false;
  couple.radius = couple.nearest = gap;
  return true;
}

void PairList::enclose(Index patch, const Points& positions) {
  auto& [vertices, edges, triangles] = parts_[patch];
  vertices.clear();
  edges.clear();
  triangles.clear();
  const auto isWhole = [](const std::vector<char>& marks, Index i) { return marks.empty() || marks[i] != 0; };
  patches_.visitVertices(patch, [&](Index v) { vertices.add(v, &v, positions); });
  patches_.visitEdges(patch, [&](Index e) {
    if (isWhole(is_edge_whole_, e)) edges.add(e, edges_[e].data(), positions);
  });
  patches_.visitTriangles(patch, [&](Index t) {
    if (isWhole(is_whole_, t)) triangles.add(t, triangles_[t].data(), positions);
  });
  vertices.end();
  edges.end();
  triangles.end();
}

void PairList::search(const Points& positions, Couple& couple) const {
  const Parts &one = parts_[couple.one], &other = parts_[couple.other];
  const Box near_one = grow(boxes_[couple.one], couple.radius), near_other = grow(boxes_[couple.other], couple.radius);
  static thread_local Primitives::Scratch scratch;
  const auto offerTriangle = [&](Index v, Index t) {
    const auto& [a, b, c] = triangles_[t];
    if (v != a && v != b && v != c) offer(positions, {{v, a, b, c}, false, 0.0}, couple);
  };
  const auto offerEdges = [&](Index e, Index f) {
    const auto& [a, b] = edges_[std::min(e, f)];
    const auto& [c, d] = edges_[std::max(e, f)];
    if (a != c && a != d && b != c && b != d) offer(positions, {{a, b, c, d}, true, 0.0}, couple);
  };
  one.vertices.visitNear(near_one, other.triangles, near_other, couple.radius, scratch, offerTriangle);
  if (couple.one != couple.other)
    other.vertices.visitNear(near_other, one.triangles, near_one, couple.radius, scratch, offerTriangle);
  one.edges.visitNear(near_one, other.edges, near_other, couple.radius, scratch, offerEdges);
  for (const Listed& listed : couple.listed) couple.nearest = std::min(couple.nearest, listed.distance);
}

void PairList::offer(const Points& positions, Pair pair, Couple& couple) const {
  const double squared = findClosest(pair, positions).squaredDistance();
  if (!(squared < couple.radius * couple.radius) || (!crossed_.empty() && isAnyIn(crossed_, pair))) return;
  pair.thickness = thicknessOf(pair);
  if (pair.thickness > 0.0) couple.listed.push_back({pair, std::sqrt(squared)});
}

double PairList::thicknessOf(const Pair& pair) const {
  const double at_rest = std::sqrt(findClosest(pair, rest_).squaredDistance());
  if (kOfRestJoined * at_rest < thickness_ && isAnyIn(edges_, pair)) return kOfRestJoined * at_rest;
  const bool was_crossed = !at_rest_.empty() && isAnyIn(at_rest_, pair);
  return was_crossed ? thickness_ : std::min(thickness_, kOfRest * at_rest);
}

}  // namespace deformable_surface::contact
