// The loads of a scene: gravity, pressure and drag of the air, named forces, anchors.
#pragma once

#include "deformable_surface/simulation/load_points.h"
#include "deformable_surface/simulation/scene_params.h"
#include "deformable_surface/solve/external_load.h"

#include <memory>
#include <set>
#include <string>
#include <utility>

namespace deformable_surface::simulation {

using model::State;

/// F = m g [Su 2007, eq. 4].
class GravityLoad : public solve::ExternalLoad {
 public:
  GravityLoad(const std::vector<double>& masses, const Vec3& gravity) : gravity(gravity), masses_(masses) {}
  void addForces(double time, const State& state, Points& forces) const override;
  double potential(double time, const State& state) const override;
  bool isConservative() const override { return true; }
  bool isEmpty() const { return gravity.isZero(0.0); }

  Vec3 gravity;  // m/s^2

 private:
  const std::vector<double>& masses_;
};

/// Pressure along the outward normal on the current area: F = p a with the area vector a = A n. In a closed surface it pushes
/// along the gradient of the volume: no net force, and a potential.
class PressureLoad : public solve::ExternalLoad {
 public:
  PressureLoad(const model::DeformableModel& model, double pressure) : model_(model), pressure_(pressure) {}
  void addForces(double time, const State& state, Points& forces) const override;
  double potential(double time, const State& state) const override;
  bool isConservative() const override { return isClosed(model_); }
  /// Exact by Simpson's rule: along a straight path the area is quadratic.
  double estimateWork(double from, double to, const State& before, const State& after) const override;
  void addIndefiniteStiffness(double time, const State& state, BlockSparse& stiffness) const override;
  void addSkewProduct(double time, const State& state, const Points& v, Points& product) const override;
  bool hasSkewStiffness() const override { return !isEmpty() && model_.sides() && !isClosed(model_); }
  void setPressure(double pressure) { pressure_ = pressure; }
  bool isEmpty() const { return pressure_ == 0.0; }

 private:
  const model::DeformableModel& model_;
  double pressure_;  // Pa
  mutable Points area_;
  mutable State between_;
};

/// Viscous drag against the normal velocity on the current area: F = -c (v . n) a with the area vector a = A n.
class DragLoad : public solve::ExternalLoad {
 public:
  DragLoad(const model::DeformableModel& model, double viscous_drag) : model_(model), drag_(viscous_drag) {}
  void addForces(double time, const State& state, Points& forces) const override;
  void addStiffness(double time, const State& state, double step, BlockSparse& stiffness) const override;
  void addRowBounds(double time, const State& state, std::vector<double>& stiffness, std::vector<double>& damping) const override;
  double estimateWork(double, double, const State&, const State&) const override { return 0.0; }
  void setDrag(double viscous_drag) { drag_ = viscous_drag; }
  bool isEmpty() const { return !(drag_ > 0.0); }

 private:
  const model::DeformableModel& model_;
  double drag_;  // N s/m per m^2
  mutable Points area_;
};

/// Anchors, springs to fixed places: F = k (r0 - s) [Su 2007, eq. 5].
class AnchorLoad : public solve::ExternalLoad {
 public:
  struct Anchor {
    Index point;
    Vec3 target;       // m
    double stiffness;  // N/m
  };
  explicit AnchorLoad(std::vector<Anchor> anchors) : anchors_(std::move(anchors)) {}
  void addForces(double time, const State& state, Points& forces) const override;
  double potential(double time, const State& state) const override;
  bool isConservative() const override { return true; }
  bool isEmpty() const { return anchors_.empty(); }
  /// The indices of points have changed: new_index (of the former points), -1 = removed.
  void renumber(const std::vector<Index>& new_index);
  double storedEnergy(double time, const State& state) const override { return potential(time, state); }
  void addStiffness(double time, const State& state, double step, BlockSparse& stiffness) const override;
  void addRowBounds(double time, const State& state, std::vector<double>& stiffness, std::vector<double>& damping) const override;

