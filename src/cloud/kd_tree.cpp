// A balanced kd-tree over a flat array of nodes. Written here rather than taken from a library, because equal distances must be
// decided by index and points must be removable.
#include "deformable_surface/cloud/kd_tree.h"

#include "deformable_surface/base/error.h"
#include "deformable_surface/base/parallel.h"
#include "deformable_surface/base/value.h"
#include "k_nearest.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
#include <utility>

namespace deformable_surface::cloud {
namespace {

// Fewer points per leaf mean more nodes to visit, more points mean more distances to compute; the fastest of those tried.
constexpr Index kLeafSize = 16;
// Slots in a cache line of today's processors.
constexpr Index kSlotsPerLine = 2;
// In place of a slot.
constexpr Index kRemoved = -1;
// A balanced tree of 2^31 points is not deeper than this, and a search keeps at most one pending node per level.
constexpr int kMaxDepth = 40;

// A tree is built in so many branches at a time, unless they are small.
constexpr std::size_t kMaxBranches = 64;
constexpr Index kSmallBranch = 4096;
constexpr Index kBlock = 1 << 15;  // slots per task of the loops that only copy: less than a millisecond of work

// Nodes of the trees of n and of n + 1 points: halves of both have one of two sizes.
std::pair<Index, Index> countNodes(Index n) {
  if (n + 1 <= kLeafSize) return {1, 1};
  const auto [half, half_and_one] = countNodes(n / 2);
  const Index even = 2 * half + 1, odd = half + half_and_one + 1, next = 2 * half_and_one + 1;
  return {n <= kLeafSize ? 1 : (n % 2 == 0 ? even : odd), n % 2 == 0 ? odd : next};
}

// All neighbours within a fixed distance, unsorted.
class InBall {
 public:
  InBall(double squared_radius, std::vector<Neighbor>& out) : squared_radius_(squared_radius), out_(out) { out_.clear(); }

  double bound() const { return squared_radius_; }
  void add(double squared_distance, Index index) { out_.push_back({squared_distance, index}); }

