// Shortest paths around single points, and lists of neighbours and weights of links derived from them.
#include "deformable_surface/cloud/geodesics.h"

#include "deformable_surface/base/error.h"
#include "deformable_surface/base/parallel.h"
#include "deformable_surface/cloud/kd_tree.h"
#include "geodesic_search.h"
#include "trust_radii.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <numeric>
#include <string>
#include <tuple>
#include <utility>

namespace deformable_surface::cloud {
namespace {

constexpr Index kBlock = 256;  // points per task: about a millisecond of work
// Detour beyond which a point belongs to another part of the surface.
constexpr double kApartDetour = 1.5 * kKeptDetour;
// A list is filled up from at most this multiple of its length of points met: at a fold most of them belong to other sheets.
constexpr std::size_t kMaxMet = 4;
// A point is at a gap if this many pairs around it, none of which share a point, are apart. An isolated point is apart from each
// of its neighbours, but these pairs share it: they count as one, which is no gap.
constexpr int kMinPairs = 3;
constexpr Index kAround = 12;
// Or if one point is apart from it, and both have this many nearest neighbours that are not apart, each nearer by this
// factor: at the corner of a slit too few points see the other side for as many pairs.
constexpr double kWideGap = 1.5;
constexpr Index kOwnNeighbors = 3;
// The margin ignores this share of the points at gaps: a few holes of the sampling are no gap.
constexpr double kMarginQuantile = 0.05;

// Neighbours that are clearly apart, of every point.
struct Apart {
  Lists lists;
  std::vector<float> ratio;  // (n) length over trust radius of the nearest of them; infinite if there is none
};

// Lists of count[i] items. Those of points with is_new are in the blocks, one after another; the others stay as they were.
Lists joinBlocks(const std::vector<std::vector<Index>>& blocks, const std::vector<Index>& count, const std::vector<char>& is_new,
                 Lists before) {
  const Index n = static_cast<Index>(count.size());
  Lists lists;
  lists.offsets.resize(n + 1);
  for (Index i = 0; i < n; ++i) lists.offsets[i + 1] = lists.offsets[i] + count[i];
  const bool are_in_place = lists.offsets == before.offsets;
  if (are_in_place)
    lists.items = std::move(before.items);
  else
    lists.items.resize(lists.offsets[n]);
  parallelFor(n, kBlock, [&](Index begin, Index end) {
    const Index* next = blocks[begin / kBlock].data();
    for (Index i = begin; i < end; ++i) {
      Index* const to = lists.items.data() + lists.offsets[i];
      if (!is_new[i]) {
        if (!are_in_place) std::copy(before.begin(i), before.end(i), to);
        continue;
      }
      std::copy(next, next + count[i], to);
      next += count[i];
    }
  });
  return lists;
}

// The state of a listed pair. kOpen: a search from the first point decides; kOpenThere: one from the second.
enum class PairState : char { kNear, kApart, kOpen, kOpenThere };

// The item of i in the list of j; -1 if j does not list it.
Index findItem(const Lists& neighbors, Index j, Index i) {
  const Index* const found = std::find(neighbors.begin(j), neighbors.end(j), i);
  return found == neighbors.end(j) ? Index{-1} : static_cast<Index>(found - neighbors.items.data());
}

// For every item. A pair that both ends list is searched from one end only: from the one with more open pairs.
std::vector<PairState> checkPairs(const GeodesicGraph& graph, const Points& positions, const Lists& neighbors) {
  const Index n = neighbors.size();
  std::vector<PairState> from_here(neighbors.items.size(), PairState::kNear);
  std::vector<Index> num_open(n);
  parallelFor(n, kBlock, [&](Index begin, Index end) {
    QuickCheck check(graph);
    for (Index i = begin; i < end; ++i) {
      const Index *first = neighbors.begin(i), *last = neighbors.end(i);
      const bool is_checked = graph.cost_is_distance;
      if (is_checked && check.run(i, positions, first, last, kApartDetour)) continue;
      for (Index e = neighbors.offsets[i]; e < neighbors.offsets[i + 1]; ++e) {
        if (is_checked && check.isShown(e - neighbors.offsets[i])) continue;
        from_here[e] = PairState::kOpen;
        ++num_open[i];
      }
    }
  });
  std::vector<PairState> states = from_here;
  parallelFor(n, kBlock, [&](Index begin, Index end) {
    for (Index i = begin; i < end; ++i) {
      for (Index e = neighbors.offsets[i]; num_open[i] > 0 && e < neighbors.offsets[i + 1]; ++e) {
        if (from_here[e] != PairState::kOpen) continue;
        const Index j = neighbors.items[e], back = findItem(neighbors, j, i);
        if (back < 0) continue;
        if (from_here[back] == PairState::kNear) {
          states[e] = PairState::kNear;
        } else if (std::make_pair(num_open[i], i) < std::make_pair(num_open[j], j)) {
          states[e] = PairState::kOpenThere;
        }
      }
    }
  });
  return states;
}

// Decides the open pairs of point i.
class PairSearch {
 public:
  PairSearch(const GeodesicGraph& graph, const Points& positions, const Lists& neighbors)
      : search_(graph, positions), positions_(positions), neighbors_(neighbors) {}

