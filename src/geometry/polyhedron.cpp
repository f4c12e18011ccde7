#include "deformable_surface/geometry/polyhedron.h"

#include "deformable_surface/base/error.h"
#include "deformable_surface/base/params.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <string>

namespace deformable_surface::geometry {
namespace {

constexpr Index kLeaf = 4;            // triangles: fewer cost more boxes than they save
constexpr int kMaxDepth = 64;         // of the tree, which is halved on every level
constexpr double kFlat = 1e-10;       // height over longest edge of a triangle whose normal would be rounding
constexpr double kOnSurface = 1e-12;  // of the extent: rounding of the nearest point
// Points of the axis.
constexpr double kLonger = 1.1;  // length over width: corners of a ball of triangles make it a little longer than wide
constexpr double kFirstWay = 1.0 / (1 << 20);  // of the extent, inwards: shorter than walls are thick
constexpr int kWays = 32;                      // places on the way inwards

double squaredDistanceToBox(const Vec3& low, const Vec3& high, const Vec3& p) {
  return (low - p).cwiseMax(p - high).cwiseMax(0.0).squaredNorm();
}

struct Edge {
  Index from, to;
  Index triangle;
  int corner;
};

bool isBefore(const Edge& a, const Edge& b) { return a.from != b.from ? a.from < b.from : a.to < b.to; }

}  // namespace

Polyhedron::Polyhedron(const Points& vertices, const std::vector<Triangle>& triangles) {
  mergeVertices(vertices, triangles);
  Vec3 low = vertices_.front(), high = low;
  for (const Vec3& v : vertices_) {
    low = low.cwiseMin(v);
    high = high.cwiseMax(v);
  }
  on_surface_ = kOnSurface * (high - low).norm();
  orient();

  Points centers;
  for (const Triangle& t : triangles_) centers.push_back((vertices_[t[0]] + vertices_[t[1]] + vertices_[t[2]]) / 3.0);
  std::vector<Index> order(triangles_.size());
  std::iota(order.begin(), order.end(), 0);
  buildNode(order, 0, static_cast<Index>(order.size()), centers);
  std::vector<Triangle> sorted;
  for (Index t : order) sorted.push_back(triangles_[t]);
  triangles_ = std::move(sorted);
  findNormals();
  findAxisPoints();
}

void Polyhedron::mergeVertices(const Points& vertices, const std::vector<Triangle>& triangles) {
  if (triangles.size() < 4 || static_cast<Index>(triangles.size()) > kMaxTriangles)
    throw InputError("found " + std::to_string(triangles.size()) + " triangles; accepted: 4 to " + std::to_string(kMaxTriangles));
  for (std::size_t v = 0; v < vertices.size(); ++v)
    if (!(vertices[v].array().abs() <= kMaxLength).all())
      throw InputError("vertex " + std::to_string(v) + ": found a coordinate that is not finite or too large; accepted: up to " +
                       formatReal(kMaxLength) + " m");
  std::vector<Index> order(vertices.size()), merged(vertices.size());
  std::iota(order.begin(), order.end(), 0);
  const auto isLess = [&](Index a, Index b) {
    return std::lexicographical_compare(vertices[a].data(), vertices[a].data() + 3, vertices[b].data(), vertices[b].data() + 3);
  };
  std::stable_sort(order.begin(), order.end(), isLess);
  for (std::size_t k = 0; k < order.size(); ++k) {
    if (k == 0 || isLess(order[k - 1], order[k])) vertices_.push_back(vertices[order[k]]);
    merged[order[k]] = static_cast<Index>(vertices_.size()) - 1;
  }
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    Triangle corners;
    for (int c = 0; c < 3; ++c) {
      const Index v = triangles[t][c];
      if (!(v >= 0 && v < static_cast<Index>(vertices.size())))
        throw InputError("triangle " + std::to_string(t) + ": found the corner " + std::to_string(v) + " of " +
                         std::to_string(vertices.size()) + " vertices; accepted: 0 to " + std::to_string(vertices.size() - 1));
      corners[c] = merged[v];
    }
    if (corners[0] == corners[1] || corners[1] == corners[2] || corners[2] == corners[0]) continue;
    const Vec3 a = vertices_[corners[1]] - vertices_[corners[0]], b = vertices_[corners[2]] - vertices_[corners[0]];
    if (!(a.cross(b).norm() > kFlat * std::max({a.squaredNorm(), b.squaredNorm(), (b - a).squaredNorm()})))
      throw InputError("triangle " + std::to_string(t) + ": found one without area; accepted: triangles with a normal");
    triangles_.push_back(corners);
  }
  if (triangles_.empty()) throw InputError("found triangles whose corners coincide only; accepted: a closed mesh");
}