 private:
  double squared_radius_;
  std::vector<Neighbor>& out_;
};

// The sum is formed in the same order for boxes and for points: rounding is monotone, so a box is never farther than its points.
inline double squaredLength(double x, double y, double z) { return x * x + y * y + z * z; }

inline double squaredDistanceToBox(const double* lo, const double* hi, const Vec3& q) {
  const double dx = std::max(std::max(lo[0] - q[0], q[0] - hi[0]), 0.0);
  const double dy = std::max(std::max(lo[1] - q[1], q[1] - hi[1]), 0.0);
  const double dz = std::max(std::max(lo[2] - q[2], q[2] - hi[2]), 0.0);
  return squaredLength(dx, dy, dz);
}

}  // namespace

KdTree::KdTree(const Points& points) {
  const Index n = static_cast<Index>(points.size());
  slots_.resize(n);
  parallelFor(n, kBlock, [&](Index begin, Index end) {
    for (Index i = begin; i < end; ++i) {
      if (!points[i].allFinite()) {
        throw InputError("kd-tree: point " + std::to_string(i) + " is not finite; only finite points can be searched");
      }
      slots_[i] = {points[i].x(), points[i].y(), points[i].z(), i};
    }
  });
  slot_of_.resize(n);
  rebuild();
  order_.resize(n);
  parallelFor(n, kBlock, [&](Index begin, Index end) {
    for (Index s = begin; s < end; ++s) order_[s] = slots_[s].point;
  });
}

// Level by level on all cores, as long as there is more than a task for each, then branch by branch.
void KdTree::rebuild() {
  num_alive_ = static_cast<Index>(slots_.size());
  nodes_.clear();
  if (num_alive_ > 0) {
    nodes_.resize(countNodes(num_alive_).first);
    struct Branch {
      Index node, begin, end;
    };
    std::vector<Branch> branches{{0, 0, num_alive_}}, halves;
    while (branches.size() < kMaxBranches && branches.front().end - branches.front().begin > kSmallBranch) {
      halves.resize(2 * branches.size());
      parallelFor(static_cast<Index>(branches.size()), 1, [&](Index b, Index) {
        const Branch& of = branches[b];
        const Index middle = makeNode(of.node, of.begin, of.end), right = of.node + 1 + countNodes(middle - of.begin).first;
        nodes_[of.node].right = right;
        halves[2 * b] = {of.node + 1, of.begin, middle};
        halves[2 * b + 1] = {right, middle, of.end};
      });
      branches.swap(halves);
    }
    parallelFor(static_cast<Index>(branches.size()), 1,
                [&](Index b, Index) { build(branches[b].node, branches[b].begin, branches[b].end); });
  }
  parallelFor(num_alive_, kBlock, [&](Index begin, Index end) {
    for (Index s = begin; s < end; ++s) slot_of_[slots_[s].point] = s;
  });
}

// One node, of which the slots are halved. Returns where the second half begins, or the end of a leaf.
Index KdTree::makeNode(Index self, Index begin, Index end) {
  Node& node = nodes_[self];
  node.begin = begin;
  node.end = end;
  node.right = 0;

  // The tight box.
  const double* first = &slots_[begin].x;
  std::copy(first, first + 3, node.lo);
  std::copy(first, first + 3, node.hi);
  for (Index s = begin + 1; s < end; ++s) {
    const double* c = &slots_[s].x;
    for (int axis = 0; axis < 3; ++axis) {
      node.lo[axis] = std::min(node.lo[axis], c[axis]);
      node.hi[axis] = std::max(node.hi[axis], c[axis]);
    }
  }
  if (end - begin <= kLeafSize) return end;

  // Halve by number along the widest axis, so that coincident points cannot recurse for ever.
  int widest = 0;
  for (int axis = 1; axis < 3; ++axis) {
    if (node.hi[axis] - node.lo[axis] > node.hi[widest] - node.lo[widest]) widest = axis;
  }
  const Index middle = begin + (end - begin) / 2;
  const auto split = [&](auto coordinate) {
    std::nth_element(slots_.begin() + begin, slots_.begin() + middle, slots_.begin() + end,
                     [coordinate](const Slot& a, const Slot& b) {
                       return a.*coordinate != b.*coordinate ? a.*coordinate < b.*coordinate : a.point < b.point;
                     });
  };
  if (widest == 0) split(&Slot::x);
  if (widest == 1) split(&Slot::y);
  if (widest == 2) split(&Slot::z);
  return middle;
}

// A node and all below it, depth first. Returns the node after them.
Index KdTree::build(Index node, Index begin, Index end) {
  const Index middle = makeNode(node, begin, end);
  if (middle == end) return node + 1;
  const Index right = build(node + 1, begin, middle);
  nodes_[node].right = right;
  return build(right, middle, end);
}

// Offers the results every alive point that is not provably farther than their bound; nearer boxes first.
template <class Results>
void KdTree::search(const Vec3& query, Results& results) const {
  if (nodes_.empty()) return;
  const Vec3 q = query;
  struct Pending {
    double squared_distance;
    Index node;
  };
  Pending stack[kMaxDepth];
  int depth = 0;
  stack[depth++] = {squaredDistanceToBox(nodes_[0].lo, nodes_[0].hi, q), 0};
  while (depth > 0) {
    const Pending top = stack[--depth];
    if (!(top.squared_distance <= results.bound())) continue;
    Index at = top.node;
    // Down to the nearest leaf; the farther sibling waits.
    while (nodes_[at].right != 0) {
      const Node& left = nodes_[at + 1];
      const Node& right = nodes_[nodes_[at].right];
      Pending near{squaredDistanceToBox(left.lo, left.hi, q), at + 1};
      Pending far{squaredDistanceToBox(right.lo, right.hi, q), nodes_[at].right};
      // Leaves are on the way from memory while the boxes are compared.
      if (left.right == 0) {
        for (Index s = left.begin; s < right.end; s += kSlotsPerLine) __builtin_prefetch(&slots_[s]);
      }
      if (far.squared_distance < near.squared_distance) std::swap(near, far);
      if (far.squared_distance <= results.bound()) stack[depth++] = far;
      at = near.node;
    }
    const Node& leaf = nodes_[at];
    for (const Slot *s = slots_.data() + leaf.begin, *end = slots_.data() + leaf.end; s != end; ++s) {
      const double squared_distance = squaredLength(s->x - q[0], s->y - q[1], s->z - q[2]);
      if (squared_distance <= results.bound()) results.add(squared_distance, s->point);
    }
  }
}

void KdTree::nearest(const Vec3& query, Index k, std::vector<Neighbor>& out, double reach) const {
  if (k < 0) throw InputError("kd-tree: k: found " + std::to_string(k) + "; accepted: 0 or more");
  if (!(reach >= 0.0)) throw InputError("kd-tree: reach: found " + formatShort(reach) + " m; accepted: 0 or more");
  KNearest results(k, out, reach * reach);
  if (k > 0) search(query, results);
}

void KdTree::withinRadius(const Vec3& query, double radius, std::vector<Neighbor>& out) const {
  if (!(radius >= 0.0)) throw InputError("kd-tree: radius: found " + formatShort(radius) + " m; accepted: 0 or more");
  InBall results(radius * radius, out);
  search(query, results);
  std::sort(out.begin(), out.end());
}

void KdTree::remove(Index point) {
  if (point < 0 || point >= size()) {
    throw InputError("kd-tree: found point " + std::to_string(point) + "; accepted: 0 to " + std::to_string(size() - 1));
  }
  if (slot_of_[point] == kRemoved) throw InputError("kd-tree: point " + std::to_string(point) + " was removed before");
  // No bound admits a distance that is not a number.
  slots_[slot_of_[point]].x = std::numeric_limits<double>::quiet_NaN();
  slot_of_[point] = kRemoved;
  if (2 * --num_alive_ > static_cast<Index>(slots_.size())) return;
  // Half of the points are gone: a new tree for the others costs less than searching through the gaps.
  slots_.erase(std::remove_if(slots_.begin(), slots_.end(), [](const Slot& slot) { return std::isnan(slot.x); }), slots_.end());
  rebuild();
}

bool KdTree::holds(const Points& points) const {
  const Index n = static_cast<Index>(points.size());
  if (size() != n || num_alive_ != n) return false;
  std::atomic<bool> are_same{true};
  parallelFor(n, kBlock, [&](Index begin, Index end) {
    for (Index s = begin; s < end; ++s) {
      const Slot& slot = slots_[s];
      if (points[slot.point] != Vec3(slot.x, slot.y, slot.z)) are_same = false;
    }
  });
  return are_same;
}

const std::vector<Index>& KdTree::order() const { return order_; }

Index KdTree::size() const { return static_cast<Index>(slot_of_.size()); }

}  // namespace deformable_surface::cloud
