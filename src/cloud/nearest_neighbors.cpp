// The nearest neighbours of all points of a cloud. Points that are near each other are searched together: the candidates around
// a group are collected once, and each point of it sorts those that are near into buckets by distance.
#include "deformable_surface/base/error.h"
#include "deformable_surface/base/parallel.h"
#include "deformable_surface/cloud/kd_tree.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

namespace deformable_surface::cloud {
namespace {

constexpr Index kGroup = 16;  // points, at most: those of a leaf of the tree
constexpr Index kBlock = 64;  // groups per task: about a millisecond of work
// Squared distances on a surface are spread evenly over the buckets: most of these hold one neighbour or none.
constexpr Index kBuckets = 64;
// From one group to the next the squared distance to the last neighbour mostly grows by less.
constexpr double kReachMargin = 1.15;
// With more candidates for each neighbour asked for and each point of the group, searches alone are faster.
constexpr std::size_t kMostCandidates = 8;
constexpr double kRounding = 1.0 + 1e-9;

// Where groups begin, and the end of the last: n is halved as the tree halves its points.
void divide(Index begin, Index end, std::vector<Index>& begins) {
  if (end - begin <= kGroup) return begins.push_back(begin);
  const Index middle = begin + (end - begin) / 2;
  divide(begin, middle, begins);
  divide(middle, end, begins);
}

// Searches for the points of one group after the other.
class GroupSearch {
 public:
  // count: neighbours asked for, with the point itself; no more than there are points.
  GroupSearch(const KdTree& tree, const Points& points, Index count) : tree_(tree), points_(points), count_(count) {}

  // Calls store(i, found) for the points i in [begin, end), with at least `count` nearest ones, nearest first.
  template <class Store>
  void run(const Index* begin, const Index* end, const Store& store) {
    collect(begin, end);
    double squared_last = 0.0;
    for (const Index* i = begin; i != end; ++i) {
      if (!findAmongCandidates(points_[*i])) searchAlone(points_[*i]);
      squared_last = std::max(squared_last, found_[count_ - 1].squared_distance);
      store(*i, found_);
    }
    squared_reach_ = kReachMargin * squared_last;
  }

 private:
  // All points within the reach of any point of the group; none if there are too many.
  void collect(const Index* begin, const Index* end) {
    Vec3 least = points_[*begin], most = least;
    for (const Index* i = begin; i != end; ++i) {
      least = least.cwiseMin(points_[*i]);
      most = most.cwiseMax(points_[*i]);
    }
    const Vec3 middle = 0.5 * (least + most);
    const double radius = (most - middle).norm();
    const std::size_t fit = kMostCandidates * static_cast<std::size_t>(count_ + (end - begin));
    tree_.withinRadius(middle, kRounding * (radius + std::sqrt(squared_reach_)), found_);
    if (found_.size() > fit) {
      searchAlone(points_[*begin]);
      squared_reach_ = kReachMargin * found_[count_ - 1].squared_distance;
      tree_.withinRadius(middle, kRounding * (radius + std::sqrt(squared_reach_)), found_);
      if (found_.size() > fit) found_.clear();
    }
    const std::size_t num = found_.size();
    index_.resize(num);
    for (std::vector<double>* values : {&x_, &y_, &z_, &squared_distance_}) values->resize(num);
    bucket_.resize(num);
    for (std::size_t c = 0; c < num; ++c) {
      index_[c] = found_[c].index;
      const Vec3& p = points_[index_[c]];
      x_[c] = p.x();
      y_[c] = p.y();
      z_[c] = p.z();
    }
  }

  void searchAlone(const Vec3& query) { tree_.nearest(query, count_, found_); }

  // False if the candidates do not decide.
  bool findAmongCandidates(const Vec3& query) {
    const double scale = kBuckets / squared_reach_;
    const Index num = static_cast<Index>(index_.size());
    if (num < count_ || !(scale > 0.0 && scale < std::numeric_limits<double>::infinity())) return false;
    const double qx = query.x(), qy = query.y(), qz = query.z();
    const double *x = x_.data(), *y = y_.data(), *z = z_.data();
    double* const squared = squared_distance_.data();
    std::int32_t* const bucket = bucket_.data();
    for (Index c = 0; c < num; ++c) {
      const double dx = x[c] - qx, dy = y[c] - qy, dz = z[c] - qz;
      squared[c] = dx * dx + dy * dy + dz * dz;
      bucket[c] = static_cast<std::int32_t>(std::min(squared[c] * scale, static_cast<double>(kBuckets)));
    }

    // The last bucket has all that is farther. Rounding is monotone: nothing in a bucket is nearer than what is in one before.
    Index place[kBuckets + 2] = {};
    for (Index c = 0; c < num; ++c) ++place[bucket[c] + 1];
    for (Index b = 0; b < kBuckets; ++b) place[b + 1] += place[b];
    const Index num_near = place[kBuckets];
    if (num_near < count_) return false;
    found_.resize(num);
    for (Index c = 0; c < num; ++c) found_[place[bucket[c]]++] = {squared[c], index_[c]};
    found_.resize(num_near);
    for (Index m = 1; m < num_near; ++m) {
      const Neighbor moved = found_[m];
      Index at = m;
      for (; at > 0 && moved < found_[at - 1]; --at) found_[at] = found_[at - 1];
      found_[at] = moved;
    }
    return found_[count_ - 1].squared_distance <= squared_reach_;
  }

  const KdTree& tree_;
  const Points& points_;
  const Index count_;
  double squared_reach_ = 0.0;  // m^2, that is tried
  // Of the candidates.
  std::vector<Index> index_;
  std::vector<double> x_, y_, z_, squared_distance_;  // m, m^2; the last from one point
  std::vector<std::int32_t> bucket_;
  std::vector<Neighbor> found_;
};

}  // namespace

Lists nearestNeighbors(const Points& points, Index k) {
  if (k < 0) throw InputError("nearest neighbours: k is " + std::to_string(k) + "; it must be 0 or more");
  const KdTree tree(points);
  const Index n = tree.size();
  const Index count = std::min(k, std::max(n - 1, 0));
  if (static_cast<double>(count) * n > std::numeric_limits<Index>::max()) {
    throw InputError("nearest neighbours: " + std::to_string(n) + " points with " + std::to_string(count) +
                     " neighbours each are too many; their product must stay below 2^31");
  }
  Lists lists;
  lists.offsets.resize(static_cast<std::size_t>(n) + 1);
  for (Index i = 0; i <= n; ++i) lists.offsets[i] = i * count;
  lists.items.resize(static_cast<std::size_t>(n) * count);
  if (count == 0) return lists;
  std::vector<Index> begins;
  divide(0, n, begins);
  begins.push_back(n);
  parallelFor(static_cast<Index>(begins.size()) - 1, kBlock, [&](Index begin, Index end) {
    // One more than wanted, for the point itself; where many coincide with it, it may be missing and the last one goes.
    GroupSearch search(tree, points, count + 1);
    const Index* const order = tree.order().data();
    for (Index group = begin; group < end; ++group) {
      search.run(order + begins[group], order + begins[group + 1], [&](Index i, const std::vector<Neighbor>& found) {
        Index* out = lists.items.data() + lists.offsets[i];
        Index* const out_end = out + count;
        for (Index m = 0; m <= count && out != out_end; ++m)
          if (found[m].index != i) *out++ = found[m].index;
      });
    }
  });
  return lists;
}

}  // namespace deformable_surface::cloud
