// Closed meshes for the tests of tools.
#pragma once

#include "deformable_surface/geometry/polyhedron.h"

#include <cmath>
#include <map>

namespace deformable_surface::test {

struct Mesh {
  Points vertices;
  std::vector<geometry::Polyhedron::Triangle> triangles;
};

/// A box of these edges (m) about the origin.
inline Mesh makeBoxMesh(const Vec3& size) {
  Mesh mesh;
  for (int v = 0; v < 8; ++v)
    mesh.vertices.push_back(0.5 * size.cwiseProduct(Vec3(v & 1 ? 1.0 : -1.0, v & 2 ? 1.0 : -1.0, v & 4 ? 1.0 : -1.0)));
  mesh.triangles = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                    {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
  return mesh;
}

/// An icosahedron whose triangles were quartered this number of times, with its corners on a sphere.
inline Mesh makeSphereMesh(double radius, int quarterings) {
  Mesh mesh;
  const double g = 0.5 * (1.0 + std::sqrt(5.0));
  mesh.vertices = {{-1, g, 0},  {1, g, 0},  {-1, -g, 0}, {1, -g, 0}, {0, -1, g},  {0, 1, g},
                   {0, -1, -g}, {0, 1, -g}, {g, 0, -1},  {g, 0, 1},  {-g, 0, -1}, {-g, 0, 1}};
  mesh.triangles = {{0, 11, 5},  {0, 5, 1},  {0, 1, 7},  {0, 7, 10}, {0, 10, 11}, {1, 5, 9}, {5, 11, 4},
                    {11, 10, 2}, {10, 7, 6}, {7, 1, 8},  {3, 9, 4},  {3, 4, 2},   {3, 2, 6}, {3, 6, 8},
                    {3, 8, 9},   {4, 9, 5},  {2, 4, 11}, {6, 2, 10}, {8, 6, 7},   {9, 8, 1}};
  for (int q = 0; q < quarterings; ++q) {
    std::map<std::pair<Index, Index>, Index> middles;
    const auto middle = [&](Index a, Index b) {
      const auto [found, is_new] = middles.insert({std::minmax(a, b), static_cast<Index>(mesh.vertices.size())});
      if (is_new) mesh.vertices.push_back(mesh.vertices[a].normalized() + mesh.vertices[b].normalized());
      return found->second;
    };
    std::vector<geometry::Polyhedron::Triangle> finer;
    for (const auto& t : mesh.triangles) {
      const Index ab = middle(t[0], t[1]), bc = middle(t[1], t[2]), ca = middle(t[2], t[0]);
      finer.insert(finer.end(), {{t[0], ab, ca}, {t[1], bc, ab}, {t[2], ca, bc}, {ab, bc, ca}});
    }
    mesh.triangles = std::move(finer);
  }
  for (Vec3& v : mesh.vertices) v *= radius / v.norm();
  return mesh;
}

/// A box with a wedge cut out of its upper side, down to the middle: concave edges and corners.
inline Mesh makeNotchedMesh() {
  const double profile[7][2] = {{-1, -1}, {1, -1}, {1, 1}, {0.5, 1}, {0, 0}, {-0.5, 1}, {-1, 1}};
  Mesh mesh;
  for (double y : {-1.0, 1.0})
    for (const auto& p : profile) mesh.vertices.emplace_back(p[0], y, p[1]);
  const Index lids[5][3] = {{0, 1, 4}, {1, 2, 4}, {2, 3, 4}, {0, 4, 6}, {4, 5, 6}};
  for (const auto& t : lids) {
    mesh.triangles.push_back({t[0], t[1], t[2]});
    mesh.triangles.push_back({t[0] + 7, t[2] + 7, t[1] + 7});
  }
  for (Index k = 0; k < 7; ++k) {
    const Index next = (k + 1) % 7;
    mesh.triangles.push_back({k, k + 7, next});
    mesh.triangles.push_back({next, k + 7, next + 7});
  }
  return mesh;
}

/// What is between two such profiles (m, counter-clockwise, filled by the triangles of the lid) at half a height above and below.
inline Mesh makePrismMesh(const std::vector<Vec2>& profile, const std::vector<geometry::Polyhedron::Triangle>& lid,
                          double height) {
  Mesh mesh;
  for (double z : {-0.5 * height, 0.5 * height})
    for (const Vec2& p : profile) mesh.vertices.emplace_back(p.x(), p.y(), z);
  const Index n = static_cast<Index>(profile.size());
  for (const auto& t : lid) {
    mesh.triangles.push_back({t[0], t[2], t[1]});
    mesh.triangles.push_back({t[0] + n, t[1] + n, t[2] + n});
  }
  for (Index k = 0; k < n; ++k) {
    const Index next = (k + 1) % n;
    mesh.triangles.push_back({k, next, k + n});
    mesh.triangles.push_back({next, next + n, k + n});
  }
  return mesh;
}

inline Mesh makeCylinderMesh(double radius, double height, int corners) {
  std::vector<Vec2> profile;
  for (int k = 0; k < corners; ++k)
    profile.emplace_back(radius * std::cos(2.0 * M_PI * k / corners), radius * std::sin(2.0 * M_PI * k / corners));
  std::vector<geometry::Polyhedron::Triangle> lid;
  for (Index k = 2; k < corners; ++k) lid.push_back({0, k - 1, k});
  return makePrismMesh(profile, lid, height);
}

/// Two arms and what joins them, all of this thickness, m. The origin is between the arms.
inline Mesh makeForkMesh(double width, double length, double thickness) {
  const double x = 0.5 * width, y = 0.5 * length, inner = x - thickness;
  return makePrismMesh(
      {{-x, -y}, {x, -y}, {x, y}, {inner, y}, {inner, thickness - y}, {-inner, thickness - y}, {-inner, y}, {-x, y}},
      {{0, 1, 4}, {0, 4, 5}, {1, 2, 3}, {1, 3, 4}, {0, 5, 6}, {0, 6, 7}}, thickness);
}

}  // namespace deformable_surface::test
