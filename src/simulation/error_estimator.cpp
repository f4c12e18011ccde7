#include "error_estimator.h"

#include "deformable_surface/base/error.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace deformable_surface::simulation {
namespace {

using solve::IntegratorType;

// The copies have one point for so many of the simulation's: doubled spacing, an eighth of the cost of explicit steps.
constexpr Index kRatio = 4;
constexpr Index kFineness = 2;  // of the copy in finer sub-steps: what it differs by is then a known share of the error

// Fitted on scenes that benchmark/calibration_section.cpp draws by other seeds; see docs/accuracy_control.md.
constexpr double kSpaceFactor = 1.6;  // also of what transfer loses
constexpr double kVerletFactor = 3.0, kFirstOrderFactor = 1.5;

// The twin's disturbance over the spacing of the copies: of the size of the errors that the simulation has anyway, which are
// those of simplification or, where all points are simulated, of time stepping.
constexpr double kDisturbance = 1e-3, kDisturbanceOfFull = 1e-6;
// The twin's distance, over the spacing, that ends the estimate. Smooth motions let the larger disturbance grow by a few times.
constexpr double kChaoticDistance = 0.05;
// Of the classical buckling strain of a shell, at the most compressed link.
constexpr double kBuckling = 1.2;

double findLargestDistance(const Points& a, const Points& b) {
  double squared = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) squared = std::max(squared, (a[i] - b[i]).squaredNorm());
  return std::sqrt(squared);
}

bool isFirstOrder(IntegratorType type) {
  return type == IntegratorType::kImplicit || type == IntegratorType::kSymplecticEuler || type == IntegratorType::kExplicitEuler;
}

}  // namespace

ErrorEstimator::ErrorEstimator(const SceneParams& params, const RestSurface& full, const RestSurface& level)
    : damping_(params.material.damping), step_(params.integrator.time_step) {
  const Index n = static_cast<Index>(level.points.size()), num_full = static_cast<Index>(full.dense.positions.size());
  is_simplified_ = n < num_full;
  unresolved_ = 1.0 - static_cast<double>(n) / num_full;

  SceneParams coarse = params;
  coarse.accuracy = AccuracyParams{};
  coarse.accuracy.estimate = false;
  coarse.output.resample = false;
  const Index points = std::max(kCoarsestPoints, n / kRatio);
  RestSurface surface = buildCoarser(coarse, full, points);
  const double spacing = std::sqrt(surface.area / static_cast<double>(surface.points.size()));
  disturbance_ = (is_simplified_ ? kDisturbance : kDisturbanceOfFull) * spacing;
  chaotic_distance_ = kChaoticDistance * spacing;
  // Both are ascending lists of the full surface's points; a point that the level had to drop is followed by none.
  std::vector<char> usable;
  for (Index i : surface.dense_index) {
    const auto found = std::lower_bound(level.dense_index.begin(), level.dense_index.end(), i);
    const bool exists = found != level.dense_index.end() && *found == i;
    common_.push_back(exists ? static_cast<Index>(found - level.dense_index.begin()) : Index{-1});
    usable.push_back(exists ? 1 : 0);
  }
  refine_ = transfer::Transfer(level.points, level.normals, surface.points, usable, params.transfer);
  coarse_now_ = surface.points;
  shadow_ = std::make_unique<Simulation>(coarse, std::move(surface));
  twin_ = std::make_unique<Simulation>(coarse, buildCoarser(coarse, full, points));
  const IntegratorType type = params.integrator.type;
  if (isFirstOrder(type) || type == IntegratorType::kAuto) {
    // Auto leaves Verlet where it would need too many sub-steps.
    coarse.integrator.type = IntegratorType::kAuto;
    verlet_ = std::make_unique<Simulation>(coarse, buildCoarser(coarse, full, points));
  }
  findBucklingStrain(params, level);
  reset();
}

// A shell of mean curvature k buckles under the compressive force 2 k sqrt(D E h) per length [Timoshenko 1961, 11.1],
// in dents as long as a few (D / (E h k^2))^(1/4). Where the points lie farther apart than that, neither they nor their copies can
// show the dents that the full surface gets; so they watch for the strain.
void ErrorEstimator::findBucklingStrain(const SceneParams& params, const RestSurface& level) {
  if (!is_simplified_ || params.mass_spring.bending != model::Bending::kCurvature) return;
  const model::MaterialParams& m = params.material;
  const double stretching = m.young_modulus * m.thickness, rigidity = m.bendingRigidity();
  double curvature = 0.0;
  for (const auto& link : level.model->stretchLinks()) {
    rest_length_.push_back((level.points[link.second] - level.points[link.first]).norm());
    curvature += (level.normals[link.second] - level.normals[link.first]).norm() / rest_length_.back();
  }
  curvature /= static_cast<double>(rest_length_.size());
  const double spacing = std::sqrt(level.area / static_cast<double>(level.points.size()));
  if (!(std::pow(rigidity / stretching, 0.25) < std::sqrt(curvature) * spacing)) return;
  links_ = level.model->stretchLinks();
  buckling_strain_ = kBuckling * 2.0 * curvature * std::sqrt(rigidity / stretching);
}

