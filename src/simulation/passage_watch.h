// Whether parts of a surface without contact have come to pass through each other.
#pragma once

#include "deformable_surface/contact/crossings.h"

#include <array>
#include <memory>
#include <optional>
#include <vector>

#include "contact_skin.h"

namespace deformable_surface::simulation {

class PassageWatch {
 public:
  struct Found {
    Index triangles;  // that edges pass through
    Vec3 place;       // m, of one of these edges
  };

  /// rest: (n) m. What passes through itself there is not found later, nor what is beside it: all
  /// pairs that have an end of such an edge and a corner of the triangle that it crosses.
  PassageWatch(const Points& rest, std::shared_ptr<const ContactSkin> skin);

  /// positions: (n) m. now: the triangles that the surface still has; null: all. O(n log n).
  std::optional<Found> look(const Points& positions, const std::vector<model::WeightedTriangle>* now);

 private:
  bool isAtRest(const contact::Crossing& crossing) const;
  void dropCut(Index n, const std::vector<model::WeightedTriangle>& now, std::vector<contact::Crossing>& found) const;

  const std::shared_ptr<const ContactSkin> skin_;
  const std::vector<contact::Edge> edges_;
  std::vector<std::array<Index, 2>> at_rest_;  // an end of an edge and a corner of a triangle that it crosses; ascending
  std::vector<contact::Box> boxes_;            // of the triangles
  contact::BoxTree tree_;
};

}  // namespace deformable_surface::simulation
