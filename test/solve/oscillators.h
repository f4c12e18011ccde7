// The simplest model: points on springs to the origin, each with its own stiffness. Its motion is known exactly.
#pragma once

#include "deformable_surface/solve/integrator.h"

namespace deformable_surface::test {

using model::State;

class Oscillators : public model::DeformableModel, public model::StiffnessMatrix {
 public:
  Oscillators(std::vector<double> stiffness, double mass, double viscosity = 0.0)
      : stiffness_(std::move(stiffness)), masses_(stiffness_.size(), mass), viscosity_(viscosity) {}

  std::unique_ptr<DeformableModel> clone() const override { return std::make_unique<Oscillators>(*this); }
  const model::StiffnessMatrix* stiffnessMatrix() const override { return this; }
  const std::vector<double>& masses() const override { return masses_; }
  bool forcesReadVelocities() const override { return viscosity_ > 0.0; }
  void addForces(const State& s, Points& forces) const override {
    ++evaluations;
    for (std::size_t i = 0; i < forces.size(); ++i) forces[i] -= stiffness_[i] * s.positions[i] + viscosity_ * s.velocities[i];
  }
  double elasticEnergy(const State& s) const override {
    double sum = 0.0;
    for (std::size_t i = 0; i < stiffness_.size(); ++i) sum += 0.5 * stiffness_[i] * s.positions[i].squaredNorm();
    return sum;
  }
  void addStiffness(const State&, double step, model::Hessian, BlockSparse& k) const override {
    for (Index i = 0; i < static_cast<Index>(stiffness_.size()); ++i)
      k.add(i, i, (stiffness_[i] + (step > 0.0 ? viscosity_ / step : 0.0)) * Mat3::Identity());
  }
  void addRowBounds(const State&, std::vector<double>& k, std::vector<double>& c) const override {
    for (std::size_t i = 0; i < stiffness_.size(); ++i) {
      k[i] += stiffness_[i];
      c[i] += viscosity_;
    }
  }

  mutable int evaluations = 0;  // of the forces

 private:
  std::vector<double> stiffness_, masses_;
  double viscosity_;
};

/// The same with further springs to the origin whose forces are slow.
class SlowerOscillators : public Oscillators, public model::SplitForces {
 public:
  SlowerOscillators(std::vector<double> stiffness, double slow_stiffness, double mass, double viscosity = 0.0)
      : Oscillators(std::move(stiffness), mass, viscosity), slow_stiffness_(slow_stiffness) {}

  std::unique_ptr<DeformableModel> clone() const override { return std::make_unique<SlowerOscillators>(*this); }
  const model::SplitForces* splitForces() const override { return this; }
  void addForces(const State& s, Points& forces) const override {
    addFastForces(s, forces);
    addSlowForces(s, forces);
  }
  void addFastForces(const State& s, Points& forces) const override { Oscillators::addForces(s, forces); }
  void addSlowForces(const State& s, Points& forces) const override {
    ++slow_evaluations;
    for (std::size_t i = 0; i < forces.size(); ++i) forces[i] -= slow_stiffness_ * s.positions[i];
  }
  void addFastStiffness(const State& s, double step, model::Hessian hessian, BlockSparse& k) const override {
    Oscillators::addStiffness(s, step, hessian, k);
  }
  double boundSlowRate(const State&) const override { return 0.0; }

  double elasticEnergy(const State& s) const override {
    double sum = Oscillators::elasticEnergy(s);
    for (const Vec3& x : s.positions) sum += 0.5 * slow_stiffness_ * x.squaredNorm();
    return sum;
  }

  mutable int slow_evaluations = 0;

 private:
  double slow_stiffness_;
};

/// A damper on each point, split off as those of contact are.
class SplitDamper : public solve::ExternalLoad {
 public:
  explicit SplitDamper(double damping, double stiffness = 0.0) : damping_(damping), stiffness_(stiffness) {}
  bool isSplitOff() const override { return true; }
  void addForces(double, const State& s, Points& forces) const override {
    for (std::size_t i = 0; i < forces.size(); ++i) forces[i] -= damping_ * s.velocities[i];
  }
  double estimateWork(double, double, const State&, const State&) const override { return 0.0; }
  void addRowBounds(double, const State&, std::vector<double>& k, std::vector<double>& c) const override {
    for (std::size_t i = 0; i < k.size(); ++i) {
      k[i] += stiffness_;
      c[i] += damping_;
    }
  }

 private:
  double damping_;    // N s/m
  double stiffness_;  // N/m, of springs that are without force here
};

/// A constant force per mass.
class ConstantField : public solve::ExternalLoad {
 public:
  ConstantField(const std::vector<double>& masses, const Vec3& field) : masses_(masses), field_(field) {}
  void addForces(double, const State&, Points& forces) const override {
    for (std::size_t i = 0; i < forces.size(); ++i) forces[i] += masses_[i] * field_;
  }
  double potential(double, const State& s) const override {
    double sum = 0.0;
    for (std::size_t i = 0; i < masses_.size(); ++i) sum -= masses_[i] * field_.dot(s.positions[i]);
    return sum;
  }
  bool isConservative() const override { return true; }

 private:
  const std::vector<double>& masses_;
  Vec3 field_;
};

}  // namespace deformable_surface::test
