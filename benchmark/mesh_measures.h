// Measures of triangle meshes for the part "growth": what kind of surface, and how far from the true one. They share nothing with
// the growth of particles: the topology is counted from the corners of the triangles alone.
#pragma once

#include "growth_shapes.h"

#include <array>
#include <string>
#include <vector>

namespace deformable_surface::benchmark {

struct TriangleMesh {
  Points vertices;
  Points normals;  // of the vertices, unit; empty: the means of their triangles
  std::vector<std::array<Index, 3>> triangles;
};

/// The triangles of an .off or .obj file; polygons become fans. Empty if the file is missing.
TriangleMesh readTriangles(const std::string& file);

struct MeshCount {
  SurfaceKind kind;   // of the vertices that triangles use
  Index unused = 0;   // vertices of no triangle
  Index crooked = 0;  // edges of three triangles or more
  Index pinched = 0;  // vertices whose triangles do not form one fan
};
/// Pieces are joined by common vertices; loops are the closed chains of edges with one triangle, taken apart at pinched vertices.
MeshCount countKind(const TriangleMesh& mesh);

struct MeshDistance {
  double to_surface = 0.0, from_surface = 0.0;  // m, rms: from the mesh to the true surface, and back
  double farthest = 0.0;                        // m, the largest of both
  double normal_angle = 0.0;                    // rad, rms angle of the vertex normals to the true ones, by area; sides aside
  double turned = 0.0;                          // share of the area whose normals are on the side of the smaller part
};
/// The true surface is that of the dense points: the tangent planes of the nearest, as far as half of their distance.
MeshDistance measureDistance(const TriangleMesh& mesh, const GrowthShape& shape);

}  // namespace deformable_surface::benchmark