bool ErrorEstimator::isBuckling(const Points& positions) const {
  for (std::size_t l = 0; l < links_.size(); ++l) {
    const double length = (positions[links_[l].second] - positions[links_[l].first]).norm();
    if (rest_length_[l] - length > buckling_strain_ * rest_length_[l]) return true;
  }
  return false;
}

void ErrorEstimator::reset() {
  forward([](Simulation& copy) { copy.reset(); });
  twin_->disturb(disturbance_);
  space_ = transfer_ = time_ = twin_distance_ = 0.0;
  steps_ = substeps_ = shadow_substeps_ = twin_substeps_ = 0;
  follows_verlet_ = is_lost_ = is_chaotic_ = has_buckled_ = false;
}

// False if one of them took no sound step or cannot be compared.
bool ErrorEstimator::stepCopies(IntegratorType type) {
  shadow_->setIntegrator(type);
  twin_->setIntegrator(type);
  twin_->setFineness(type == IntegratorType::kVerlet ? kFineness : 1);
  if (!shadow_->step().ok || !twin_->step().ok) return false;
  shadow_substeps_ += shadow_->lastSubsteps();
  twin_substeps_ += twin_->lastSubsteps();
  if (steps_++ == 0) follows_verlet_ = isFirstOrder(type);
  if (!follows_verlet_) return !isFirstOrder(type);
  return verlet_->step().ok && verlet_->lastIntegrator() == IntegratorType::kVerlet;
}

std::string ErrorEstimator::follow(const Points& positions, IntegratorType type, Index substeps) {
  if (is_lost_) return "";
  if (!stepCopies(type)) {
    is_lost_ = true;
    return std::string("the error cannot be estimated until the next reset: ") +
           (isFirstOrder(type) ? "Verlet's steps, which show what the integrator damps, do not fit max_substeps on a quarter of "
                                 "the points either"
                               : "a coarser copy could take no sound step");
  }
  substeps_ += substeps;

  // How far the simulation is from its shadow at the points of both, and what is lost where the others follow these.
  const Points& shadow = shadow_->state().positions;
  double apart = 0.0, lost = 0.0;
  if (is_simplified_) {
    for (std::size_t i = 0; i < shadow.size(); ++i) {
      if (common_[i] < 0) continue;
      coarse_now_[i] = positions[common_[i]];
      apart = std::max(apart, (coarse_now_[i] - shadow[i]).norm());
    }
    refine_.apply(coarse_now_, refined_);
    lost = findLargestDistance(refined_, positions);
  }

  // An oscillating difference passes through zero, the error need not: the largest so far counts while damping lets it last.
  const double lasting = type == IntegratorType::kStatic ? 0.0 : std::exp(-0.5 * damping_ * step_);
  const auto hold = [&](double& held, double now) { held = std::max(lasting * held, now); };
  hold(space_, kSpaceFactor * unresolved_ * apart);
  hold(transfer_, kSpaceFactor * unresolved_ * lost);
  if (type != IntegratorType::kStatic) hold(time_, measureTime(type));
  hold(twin_distance_, findLargestDistance(shadow, twin_->state().positions));

  const bool was_chaotic = is_chaotic_;
  is_chaotic_ = twin_distance_ > chaotic_distance_;
  if (!has_buckled_ && isBuckling(positions)) {
    has_buckled_ = true;
    return "the error cannot be estimated until the next reset: the surface is compressed beyond its buckling strain, and its "
           "points are too far apart to show the dents";
  }
  if (!is_chaotic_ || was_chaotic) return "";
  return "the error cannot be estimated: two runs on a quarter of the points that began " + std::to_string(1e3 * disturbance_) +
         " mm apart are " + std::to_string(1e3 * twin_distance_) + " mm apart, as where a surface buckles or crumples";
}

// Beside a first-order method, Verlet's has no error worth counting, and the method's own is as its sub-steps; else the errors of
// shadow and twin are as the squares of their sub-steps.
double ErrorEstimator::measureTime(IntegratorType type) const {
  const Points& shadow = shadow_->state().positions;
  const double own = static_cast<double>(substeps_), coarse = static_cast<double>(shadow_substeps_) / own,
               fine = static_cast<double>(twin_substeps_) / own;
  if (isFirstOrder(type)) return kFirstOrderFactor * coarse * findLargestDistance(shadow, verlet_->state().positions);
  return kVerletFactor * findLargestDistance(shadow, twin_->state().positions) / (1.0 / (coarse * coarse) - 1.0 / (fine * fine));
}

double ErrorEstimator::total() const {
  if (is_lost_ || is_chaotic_ || has_buckled_) return std::numeric_limits<double>::infinity();
  return space_ + transfer_ + time_;
}

}  // namespace deformable_surface::simulation
