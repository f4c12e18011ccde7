// Pairs that meet, the place and axis of the tube between their sheets, and its particles.
#include "deformable_surface/model/oriented_particles/sheet_joint.h"

#include "deformable_surface/cloud/kd_tree.h"

#include <algorithm>
#include <cmath>
#include <tuple>
#include <utility>

namespace deformable_surface::model {
namespace {

// Lengths in spacings. Chosen on spheres of 400 to 800 particles with balls of 0.3, 0.4 and 0.6 of their radius.
constexpr double kFacing = -0.5;   // cosine between normals
constexpr double kAhead = 0.7;     // cosine between a normal and the line to the other
constexpr double kAlmost = 1.0;    // pairs that are this much farther apart than those that meet tell place and axis, too
constexpr double kTogether = 1.2;  // as far as the middles of pairs reach one another
constexpr double kStep = 1.6;      // from neighbour to neighbour
constexpr int kSteps = 8;          // through a tube there are up to seven from a pair beside it; with five a second tube opened
constexpr double kWaist = 0.624;   // radius of the waist, in reaches of bonds: across, particles are out of reach
constexpr double kRows = 1.06;     // from ring to ring
constexpr double kAround = 1.03;   // from particle to particle of a ring
constexpr double kRim = 0.3;       // particles inside of this distance outside of the rings go
constexpr double kHigh = 1.3;      // and up to this height above the sheets: dents are hollow there
constexpr double kClear = 0.75;    // and those this near to a new one

struct Meeting {
  double squared_distance;
  Index i, j;
};

// 1 for the particles that are reached from one in few steps, each to a neighbour that does not face it: where tools press on a
// tube, its rings are folded more sharply than by 90 degrees.
std::vector<char> findNearAlongSurface(const cloud::KdTree& tree, const Points& positions, const Points& normals, double step,
                                       Index from) {
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
        if (is_reached[q.index] || !(normals[q.index].dot(normals[reached[begin]]) > kFacing)) continue;
        is_reached[q.index] = 1;
        reached.push_back(q.index);
      }
    }
  }
  return is_reached;
}

Vec3 middleOf(const Meeting& m, const Points& positions) { return 0.5 * (positions[m.i] + positions[m.j]); }

// Of meetings, the nearest first: that of the nearest pair that meets and all that are beside it, and beside those. Where any of
// these is near along the surface, as beside a tube, the place has been joined.
template <class IsJoined>
std::vector<Meeting> findPlace(const std::vector<Meeting>& meetings, const Points& positions, double meeting, double spacing,
                               const IsJoined& isJoined) {
  if (meetings.empty()) return {};
  Points middles;
  for (const Meeting& m : meetings) middles.push_back(middleOf(m, positions));
  const cloud::KdTree tree(middles);
  std::vector<char> is_seen(meetings.size(), 0);
  std::vector<cloud::Neighbor> near;
  for (std::size_t first = 0; first < meetings.size(); ++first) {
    if (!(meetings[first].squared_distance <= meeting * meeting)) break;
    if (std::exchange(is_seen[first], 1)) continue;
    std::vector<Meeting> place(1, meetings[first]);
    for (std::size_t k = 0; k < place.size(); ++k) {
      tree.withinRadius(middleOf(place[k], positions), kTogether * spacing, near);
      for (const cloud::Neighbor& q : near)
        if (!std::exchange(is_seen[q.index], 1)) place.push_back(meetings[q.index]);
    }
    if (!isJoined(place)) return place;
  }
  return {};
}

}  // namespace