 private:
  std::vector<Anchor> anchors_;
};

/// Whether a step of a run from 0 to duration (s) begins while the force acts.
bool actsInAStep(const ForceParams& force, double time_step, double duration);

/// Named forces. Each keeps the points that it took when it started; they share it in proportion to mass. With a radius these are
/// points of the cloud, if they are known: a loaded patch then ends where its radius says, and not at the simulation points that
/// happen to lie in it. What a point of the cloud carries acts on the simulation points that it follows, by the transpose of its
/// row. The height of the point over the plane fitted to these is left out: its moment is of second order in the spacing, and
/// without it the force stays constant, with a linear potential.
class NamedForces : public solve::ExternalLoad {
 public:
  struct Named {
    ForceParams params;
    bool started = false;
    std::vector<Index> points;   // ascending
    std::vector<double> shares;  // sum to one; may be negative at a free edge
    /// What carries it in the cloud: simulation points (< m), or m + a point between them. None if points are these themselves.
    struct Carrier {
      Index point;
      double share;  // sum to one
    };
    std::shared_ptr<const std::vector<Carrier>> carriers;  // null: none; shared, as states are copied in each step
  };

  explicit NamedForces(const std::vector<double>& masses) : masses_(masses) {}
  /// For a model without motion along this unit vector: a notice names forces with a part along it. Zero (default): none.
  void setDropped(const Vec3& along) { dropped_ = along; }

  /// The points of the cloud that carry forces with a radius; null: the simulation points do.
  void setLoadPoints(std::shared_ptr<const LoadPoints> points) { load_points_ = std::move(points); }
  const std::shared_ptr<const LoadPoints>& loadPoints() const { return load_points_; }
  /// Whether any force has a radius.
  bool needLoadPoints() const;
  /// Points between that follow both sides of a cut (1): the simulation points of their cells carry for them. Empty: none.
  void setSevered(std::vector<char> is_severed) { is_severed_ = std::move(is_severed); }
  /// Forces that have begun act on other simulation points where the surface was cut.
  void followCut();

  /// Adds the force or replaces the one of the same id; a zero force removes it.
  void set(const ForceParams& force);
  void remove(const std::string& id);
  void clear() {
    forces_.clear();
    reported_.clear();
  }

  /// To be called at the beginning of a step: forces that begin take their points, forces that end are removed. The notice
  /// reports forces that begin badly: the points are far from where the force was put, or all pinned,
  /// or a part of it is dropped. It is given once, until a force of the same id begins well.
  struct Update {
    bool changed = false;  // any began or left
    std::string notice;
    std::vector<Index> points;  // on which these forces acted or will act
  };
  Update update(double time, const State& state, const std::vector<char>& pinned);

  /// All forces, by ascending id: for snapshots.
  const std::vector<Named>& all() const { return forces_; }
  void restore(const std::vector<Named>& forces) { forces_ = forces; }
  /// The indices of points have changed: new_index (of the former points), -1 = removed. The remaining points share the force.
  void renumber(const std::vector<Index>& new_index);

  void addForces(double time, const State& state, Points& forces) const override;
  double potential(double time, const State& state) const override;
  bool isConservative() const override { return true; }

  /// Mean position of the loaded points, and the force, of each force that acts now.
  std::vector<std::pair<Vec3, Vec3>> active(const State& state) const;

 private:
  const std::vector<double>& masses_;
  void takeNearestOrWithin(const State& state, Named& force) const;
  void takeCarriers(const State& state, Named& force) const;
  void spreadCarriers(Named& force) const;
  void report(const std::string& id, const std::string& problem, std::string& notice);
  static std::string findMisplacement(const Named& force, const State& state, const std::vector<char>& pinned);
  std::string findProblem(const Named& force, const State& state, const std::vector<char>& pinned) const;

  Vec3 dropped_ = Vec3::Zero();
  std::shared_ptr<const LoadPoints> load_points_;
  std::vector<char> is_severed_;  // (points between), or empty
  std::vector<Named> forces_;     // ascending id
  std::set<std::string> reported_;
};

}  // namespace deformable_surface::simulation
