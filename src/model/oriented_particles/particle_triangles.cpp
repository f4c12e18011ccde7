// Candidates with their spheres, found in parallel; then a choice among overlapping ones, in a fixed order.
#include "deformable_surface/model/oriented_particles/particle_triangles.h"

#include "deformable_surface/base/error.h"
#include "deformable_surface/base/parallel.h"
#include "deformable_surface/cloud/kd_tree.h"
#include "deformable_surface/cloud/links.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <tuple>

namespace deformable_surface::model {
namespace {

// Cosine of the angle between a triangle's plane and the tangent plane of a corner: the same limit as for links
// (cloud/links.h).
constexpr double kMinAgreement = 0.5;

// Share of a sphere's radius by which a particle may miss it and still count as lying on it: far above the rounding of float
// coordinates, far below the differences between lattices.
constexpr double kTie = 0.01;

// Share of the radius that a particle may lie inside the sphere of a triangle which closes a gap. On curved or noisy
// surfaces the spheres of both pairs of triangles in a quadrilateral may contain its fourth corner, though not deeply.
constexpr double kMaxDepth = 0.3;

// Of the longest edge: that across a quadrilateral which nothing else closes.
constexpr double kLongestDiagonal = 4.0 / 3.0;

constexpr Index kBlock = 256;

constexpr double kTwoPi = 6.283185307179586;

struct Candidate {
  Index corner[3];
  int rank;      // 0 = empty sphere, 1 = particles on it, 2 = within it
  double depth;  // of rank 2: share of the radius that the deepest particle lies inside

  bool operator<(const Candidate& o) const {
    return std::tie(rank, depth, corner[0], corner[1], corner[2]) <
           std::tie(o.rank, o.depth, o.corner[0], o.corner[1], o.corner[2]);
  }
};

struct Sphere {
  Vec3 center;
  double radius;  // m; infinite or not a number for collinear corners
};

Sphere findSphere(const Vec3& a, const Vec3& b, const Vec3& c) {
  const Vec3 u = b - a, v = c - a, n = u.cross(v);
  const Vec3 to_center = (u.squaredNorm() * v.cross(n) + v.squaredNorm() * n.cross(u)) / (2.0 * n.squaredNorm());
  return {a + to_center, to_center.norm()};
}

// Share of the radius that the deepest particle facing `normal` lies inside the sphere; negative if all are outside. Corners are
// not counted.
template <std::size_t N>
double findDepth(const Points& positions, const Points& normals, const Vec3& normal, const Sphere& sphere,
                 const std::vector<cloud::Neighbor>& near, const Index (&corners)[N], const AreApart& apart) {
  double depth = -1.0;
  for (const cloud::Neighbor& q : near) {
    if (std::find(corners, corners + N, q.index) != corners + N || !(normals[q.index].dot(normal) > 0.0)) continue;
    if (apart && std::any_of(corners, corners + N, [&](Index c) { return apart(q.index, c); })) continue;
    depth = std::max(depth, 1.0 - (positions[q.index] - sphere.center).norm() / sphere.radius);
  }
  return depth;
}

class Candidates {
 public:
  Candidates(const Points& positions, const Points& normals, double max_edge, const AreApart& apart)
      : positions_(positions), normals_(normals), max_edge_(max_edge), apart_(apart), tree_(positions) {}

  std::vector<Candidate> find() const {
    const Index n = static_cast<Index>(positions_.size());
    std::vector<std::vector<Candidate>> of_block(n / kBlock + 1);
    parallelFor(n, kBlock, [&](Index begin, Index end) {
      std::vector<cloud::Neighbor> near, in_sphere;
      for (Index i = begin; i < end; ++i) addAt(i, near, in_sphere, of_block[begin / kBlock]);
    });
    std::vector<Candidate> all;
    for (const auto& some : of_block) all.insert(all.end(), some.begin(), some.end());
    return all;
  }

 private:
  // Adds the candidates with i as their smallest corner.
  void addAt(Index i, std::vector<cloud::Neighbor>& near, std::vector<cloud::Neighbor>& in_sphere,
             std::vector<Candidate>& out) const {
    tree_.withinRadius(positions_[i], max_edge_, near);
    for (std::size_t s = 0; s < near.size(); ++s) {
      for (std::size_t r = 0; r < s; ++r) {
        const Index a = std::min(near[r].index, near[s].index), b = std::max(near[r].index, near[s].index);
        if (a <= i || !((positions_[b] - positions_[a]).norm() <= max_edge_)) continue;
        if (apart_ && (apart_(i, a) || apart_(i, b) || apart_(a, b))) continue;
        Candidate candidate{{i, a, b}, 0, 0.0};
        Vec3 normal = (positions_[a] - positions_[i]).cross(positions_[b] - positions_[i]).normalized();
        if (normal.dot(normals_[i]) < 0.0) {
          normal = -normal;
          std::swap(candidate.corner[1], candidate.corner[2]);
        }
        if (!(std::min({normal.dot(normals_[i]), normal.dot(normals_[a]), normal.dot(normals_[b])}) >= kMinAgreement)) continue;
        const Sphere sphere = findSphere(positions_[i], positions_[a], positions_[b]);
        if (!(sphere.radius <= max_edge_)) continue;
        // Most candidates fail at a particle that is near i anyway.
        if (findDepth(positions_, normals_, normal, sphere, near, candidate.corner, apart_) > kMaxDepth) continue;
        tree_.withinRadius(sphere.center, (1.0 + kTie) * sphere.radius, in_sphere);
        const double depth = findDepth(positions_, normals_, normal, sphere, in_sphere, candidate.corner, apart_);
        if (depth > kMaxDepth) continue;
        candidate.rank = depth < -kTie ? 0 : depth <= kTie ? 1 : 2;
        if (candidate.rank == 2) candidate.depth = depth;
        out.push_back(candidate);
      }
    }
  }

