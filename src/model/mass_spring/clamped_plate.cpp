#include "clamped_plate.h"

#include <algorithm>
#include <cmath>

namespace deformable_surface::model {
namespace {

constexpr double kClose = 0.5;  // fraction of the spacing: nearer points on an edge are merged
// Least height of a triangle of held points over its longest side, for near points and for any, for it to support a point beside
// it.
constexpr double kFat = 0.2, kThin = 0.02;
// Cosine between the normals of a triangle and of the surface: those across a sharp crease can stand upright on the surface and
// tell no slope.
constexpr double kUpright = 0.3;
constexpr std::size_t kNear = 12, kMost = 200;  // number of held points that are searched, first and then

bool holds(const std::vector<Index>& list, Index i) { return std::find(list.begin(), list.end(), i) != list.end(); }

double measureSpacing(Index i, const PlateRest& plate) {
  double sum = 0.0;
  for (const Index* j = plate.ring.begin(i); j != plate.ring.end(i); ++j) sum += (plate.points[*j] - plate.points[i]).norm();
  return sum / std::max(Index{1}, plate.ring.count(i));
}

struct Patches {
  const std::vector<char>& of;  // (n)
  const std::vector<char>& is_inner;
};

// i and the nearest points of its patch, at most most of them, by rings.
std::vector<Index> findPatch(Index i, const PlateRest& plate, const Patches& patches, std::size_t most) {
  std::vector<Index> patch{i};
  for (std::size_t next = 0; next < patch.size(); ++next)
    for (const Index* j = plate.ring.begin(patch[next]); j != plate.ring.end(patch[next]) && patch.size() < most; ++j)
      if (patches.is_inner[*j] && patches.of[*j] == patches.of[i] && !holds(patch, *j)) patch.push_back(*j);
  return patch;
}

// The triangle of i and two others of a patch with the best shape for its size. Returns its height over its longest side. normal:
// of the surface at i.
double chooseTriangle(const std::vector<Index>& patch, const Points& x, const Vec3& normal, Index (&corners)[3]) {
  double best = 0.0, best_shape = 0.0;
  const Vec3& origin = x[patch[0]];
  for (std::size_t a = 1; a < patch.size(); ++a)
    for (std::size_t b = a + 1; b < patch.size(); ++b) {
      const Vec3 u = x[patch[a]] - origin, v = x[patch[b]] - origin;
      const double longest = std::max({u.squaredNorm(), v.squaredNorm(), (u - v).squaredNorm()});
      const Vec3 cross = u.cross(v);
      const double shape = cross.norm() / longest, value = shape / std::sqrt(longest);
      if (!(shape >= kThin) || !(value > best) || std::abs(cross.dot(normal)) < kUpright * cross.norm()) continue;
      best = value;
      best_shape = shape;
      corners[0] = patch[0];
      corners[1] = patch[a];
      corners[2] = patch[b];
    }
  return best_shape;
}

// Finds the support of the place of an edge near i; false: i and the points held with it are collinear.
bool carry(Index i, const Vec3& place, const PlateRest& plate, const Patches& patches, EdgePoint& edge) {
  const Points& x = plate.points;
  double shape = chooseTriangle(findPatch(i, plate, patches, kNear), x, plate.normals[i], edge.points);
  if (!(shape >= kFat)) shape = chooseTriangle(findPatch(i, plate, patches, kMost), x, plate.normals[i], edge.points);
  if (!(shape >= kThin)) return false;
  const Vec3 u = x[edge.points[1]] - x[i], v = x[edge.points[2]] - x[i];
  const Vec3 normal = u.cross(v);
  const double squares = normal.squaredNorm();
  edge.gradients[1] = v.cross(normal) / squares;
  edge.gradients[2] = normal.cross(u) / squares;
  edge.gradients[0] = -edge.gradients[1] - edge.gradients[2];
  for (int c = 0; c < 3; ++c) edge.weights[c] = (c == 0 ? 1.0 : 0.0) + edge.gradients[c].dot(place - x[i]);
  return true;
}

}  // namespace

ClampedPlate clampPlate(const PlateRest& plate, const std::vector<char>& held, const std::vector<ClampEdge>& edges) {
  const Index n = static_cast<Index>(plate.points.size());
  ClampedPlate clamped{plate, n, {}, std::vector<char>(n, 0), 0};
  if (std::all_of(held.begin(), held.end(), [](char patch) { return patch == 0; })) return clamped;
  const auto isBesideFree = [&](Index i) {
    return std::any_of(plate.ring.begin(i), plate.ring.end(i), [&](Index j) { return !held[j]; });
  };
  for (Index i = 0; i < n; ++i) clamped.is_inner[i] = held[i] && plate.ring.count(i) > 0 && !isBesideFree(i);
  for (const ClampEdge& edge : edges) clamped.is_inner[edge.point] = held[edge.point] != 0;

  // Points on the edge: each held point beside free ones is moved there, or an existing edge point replaces it.
  std::vector<Index> moved(n, -1);  // new place of a held point
  for (Index i = 0; i < n; ++i)
    if (!clamped.is_inner[i]) moved[i] = i;
  for (const ClampEdge& edge : edges) {
    if (!held[edge.point] || !isBesideFree(edge.point)) continue;
    EdgePoint point;
    if (!carry(edge.point, edge.place, plate, {held, clamped.is_inner}, point)) {
      ++clamped.num_hinged;
      continue;
    }
    const double close = kClose * measureSpacing(edge.point, plate);
    Index same = -1;
    for (Index e = n; e < static_cast<Index>(clamped.plate.points.size()); ++e)
      if ((clamped.plate.points[e] - edge.place).norm() < close && held[clamped.edge_points[e - n].points[0]] == held[edge.point])
        same = e;
    if (same < 0) {
      same = static_cast<Index>(clamped.plate.points.size());
      Vec3 place = Vec3::Zero();
      for (int c = 0; c < 3; ++c) place += point.weights[c] * plate.points[point.points[c]];
      clamped.plate.points.push_back(place);
      clamped.plate.normals.push_back(plate.normals[edge.point]);
      if (!plate.shares.empty()) clamped.plate.shares.push_back(plate.shares[edge.point]);
      clamped.edge_points.push_back(point);
    }
    moved[edge.point] = same;
  }
  // Held points beside free ones without an edge point are hinges.
  for (Index i = 0; i < n; ++i) {
    if (moved[i] >= 0 || !isBesideFree(i)) continue;
    clamped.is_inner[i] = 0;
    moved[i] = i;
  }

  const Index size = static_cast<Index>(clamped.plate.points.size());
  std::vector<std::vector<Index>> rings(size);
  for (Index i = 0; i < n; ++i) {
    if (moved[i] < 0) continue;
    std::vector<Index>& ring = rings[moved[i]];
    for (const Index* j = plate.ring.begin(i); j != plate.ring.end(i); ++j)
      if (moved[*j] >= 0 && moved[*j] != moved[i] && !holds(ring, moved[*j])) ring.push_back(moved[*j]);
  }
  clamped.plate.ring = Lists{};
  for (const std::vector<Index>& ring : rings) {
    clamped.plate.ring.items.insert(clamped.plate.ring.items.end(), ring.begin(), ring.end());
    clamped.plate.ring.offsets.push_back(static_cast<Index>(clamped.plate.ring.items.size()));
  }
  clamped.plate.triangles.clear();
  for (WeightedTriangle t : plate.triangles) {
    for (Index& corner : t.corner) corner = moved[corner];
    const auto& [a, b, c] = t.corner;
    if (a < 0 || b < 0 || c < 0 || a == b || b == c || c == a) continue;
    if (clamped.isEdge(a) && clamped.isEdge(b) && clamped.isEdge(c)) continue;
    clamped.plate.triangles.push_back(t);
  }
  return clamped;
}

}  // namespace deformable_surface::model
