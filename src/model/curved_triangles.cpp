#include "deformable_surface/model/curved_triangles.h"

#include "deformable_surface/base/error.h"

#include <algorithm>
#include <map>
#include <string>
#include <utility>

namespace deformable_surface::model {
namespace {

struct End {
  Vec3 p, n;
  double value;
};

// The control point of an edge that is nearer to a: a third of the way to b, in the tangent plane of a.
Vec3 leave(const End& a, const End& b) { return (2.0 * a.p + b.p - (b.p - a.p).dot(a.n) * a.n) / 3.0; }

// The normal in the middle of an edge: the mean, mirrored at the plane across the edge. An edge without length has the mean.
Vec3 findMiddleNormal(const End& a, const End& b) {
  const Vec3 along = b.p - a.p, sum = a.n + b.n;
  const double squared = along.squaredNorm();
  const Vec3 middle = squared > 0.0 ? Vec3(sum - 2.0 * along.dot(sum) / squared * along) : sum;
  return middle.norm() > 0.0 ? Vec3(middle.normalized()) : a.n;
}

// [Vlachos 2001], but for the factor 2 of the mixed terms of the normal, as Bernstein polynomials have it. Without it normals
// differ from those of a sphere by the first order of the edge. c: the corners; u: their weights, which sum to one.
End evaluate(const End (&c)[3], const Vec3& u) {
  Vec3 cubic = Vec3::Zero(), edges = Vec3::Zero(), corners = Vec3::Zero(), normal = Vec3::Zero();
  double value = 0.0;
  for (int i = 0; i < 3; ++i) {
    const int j = (i + 1) % 3;
    const Vec3 from_i = leave(c[i], c[j]), from_j = leave(c[j], c[i]);
    cubic += u[i] * u[i] * u[i] * c[i].p + 3.0 * u[i] * u[j] * (u[i] * from_i + u[j] * from_j);
    edges += (from_i + from_j) / 6.0;
    corners += c[i].p / 3.0;
    value += u[i] * c[i].value;
    normal += u[i] * u[i] * c[i].n + 2.0 * u[i] * u[j] * findMiddleNormal(c[i], c[j]);
  }
  const Vec3 center = edges + 0.5 * (edges - corners);
  const double length = normal.norm();
  return {cubic + 6.0 * u[0] * u[1] * u[2] * center, length > 0.0 ? Vec3(normal / length) : c[0].n, value};
}

}  // namespace

CurvedTriangles curveTriangles(const Points& positions, const Points& normals, const std::vector<WeightedTriangle>& triangles,
                               Index pieces, const std::vector<double>& values) {
  if (pieces < 1) throw InputError("pieces: found " + std::to_string(pieces) + "; accepted: at least 1");
  if (normals.size() != positions.size())
    throw InputError("normals: found " + std::to_string(normals.size()) + "; accepted: " + std::to_string(positions.size()) +
                     ", one per position");
  if (!values.empty() && values.size() != positions.size())
    throw InputError("values: found " + std::to_string(values.size()) + "; accepted: none, or " +
                     std::to_string(positions.size()) + ", one per position");
  CurvedTriangles curved{positions, normals, {}, values};
  const auto add = [&](const End& end) {
    curved.positions.push_back(end.p);
    curved.normals.push_back(end.n);
    if (!values.empty()) curved.values.push_back(end.value);
    return static_cast<Index>(curved.positions.size()) - 1;
  };
  std::map<std::pair<Index, Index>, Index> first_of_edge;  // (smaller corner, larger): the point next to the smaller one
  for (const WeightedTriangle& t : triangles) {
    const auto& corner = t.corner;
    const auto endOf = [&](Index i) { return End{positions[i], normals[i], values.empty() ? 0.0 : values[i]}; };
    const End ends[3] = {endOf(corner[0]), endOf(corner[1]), endOf(corner[2])};
    // The point with these shares of the corners, in pieces.
    const auto find = [&](Index a, Index b) {
      const Index share[3] = {a, b, pieces - a - b};
      for (int i = 0; i < 3; ++i) {
        if (share[i] == pieces) return corner[i];
        if (share[i] > 0) continue;
        const auto [low, high] = std::minmax({(i + 1) % 3, (i + 2) % 3}, [&](int j, int k) { return corner[j] < corner[k]; });
        if (share[low] == 0 || share[high] == 0) continue;  // a corner
        const auto [place, is_new] = first_of_edge.try_emplace({corner[low], corner[high]}, 0);
        if (is_new) {
          place->second = static_cast<Index>(curved.positions.size());
          const End edge[3] = {endOf(corner[low]), endOf(corner[high]), endOf(corner[low])};
          for (Index k = 1; k < pieces; ++k) {
            const double w = static_cast<double>(k) / static_cast<double>(pieces);
            add(evaluate(edge, Vec3(1.0 - w, w, 0.0)));
          }
        }
        return place->second + share[high] - 1;
      }
      return add(evaluate(ends, Vec3(share[0], share[1], share[2]) / static_cast<double>(pieces)));
    };
    std::vector<Index> row, next;  // of equal shares of the first corner
    for (Index b = 0; b <= pieces; ++b) row.push_back(find(0, b));
    for (Index a = 1; a <= pieces; ++a, row = next) {
      next.clear();
      for (Index b = 0; b <= pieces - a; ++b) next.push_back(find(a, b));
      // Corners in the order of the triangle's.
      for (Index b = 0; b <= pieces - a; ++b) {
        curved.triangles.push_back({{next[b], row[b + 1], row[b]}, t.weight});
        if (b < pieces - a) curved.triangles.push_back({{next[b], next[b + 1], row[b + 1]}, t.weight});
      }
    }
  }
  return curved;
}

}  // namespace deformable_surface::model
