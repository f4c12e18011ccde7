#include "deformable_surface/model/oriented_particles/approach_tree.h"

#include "deformable_surface/base/parallel.h"
#include "deformable_surface/base/simd.h"

#include <algorithm>
#include <limits>
#include <numeric>

namespace deformable_surface::model {
namespace {

constexpr Index kMostVisits = 20;  // pairs of boxes for each particle: they take as long as making the lists anew
constexpr Index kTired = 2;        // of them for each particle: a look at all near pairs takes about as long
constexpr Index kMostAge = 4;      // calls of renew() between two trees, which cost a third of the lists
constexpr Index kLeafBlock = 32;

}  // namespace

Index ApproachTree::beginOf(Index leaf) const {
  return static_cast<Index>(static_cast<std::int64_t>(leaf) * size() / num_leaves_);
}

void ApproachTree::renew(const Points& places) {
  if (places.size() != order_.size() || (++age_ >= kMostAge && is_slow_)) {
    build(places);
    age_ = 0;
  }
  is_slow_ = has_base_ = false;
  may_have_base_ = true;
  visited_ = 0;
}

void ApproachTree::build(const Points& places) {
  order_.resize(places.size());
  std::iota(order_.begin(), order_.end(), 0);
  num_leaves_ = 1;
  while (num_leaves_ * kLeaf < size()) num_leaves_ *= 2;
  boxes_.resize(2 * num_leaves_);
  leaves_.resize(num_leaves_);
  for (Index width = num_leaves_; width > 1; width /= 2)
    for (Index leaf = 0; leaf < num_leaves_; leaf += width) {
      const auto begin = order_.begin() + beginOf(leaf), middle = order_.begin() + beginOf(leaf + width / 2),
                 end = order_.begin() + beginOf(leaf + width);
      Vec3 low = places[*begin], high = low;
      for (auto i = begin; i != end; ++i) {
        low = low.cwiseMin(places[*i]);
        high = high.cwiseMax(places[*i]);
      }
      int axis;
      (high - low).maxCoeff(&axis);
      std::nth_element(begin, middle, end, [&](Index a, Index b) {
        return places[a][axis] < places[b][axis] || (!(places[b][axis] < places[a][axis]) && a < b);
      });
    }
}

void ApproachTree::fill(const Points& then, const Points& now, Index leaf) {
  constexpr double kFar = std::numeric_limits<double>::infinity();
  Vec3 low = Vec3::Constant(kFar), high = -low, least_move = low, most_move = high;
  Leaf& places = leaves_[leaf];
  const Index begin = beginOf(leaf), count = beginOf(leaf + 1) - begin;
  for (Index k = 0; k < count; ++k) {
    const Index i = order_[begin + k];
    const Vec3 &p = now[i], move = p - then[i];
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
    least_move = least_move.cwiseMin(move);
    most_move = most_move.cwiseMax(move);
    places.particle[k] = i;
    places.x[k] = p.x();
    places.y[k] = p.y();
    places.z[k] = p.z();
  }
  places.count = count;
  for (Index k = count; k < kLeaf; ++k) places.x[k] = std::numeric_limits<double>::quiet_NaN();
  Box& box = boxes_[num_leaves_ + leaf];
  for (const auto& [numbers, vector] : {std::pair(box.low, low), std::pair(box.high, high), std::pair(box.least_move, least_move),
                                        std::pair(box.most_move, most_move)})
    Eigen::Map<Vec4>(numbers) << vector, 0.0;
}

// Looks for pairs that are near but not listed.
class ApproachTree::Search {
 public:
  // slack: m, that pairs may move against each other from the base. looks_at_all: whether pairs nearer than the radius and the
  // slack are listed, wherever they were at the base.
  Search(const ApproachTree& tree, const Points& then, const Points& base, const Points& now, const Lengths& lengths,
         double slack, bool looks_at_all)
      : tree_(tree),
        then_(then),
        base_(base),
        now_(now),
        lengths_(lengths),
        slack_(looks_at_all ? -1.0 : slack),
        radius_(looks_at_all ? lengths.radius + slack : lengths.radius),
        skin_(looks_at_all ? lengths.skin - slack : lengths.skin) {}
  Index visited() const { return visited_; }

  // False if there is one, or after `most` pairs of boxes.
  DEFORMABLE_SURFACE_INLINE bool run(Index most) {
    const double squared_radius = radius_ * radius_, squared_slack = slack_ > 0.0 ? slack_ * slack_ : -1.0;
    constexpr int kMostLevels = 32;
    struct {
      Index a, b;
    } stack[3 * kMostLevels + 4];
    int top = 0;
    stack[top++] = {1, 1};
    while (top > 0) {
      const auto [a, b] = stack[--top];
      ++visited_;
      if (areFarOrStill(tree_.boxes_[a], tree_.boxes_[b], squared_radius, squared_slack)) continue;
      if (visited_ > most) return false;
      if (a >= tree_.num_leaves_) {
        if (!areListed(tree_.leaves_[a - tree_.num_leaves_], tree_.leaves_[b - tree_.num_leaves_])) return false;
        continue;
      }
      stack[top++] = {2 * a, 2 * b};
      stack[top++] = {2 * a + 1, 2 * b + 1};
      stack[top++] = {2 * a, 2 * b + 1};
      if (a != b) stack[top++] = {2 * a + 1, 2 * b};
    }
    return true;
  }

