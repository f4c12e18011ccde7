// Pairs that meet, the place and axis of the tube between their sheets, and its particles.
#include "deformable_surface/model/oriented_particles/sheet_joint.h"

#include "deformable_surface/cloud/kd_tree.h"

#include <algorithm>
#include <cmath>
#include <tuple>

namespace deformable_surface::model {
namespace {

// Lengths in spacings. Chosen on spheres of 400 to 800 particles with balls of 0.3, 0.4 and 0.6 of their radius.
constexpr double kFacing = -0.5;   // cosine between normals
constexpr double kAhead = 0.7;     // cosine between a normal and the line to the other
constexpr double kTogether = 2.0;  // pairs with a middle this near to that of the nearest pair tell place and axis
constexpr double kStep = 1.6;      // from neighbour to neighbour
constexpr int kSteps = 8;          // through a tube there are up to seven from a pair beside it; with five a second tube opened
constexpr double kRing = 0.5;      // height of a ring above the middle
constexpr double kWaist = 1.15;    // radius of a ring: seven particles a spacing apart; across, they are out of reach of bonds
constexpr double kRim = 0.3;       // particles inside of this distance outside of the rings go
constexpr double kHigh = 2.2;      // and up to this height above the middle: dents are hollow there
constexpr double kClear = 0.75;    // and those this near to a new one
constexpr int kAround = kTubeParticles / 2;

struct Meeting {
  double squared_distance;
  Index i, j;
};

// Whether one particle is reached from another in few steps, each to a neighbour that faces the same way within 90 degrees.
bool areNearAlongSurface(const cloud::KdTree& tree, const Points& positions, const Points& normals, double step, Index from,
                         Index to) {
  std::vector<Index> reached(1, from);
  std::vector<char> is_reached(positions.size(), 0);
  is_reached[from] = 1;
  std::vector<cloud::Neighbor> near;
  std::size_t begin = 0;
  for (int steps = 0; steps < kSteps; ++steps) {
    const std::size_t end = reached.size();
    for (; begin < end; ++begin) {
      tree.withinRadius(positions[reached[begin]], step, near);
      for (const cloud::Neighbor& q : near) {
        if (is_reached[q.index] || !(normals[q.index].dot(normals[reached[begin]]) > 0.0)) continue;
        if (q.index == to) return true;
        is_reached[q.index] = 1;
        reached.push_back(q.index);
      }
    }
  }
  return false;
}

}  // namespace

std::optional<SheetJoint> joinSheets(const Points& positions, const Orientations& orientations, const std::vector<char>& is_gone,
                                     double spacing, double meeting, const std::vector<Index>& candidates,
                                     const std::function<bool(Index, Index)>& may_join) {
  if (candidates.size() < 2) return {};
  const Index n = static_cast<Index>(positions.size());
  Points normals;
  for (const Eigen::Quaterniond& q : orientations) normals.push_back(q * Vec3::UnitZ());
  const cloud::KdTree tree(positions);
  std::vector<char> is_candidate(n, 0);
  for (const Index i : candidates) is_candidate[i] = !is_gone[i];

  std::vector<Meeting> meetings;
  std::vector<cloud::Neighbor> near;
  for (const Index i : candidates) {
    if (!is_candidate[i]) continue;
    tree.withinRadius(positions[i], meeting, near);
    for (const cloud::Neighbor& q : near) {
      const Index j = q.index;
      if (j <= i || !is_candidate[j] || !(normals[i].dot(normals[j]) < kFacing)) continue;
      const Vec3 line = positions[j] - positions[i];
      const double ahead = normals[i].dot(line), back = -normals[j].dot(line), least = kAhead * line.norm();
      const bool is_across = (ahead > least && back > least) || (ahead < -least && back < -least);
      if (is_across && may_join(i, j)) meetings.push_back({q.squared_distance, i, j});
    }
  }
  std::sort(meetings.begin(), meetings.end(), [](const Meeting& a, const Meeting& b) {
    return std::tie(a.squared_distance, a.i, a.j) < std::tie(b.squared_distance, b.i, b.j);
  });
  const auto first = std::find_if(meetings.begin(), meetings.end(), [&](const Meeting& m) {
    return !areNearAlongSurface(tree, positions, normals, kStep * spacing, m.i, m.j);
  });
  if (first == meetings.end()) return {};

  // Towards the sheet of first->i. Backs meet where its normal points away from the other.
  const auto middleOf = [&](const Meeting& m) { return Vec3(0.5 * (positions[m.i] + positions[m.j])); };
  const bool is_back = normals[first->i].dot(positions[first->j] - positions[first->i]) < 0.0;
  const double side = is_back ? 1.0 : -1.0;
  const Vec3 up = side * (normals[first->i] - normals[first->j]);
  Vec3 middle = Vec3::Zero(), axis = Vec3::Zero();
  double count = 0.0;
  for (const Meeting& m : meetings) {
    if (!((middleOf(m) - middleOf(*first)).norm() <= kTogether * spacing)) continue;
    const Vec3 along = side * (normals[m.i] - normals[m.j]);
    axis += along.dot(up) > 0.0 ? along : -along;
    middle += middleOf(m);
    count += 1.0;
  }
  middle /= count;
  axis.normalize();
  const Vec3 x = axis.unitOrthogonal(), y = axis.cross(x);

  SheetJoint joint;
  joint.is_gone = is_gone;
  Points tube, tube_normals, tube_tangents;
  for (int k = 0; k < 2 * kAround; ++k) {
    const double above = k % 2 == 0 ? kRing : -kRing, angle = kPi * k / kAround;  // the rings are half a particle apart
    const Vec3 outwards = std::cos(angle) * x + std::sin(angle) * y;
    tube.push_back(middle + spacing * (kWaist * outwards + above * axis));
    const double rise = above * spacing / (0.5 * meeting);  // sine of the slope of the half circle
    tube_normals.push_back(side * (rise * axis - std::sqrt(1.0 - rise * rise) * outwards));
    tube_tangents.push_back(axis.cross(outwards));
  }
  tree.withinRadius(middle, std::hypot(kWaist + kRim, kHigh) * spacing, near);
  for (const cloud::Neighbor& q : near) {
    const Vec3 offset = positions[q.index] - middle;
    const double height = offset.dot(axis);
    if (std::abs(height) <= kHigh * spacing && (offset - height * axis).norm() <= (kWaist + kRim) * spacing)
      joint.is_gone[q.index] = 1;
  }
  for (const Vec3& place : tube) {
    tree.withinRadius(place, kClear * spacing, near);
    for (const cloud::Neighbor& q : near) joint.is_gone[q.index] = 1;
  }
  // Parents: the nearest remaining ones above and below.
  for (std::size_t k = 0; k < tube.size(); ++k) {
    Mat3 frame;
    frame.col(0) = tube_tangents[k];
    frame.col(2) = tube_normals[k];
    frame.col(1) = tube_normals[k].cross(tube_tangents[k]);
    NewParticle particle{tube[k], Eigen::Quaterniond(frame).normalized(), {-1, -1}};
    tree.withinRadius(tube[k], 2.0 * kHigh * spacing, near);
    for (const cloud::Neighbor& q : near) {
      if (joint.is_gone[q.index]) continue;
      const double height = (positions[q.index] - middle).dot(axis);
      Index& parent = particle.parents[height > 0.0 ? 0 : 1];
      if (parent < 0) parent = q.index;
    }
    if (particle.parents[0] < 0 || particle.parents[1] < 0) return {};  // no sheets are left around
    joint.tube.push_back(particle);
  }
  return joint;
}

}  // namespace deformable_surface::model
