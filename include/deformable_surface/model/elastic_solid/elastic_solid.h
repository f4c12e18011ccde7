// Elastic bodies without a mesh: strain is computed at the points, fitted to their neighbours.
#pragma once

#include "deformable_surface/base/padded_points.h"
#include "deformable_surface/model/deformable_model.h"
#include "deformable_surface/model/elastic_solid/elastic_solid_params.h"
#include "deformable_surface/model/elastic_solid/plastic_flow.h"
#include "deformable_surface/model/elastic_solid/solid_passes.h"
#include "deformable_surface/model/material_params.h"

#include <optional>

namespace deformable_surface::model {

/// Total Lagrangian meshfree elasticity with moving-least-squares gradients [Mueller et al. 2004; Ganzenmueller 2015]:
///   E = sum_i V_i psi(F_i) + s/2 sum_i sum_j w'_ij |x_j - x_i - F'_i (X_j - X_i)|^2,
/// F_i by gradients that keep Gauss's theorem (ConsistentGradients), psi by Young's modulus, Poisson's ratio and law. The
/// second sum penalises motions from point to point that the first does not resist. F'_i is the fit of the nearest
/// points with the same weights. It minimises the second sum, so that its forces need no derivative of F'_i; the sum is zero for
/// every affine motion. Rigid motions and uniform strains are exact.
class ElasticSolid : public DeformableModel,
                     public PlanarMotion,
                     public InnerState,
                     public StiffnessProducts,
                     public Partition,
                     public Links,
                     public Stresses {
 public:
  /// rest: (n x 3) m; neighbors: lists of about thirty (planar: sixteen), nearest first; detours: weight of each listed pair, or
  /// empty. across: unit normal of the plane that the points lie in, or zero for a body in space. around: (n) m^3, or
  /// m^2, around each point of a finer cloud that has been thinned out: cells are filled to that degree; empty: wholly.
  ElasticSolid(const Points& rest, const Lists& neighbors, const std::vector<double>& detours, const Vec3& across,
               const MaterialParams& material, const ElasticSolidParams& params, Outline outline = Outline::kSurface,
               const std::vector<double>& around = {});

  std::unique_ptr<DeformableModel> clone() const override { return std::make_unique<ElasticSolid>(*this); }
  const std::vector<double>& masses() const override { return masses_; }
  const StiffnessProducts* stiffnessProducts() const override { return this; }
  const PlanarMotion* planarMotion() const override { return isPlanar() ? this : nullptr; }
  const Partition* partition() const override { return this; }
  const Links* links() const override { return this; }
  const Stresses* stresses() const override { return this; }
  InnerState* innerState() override { return this; }
  /// A planar solid has no forces across its plane.
  void confine(Points& forces) const override;
  bool forcesReadVelocities() const override { return false; }
  void beginAtRest(State& state) override;
  void adopt(const State& state) override;
  /// After a step of dt seconds: stress beyond the yield causes flow (PlasticFlow), in a state that was adopted or began at rest.
  /// Returns whether anything flowed.
  bool flow(double dt, State& state);
  void addForces(const State& state, Points& forces) const override;
  double elasticEnergy(const State& state) const override;
  /// The stable step of the body at rest, with a stiffness that bounds that of most states (StressLaw::kBound). Of the state
  /// plastic flow counts, which may shorten lengths and so raise frequencies, and by the neo-Hookean law its stiffening.
  double findStableStep(const State& state) const override;
  void prepareStiffness(const State& state, Hessian hessian) const override;
  void addStiffnessProduct(const Points& v, Points& product) const override;
  const std::vector<Coupling>& couplings() const override { return couplings_; }
  void addRowBounds(const State& state, std::vector<double>& stiffness, std::vector<double>& damping) const override;

  /// False for a solid that may flow. Forces in a part equal those of the whole to rounding.
  bool markPartners(const std::vector<Index>& points, std::vector<char>& marked) const override;
  Part makePart(const std::vector<char>& wanted) const override;

  double maxStretch(const State& state) const override;
  void computePointStrain(const State& state, std::vector<double>& strain) const override;
  /// Of the Cauchy stress P F^T / det F; by the linear law of P.
  void computePointStress(const State& state, std::vector<double>& stress) const override;
  /// Links between points that are both among each other's nearest, and others that join what forces join.
  const std::vector<std::pair<Index, Index>>& stretchLinks() const override { return links_; }
  const std::vector<std::pair<Index, Index>>& bendLinks() const override { return no_links_; }

  /// Turns normals (n x 3, unit or zero) from rest to the state, by the cofactors of F.
  void turnNormals(const State& state, const Points& normals, std::vector<Eigen::Vector3f>& turned) const;

  const std::vector<double>& volumes() const { return passes_.rest.volumes; }
  bool isPlanar() const { return !passes_.rest.across.isZero(0.0); }
  const Vec3& across() const { return passes_.rest.across; }
  /// Points whose neighbours span fewer dimensions than the body. They have no strain in the missing directions.
  Index numDeficient() const { return num_deficient_; }
  /// Number of neighbours used for strain, summed over all points.
  Index numPairs() const { return static_cast<Index>(passes_.rest.fit.pairs.items.size()); }

 private:
  explicit ElasticSolid(SolidRest rest);  // the rest is to be filled in
  void joinLinks();
  void findRowBounds();
  void findCouplings();
  double stretchOf(std::size_t link, const State& state) const;
  void boundStableStep();
  void addPassForces(StressLaw law, const double* positions, Points& forces) const;

  StressLaw law_ = StressLaw::kCorotated;
  bool is_plate_ = false;       // no stress across the plane
  mutable SolidPasses passes_;  // with scratch of its own
  std::optional<PlasticFlow> plasticity_;
  std::vector<double> masses_, row_bounds_;
  std::vector<Coupling> couplings_;
  double stable_step_ = 0.0;
  Index num_deficient_ = 0;
  std::vector<std::pair<Index, Index>> links_, no_links_;
  std::vector<double> lengths_;  // m, of links at rest
  // Scratch.
  mutable PaddedPoints positions_;
  mutable Points product_;
  // An implicit step asks for the energies of its start and of its end more than once.
  mutable Points energy_at_;
  mutable double energy_ = 0.0;
};

}  // namespace deformable_surface::model
