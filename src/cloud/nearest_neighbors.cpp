// The nearest neighbours of all points of a cloud. Points that are near each other are searched together: the candidates around
// a group are collected once, and each point of it sorts those that are near into buckets by distance.
#include "deformable_surface/base/error.h"
#include "deformable_surface/base/parallel.h"
#include "deformable_surface/cloud/kd_tree.h"

#include <algorithm>
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

// Points one coordinate after the other.
struct Coordinates {
  std::vector<double> x, y, z;  // m
  std::vector<Index> index;

  std::size_t size() const { return index.size(); }
  void resize(std::size_t n) {
    for (std::vector<double>* values : {&x, &y, &z}) values->resize(n);
    index.resize(n);
  }
};

struct Box {
  Vec3 least = Vec3::Zero(), most = Vec3::Zero();

  // Of the way from a box to this one. The sum is that of squared distances, and rounding is monotone: no point of the one is
  // nearer to a point of the other.
  double squaredGap(const Vec3& other_least, const Vec3& other_most) const {
    double gap[3];
    for (int axis = 0; axis < 3; ++axis)
      gap[axis] = std::max(std::max(least[axis] - other_most[axis], other_least[axis] - most[axis]), 0.0);
    return gap[0] * gap[0] + gap[1] * gap[1] + gap[2] * gap[2];
  }
};

// The points in the order of the tree, halved as the tree halves them, down to groups.
class Groups {
 public:
  Groups(const Points& points, const std::vector<Index>& order) {
    const Index n = static_cast<Index>(order.size());
    all_.resize(n);
    parallelFor(n, kBlock * kGroup, [&](Index begin, Index end) {
      for (Index s = begin; s < end; ++s) {
        const Vec3& p = points[order[s]];
        all_.x[s] = p.x();
        all_.y[s] = p.y();
        all_.z[s] = p.z();
        all_.index[s] = order[s];
      }
    });
    divide(0, n);
  }

  Index size() const { return static_cast<Index>(leaves_.size()); }
  const Box& box(Index group) const { return nodes_[leaves_[group]].box; }
  const Index* begin(Index group) const { return all_.index.data() + nodes_[leaves_[group]].begin; }
  const Index* end(Index group) const { return all_.index.data() + nodes_[leaves_[group]].end; }

  // All points within a distance of a box.
  void findAround(const Box& box, double squared_reach, Coordinates& found) const {
    found.resize(0);
    for (std::size_t at = 0; at < nodes_.size();) {
      const Node& node = nodes_[at];
      if (!(node.box.squaredGap(box.least, box.most) <= squared_reach)) {
        at = node.next;
        continue;
      }
      ++at;
      if (node.end - node.begin > kGroup) continue;
      // Every point is written and only near ones are counted: branches would be mispredicted.
      std::size_t count = found.size();
      found.resize(count + (node.end - node.begin));
      for (Index s = node.begin; s < node.end; ++s) {
        const Vec3 p(all_.x[s], all_.y[s], all_.z[s]);
        found.x[count] = p.x();
        found.y[count] = p.y();
        found.z[count] = p.z();
        found.index[count] = all_.index[s];
        count += box.squaredGap(p, p) <= squared_reach;
      }
      found.resize(count);
    }
  }

 private:
  struct Node {
    Box box;
    Index begin, end;
    std::size_t next;  // after all nodes below
  };

  void divide(Index begin, Index end) {
    const std::size_t self = nodes_.size();
    nodes_.push_back({Box(), begin, end, 0});
    Box box;
    if (end - begin <= kGroup) {
      leaves_.push_back(self);
      box.least = box.most = Vec3(all_.x[begin], all_.y[begin], all_.z[begin]);
      for (Index s = begin; s < end; ++s) {
        const Vec3 p(all_.x[s], all_.y[s], all_.z[s]);
        box = {box.least.cwiseMin(p), box.most.cwiseMax(p)};
      }
    } else {
      const Index middle = begin + (end - begin) / 2;
      divide(begin, middle);
      const std::size_t second = nodes_.size();
      divide(middle, end);
      box = {nodes_[self + 1].box.least.cwiseMin(nodes_[second].box.least),
             nodes_[self + 1].box.most.cwiseMax(nodes_[second].box.most)};
    }
    nodes_[self].box = box;
    nodes_[self].next = nodes_.size();
  }