  const Points& positions_;
  const Points& normals_;
  double max_edge_;
  const AreApart& apart_;
  cloud::KdTree tree_;
};

// The triangles chosen so far, as the sectors that they cover at each corner.
class Manifold {
 public:
  Manifold(const Points& positions, const Points& normals)
      : positions_(positions), normals_(normals), sectors_(positions.size()) {}

  // Adds the triangle unless it overlaps another at a corner, or shares fewer than min_joined edges with others.
  bool add(const Index (&corner)[3], int min_joined) {
    Sector sector[3];
    int joined = 0;
    for (int s = 0; s < 3; ++s) {
      const Index at = corner[s], from = corner[(s + 1) % 3], to = corner[(s + 2) % 3];
      const cloud::TangentPlane plane(positions_[at], normals_[at]);
      sector[s] = {from, to, findAngle(plane, from), findAngle(plane, to)};
      if (!(sector[s].width() < 0.5 * kTwoPi)) return false;  // seen along this normal it is turned over
      for (const Sector& other : sectors_[at]) {
        if (turn(sector[s].begin, other.begin) < sector[s].width()) return false;
        if (turn(other.begin, sector[s].begin) < other.width()) return false;
        joined += other.to == from;
      }
    }
    if (joined < min_joined) return false;
    for (int s = 0; s < 3; ++s) sectors_[corner[s]].push_back(sector[s]);
    return true;
  }

 private:
  // Angle (rad) from one direction counter-clockwise to another, 0 .. 2 pi. The same directions give the same bits.
  static double turn(double from, double to) { return to >= from ? to - from : to - from + kTwoPi; }

  struct Sector {
    Index from, to;
    double begin, end;  // rad, in the tangent plane
    double width() const { return turn(begin, end); }
  };

  double findAngle(const cloud::TangentPlane& plane, Index i) const {
    const Vec2 p = plane.project(positions_[i]);
    return std::atan2(p.y(), p.x());
  }

  const Points& positions_;
  const Points& normals_;
  std::vector<std::vector<Sector>> sectors_;  // (n)
};

// Closes what the spheres leave open within one ring of particles: boundary loops of three or four edges. Nothing is missing
// there: a hole of the surface would be wider. Such loops remain where the surface is bent so much, or two particles are so
// close, that both pairs of triangles of a quadrilateral have a particle deep within their spheres. Each triangle faces the way
// of its corners.
class LoopCloser {
 public:
  LoopCloser(const Points& positions, const Points& normals, double max_edge, const AreApart& apart)
      : positions_(positions), normals_(normals), max_edge_(max_edge), apart_(apart) {}

  void close(std::vector<WeightedTriangle>& triangles) {
    for (const WeightedTriangle& t : triangles)
      for (int s = 0; s < 3; ++s) edges_.emplace(t.corner[s], t.corner[(s + 1) % 3]);
    std::map<Index, Index> next;  // along the hole, which is to the left
    std::set<Index> pinched;      // more than one loop passes through them
    for (const auto& [from, to] : edges_) {
      if (edges_.count({to, from})) continue;
      if (!next.emplace(to, from).second) pinched.insert(to);
    }
    for (const auto& [first, second] : next) {
      std::vector<Index> loop{first};
      for (Index i = second; i != first && loop.size() <= 4; i = next.at(i)) loop.push_back(i);
      // Each loop once, from its smallest particle on.
      if (loop.size() > 4 || *std::min_element(loop.begin(), loop.end()) != first) continue;
      if (std::any_of(loop.begin(), loop.end(), [&](Index i) { return pinched.count(i) > 0; })) continue;
      if (loop.size() == 3) {
        if (agreement(loop[0], loop[1], loop[2]) > 0.0) add(loop[0], loop[1], loop[2], triangles);
      } else if (loop.size() == 4) {
        const Index a = loop[0], b = loop[1], c = loop[2], d = loop[3];
        if (apart_ && (apart_(a, c) || apart_(b, d))) continue;  // a cut between two of its particles
        const double one = mayJoin(a, c) ? std::min(agreement(a, b, c), agreement(a, c, d)) : -1.0;
        const double other = mayJoin(b, d) ? std::min(agreement(a, b, d), agreement(b, c, d)) : -1.0;
        if (!(std::max(one, other) > 0.0)) continue;
        add(a, b, one >= other ? c : d, triangles);
        one >= other ? add(a, c, d, triangles) : add(b, c, d, triangles);
      }
    }
  }

