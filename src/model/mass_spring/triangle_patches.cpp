// The triangles in the order of their force loop: which of them act as one, and the numbers that the loop reads.
#include "deformable_surface/model/mass_spring/triangle_membrane.h"

#include "deformable_surface/model/mass_spring/incidence.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace deformable_surface::model {

// Triangles with a side in common, by that side. Those of four cocircular points, on every three of them, are found first.
void TriangleMembrane::groupTriangles() {
  patches_.clear();
  const Index n = static_cast<Index>(elements_.size());
  using Side = std::array<Index, 3>;  // two points, ascending, and the triangle
  std::vector<Side> sides;
  sides.reserve(3 * n);
  const auto makeSide = [](Index i, Index j, Index t) { return Side{std::min(i, j), std::max(i, j), t}; };
  for (Index t = 0; t < n; ++t)
    for (int c = 0; c < 3; ++c) sides.push_back(makeSide(elements_[t].corner[c], elements_[t].corner[(c + 1) % 3], t));
  std::sort(sides.begin(), sides.end());
  std::vector<char> is_taken(n, 0);
  const auto oppositeOf = [&](const Side& side) {
    const auto& [i, j, k] = elements_[side[2]].corner;
    return i + j + k - side[0] - side[1];
  };
  // visit(point opposite the side, triangle): of each free triangle at a side, until it returns true.
  const auto findAt = [&](Index i, Index j, const auto& visit) {
    for (auto s = std::lower_bound(sides.begin(), sides.end(), makeSide(i, j, 0));
         s != sides.end() && (*s)[0] == std::min(i, j) && (*s)[1] == std::max(i, j); ++s)
      if (!is_taken[(*s)[2]] && visit(oppositeOf(*s), (*s)[2])) return;
  };
  const auto findOne = [&](Index i, Index j, Index opposite) {
    Index found = -1;
    findAt(i, j, [&](Index point, Index t) { return point == opposite && (found = t, true); });
    return found;
  };
  for (Index t = 0; t < n; ++t) {
    if (is_taken[t]) continue;
    const auto& [i, j, k] = elements_[t].corner;
    Patch four{{i, j, k, -1}, {t, -1, -1, -1}};
    findAt(i, k, [&, i = i, j = j, k = k](Index point, Index u) {
      if (point == j) return false;
      four = {{i, j, k, point}, {t, u, findOne(i, j, point), findOne(j, k, point)}};
      return four.elements[2] >= 0 && four.elements[3] >= 0;
    });
    if (four.points[3] < 0 || four.elements[2] < 0 || four.elements[3] < 0) continue;
    patches_.push_back(four);
    for (const Index u : four.elements) is_taken[u] = 1;
  }
  num_fours_ = static_cast<Index>(patches_.size());
  // The others by twos, first with the neighbour that has the fewest others.
  const auto countFree = [&](Index t) {
    Index count = 0;
    for (int c = 0; c < 3; ++c)
      findAt(elements_[t].corner[c], elements_[t].corner[(c + 1) % 3], [&](Index, Index u) {
        count += u != t;
        return false;
      });
    return count;
  };
  for (Index t = 0; t < n; ++t) {
    if (is_taken[t]) continue;
    const auto& corner = elements_[t].corner;
    Patch pair = makeSingle(t);
    Index fewest = std::numeric_limits<Index>::max();
    for (int c = 0; c < 3; ++c) {
      const Index i = corner[c], j = corner[(c + 1) % 3], k = corner[(c + 2) % 3];
      findAt(i, j, [&](Index point, Index u) {
        if (u == t || point == k) return false;
        const Index free = countFree(u);
        if (free < fewest) {
          fewest = free;
          pair = makePair(t, u);
        }
        return false;
      });
    }
    patches_.push_back(pair);
    for (const Index u : pair.elements)
      if (u >= 0) is_taken[u] = 1;
  }
}

// Without a partner the second triangle is the first one, without weight.
TriangleMembrane::Patch TriangleMembrane::makeSingle(Index t) const {
  const auto& [i, j, k] = elements_[t].corner;
  return {{i, j, k, j}, {t, -1, -1, -1}};
}

// Of two triangles with a side in common.
TriangleMembrane::Patch TriangleMembrane::makePair(Index t, Index u) const {
  const auto& of_t = elements_[t].corner;
  const auto& of_u = elements_[u].corner;
  for (int c = 0; c < 3; ++c) {
    const Index i = of_t[c], j = of_t[(c + 1) % 3], k = of_t[(c + 2) % 3];
    if (std::find(of_u, of_u + 3, i) == of_u + 3 || std::find(of_u, of_u + 3, j) == of_u + 3) continue;
    const Index opposite = of_u[0] + of_u[1] + of_u[2] - i - j;
    if (opposite != k) return {{i, k, j, opposite}, {t, u, -1, -1}};
  }
  return makeSingle(t);
}