std::optional<SheetJoint> joinSheets(const Points& positions, const Orientations& orientations, const std::vector<char>& is_gone,
                                     double spacing, double reach, double meeting, double shortest,
                                     const std::vector<Index>& candidates, const std::function<bool(Index, Index)>& may_join) {
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
    tree.withinRadius(positions[i], meeting + kAlmost * spacing, near);
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
  const auto isJoined = [&](std::vector<Meeting> pairs) {
    std::sort(pairs.begin(), pairs.end(), [](const Meeting& a, const Meeting& b) { return a.i < b.i; });
    std::vector<char> is_near;
    for (std::size_t k = 0; k < pairs.size(); ++k) {
      if (k == 0 || pairs[k].i != pairs[k - 1].i)
        is_near = findNearAlongSurface(tree, positions, normals, kStep * spacing, pairs[k].i);
      if (is_near[pairs[k].j]) return true;
    }
    return false;
  };
  const std::vector<Meeting> place = findPlace(meetings, positions, meeting, spacing, isJoined);
  if (place.empty()) return {};

  // Towards the sheet of the first particle. Backs meet where its normal points away from the other.
  const Meeting& first = place.front();
  const bool is_back = normals[first.i].dot(positions[first.j] - positions[first.i]) < 0.0;
  const double side = is_back ? 1.0 : -1.0;
  const Vec3 up = side * (normals[first.i] - normals[first.j]);
  Vec3 middle = Vec3::Zero(), axis = Vec3::Zero();
  for (const Meeting& m : place) {
    const Vec3 along = side * (normals[m.i] - normals[m.j]);
    axis += along.dot(up) > 0.0 ? along : -along;
    middle += middleOf(m, positions);
  }
  middle /= static_cast<double>(place.size());
  axis.normalize();
  const Vec3 x = axis.unitOrthogonal(), y = axis.cross(x);

  // Rings along a half circle from sheet to sheet.
  const double apart = std::sqrt(first.squared_distance);
  const double bend = 0.5 * std::max(apart, std::min(shortest, meeting)), waist = kWaist * reach;
  const int num_rings = std::max(2, static_cast<int>(std::lround(kPi * bend / (kRows * spacing))) - 1);
  const double between = kRows * spacing / bend, steepest = 0.5 * (num_rings - 1) * between;
  SheetJoint joint;
  joint.is_gone = is_gone;
  joint.middle = middle;
  joint.apart = apart;
  Points tube, tube_normals, tube_tangents;
  for (int ring = 0; ring < num_rings; ++ring) {
    const double slope = ring * between - steepest;
    const double radius = waist + bend * (1.0 - std::cos(slope)), above = bend * std::sin(slope);
    const int around = static_cast<int>(std::lround(2.0 * kPi * radius / (kAround * spacing)));
    for (int k = 0; k < around; ++k) {
      const double angle = 2.0 * kPi * (k + 0.5 * (ring % 2)) / around;
      const Vec3 outwards = std::cos(angle) * x + std::sin(angle) * y;
      tube.push_back(middle + radius * outwards + above * axis);
      tube_normals.push_back(side * (std::sin(slope) * axis - std::cos(slope) * outwards));
      tube_tangents.push_back(axis.cross(outwards));
    }
  }
  const double open = waist + bend * (1.0 - std::cos(steepest)) + kRim * spacing, high = bend + kHigh * spacing;
  tree.withinRadius(middle, std::hypot(open, high), near);
  for (const cloud::Neighbor& q : near) {
    const Vec3 offset = positions[q.index] - middle;
    const double height = offset.dot(axis);
    if (std::abs(height) <= high && (offset - height * axis).norm() <= open) joint.is_gone[q.index] = 1;
  }
  for (const Vec3& born : tube) {
    tree.withinRadius(born, kClear * spacing, near);
    for (const cloud::Neighbor& q : near) joint.is_gone[q.index] = 1;
  }
  // Parents: the nearest remaining ones above and below.
  for (std::size_t k = 0; k < tube.size(); ++k) {
    Mat3 frame;
    frame.col(0) = tube_tangents[k];
    frame.col(2) = tube_normals[k];
    frame.col(1) = tube_normals[k].cross(tube_tangents[k]);
    NewParticle particle{tube[k], Eigen::Quaterniond(frame).normalized(), {-1, -1}};
    tree.withinRadius(tube[k], open + high, near);
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
