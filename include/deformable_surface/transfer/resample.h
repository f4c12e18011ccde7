// New dense points where the surface is stretched [Su 2007, sec. 5 after Alexa 2003], appended behind the input's with stable
// ids.
#pragma once

#include "deformable_surface/cloud/rings.h"
#include "deformable_surface/transfer/transfer.h"

namespace deformable_surface::transfer {

/// Keeps the sampling of the deformed surface near that at rest. When a link between neighbouring dense points is longer
/// than max_stretch times the local rest spacing and its own length at rest, a point is inserted at its middle at rest. It is
/// projected on the moving-least-squares surface (a quadratic height field over the neighbours [Alexa 2003]) and moves with the
/// surface from then on. Points are not removed until a reset: an index always means the same point. At most
/// max_points are inserted.
class Resampler {
 public:
  /// max_stretch > 1; dense (n x 3) finite, normals (n x 3) unit, rings of the same points: all at rest.
  Resampler(const Points& dense, const Points& normals, const cloud::Rings& dense_rings, double max_stretch, Index max_points);

  /// Checks the deformed positions of all points so far (input's and inserted) and inserts where needed, on the longest links
  /// first. Each link is halved once per call: a sudden large stretch takes a few calls. Returns the number of new points.
  /// Links whose ends are not finite are skipped. O(links).
  Index update(const Points& dense_now);

  const Points& insertedRest() const;     // (p x 3) at rest, in the order of insertion
  const Points& insertedNormals() const;  // (p x 3) at rest
  /// The two points between which each was inserted (indices may name inserted points too). Extra fields are copied from the
  /// first.
  const std::vector<std::pair<Index, Index>>& parents() const;
  /// Changes whenever an update has changed anything.
  std::uint64_t revision() const { return revision_; }
  /// Memory in use.
  std::size_t bytes() const;

 private:
  struct Link {
    Index a, b;          // a < b
    double rest_length;  // m
  };

  void halve(Link link);
  Vec3 project(const Vec3& middle, Vec3& normal, Index a, Index b) const;
  Index findNear(const Vec3& place, double distance, Index a, Index b) const;
  void addLink(Index a, Index b);
  Vec3 restPosition(Index i) const { return i < num_dense_ ? dense_[i] : inserted_rest_[i - num_dense_]; }
  Vec3 restNormal(Index i) const { return i < num_dense_ ? normals_[i] : inserted_normals_[i - num_dense_]; }

  Index num_dense_ = 0;
  double max_stretch_ = 0.0;
  Index max_points_ = 0;
  std::uint64_t revision_ = 0;
  Points dense_, normals_;
  Points inserted_rest_, inserted_normals_;
  std::vector<std::pair<Index, Index>> parents_;
  std::vector<std::vector<Index>> adjacent_;  // of all points so far, ascending
  std::vector<double> spacing_;               // m, of all points so far: mean link length at rest
  std::vector<Link> links_;                   // each once
  std::vector<double> too_long_;              // m, scratch, of links_: the length now if it is too long, else 0
};

}  // namespace deformable_surface::transfer
