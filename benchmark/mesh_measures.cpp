#include "mesh_measures.h"

#include "deformable_surface/cloud/kd_tree.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <map>
#include <numeric>
#include <sstream>
#include <utility>

namespace deformable_surface::benchmark {
namespace {

constexpr Index kProbes = 10000;  // of the true surface

class Sets {
 public:
  explicit Sets(std::size_t n) : parent_(n) { std::iota(parent_.begin(), parent_.end(), 0); }
  Index find(Index i) {
    while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
    return i;
  }
  void join(Index i, Index j) { parent_[find(i)] = find(j); }

 private:
  std::vector<Index> parent_;
};

// The point of a triangle nearest to p, by its Voronoi regions [Ericson 2005, sec. 5.1.5].
Vec3 findNearest(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c) {
  const Vec3 ab = b - a, ac = c - a, ap = p - a, bp = p - b, cp = p - c;
  const double d1 = ab.dot(ap), d2 = ac.dot(ap), d3 = ab.dot(bp), d4 = ac.dot(bp), d5 = ab.dot(cp), d6 = ac.dot(cp);
  if (d1 <= 0.0 && d2 <= 0.0) return a;
  if (d3 >= 0.0 && d4 <= d3) return b;
  if (d6 >= 0.0 && d5 <= d6) return c;
  const double vc = d1 * d4 - d3 * d2, vb = d5 * d2 - d1 * d6, va = d3 * d6 - d5 * d4;
  if (vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0) return a + d1 / (d1 - d3) * ab;
  if (vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0) return a + d2 / (d2 - d6) * ac;
  if (va <= 0.0 && d4 - d3 >= 0.0 && d5 - d6 >= 0.0) return b + (d4 - d3) / (d4 - d3 + d5 - d6) * (c - b);
  const double sum = va + vb + vc;
  return a + vb / sum * ab + vc / sum * ac;
}

// Points of the triangles no farther apart than some distance, each with its triangle and its share of the area.
struct Spread {
  Points points;
  std::vector<Index> triangle;
  std::vector<double> area;
};
Spread spreadOver(const TriangleMesh& mesh, double apart) {
  Spread spread;
  for (std::size_t k = 0; k < mesh.triangles.size(); ++k) {
    const auto& t = mesh.triangles[k];
    const Vec3 &a = mesh.vertices[t[0]], &b = mesh.vertices[t[1]], &c = mesh.vertices[t[2]];
    const double longest = std::max({(b - a).norm(), (c - b).norm(), (a - c).norm()});
    constexpr Index kMostParts = 40;
    const Index parts = std::clamp<Index>(static_cast<Index>(std::ceil(longest / apart)), 1, kMostParts);
    const double area = 0.5 * (b - a).cross(c - a).norm() / (parts * parts);
    for (Index i = 0; i < parts; ++i) {
      for (Index j = 0; j < 2 * (parts - i) - 1; ++j) {  // small triangles of a row, every second one upside down
        const double u = (i + (j % 2 == 0 ? 1.0 : 2.0) / 3.0) / parts, v = (j / 2 + (j % 2 == 0 ? 1.0 : 2.0) / 3.0) / parts;
        spread.points.push_back(a + u * (b - a) + v * (c - a));
        spread.triangle.push_back(static_cast<Index>(k));
        spread.area.push_back(area);
      }
    }
  }
  return spread;
}

Points findVertexNormals(const TriangleMesh& mesh) {
  if (!mesh.normals.empty()) return mesh.normals;
  Points normals(mesh.vertices.size(), Vec3::Zero());
  for (const auto& t : mesh.triangles) {
    const Vec3 area = (mesh.vertices[t[1]] - mesh.vertices[t[0]]).cross(mesh.vertices[t[2]] - mesh.vertices[t[0]]);
    for (const Index i : t) normals[i] += area;
  }
  for (Vec3& n : normals) n.normalize();
  return normals;
}

}  // namespace

TriangleMesh readTriangles(const std::string& name) {
  TriangleMesh mesh;
  std::ifstream file(name);
  if (!file) return mesh;
  const auto addFan = [&](const std::vector<Index>& corners) {
    for (std::size_t k = 2; k < corners.size(); ++k) mesh.triangles.push_back({corners[0], corners[k - 1], corners[k]});
  };
  if (name.size() > 4 && name.substr(name.size() - 4) == ".off") {
    std::string word;
    Index vertices = 0, faces = 0, edges = 0;
    file >> word >> vertices >> faces >> edges;
    mesh.vertices.resize(vertices);
    for (Vec3& v : mesh.vertices) file >> v.x() >> v.y() >> v.z();
    for (Index f = 0; f < faces; ++f) {
      std::size_t count = 0;
      file >> count;
      std::vector<Index> corners(file ? count : 0);
      for (Index& c : corners) file >> c;
      addFan(corners);
    }
    return mesh;
  }
  for (std::string line; std::getline(file, line);) {
    std::istringstream words(line);
    std::string kind;
    words >> kind;
    if (kind == "v") {
      Vec3 v;
      words >> v.x() >> v.y() >> v.z();
      mesh.vertices.push_back(v);
    } else if (kind == "f") {
      std::vector<Index> corners;
      for (std::string corner; words >> corner;) corners.push_back(static_cast<Index>(std::stol(corner)) - 1);
      addFan(corners);
    }
  }
  return mesh;
}

MeshCount countKind(const TriangleMesh& mesh) {
  MeshCount count;
  const std::size_t n = mesh.vertices.size();
  Sets pieces(n);
  std::vector<char> is_used(n, 0);
  struct Edge {
    int forward = 0, backward = 0;
  };
  std::map<std::pair<Index, Index>, Edge> edges;
  std::vector<std::vector<std::pair<Index, Index>>> around(n);  // the opposite edge of each triangle at a vertex
  for (const auto& t : mesh.triangles) {
    for (int s = 0; s < 3; ++s) {
      const Index a = t[s], b = t[(s + 1) % 3];
      is_used[a] = 1;
      pieces.join(a, b);
      Edge& edge = edges[{std::min(a, b), std::max(a, b)}];
      ++(a < b ? edge.forward : edge.backward);
      around[a].emplace_back(b, t[(s + 2) % 3]);
    }
  }
  Index used = 0;
  count.kind.pieces = 0;
  for (std::size_t i = 0; i < n; ++i) {
    used += is_used[i];
    count.unused += !is_used[i];
    count.kind.pieces += is_used[i] && pieces.find(static_cast<Index>(i)) == static_cast<Index>(i);
  }
  count.kind.euler_characteristic = used - static_cast<Index>(edges.size()) + static_cast<Index>(mesh.triangles.size());

  // Fans of each vertex; ends of a fan are ends of the boundary's edges there. Each end is joined to the other end of its fan and
  // to the end at the other vertex of its edge: loops are the sets.
  std::map<std::pair<Index, Index>, Index> ends;  // (vertex, edge's other vertex)
  for (const auto& [edge, uses] : edges) {
    count.crooked += uses.forward + uses.backward > 2;
    if (uses.forward + uses.backward != 1) continue;
    ends.emplace(edge, static_cast<Index>(ends.size()));
    ends.emplace(std::pair(edge.second, edge.first), static_cast<Index>(ends.size()));
  }
  Sets loops(ends.size());
  for (const auto& [end, index] : ends) loops.join(index, ends.at({end.second, end.first}));
  for (std::size_t i = 0; i < n; ++i) {
    std::map<Index, Index> number;  // of the neighbours
    for (const auto& [a, b] : around[i]) {
      number.emplace(a, static_cast<Index>(number.size()));
      number.emplace(b, static_cast<Index>(number.size()));
    }
    Sets fans(number.size());
    for (const auto& [a, b] : around[i]) fans.join(number.at(a), number.at(b));
    Index num_fans = 0;
    for (std::size_t k = 0; k < number.size(); ++k) num_fans += fans.find(static_cast<Index>(k)) == static_cast<Index>(k);
    count.pinched += num_fans > 1;
    std::map<Index, Index> first_end;  // of a fan
    for (const auto& [neighbor, k] : number) {
      const auto end = ends.find({static_cast<Index>(i), neighbor});
      if (end == ends.end()) continue;
      const auto [other, is_new] = first_end.emplace(fans.find(k), end->second);
      if (!is_new) loops.join(other->second, end->second);
    }
  }
  count.kind.loops = 0;
  for (std::size_t k = 0; k < ends.size(); ++k) count.kind.loops += loops.find(static_cast<Index>(k)) == static_cast<Index>(k);
  return count;
}

MeshDistance measureDistance(const TriangleMesh& mesh, const GrowthShape& shape) {
  MeshDistance result;
  if (mesh.triangles.empty()) {
    result.to_surface = result.from_surface = result.farthest = HUGE_VAL;
    return result;
  }
  const Points &truth = shape.surface.positions, &true_normals = shape.surface.normals;
  const double dense = std::sqrt(shape.area / static_cast<double>(truth.size()));
  const cloud::KdTree true_tree(truth);
  std::vector<cloud::Neighbor> near;
  const auto findDistance = [&](const Vec3& p) {
    true_tree.nearest(p, 1, near);
    const Index i = near[0].index;
    const Vec3 line = p - truth[i];
    const double height = line.dot(true_normals[i]), aside = (line - height * true_normals[i]).norm();
    // Off the edge of the surface, or of a face, the nearest point is farther aside than others of the same face can be.
    return std::hypot(height, std::max(0.0, aside - dense));
  };

  const Spread spread = spreadOver(mesh, 2.0 * dense);
  const Points normals = findVertexNormals(mesh);
  double squares = 0.0, area = 0.0, angles = 0.0, positive = 0.0;
  for (std::size_t k = 0; k < spread.points.size(); ++k) {
    const double distance = findDistance(spread.points[k]);
    result.farthest = std::max(result.farthest, distance);
    squares += spread.area[k] * distance * distance;
    area += spread.area[k];
    const Vec3& true_normal = true_normals[near[0].index];
    const auto& t = mesh.triangles[spread.triangle[k]];
    for (const Index i : t) {
      true_tree.nearest(mesh.vertices[i], 1, near);
      const double cosine = normals[i].dot(true_normals[near[0].index]);
      const double angle = std::acos(std::clamp(std::abs(cosine), 0.0, 1.0));
      angles += spread.area[k] / 3.0 * angle * angle;
    }
    const Vec3 face = (mesh.vertices[t[1]] - mesh.vertices[t[0]]).cross(mesh.vertices[t[2]] - mesh.vertices[t[0]]);
    positive += spread.area[k] * (face.dot(true_normal) > 0.0);
  }
  result.to_surface = std::sqrt(squares / area);
  result.normal_angle = std::sqrt(angles / area);
  result.turned = std::min(positive, area - positive) / area;

  const cloud::KdTree tree(spread.points);
  constexpr Index kLooked = 8;  // nearest places whose triangles may hold the nearest point
  const Index step = std::max<Index>(1, static_cast<Index>(truth.size()) / kProbes);
  squares = 0.0;
  Index count = 0;
  for (std::size_t i = 0; i < truth.size(); i += step, ++count) {
    tree.nearest(truth[i], kLooked, near);
    double least = HUGE_VAL;
    for (const cloud::Neighbor& q : near) {
      const auto& t = mesh.triangles[spread.triangle[q.index]];
      const Vec3 place = findNearest(truth[i], mesh.vertices[t[0]], mesh.vertices[t[1]], mesh.vertices[t[2]]);
      least = std::min(least, (truth[i] - place).norm());
    }
    squares += least * least;
    result.farthest = std::max(result.farthest, least);
  }
  result.from_surface = std::sqrt(squares / count);
  return result;
}

}  // namespace deformable_surface::benchmark
