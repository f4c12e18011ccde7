// What knives and tears do to a mass-spring surface in a step. Apart from the order of a step, because most surfaces are never
// cut.
#pragma once

#include "deformable_surface/model/mass_spring/mass_spring.h"
#include "deformable_surface/tool/blade.h"
#include "deformable_surface/tool/tool.h"

namespace deformable_surface::simulation {

/// What follows the simulation points and must know on which side of a cut it is.
class CutFollower {
 public:
  virtual ~CutFollower() = default;
  /// A knife went through the surface while the simulation points (m x 3) moved from before to after: what follows them no longer
  /// follows those that the knife went between. Returns whether there is any.
  virtual bool sever(const tool::BladeSweep& blade, const Points& before, const Points& after) = 0;
  /// The links (m) that are whole are others than before.
  virtual void followLinks(const std::vector<std::pair<Index, Index>>& whole) = 0;
};

class Cutting {
 public:
  /// model is kept by reference. tear_strain: l / l0 - 1 at which links tear, 0: never.
  Cutting(model::MassSpring& model, double tear_strain);

  /// Before a step from time (s): whether something can be cut in it; if so, the positions are kept.
  bool beginStep(const std::vector<tool::ToolParams>& tools, double time, const Points& positions);
  /// After it, if beginStep() said so: cuts the links that knives went through and those that are stretched too far, and tells
  /// the follower, if there is one. Returns whether any was cut.
  bool endStep(const std::vector<tool::ToolParams>& tools, double time, double step, const Points& positions,
               CutFollower* follower);

  const std::vector<model::MassSpring::Link>& cuts() const { return model_.cuts(); }
  void setCuts(const std::vector<model::MassSpring::Link>& cuts) { model_.setCuts(cuts); }

 private:
  using Link = model::MassSpring::Link;

  void cut(const tool::BladeSweep& blade, const Points& positions, const std::vector<Link>& links);
  void tear(const Points& positions);

  model::MassSpring& model_;
  const double tear_strain_;
  double spacing_ = 0.0, longest_ = 0.0;  // m, mean and largest length of links at rest
  Points before_;                         // m, of the last beginStep()
  std::vector<Link> found_;               // in this step
  std::vector<char> is_cut_;              // (links) scratch
};

}  // namespace deformable_surface::simulation