  Coordinates all_;
  std::vector<Node> nodes_;  // depth first
  std::vector<std::size_t> leaves_;
};

// Searches for the points of one group after the other.
class GroupSearch {
 public:
  // count: neighbours asked for, with the point itself; no more than there are points.
  GroupSearch(const KdTree& tree, const Groups& groups, const Points& points, Index count)
      : tree_(tree), groups_(groups), points_(points), count_(count) {}

  // Calls store(i, found) for the points i of a group, with at least `count` nearest ones, nearest first.
  template <class Store>
  void run(Index group, const Store& store) {
    collect(group);
    double squared_last = 0.0;
    for (const Index* i = groups_.begin(group); i != groups_.end(group); ++i) {
      if (!findAmongCandidates(points_[*i])) searchAlone(points_[*i]);
      squared_last = std::max(squared_last, found_[count_ - 1].squared_distance);
      store(*i, found_);
    }
    squared_reach_ = kReachMargin * squared_last;
  }

 private:
  // All points within the reach of any point of the group; none if there are too many.
  void collect(Index group) {
    const std::size_t of_group = groups_.end(group) - groups_.begin(group), fit = kMostCandidates * (count_ + of_group);
    groups_.findAround(groups_.box(group), squared_reach_, near_);
    if (near_.size() > fit) {
      searchAlone(points_[*groups_.begin(group)]);
      squared_reach_ = kReachMargin * found_[count_ - 1].squared_distance;
      groups_.findAround(groups_.box(group), squared_reach_, near_);
      if (near_.size() > fit) near_.resize(0);
    }
    squared_distance_.resize(near_.size());
    bucket_.resize(near_.size());
  }

  void searchAlone(const Vec3& query) { tree_.nearest(query, count_, found_); }

  // False if the candidates do not decide.
  bool findAmongCandidates(const Vec3& query) {
    const double scale = kBuckets / squared_reach_;
    const Index num = static_cast<Index>(near_.size());
    if (num < count_ || !(scale > 0.0 && scale < std::numeric_limits<double>::infinity())) return false;
    const double qx = query.x(), qy = query.y(), qz = query.z();
    const double *x = near_.x.data(), *y = near_.y.data(), *z = near_.z.data();
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
    for (Index c = 0; c < num; ++c) found_[place[bucket[c]]++] = {squared[c], near_.index[c]};
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
  const Groups& groups_;
  const Points& points_;
  const Index count_;
  double squared_reach_ = 0.0;            // m^2, that is tried
  Coordinates near_;                      // the candidates
  std::vector<double> squared_distance_;  // m^2, of the candidates from one point
  std::vector<std::int32_t> bucket_;      // of the candidates
  std::vector<Neighbor> found_;
};

}  // namespace

Lists nearestNeighbors(const Points& points, Index k) { return nearestNeighbors(points, KdTree(points), k); }

Lists nearestNeighbors(const Points& points, const KdTree& tree, Index k) {
  if (k < 0) throw InputError("nearest neighbours: k: found " + std::to_string(k) + "; accepted: 0 or more");
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
  const Groups groups(points, tree.order());
  parallelFor(groups.size(), kBlock, [&](Index begin, Index end) {
    // One more than wanted, for the point itself; where many coincide with it, it may be missing and the last one goes.
    GroupSearch search(tree, groups, points, count + 1);
    for (Index group = begin; group < end; ++group) {
      search.run(group, [&](Index i, const std::vector<Neighbor>& found) {
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