// The patches of a membrane that had more triangles. What is left of a patch that has lost some is taken by twos.
void TriangleMembrane::takePatches(const TriangleMembrane& whole) {
  const Index n = static_cast<Index>(elements_.size());
  std::vector<Index> place(whole.elements_.size(), -1);  // of its triangles here
  Index next = 0;
  for (std::size_t t = 0; t < place.size() && next < n; ++t)
    if (std::equal(elements_[next].corner, elements_[next].corner + 3, whole.elements_[t].corner)) place[t] = next++;
  patches_.clear();
  std::vector<Patch> pairs;
  for (Patch patch : whole.patches_) {
    Index left[4], count = 0;
    bool is_complete = true;
    for (Index& t : patch.elements) {
      if (t < 0) continue;
      t = place[t];
      if (t >= 0) left[count++] = t;
      is_complete = is_complete && t >= 0;
    }
    if (is_complete) {
      (count == 4 ? patches_ : pairs).push_back(patch);
    } else {
      for (Index k = 0; k + 1 < count; k += 2) pairs.push_back(makePair(left[k], left[k + 1]));
      if (count % 2 == 1) pairs.push_back(makeSingle(left[count - 1]));
    }
  }
  num_fours_ = static_cast<Index>(patches_.size());
  patches_.insert(patches_.end(), pairs.begin(), pairs.end());
}

// The numbers of an element for the force loop, with its edges from p to q and to r.
std::array<double, 6> TriangleMembrane::constantsOf(const Element& e, Index p, Index q, Index r) {
  const Mat2 at_rest = e.inverse.inverse();
  const auto placeOf = [&](Index point) -> Vec2 {
    return point == e.corner[0] ? Vec2::Zero() : Vec2(at_rest.col(point == e.corner[1] ? 0 : 1));
  };
  Mat2 edges;
  edges << placeOf(q) - placeOf(p), placeOf(r) - placeOf(p);
  const Mat2 inverse = edges.inverse(), G = inverse * inverse.transpose();
  const double det = std::abs(inverse.determinant());
  return {G(0, 0), G(0, 1), G(1, 1), det, e.area, e.area * det};
}

void TriangleMembrane::prepareForceLoop(Index num_points) {
  const Index num_patches = static_cast<Index>(patches_.size());
  const Index groups_of_fours = (num_fours_ + 3) / 4, groups = groups_of_fours + (num_patches - num_fours_ + 3) / 4;
  std::vector<std::pair<Index, Index>> corners;
  corners.reserve(4 * num_patches);
  corner_force_.resize(64 * groups);
  group_points_.resize(16 * groups);
  group_constants_.resize(96 * groups_of_fours + 48 * (groups - groups_of_fours));
  for (Index place = 0; place < 4 * groups; ++place) {
    const Index group = place / 4, lane = place % 4;
    const bool is_four = group < groups_of_fours;
    const Index wanted = is_four ? place : num_fours_ + place - 4 * groups_of_fours, end = is_four ? num_fours_ : num_patches;
    // The last group is filled up with the last patch, whose forces there are not gathered.
    const Patch& patch = patches_[std::min(wanted, end - 1)];
    for (int c = 0; c < 4; ++c) {
      group_points_[16 * group + 4 * c + lane] = patch.points[c];
      if (wanted < end && (c < 3 || patch.elements[1] >= 0)) corners.emplace_back(patch.points[c], 16 * group + 4 * c + lane);
    }
    double* constants = &group_constants_[is_four ? 96 * group : 96 * groups_of_fours + 48 * (group - groups_of_fours)];
    const auto& [i, j, k, l] = patch.points;
    const Index ends[4][3] = {{i, j, k}, {i, k, l}, {i, j, l}, {j, k, l}};
    for (int t = 0; t < (is_four ? 4 : 2); ++t) {
      const bool is_there = patch.elements[t] >= 0;
      const Element& e = elements_[patch.elements[is_there ? t : 0]];
      std::array<double, 6> numbers = constantsOf(e, ends[t][0], ends[t][1], ends[t][2]);
      if (!is_there) numbers[4] = numbers[5] = 0.0;
      for (int c = 0; c < 6; ++c) constants[24 * t + 4 * c + lane] = numbers[c];
    }
  }
  incidence_ = groupByPoint(num_points, corners);
}

Index TriangleMembrane::patchOf(Index item) const {
  const Index group = item / 16, groups_of_fours = (num_fours_ + 3) / 4;
  return item % 4 + (group < groups_of_fours ? 4 * group : num_fours_ + 4 * (group - groups_of_fours));
}

}  // namespace deformable_surface::model
