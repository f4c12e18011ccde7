// Whether parts of a surface may be near each other, judged quickly: by the distances of its points and the angles of its folds.
#pragma once

#include "deformable_surface/contact/patches.h"

#include <array>
#include <cstdint>
#include <vector>

namespace deformable_surface::contact {

/// Parts that approach each other have points near each other first, and a crumple has a sharp fold. Points within three edges
/// along the surface, or more if the reach is longer, do not count: only a sharp fold brings them onto each other. Nor do points
/// on opposite sides of a thin part of a body. This costs far less than a list of pairs, but it is no proof.
class QuickLook {
 public:
  /// rest: (n) m. edges: of the triangles, ascending. patches: of the same surface, kept by reference. reach: m. is_body: the
  /// triangles enclose matter; seen from outside, the corners of all go the same way round.
  QuickLook(const Points& rest, const std::vector<Triangle>& triangles, const std::vector<Edge>& edges, const Patches& patches,
            double reach, bool is_body = false);

  /// Whether any parts may be nearer than the reach.
  bool isAnyNear(const Points& positions);
  /// m, where the last look saw it.
  const Vec3& placeSeen() const { return place_seen_; }

 private:
  // Two triangles that share an edge.
  struct Fold {
    Index one, other;
    double sense;  // -1 where the corners of one are in the other order, else 1
    double least;  // cosine of the sharpest angle that is no crumple
  };
  struct Vertex {
    Index index, place;  // place: in its patch
  };
  // By vertex of the one patch: a bit for each of the other.
  using Neighbours = std::array<std::uint32_t, Patches::kMostVertices>;

  void listFolds(const Points& rest);
  void setNeighbours(const std::vector<Edge>& pairs);
  std::vector<Edge> listOpposite(const Points& rest);
  bool isAnyFoldSharp(const Points& positions);
  // Points nearer than their reach that are not neighbours, until visit(one, other) returns true. Returns whether it has.
  template <class Visit>
  bool visitNear(const Points& positions, const Visit& visit);
  void listWithin(Index patch, const Box& box, const Points& positions, std::vector<Vertex>& list) const;

  const std::vector<Triangle> triangles_;
  const std::vector<Edge> edges_;
  const Patches& patches_;
  const double reach_;
  const Index num_points_;
  std::vector<Fold> folds_;
  std::vector<std::array<Index, 2>> couples_;  // of patches, the lower first, that have such points; ascending
  std::vector<Neighbours> neighbours_;         // of each: these points
  std::vector<Box> boxes_;                     // of the patches, half a reach larger
  BoxTree tree_;
  std::vector<Vertex> of_one_, of_other_;  // scratch
  std::vector<Vec3> normals_;              // (triangles), scratch
  std::vector<double> longest_;            // (n) m, of the edges at a point; scratch
  Vec3 place_seen_ = Vec3::Zero();         // m
};

}  // namespace deformable_surface::contact
