// Cuts of a mass-spring surface by knives and tears in a step. Most surfaces are never
// cut.
#pragma once

#include "deformable_surface/model/mass_spring/mass_spring.h"
#include "deformable_surface/simulation/evolution.h"

namespace deformable_surface::simulation {

class Cutting : public Evolution, public solve::Breaking {
 public:
  /// model is kept by reference. tear_strain: l / l0 - 1 at which links tear, 0: never.
  Cutting(model::MassSpring& model, double tear_strain);

  void forget() override { setCuts({}); }
  void beginStep(double time, const std::vector<tool::ToolParams>& tools, const Points& positions) override;
  solve::Breaking* breaking() override { return tear_strain_ > 0.0 ? this : nullptr; }
  bool isAnyStretched(const model::DeformableModel& model, const model::State& state) const override;
  std::optional<double> breakStretched(const model::State& state) override;
  void takeBack() override { setMemory(begun_with_); }
  /// Cuts the links that knives passed through and those that are stretched too far, and informs the follower of all that were
  /// cut in the step.
  AfterStep endStep(double time, double step, const std::vector<tool::ToolParams>& tools, model::State& state,
                    CutFollower* follower) override;
  /// Knives cut springs without resistance.
  bool isPushedBy(const tool::ToolParams& tool) const override { return tool.mode != tool::Mode::kCut; }
  std::shared_ptr<const Memory> memory() const override { return cuts_; }
  void setMemory(const std::shared_ptr<const Memory>& saved) override;
  std::uint64_t addToHash(std::uint64_t hash) const override;

  using Link = model::MassSpring::Link;

 private:
  struct Cuts : Memory {
    std::vector<Link> links;
    double spacing = 0.0, longest = 0.0;  // m, see below: a fork is made with a model that is cut
    std::size_t bytes() const override { return links.size() * sizeof(Link); }
  };

  void setCuts(const std::vector<Link>& cuts);
  bool cutLinks(double time, double step, const std::vector<tool::ToolParams>& tools, const Points& positions,
                CutFollower* follower);
  void cut(const tool::BladeSweep& blade, const Points& positions, const std::vector<Link>& links);
  void cutFound();
  void tear(const Points& positions);

  model::MassSpring& model_;
  const double tear_strain_;
  double spacing_ = 0.0, longest_ = 0.0;    // m, mean and largest length at rest of the links of the whole surface
  std::shared_ptr<const Cuts> cuts_;        // of the model; null: none
  std::shared_ptr<const Cuts> begun_with_;  // when the last step began
  bool may_cut_ = false;                    // in this step
  Points before_;                           // m, when a step with a knife began last
  std::vector<Link> found_;                 // in this step
  std::vector<char> is_cut_;                // (links) scratch
};

}  // namespace deformable_surface::simulation
