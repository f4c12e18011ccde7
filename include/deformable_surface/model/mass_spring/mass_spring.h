// The mass-spring surface of Su 2007, with two extensions that make it accurate: a membrane of co-rotated triangles and a bending
// energy with a stated rigidity, on the same rings. The published springs stay selectable.
#pragma once

#include "deformable_surface/base/padded_points.h"
#include "deformable_surface/model/deformable_model.h"
#include "deformable_surface/model/mass_spring/curvature_bending.h"
#include "deformable_surface/model/mass_spring/mass_spring_params.h"
#include "deformable_surface/model/mass_spring/springs.h"
#include "deformable_surface/model/mass_spring/triangle_membrane.h"
#include "deformable_surface/model/material_params.h"

namespace deformable_surface::cloud {
struct Rings;
}

namespace deformable_surface::model {

class MassSpring : public DeformableModel,
                   public Clamping,
                   public PointMaterials,
                   public SplitForces,
                   public Partition,
                   public StiffnessMatrix,
                   public Sides,
                   public Links {
 public:
  /// rest, normals (n x 3): the simulation points; rings: of these. surface_area, m^2: of the full cloud, so that the masses sum
  /// to the surface's however few points are simulated. closed: it has no boundary. held, edges: see setHeld(). Throws
  /// InputError if an open surface has a volume_stiffness.
  ///
  /// Springs: stretching springs along the rings, bending springs across (r to r + 2) [Su 2007, sec. 4.1], each pair once. Their
  /// stiffness is k = E h sum A_T / l^2 over the triangles at the spring; bending springs get bending_spring_ratio of the mean.
  /// All are scaled so that an affine strain of the network costs the energy of the material (isotropic estimate
  /// E h = sum k l^2 / (3 A)). On irregular rings the network is then 10 to 25 percent soft, with Poisson's ratio about 1/3.
  /// With uniform stiffness, spring_constant and bending_spring_ratio times it are used as they are.
  MassSpring(const Points& rest, const Points& normals, const cloud::Rings& rings, double surface_area, bool closed,
             const MaterialParams& material, const MassSpringParams& params, const std::vector<char>& held = {},
             const std::vector<ClampEdge>& edges = {});

  std::unique_ptr<DeformableModel> clone() const override { return std::make_unique<MassSpring>(*this); }
  const std::vector<double>& masses() const override { return masses_; }
  const StiffnessMatrix* stiffnessMatrix() const override { return this; }
  /// The forces of the curvature energy are slow: a surface that is thin compared with its point spacing bends slowly compared
  /// with how it stretches.
  const SplitForces* splitForces() const override { return hasCurvature() ? this : nullptr; }
  const Partition* partition() const override { return this; }
  const Sides* sides() const override { return this; }
  const Links* links() const override { return this; }
  PointMaterials* pointMaterials() override { return this; }
  Clamping* clamping() override { return this; }
  bool setHeld(const std::vector<char>& held, const std::vector<ClampEdge>& edges) override;
  /// Springs and triangles take the stretching of their ends or corners, curvature fits the bending of their point, bending
  /// springs the stretching, masses the density.
  void setMaterial(const std::vector<PointMaterial>& materials) override;
  void addForces(const State& state, Points& forces) const override;
  bool forcesReadVelocities() const override { return along_damping_ + relative_damping_ > 0.0; }
  void addFastForces(const State& state, Points& forces) const override;
  void addSlowForces(const State& state, Points& forces) const override;
  void addFastStiffness(const State& state, double step, Hessian hessian, BlockSparse& stiffness) const override;
  double boundSlowRate(const State& state) const override { return bending_.boundRate(state, masses_); }
  /// False with a constant volume, which couples all points.
  bool markPartners(const std::vector<Index>& points, std::vector<char>& marked) const override;
  Part makePart(const std::vector<char>& wanted) const override;
  double elasticEnergy(const State& state) const override;
  void addStiffness(const State& state, double step, Hessian hessian, BlockSparse& stiffness) const override;
  /// True for triangles with the curvature energy, or without bending.
  bool knowsCouplings() const override;
  bool findCouplings(const State& state, double support, std::vector<Coupling>& along,
                     std::vector<Coupling>& across) const override;
  double rankOneStiffness(const State& state, Points& v) const override;
  void addRowBounds(const State& state, std::vector<double>& stiffness, std::vector<double>& damping) const override;
  void computeAreaVectors(const State& state, Points& area_vectors) const override;
  bool isClosed() const override { return closed_ && cuts_.empty(); }
  double enclosedVolume(const State& state) const override;
  void computeVolumeGradient(const State& state, Points& gradient) const override;
  double maxStretch(const State& state) const override { return stretching_.maxStretch(state); }
  void computePointStrain(const State& state, std::vector<double>& strain) const override;
  const std::vector<std::pair<Index, Index>>& stretchLinks() const override { return stretching_.links(); }
  const std::vector<std::pair<Index, Index>>& bendLinks() const override { return bending_springs_.links(); }
  const std::vector<WeightedTriangle>& triangles() const override { return triangles_; }

  const Springs& stretchingSprings() const { return stretching_; }

  using Link = std::pair<Index, Index>;  // the smaller index first
  /// Sets the cut links, ascending. They replace the former ones: all others are whole. A cut removes the springs of a
  /// link, the triangles that have it as an edge, and its place in the rings that curvature is fitted to. In a membrane
  /// of triangles, links that are left without any triangle are cut too. Masses stay: a cut takes stiffness only. Nothing is
  /// allocated or slower while nothing is cut. O(n).
  void setCuts(const std::vector<Link>& links);
  /// The cut links, including those that were left without triangles. Given to setCuts() they give the same surface.
  const std::vector<Link>& cuts() const { return cuts_; }

  /// Points whose mass was raised because their ring has almost no area, and points without bending energy.
  Index numMassRaised() const { return num_mass_raised_; }
  Index numWithoutBending() const { return num_without_bending_; }
  /// Whether it has a curvature energy. Of its clamps see CurvatureBending::numHinged().
  bool hasCurvature() const { return plate_.rigidity > 0.0; }
  Index numHinged() const { return bending_.numHinged(); }

 private:
  MassSpring() = default;  // of no points: a part before it is filled
  bool isCut(Index i, Index j) const;
  void rememberMade();
  void groupTriangles();
  Springs takeSprings(const std::vector<Link>& links, const std::vector<double>& stiffness) const;
  void buildBending();
  void rebuild();

  // As it was made. The elements are stored here at the first change.
  struct Made {
    Points points;  // (n x 3) at rest
    double membrane_stiffness = 0.0, poisson_ratio = 0.0;
    std::vector<WeightedTriangle> triangles;
    std::shared_ptr<const TriangleMembrane> membrane;
    std::vector<Link> links, across;                  // stretching and bending springs and
    std::vector<double> stiffness, across_stiffness;  // theirs, N/m
    std::vector<double> masses;
  };
  Made made_;
  std::vector<Link> cuts_;                // that changed it since
  std::vector<PointMaterial> materials_;  // (n) the same; empty: none
  // Constant except for these changes.
  std::vector<double> masses_;
  std::vector<WeightedTriangle> triangles_;
  Lists triangle_corners_;  // per point: 3 * triangle + corner
  Membrane membrane_ = Membrane::kTriangles;
  double along_damping_ = 0.0, relative_damping_ = 0.0;  // s; spring_damping, one of the two is 0
  Springs stretching_;  // elastic if membrane_ is kSprings; carries the damping and the display in any case
  Springs bending_springs_;
  TriangleMembrane membrane_triangles_;
  CurvatureBending bending_;
  PlateRest plate_;         // the bending is rebuilt from it when other points are held; empty without bending
  std::vector<char> held_;  // of which it was made, with
  std::vector<ClampEdge> edges_;
  std::shared_ptr<const BalancedPlate> whole_;  // of the bending without cuts and these clamps; made at the first cut
  bool closed_ = false;
  double volume_stiffness_ = 0.0;
  double rest_volume_ = 0.0;
  Index num_mass_raised_ = 0, num_without_bending_ = 0;
  // Start of findCouplings(), made when first needed.
  struct Guess {
    std::vector<Coupling> along, across;  // across: without tension; with the pairs of bending or, where it is weak, without
    std::vector<Index> edges;             // of each edge of each triangle its place in across
  };
  mutable Guess stiff_guess_, slack_guess_;    // with the pairs of bending; without
  mutable double bending_sum_ = -1.0;          // of its springs, N/m; below 0: not known
  mutable std::vector<double> springs_along_;  // of each edge of each triangle, N/m; empty: not known
  void forgetGuesses();
  void makeGuess(bool has_bending, Guess& guess) const;
  // Scratch.
  mutable PaddedPoints positions_;
  mutable std::vector<double> springs_across_;
  mutable Points volume_gradient_;
  mutable Points triangle_shares_;  // m^2, of the area vector of each triangle, the share of each corner
};

}  // namespace deformable_surface::model
