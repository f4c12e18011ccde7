// Breaking of a closed surface under pressure.
#pragma once

#include "deformable_surface/simulation/loads.h"
#include "deformable_surface/solve/breaking.h"

namespace deformable_surface::simulation {

/// Pressure in a closed surface has the potential -p V, which ends where the surface opens. It goes with what broke, as the
/// elastic energy does.
class Burst : public solve::Breaking {
 public:
  /// Both are kept by reference.
  Burst(const model::DeformableModel& model, const PressureLoad& pressure) : model_(model), pressure_(pressure) {}

  /// Breaking as the evolution has it (null: none), from now on with that energy.
  solve::Breaking* over(solve::Breaking* breaking) {
    breaking_ = breaking;
    return breaking && isClosed(model_) && !pressure_.isEmpty() ? this : breaking;
  }

  bool isAnyStretched(const model::DeformableModel& model, const model::State& state) const override {
    return breaking_->isAnyStretched(model, state);
  }
  std::optional<double> breakStretched(const model::State& state) override {
    if (!isAnyStretched(model_, state)) return std::nullopt;
    const double before = pressure_.potential(0.0, state);
    const std::optional<double> lost = breaking_->breakStretched(state);
    return lost ? std::optional(*lost + before - pressure_.potential(0.0, state)) : std::nullopt;
  }
  void takeBack() override { breaking_->takeBack(); }

 private:
  const model::DeformableModel& model_;
  const PressureLoad& pressure_;
  solve::Breaking* breaking_ = nullptr;
};

}  // namespace deformable_surface::simulation