 private:
  bool mayJoin(Index i, Index j) const {
    return !edges_.count({i, j}) && !edges_.count({j, i}) &&
           (positions_[j] - positions_[i]).norm() <= kLongestDiagonal * max_edge_;
  }
  // The least cosine between the triangle's normal and those of its corners.
  double agreement(Index a, Index b, Index c) const {
    if (apart_ && (apart_(a, b) || apart_(b, c) || apart_(c, a))) return -1.0;
    const Vec3 normal = (positions_[b] - positions_[a]).cross(positions_[c] - positions_[a]).normalized();
    return std::min({normal.dot(normals_[a]), normal.dot(normals_[b]), normal.dot(normals_[c])});
  }
  void add(Index a, Index b, Index c, std::vector<WeightedTriangle>& triangles) {
    for (const auto& edge : {std::pair(a, b), std::pair(b, c), std::pair(c, a)}) edges_.insert(edge);
    while (a > b || a > c) std::tie(a, b, c) = std::tuple(b, c, a);
    triangles.push_back({{a, b, c}, 1.0});
  }

  const Points& positions_;
  const Points& normals_;
  const double max_edge_;
  const AreApart& apart_;
  std::set<std::pair<Index, Index>> edges_;
};

void check(const Points& positions, const Points& normals, double max_edge) {
  if (positions.size() != normals.size()) {
    throw InputError("found " + std::to_string(positions.size()) + " positions and " + std::to_string(normals.size()) +
                     " normals; accepted: one normal for each particle");
  }
  for (const Points* points : {&positions, &normals}) {
    for (const Vec3& p : *points) {
      if (!p.allFinite()) throw InputError("found a position or a normal that is not finite; accepted: finite numbers");
    }
  }
  if (!(max_edge > 0.0 && std::isfinite(max_edge))) {
    throw InputError("found a longest edge of " + std::to_string(max_edge) + " m; accepted: a length above 0");
  }
}

}  // namespace

std::vector<WeightedTriangle> triangulateParticles(const Points& positions, const Points& normals, double max_edge,
                                                   const AreApart& apart) {
  check(positions, normals, max_edge);
  std::vector<Candidate> candidates = Candidates(positions, normals, max_edge, apart).find();
  std::sort(candidates.begin(), candidates.end());
  Manifold manifold(positions, normals);
  std::vector<WeightedTriangle> triangles;
  for (const Candidate& c : candidates) {
    if (manifold.add(c.corner, c.rank == 2 ? 2 : 0)) triangles.push_back({{c.corner[0], c.corner[1], c.corner[2]}, 1.0});
  }
  LoopCloser(positions, normals, max_edge, apart).close(triangles);
  std::sort(triangles.begin(), triangles.end(), [](const WeightedTriangle& a, const WeightedTriangle& b) {
    return std::lexicographical_compare(a.corner, a.corner + 3, b.corner, b.corner + 3);
  });
  return triangles;
}

std::vector<std::pair<Index, Index>> linkChains(const Points& positions, const Points& normals, double max_edge,
                                                const AreApart& apart) {
  check(positions, normals, max_edge);
  const Index n = static_cast<Index>(positions.size());
  const cloud::KdTree tree(positions);
  std::vector<std::pair<Index, Index>> links;
  std::vector<cloud::Neighbor> near, in_sphere;
  for (Index i = 0; i < n; ++i) {
    tree.withinRadius(positions[i], max_edge, near);
    std::sort(near.begin(), near.end(), [](const cloud::Neighbor& a, const cloud::Neighbor& b) { return a.index < b.index; });
    for (const cloud::Neighbor& q : near) {
      const Index j = q.index;
      if (j <= i || !(normals[i].dot(normals[j]) > 0.0) || (apart && apart(i, j))) continue;
      if (!cloud::isFlat(positions[j] - positions[i], normals[i], normals[j])) continue;
      const Sphere sphere{0.5 * (positions[i] + positions[j]), 0.5 * std::sqrt(q.squared_distance)};
      tree.withinRadius(sphere.center, sphere.radius, in_sphere);
      const Index ends[2] = {i, j};
      if (findDepth(positions, normals, normals[i] + normals[j], sphere, in_sphere, ends, apart) < 0.0) links.push_back({i, j});
    }
  }
  return links;
}

}  // namespace deformable_surface::model
