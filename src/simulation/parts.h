// The connected parts of a surface or body. Both the building of the rest surface and steps need
// them. Private.
#pragma once

#include "deformable_surface/simulation/contact_load.h"
#include "deformable_surface/simulation/rest_surface.h"

#include <string>
#include <utility>
#include <vector>

namespace deformable_surface::simulation {

/// Parts of n points, numbered in the order of their smallest index.
struct Parts {
  std::vector<Index> label;  // (n) the part of each point
  std::vector<Index> size;   // points of each part

  Index count() const { return static_cast<Index>(size.size()); }
};

Parts findParts(Index n, const std::vector<std::pair<Index, Index>>& links);
std::vector<std::pair<Index, Index>> linksOf(const Lists& neighbors);

/// Marks (n, 1) the points of the `most` largest parts; of equal ones the first.
std::vector<char> markLargest(const Parts& parts, Index most);

/// Removes whole parts from the dense points, those whose points are not kept (n, 1). They become holes of the input, and a note
/// says how many and why.
void leaveOut(const std::string& why, const Parts& parts, const std::vector<char>& kept, RestSurface& s);

/// For a scene with input.largest_parts: keeps only that many largest parts of the dense points.
void keepLargestParts(const SceneParams& params, const Parts& parts, RestSurface& s);

/// Loose parts of an equilibrium: held neither by a held point nor by a load that resists motion, nor perhaps by a tool, though
/// their loads do not sum to zero. Allocates nothing while the numbers of points and parts stay.
class LooseParts {
 public:
  /// links: of the n points now; null: all points are one part.
  void follow(Index n, const std::vector<std::pair<Index, Index>>* links);
  /// held, stiffness, loads and positions are by point: 1 where it is held, N/m of the loads against its motion, N and m.
  /// contact: the tools that act at that time, s; stiffness and loads are without theirs.
  void find(const std::vector<char>& held, const std::vector<double>& stiffness, const Points& loads, const Points& positions,
            const ContactLoad& contact, double time);

  bool isLoose(Index point) const { return is_loose_[parts_.label[point]]; }
  /// Whether no part has an equilibrium.
  bool areAll() const { return count_ > 0 && count_ == parts_.count(); }
  Index numPoints() const { return points_; }  // that are loose
  double load() const { return load_; }        // N, the sum of the loads on the first loose part
  /// The notice about loose parts, which stay in place.
  std::string describe() const;

 private:
  Parts parts_;
  std::vector<std::pair<Index, Index>> links_;
  std::vector<char> is_loose_, is_held_;  // by part
  std::vector<double> sizes_;             // N, by part: the sums of the sizes of the loads
  Points sums_;                           // N, by part
  Index count_ = 0, points_ = 0;
  double load_ = 0.0;
  Vec3 place_ = Vec3::Zero();  // m, of the first loose point
};

}  // namespace deformable_surface::simulation
