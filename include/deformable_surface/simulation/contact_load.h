// Contact with the solid tools of a scene, as a load on the simulation points.
#pragma once

#include "deformable_surface/solve/external_load.h"
#include "deformable_surface/tool/tool.h"

namespace deformable_surface::simulation {

/// Points inside a tool are pushed out along its normal by F = m r^2 d, d the depth: a penalty with the potential m r^2 d^2 / 2. Being in
/// proportion to mass, it adds at most r^2 to the square of the highest frequency, wherever it acts; and at rest a point is as
/// deep as its share of the load over m r^2. No friction. The simulation points alone are seen, not the surface between them.
class ContactLoad : public solve::ExternalLoad {
 public:
  ContactLoad(const std::vector<double>& masses, std::vector<tool::ToolParams> tools) : masses_(masses), tools_(std::move(tools)) {}

  /// r, 1/s. Set once the stable step at rest is known.
  void setRate(double rate) { rate_ = rate; }

  void addForces(double time, const model::State& state, Points& forces) const override;
  double potential(double time, const model::State& state) const override;
  bool isConservative() const override { return true; }
  double storedEnergy(double time, const model::State& state) const override { return potential(time, state); }
  /// What tools in motion do: the potential's gain at the points before and at those after, whichever is more.
  double estimateWork(double from, double to, const model::State& before, const model::State& after) const override;
  void addStiffness(double time, const model::State& state, double step, BlockSparse& stiffness) const override;
  void addRowBounds(double time, const model::State& state, std::vector<double>& stiffness, std::vector<double>& damping) const override;

 private:
  const std::vector<double>& masses_;
  std::vector<tool::ToolParams> tools_;
  double rate_ = 0.0;
};

}  // namespace deformable_surface::simulation