  void run(Index i, std::vector<PairState>& states) {
    wanted_.clear();
    Vec3 middle = Vec3::Zero();
    for (Index e = neighbors_.offsets[i]; e < neighbors_.offsets[i + 1]; ++e) {
      if (states[e] != PairState::kOpen) continue;
      wanted_.emplace_back(neighbors_.items[e], e);
      middle += positions_[neighbors_.items[e]];
    }
    if (wanted_.empty()) return;
    middle /= static_cast<double>(wanted_.size());
    double radius = 0.0;  // around the middle, of the wanted points
    for (const auto& pair : wanted_) radius = std::max(radius, (positions_[pair.first] - middle).norm());
    Index farthest = wanted_.back().second;  // of the open ones, which are listed nearest first
    std::sort(wanted_.begin(), wanted_.end());
    const auto findReach = [&] { return kApartDetour * (positions_[neighbors_.items[farthest]] - positions_[i]).norm(); };
    double reach = findReach();
    std::size_t missing = wanted_.size();
    const auto visit = [&](Index point, double distance) {
      const auto found = std::lower_bound(wanted_.begin(), wanted_.end(), std::make_pair(point, Index{0}));
      if (found != wanted_.end() && found->first == point) {
        const bool is_near = distance <= kApartDetour * (positions_[point] - positions_[i]).norm();
        states[found->second] = is_near ? PairState::kNear : PairState::kApart;
        if (--missing == 0) return false;
        while (states[farthest] != PairState::kOpen) --farthest;
        reach = findReach();
      }
      return distance <= reach;
    };
    // No path is shorter than in space.
    const auto leadsThere = [&](Index point, double cost) {
      const double room = std::max(0.0, reach - cost) + radius;
      return !search_.costIsDistance() || (positions_[point] - middle).squaredNorm() <= room * room;
    };
    search_.run(i, reach, visit, leadsThere);
    for (const auto& pair : wanted_)
      if (states[pair.second] == PairState::kOpen) states[pair.second] = PairState::kApart;
  }

