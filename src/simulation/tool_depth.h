// What contact with solid tools leaves: how deep points of the full cloud lie in them, and tools that have come between the
// points that touch tools. For the error estimator.
#pragma once

#include "deformable_surface/simulation/contact_load.h"

#include <memory>
#include <vector>

#include "dynamics.h"

namespace deformable_surface::simulation {

/// It looks at the simulation points, and at some points of the cloud in the cell of each: more than touch tools by default. Held
/// points do not count, as no tool can push them.
class ToolDepth {
 public:
  /// level: its points are looked at. It is not kept.
  explicit ToolDepth(const Dynamics& level);
  ToolDepth(const ToolDepth& other) : ToolDepth(other.masses_.size(), other.contact_.points().sharedBetween()) {}
  ToolDepth& operator=(const ToolDepth&) = delete;

  /// The depth (m) of the deepest point now. level: with as many simulation points. Allocates nothing after the first calls.
  double measure(const Dynamics& level);
  /// A tool in the surface of which the estimate knows nothing; null: there is none. It pushes none of the level's points. Or it
  /// is a needle, narrower than one and a half spacings of the cloud, where that has more points than the level: whether it hangs
  /// on a point or passes between them differs between the two. spacing: of the simulation points, m.
  struct Unfelt {
    const tool::ToolParams* tool = nullptr;
    bool is_needle = false;
  };
  Unfelt findUnfelt(const Dynamics& level, double spacing) const;

 private:
  ToolDepth(std::size_t num_points, std::shared_ptr<const transfer::SampledPoints> between);

  const std::vector<double> masses_;  // (m) kg, of no meaning
  ContactLoad contact_{masses_};      // its tools are those of the level, its points between more
  std::vector<ContactLoad::Body> bodies_;
};

}  // namespace deformable_surface::simulation