// Refuses open surfaces, and flips all triangles if they face inwards.
void Polyhedron::orient() {
  std::vector<Edge> edges;
  for (std::size_t t = 0; t < triangles_.size(); ++t)
    for (int c = 0; c < 3; ++c) edges.push_back({triangles_[t][c], triangles_[t][(c + 1) % 3], static_cast<Index>(t), c});
  std::sort(edges.begin(), edges.end(), isBefore);
  Index open = 0, twice = 0;
  for (std::size_t e = 0; e < edges.size(); ++e) {
    const Edge back{edges[e].to, edges[e].from, 0, 0};
    if (e > 0 && !isBefore(edges[e - 1], edges[e])) ++twice;
    if (!std::binary_search(edges.begin(), edges.end(), back, isBefore)) ++open;
  }
  if (twice > 0)
    throw InputError("found " + std::to_string(twice) +
                     " edges that two triangles pass in the same direction; accepted: meshes whose " +
                     "triangles are all wound alike, two at every edge");
  if (open > 0)
    throw InputError("found an open mesh: " + std::to_string(open) +
                     " edges belong to one triangle only; accepted: closed meshes");

  Vec3 middle = Vec3::Zero();
  for (const Vec3& v : vertices_) middle += v / static_cast<double>(vertices_.size());
  for (const Triangle& t : triangles_)
    volume_ += (vertices_[t[0]] - middle).dot((vertices_[t[1]] - middle).cross(vertices_[t[2]] - middle)) / 6.0;
  if (!(std::abs(volume_) > 0.0)) throw InputError("found a mesh that encloses no volume; accepted: closed meshes around a body");
  if (volume_ > 0.0) return;
  volume_ = -volume_;
  for (Triangle& t : triangles_) std::swap(t[1], t[2]);
}

Vec3 Polyhedron::areaVector(const Triangle& t) const {
  return (vertices_[t[1]] - vertices_[t[0]]).cross(vertices_[t[2]] - vertices_[t[0]]);
}

void Polyhedron::findNormals() {
  vertex_normals_.assign(vertices_.size(), Vec3::Zero());
  std::vector<Edge> edges;
  for (std::size_t t = 0; t < triangles_.size(); ++t) {
    const Triangle& corner = triangles_[t];
    face_normals_.push_back(areaVector(corner).normalized());
    for (int c = 0; c < 3; ++c) {
      const Vec3& at = vertices_[corner[c]];
      const Vec3 a = vertices_[corner[(c + 1) % 3]] - at, b = vertices_[corner[(c + 2) % 3]] - at;
      vertex_normals_[corner[c]] += std::atan2(a.cross(b).norm(), a.dot(b)) * face_normals_[t];
      edges.push_back({corner[c], corner[(c + 1) % 3], static_cast<Index>(t), c});
    }
  }
  std::sort(edges.begin(), edges.end(), isBefore);
  edge_normals_.resize(triangles_.size());
  for (const Edge& edge : edges) {
    const auto other = std::lower_bound(edges.begin(), edges.end(), Edge{edge.to, edge.from, 0, 0}, isBefore);
    edge_normals_[edge.triangle][edge.corner] = face_normals_[edge.triangle] + face_normals_[other->triangle];
  }
}