 private:
  Search search_;
  const Points& positions_;
  const Lists& neighbors_;
  std::vector<std::pair<Index, Index>> wanted_;  // point, item
};

Apart findApart(const GeodesicGraph& graph, const Points& positions, const SurfaceSides& sides, const Lists& neighbors) {
  const Index n = neighbors.size();
  std::vector<PairState> states = checkPairs(graph, positions, neighbors);
  parallelFor(n, kBlock, [&](Index begin, Index end) {
    PairSearch search(graph, positions, neighbors);
    for (Index i = begin; i < end; ++i) search.run(i, states);
  });
  Apart apart;
  apart.ratio.assign(n, std::numeric_limits<float>::infinity());
  std::vector<std::vector<Index>> blocks((n + kBlock - 1) / kBlock);
  std::vector<Index> count(n);
  parallelFor(n, kBlock, [&](Index begin, Index end) {
    for (Index i = begin; i < end; ++i) {
      for (Index e = neighbors.offsets[i]; e < neighbors.offsets[i + 1]; ++e) {
        const Index j = neighbors.items[e];
        const PairState state = states[e] == PairState::kOpenThere ? states[findItem(neighbors, j, i)] : states[e];
        if (state == PairState::kNear) continue;
        double ratio = 0.0;
        if (!graph.trust_radius.empty()) {
          ratio =
              std::sqrt(measureSquaredLength(positions, sides, i, j)) / std::max(graph.trust_radius[i], graph.trust_radius[j]);
        }
        apart.ratio[i] = std::min(apart.ratio[i], static_cast<float>(ratio));
        blocks[begin / kBlock].push_back(j);
        ++count[i];
      }
    }
  });
  apart.lists = joinBlocks(blocks, count, std::vector<char>(n, 1), {});
  return apart;
}

// True where enough separate pairs around a point are apart, or one pair that spans a wide gap.
std::vector<char> findAtGap(const Points& positions, const Lists& apart, const Lists& neighbors) {
  const Index n = neighbors.size();
  std::vector<char> at_gap(n);
  const auto isApart = [&](Index i, Index j) { return std::find(apart.begin(i), apart.end(i), j) != apart.end(i); };
  // Distance of the nearest neighbours that are not apart; infinite if one of them is.
  const auto findOwnReach = [&](Index i) {
    const Index* const first = neighbors.begin(i);
    if (neighbors.count(i) < kOwnNeighbors) return std::numeric_limits<double>::infinity();
    if (std::any_of(first, first + kOwnNeighbors, [&](Index j) { return isApart(i, j); }))
      return std::numeric_limits<double>::infinity();
    return (positions[first[kOwnNeighbors - 1]] - positions[i]).norm();
  };
  const auto seesWideGap = [&](Index i) {
    if (apart.count(i) == 0) return false;
    const double own = findOwnReach(i);
    return std::any_of(apart.begin(i), apart.end(i), [&](Index j) {
      const double length = (positions[j] - positions[i]).norm();
      return length > kWideGap * own && length > kWideGap * findOwnReach(j);
    });
  };
  parallelFor(n, kBlock, [&](Index begin, Index end) {
    std::vector<Index> paired;
    const auto isFree = [&](Index i) { return std::find(paired.begin(), paired.end(), i) == paired.end(); };
    const auto pair = [&](Index i) {
      if (!isFree(i)) return;
      const Index* other = std::find_if(apart.begin(i), apart.end(i), isFree);
      if (other != apart.end(i)) paired.insert(paired.end(), {i, *other});
    };
    for (Index i = begin; i < end; ++i) {
      paired.clear();
      pair(i);
      const Index* last = neighbors.begin(i) + std::min(kAround, neighbors.count(i));
      for (const Index* j = neighbors.begin(i); j != last; ++j) pair(*j);
      at_gap[i] = paired.size() >= 2 * kMinPairs || seesWideGap(i);
    }
  });
  return at_gap;
}

// Whether each of two points lies clearly in front of the other, by normals with a common side that turn by no less.
bool isInFront(const Points& positions, const SurfaceSides& sides, Index i, Index j, double cosine) {
  constexpr double kClear = 0.1;  // of the length: points on a plane are not in front of each other, but for noise
  const Vec3 d = positions[j] - positions[i];
  const double clear = kClear * d.norm();
  return sides.normals[i].dot(sides.normals[j]) < cosine && d.dot(sides.normals[i]) > clear && d.dot(sides.normals[j]) < -clear;
}

// See GeodesicNeighbors::num_joined. neighbors: in space.
Index countJoined(const GeodesicGraph& graph, const Points& positions, const SurfaceSides& sides, const Lists& neighbors) {
  constexpr double kBent = 0.5;  // cosine of 60 degrees, by which no smooth surface turns from point to point
  if (!sides.oriented || sides.normals.empty() || graph.trust_radius.empty()) return 0;
  const Index n = neighbors.size();
  Lists facing;
  for (Index i = 0; i < n; ++i) {
    for (const Index* j = neighbors.begin(i); j != neighbors.end(i); ++j) {
      const double near = std::max(graph.trust_radius[i], graph.trust_radius[*j]);
      if ((positions[*j] - positions[i]).squaredNorm() <= near * near && isInFront(positions, sides, i, *j, kFacingCosine))
        facing.items.push_back(*j);
    }
    facing.offsets.push_back(static_cast<Index>(facing.items.size()));
  }
  if (facing.items.empty()) return 0;
  GeodesicGraph round;  // without links to what is in front
  round.cost_is_distance = graph.cost_is_distance;
  for (Index i = 0; i < n; ++i) {
    for (Index e = graph.links.offsets[i]; e < graph.links.offsets[i + 1]; ++e) {
      if (isInFront(positions, sides, i, graph.links.items[e], kBent)) continue;
      round.links.items.push_back(graph.links.items[e]);
      round.cost.push_back(graph.cost[e]);
    }
    round.links.offsets.push_back(static_cast<Index>(round.links.items.size()));
  }
  const std::vector<double> across = findGeodesicDistances(graph, positions, facing, kKeptDetour);
  const std::vector<double> around = findGeodesicDistances(round, positions, facing, kKeptDetour);
  Index joined = 0;
  for (Index i = 0; i < n; ++i) {
    bool is_joined = false;
    for (Index e = facing.offsets[i]; e < facing.offsets[i + 1]; ++e) {
      // Beside where two parts are nearest, the way leads over links as long as the trust radius.
      const Index j = facing.items[e];
      const double most = kKeptDetour * std::max(graph.trust_radius[i], graph.trust_radius[j]);
      is_joined = is_joined || (across[e] <= most && !(around[e] <= most));
    }
    joined += is_joined;
  }
  return joined;
}

}  // namespace

std::vector<double> findGeodesicDistances(const GeodesicGraph& graph, const Points& positions, const Lists& links,
                                          double max_detour) {
  const Index n = graph.links.size();
  if (links.size() != n || static_cast<Index>(positions.size()) != n) {
    throw InputError("findGeodesicDistances: found " + std::to_string(links.size()) + " lists and " +
                     std::to_string(positions.size()) + " positions on a graph of " + std::to_string(n) +
                     " points; accepted: equally many");
  }
  std::vector<double> distance(links.items.size(), std::numeric_limits<double>::infinity());
  parallelFor(n, kBlock, [&](Index begin, Index end) {
    Search search(graph, positions);
    std::vector<std::pair<Index, Index>> wanted;  // point, place in the lists
    for (Index i = begin; i < end; ++i) {
      wanted.clear();
      for (Index e = links.offsets[i]; e < links.offsets[i + 1]; ++e) wanted.push_back({links.items[e], e});
      std::sort(wanted.begin(), wanted.end());
      std::size_t missing = wanted.size();
      if (missing == 0) continue;
      double longest = 0.0;
      for (const auto& pair : wanted) longest = std::max(longest, (positions[pair.first] - positions[i]).norm());
      search.run(i, max_detour * longest, [&](Index point, double d) {
        auto w = std::lower_bound(wanted.begin(), wanted.end(), std::make_pair(point, Index{0}));
        for (; w != wanted.end() && w->first == point; ++w, --missing) distance[w->second] = d;
        return missing > 0;
      });
    }
  });
  return distance;
}

double weighDetour(double detour) {
  const double t = std::min(std::max((detour - kFreeDetour) / (kLongestDetour - kFreeDetour), 0.0), 1.0);
  return 1.0 - t * t * (3.0 - 2.0 * t);
}

std::vector<double> geodesicWeights(const GeodesicGraph& graph, const Points& positions, const Lists& links) {
  std::vector<double> weight = findGeodesicDistances(graph, positions, links, kLongestDetour);
  for (Index i = 0; i < links.size(); ++i) {
    for (Index e = links.offsets[i]; e < links.offsets[i + 1]; ++e) {
      const double length = (positions[links.items[e]] - positions[i]).norm();
      weight[e] = length > 0.0 ? weighDetour(weight[e] / length) : 1.0;
    }
  }
  return weight;
}

GeodesicNeighbors keepGeodesicNeighbors(const GeodesicGraph& graph, const Points& positions, const SurfaceSides& sides,
                                        Lists neighbors) {
  const Index n = neighbors.size();
  if (graph.links.size() != n || static_cast<Index>(positions.size()) != n) {
    throw InputError("keepGeodesicNeighbors: found " + std::to_string(n) + " lists and " + std::to_string(positions.size()) +
                     " positions on a graph of " + std::to_string(graph.links.size()) + " points; accepted: equally many");
  }
  const Apart apart = findApart(graph, positions, sides, neighbors);
  std::vector<char> at_gap = findAtGap(positions, apart.lists, neighbors);
  std::vector<std::vector<Index>> blocks((n + kBlock - 1) / kBlock);
  std::vector<Index> count(n), refused(n);
  parallelFor(n, kBlock, [&](Index begin, Index end) {
    std::vector<Index>& out = blocks[begin / kBlock];
    Search search(graph, positions);
    std::vector<Neighbor> kept;
    for (Index i = begin; i < end; ++i) {
      const Index *first = neighbors.begin(i), *last = neighbors.end(i);
      const std::size_t wanted = last - first;
      count[i] = neighbors.count(i);
      if (!at_gap[i] || wanted == 0) continue;
      kept.clear();
      std::size_t met = 0;
      const double reach = kKeptDetour * (positions[last[-1]] - positions[i]).norm();
      search.run(i, kNoLimit, [&](Index point, double distance) {
        if (point == i) return true;
        const double squared = (positions[point] - positions[i]).squaredNorm();
        if (distance * distance <= kKeptDetour * kKeptDetour * squared) kept.push_back({squared, point});
        ++met;
        return !(distance > reach && (kept.size() >= wanted || met >= kMaxMet * wanted));
      });
      std::sort(kept.begin(), kept.end());
      for (const Index* j = first; j != last; ++j) {
        const Neighbor listed{(positions[*j] - positions[i]).squaredNorm(), *j};
        refused[i] += !std::binary_search(kept.begin(), kept.end(), listed);
      }
      count[i] = static_cast<Index>(std::min(kept.size(), wanted));
      for (Index m = 0; m < count[i]; ++m) out.push_back(kept[m].index);
    }
  });

  GeodesicNeighbors result;
  std::vector<float> gaps;
  for (Index i = 0; i < n; ++i) {
    if (at_gap[i] && apart.lists.count(i) > 0) gaps.push_back(apart.ratio[i]);
  }
  result.num_at_gaps = static_cast<Index>(gaps.size());
  if (!gaps.empty() && !graph.trust_radius.empty()) {
    const auto quantile = gaps.begin() + static_cast<std::ptrdiff_t>(kMarginQuantile * gaps.size());
    std::nth_element(gaps.begin(), quantile, gaps.end());
    result.margin = *quantile;
  }
  result.num_joined = countJoined(graph, positions, sides, neighbors);
  result.num_refused = std::accumulate(refused.begin(), refused.end(), Index{0});
  result.lists = joinBlocks(blocks, count, at_gap, std::move(neighbors));
  result.is_changed = std::move(at_gap);
  return result;
}

Lists findRefusedPairs(const Points& positions, const Lists& over_surface) {
  const Index n = over_surface.size();
  Index longest = 0;
  for (Index i = 0; i < n; ++i) longest = std::max(longest, over_surface.count(i));
  const Lists in_space = nearestNeighbors(positions, longest);
  const auto lists = [&](Index i, Index j) {
    return std::find(over_surface.begin(i), over_surface.end(i), j) != over_surface.end(i);
  };
  std::vector<std::vector<Index>> refused(n);
  for (Index i = 0; i < n; ++i) {
    const Index* last = in_space.begin(i) + std::min(in_space.count(i), over_surface.count(i));
    for (const Index* j = in_space.begin(i); j != last; ++j) {
      if (lists(i, *j) || lists(*j, i)) continue;
      refused[i].push_back(*j);
      refused[*j].push_back(i);
    }
  }
  Lists result;
  for (std::vector<Index>& pairs : refused) {
    std::sort(pairs.begin(), pairs.end());
    pairs.erase(std::unique(pairs.begin(), pairs.end()), pairs.end());
    result.items.insert(result.items.end(), pairs.begin(), pairs.end());
    result.offsets.push_back(static_cast<Index>(result.items.size()));
  }
  return result;
}

}  // namespace deformable_surface::cloud