 private:
  // The squared length of the larger of a - b and c - d, by axis, where it is positive.
  static DEFORMABLE_SURFACE_INLINE double squareLarger(const double* a, const double* b, const double* c, const double* d) {
    const Double4 zero{0.0, 0.0, 0.0, 0.0};
    Double4 larger, other, from;
    load(a, larger);
    load(b, from);
    larger -= from;
    load(c, other);
    load(d, from);
    other -= from;
    larger = larger > other ? larger : other;
    larger = zero > larger ? zero : larger;  // what is undefined remains so
    larger *= larger;
    return larger[0] + larger[1] + larger[2];
  }

  // Whether no pair of both boxes is near now, or none has moved against each other by more than the slack.
  static DEFORMABLE_SURFACE_INLINE bool areFarOrStill(const Box& a, const Box& b, double squared_radius, double squared_slack) {
    return squareLarger(b.low, a.high, a.low, b.high) > squared_radius ||
           squareLarger(b.most_move, a.least_move, a.most_move, b.least_move) <= squared_slack;
  }

  // Whether the near pairs of two leaves are listed.
  DEFORMABLE_SURFACE_INLINE bool areListed(const Leaf& a, const Leaf& b) const {
    constexpr double kRounding = 1.0 - 1e-9;
    const double squared_reach = kRounding * lengths_.reach * lengths_.reach;
    const double squared_skin = kRounding * skin_ * skin_, squared_slack = slack_ > 0.0 ? kRounding * slack_ * slack_ : -1.0;
    const Double4 most = Double4{0.0, 0.0, 0.0, 0.0} + radius_ * radius_;
    for (Index i = 0; i < a.count; ++i)
      for (Index first = 0; first < kLeaf; first += 4) {
        Double4 x, y, z;
        load(b.x + first, x);
        load(b.y + first, y);
        load(b.z + first, z);
        x -= a.x[i];
        y -= a.y[i];
        z -= a.z[i];
        const auto is_near = x * x + y * y + z * z < most;  // -1 where it holds
        if ((is_near[0] | is_near[1] | is_near[2] | is_near[3]) == 0) continue;
        for (Index k = 0; k < 4; ++k) {
          if (is_near[k] == 0 || (&a == &b && first + k <= i)) continue;
          const Index p = a.particle[i], q = b.particle[first + k];
          const Vec3 before = then_[q] - then_[p], here = now_[q] - now_[p];
          if (lengths_.is_listed_by_distance && before.squaredNorm() <= squared_reach) continue;
          if ((here - before).squaredNorm() <= squared_skin) continue;
          if (!((here - (base_[q] - base_[p])).squaredNorm() <= squared_slack)) return false;
        }
      }
    return true;
  }

  const ApproachTree& tree_;
  const Points &then_, &base_, &now_;
  const Lengths& lengths_;
  const double slack_, radius_, skin_;  // m; a slack below zero: none
  Index visited_ = 0;
};

DEFORMABLE_SURFACE_WIDE
bool ApproachTree::runWide(Search& search, Index most) { return search.run(most); }

void ApproachTree::join() {
  for (Index k = num_leaves_ - 1; k > 0; --k) {
    const Box &a = boxes_[2 * k], &b = boxes_[2 * k + 1];
    Box& both = boxes_[k];
    for (int axis = 0; axis < 4; ++axis) {
      both.low[axis] = std::min(a.low[axis], b.low[axis]);
      both.high[axis] = std::max(a.high[axis], b.high[axis]);
      both.least_move[axis] = std::min(a.least_move[axis], b.least_move[axis]);
      both.most_move[axis] = std::max(a.most_move[axis], b.most_move[axis]);
    }
  }
}

bool ApproachTree::holds(const Points& then, const Points& now, const Lengths& lengths) {
  const Points& base = has_base_ ? base_ : then;
  parallelFor(num_leaves_, kLeafBlock, [&](Index begin, Index end) {
    for (Index leaf = begin; leaf < end; ++leaf) fill(base, now, leaf);
  });
  join();
  Search search(*this, then, base, now, lengths, slack(lengths.skin), false);
  const bool holds = runWide(search, kMostVisits * size() - visited_);
  visited_ += search.visited();
  is_slow_ = visited_ > kMostVisits * size();
  if (!holds || !may_have_base_ || visited_ <= kTired * size()) return holds;
  Search all(*this, then, base, now, lengths, kLeft * lengths.skin, true);
  may_have_base_ = runWide(all, kMostVisits * size());
  if (!may_have_base_) return holds;
  base_ = now;
  has_base_ = true;
  visited_ = 0;
  return holds;
}

std::size_t ApproachTree::bytes() const {
  return order_.capacity() * sizeof(Index) + base_.capacity() * sizeof(Vec3) + boxes_.capacity() * sizeof(Box) +
         leaves_.capacity() * sizeof(Leaf);
}

}  // namespace deformable_surface::model