// Halves the triangles by their centres along the longest side of their box.
Index Polyhedron::buildNode(std::vector<Index>& order, Index begin, Index end, const Points& centers) {
  const Index index = static_cast<Index>(nodes_.size());
  const double infinity = std::numeric_limits<double>::infinity();
  Node node{Vec3::Constant(infinity), Vec3::Constant(-infinity), begin, end - begin};
  for (Index k = begin; k < end; ++k)
    for (Index v : triangles_[order[k]]) {
      node.low = node.low.cwiseMin(vertices_[v]);
      node.high = node.high.cwiseMax(vertices_[v]);
    }
  nodes_.push_back(node);
  if (end - begin <= kLeaf) return index;
  int axis;
  (node.high - node.low).maxCoeff(&axis);
  const Index middle = begin + (end - begin) / 2;
  std::nth_element(order.begin() + begin, order.begin() + middle, order.begin() + end, [&](Index a, Index b) {
    return centers[a][axis] != centers[b][axis] ? centers[a][axis] < centers[b][axis] : a < b;
  });
  buildNode(order, begin, middle, centers);
  nodes_[index].first = buildNode(order, middle, end, centers);
  nodes_[index].count = 0;
  return index;
}

// The nearest point of a triangle by the region that a point lies over [Ericson, Real-Time Collision Detection, sec. 5.1.5].
void Polyhedron::lookAt(Index triangle, const Vec3& p, Nearest& nearest) const {
  const Triangle& t = triangles_[triangle];
  const Vec3 &a = vertices_[t[0]], &b = vertices_[t[1]], &c = vertices_[t[2]];
  const auto offer = [&](const Vec3& point, const Vec3& pseudonormal) {
    const double squared_distance = (p - point).squaredNorm();
    if (squared_distance < nearest.squared_distance) nearest = {squared_distance, point, pseudonormal};
  };
  const Vec3 ab = b - a, ac = c - a, ap = p - a, bp = p - b, cp = p - c;
  const double d1 = ab.dot(ap), d2 = ac.dot(ap), d3 = ab.dot(bp), d4 = ac.dot(bp), d5 = ab.dot(cp), d6 = ac.dot(cp);
  if (d1 <= 0.0 && d2 <= 0.0) return offer(a, vertex_normals_[t[0]]);
  if (d3 >= 0.0 && d4 <= d3) return offer(b, vertex_normals_[t[1]]);
  if (d6 >= 0.0 && d5 <= d6) return offer(c, vertex_normals_[t[2]]);
  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0) return offer(a + d1 / (d1 - d3) * ab, edge_normals_[triangle][0]);
  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0) return offer(a + d2 / (d2 - d6) * ac, edge_normals_[triangle][2]);
  const double va = d3 * d6 - d5 * d4;
  if (va <= 0.0 && d4 >= d3 && d5 >= d6)
    return offer(b + (d4 - d3) / ((d4 - d3) + (d5 - d6)) * (c - b), edge_normals_[triangle][1]);
  const Vec3& normal = face_normals_[triangle];
  offer(p - normal.dot(ap) * normal, normal);
}

Polyhedron::Nearest Polyhedron::findNearest(const Vec3& p) const {
  Nearest nearest{std::numeric_limits<double>::infinity(), Vec3::Zero(), Vec3::UnitZ()};
  struct Waiting {
    Index node;
    double squared_distance;
  } stack[kMaxDepth];
  int size = 0;
  stack[size++] = {0, 0.0};
  while (size > 0) {
    const Waiting top = stack[--size];
    if (!(top.squared_distance < nearest.squared_distance)) continue;
    const Node& node = nodes_[top.node];
    for (Index k = 0; k < node.count; ++k) lookAt(node.first + k, p, nearest);
    if (node.count > 0) continue;
    Waiting left{top.node + 1, squaredDistanceToBox(nodes_[top.node + 1].low, nodes_[top.node + 1].high, p)};
    Waiting right{node.first, squaredDistanceToBox(nodes_[node.first].low, nodes_[node.first].high, p)};
    if (right.squared_distance < left.squared_distance) std::swap(left, right);
    stack[size++] = right;
    stack[size++] = left;
  }
  return nearest;
}

