// A closed polyhedron as a solid. It is built once, can be refused, and finds its nearest triangle in a tree of
// boxes.
#pragma once

#include "deformable_surface/geometry/signed_distance.h"

#include <array>
#include <vector>

namespace deformable_surface::geometry {

class Polyhedron {
 public:
  using Triangle = std::array<Index, 3>;
  // More than any tool needs. A scan given by mistake in place of a tool may have more.
  static constexpr Index kMaxTriangles = 1000000;

  /// vertices (n x 3) m, in the solid's frame; triangles by their corners, counted from 0. Vertices at the same place are merged,
  /// and triangles that then have fewer than three corners are dropped. All triangles must be wound the same way; if the volume
  /// is negative, all are flipped. Throws InputError for corners that are no vertex, triangles without area, and edges that
  /// are not passed by two triangles in opposite directions: an open mesh, one that is wound inconsistently, or one that touches
  /// itself along an edge. Self-intersection is not checked. O(n log n).
  Polyhedron(const Points& vertices, const std::vector<Triangle>& triangles);

  /// Exact. The sign comes from the angle-weighted pseudonormal of the nearest face, edge or vertex [Baerentzen
  /// and Aanaes 2005], which is right for every point. About O(log n).
  SignedDistance findSignedDistance(const Vec3& point) const;
  /// A lower bound of the distance of points outside, m: that from the box around it; 0 within the box.
  double boundDistance(const Vec3& point) const;

  /// After the checks: each vertex once, triangles counter-clockwise seen from outside.
  const Points& vertices() const { return vertices_; }
  const std::vector<Triangle>& triangles() const { return triangles_; }
  double volume() const { return volume_; }               // m^3
  const Vec3& low() const { return nodes_.front().low; }  // m, corners of its box
  const Vec3& high() const { return nodes_.front().high; }
  /// m, of the smallest ball about the origin that holds the bounding box.
  double radius() const { return low().cwiseAbs().cwiseMax(high().cwiseAbs()).norm(); }
  /// Places in the body, m, that tell which way it has gone: one near its middle and, where it is longer than wide, one towards
  /// either end. Found once, by O(n).
  const Points& axisPoints() const { return axis_points_; }

 private:
  struct Node {
    Vec3 low, high;      // m
    Index first, count;  // triangles of a leaf; count 0: the left child is the next node, and first is the right one
  };
  struct Nearest {
    double squared_distance;
    Vec3 point;
    Vec3 pseudonormal;  // not unit
  };

  void mergeVertices(const Points& vertices, const std::vector<Triangle>& triangles);
  void orient();
  void findNormals();
  Index buildNode(std::vector<Index>& order, Index begin, Index end, const Points& centers);
  void lookAt(Index triangle, const Vec3& point, Nearest& nearest) const;
  Nearest findNearest(const Vec3& point) const;
  Vec3 areaVector(const Triangle& t) const;
  Mat3 findPrincipalAxes() const;
  Vec3 moveInside(const Vec3& place) const;
  void findAxisPoints();

  Points vertices_;
  std::vector<Triangle> triangles_;  // in the order of the leaves
  double volume_ = 0.0;
  double on_surface_ = 0.0;  // m, below which the direction of the nearest point would be rounding
  std::vector<Node> nodes_;
  // Pseudonormals.
  Points face_normals_;                            // (triangles) unit
  std::vector<std::array<Vec3, 3>> edge_normals_;  // (triangles) of the edge from corner c to the next
  Points vertex_normals_;                          // (vertices)
  Points axis_points_;                             // m
};

}  // namespace deformable_surface::geometry