SignedDistance Polyhedron::findSignedDistance(const Vec3& p) const {
  const Nearest nearest = findNearest(p);
  const Vec3 away = p - nearest.point;
  const double distance = std::sqrt(nearest.squared_distance), side = away.dot(nearest.pseudonormal) < 0.0 ? -1.0 : 1.0;
  if (distance > on_surface_) return {side * distance, side / distance * away};
  return {side * distance, nearest.pseudonormal.normalized()};
}

// Of the surface, by its area, in columns.
Mat3 Polyhedron::findPrincipalAxes() const {
  double area = 0.0;
  Vec3 middle = Vec3::Zero();
  for (const Triangle& t : triangles_) {
    const double share = areaVector(t).norm();
    area += share;
    middle += share * (vertices_[t[0]] + vertices_[t[1]] + vertices_[t[2]]) / 3.0;
  }
  middle /= area;
  Mat3 spread = Mat3::Zero();
  const double size = (high() - low()).norm();
  for (const Triangle& t : triangles_) {
    Vec3 sum = Vec3::Zero();
    Mat3 squares = Mat3::Zero();
    for (const Index v : t) {
      const Vec3 x = (vertices_[v] - middle) / size;
      sum += x;
      squares += x * x.transpose();
    }
    spread += areaVector(t).norm() / area * (squares + sum * sum.transpose());
  }
  return Eigen::SelfAdjointEigenSolver<Mat3>(spread).eigenvectors();
}

// The deepest place on the way inwards from the nearest point of the surface, of the part of the body that begins there.
Vec3 Polyhedron::moveInside(const Vec3& place) const {
  const Nearest nearest = findNearest(place);
  const Vec3 inwards = -nearest.pseudonormal.normalized();
  const auto findDepth = [&](const Vec3& p) { return -findSignedDistance(p).distance; };
  const auto goOn = [&](double way) -> Vec3 { return nearest.point + way * inwards; };

  const double size = (high() - low()).norm();
  double way = kFirstWay * size;
  while (way < size && findDepth(goOn(2.0 * way)) > findDepth(goOn(way))) way *= 2.0;
  Vec3 deepest = place;
  double depth = findDepth(place);
  for (int k = 1; k <= kWays; ++k) {
    const Vec3 next = goOn(2.0 * way * k / kWays);
    const double next_depth = findDepth(next);
    if (!(next_depth > depth + on_surface_)) continue;
    depth = next_depth;
    deepest = next;
  }
  return deepest;
}

// In the smaller of the boxes along the frame and along the principal axes: its middle, and half its width from either end.
void Polyhedron::findAxisPoints() {
  const auto findExtents = [&](const Mat3& axes, Vec3& middle) -> Vec3 {
    Vec3 least = axes.transpose() * vertices_.front(), most = least;
    for (const Vec3& v : vertices_) {
      const Vec3 along = axes.transpose() * v;
      least = least.cwiseMin(along);
      most = most.cwiseMax(along);
    }
    middle = axes * (0.5 * (least + most));
    return most - least;
  };
  Mat3 axes = Mat3::Identity();
  Vec3 middle, turned_middle;
  Vec3 extents = findExtents(axes, middle);
  const Mat3 turned_axes = findPrincipalAxes();
  const Vec3 turned_extents = findExtents(turned_axes, turned_middle);
  if (turned_extents.prod() < extents.prod()) {
    axes = turned_axes;
    middle = turned_middle;
    extents = turned_extents;
  }
  Index longest;
  const double length = extents.maxCoeff(&longest);
  std::sort(extents.data(), extents.data() + 3);
  const double width = extents[1];
  axis_points_ = {moveInside(middle)};
  if (!(length > kLonger * width)) return;
  const Vec3 end = 0.5 * (length - width) * axes.col(longest);
  axis_points_.push_back(moveInside(middle + end));
  axis_points_.push_back(moveInside(middle - end));
}

double Polyhedron::boundDistance(const Vec3& point) const { return std::sqrt(squaredDistanceToBox(low(), high(), point)); }

}  // namespace deformable_surface::geometry
