#include "error_estimator.h"

#include "deformable_surface/base/error.h"
#include "deformable_surface/base/interrupt.h"
#include "deformable_surface/base/notice.h"
#include "deformable_surface/base/parallel.h"
#include "deformable_surface/base/value.h"
#include "deformable_surface/cloud/kd_tree.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
#include <tuple>
#include <utility>

#include "spacing.h"
#include "step_work.h"

namespace deformable_surface::simulation {
namespace {

using solve::IntegratorType;

constexpr Index kFineness = 2;  // of the copy in finer sub-steps: the difference is then a known share of the error
// At least, even if the copy happened to take few sub-steps more than the other, as in the first steps near a tool.
constexpr double kLeastFineness = 1.5;

// Fitted on scenes that benchmark/calibration_section.cpp draws with other seeds; see docs/accuracy_control.md.
constexpr double kSolidFactor = 1.6;     // of distances between copies of solids; there is none for mass-spring surfaces
constexpr double kParticleFactor = 2.5;  // see docs/oriented_particles.md
constexpr double kRegionFactor = 1.3;    // of the largest distance in a region
constexpr double kDepthFactor = 1.6;     // of points in tools
constexpr double kVerletFactor = 3.0, kDampingFactor = 2.0;

// With fewer simulation points estimates were below errors. The same holds for more than this share of the input's points, except
// all: what is left out then hardly shows in copies with a quarter of the points.
constexpr Index kFewestCalibrated = 128;
constexpr double kMostCalibrated = 0.5;

// The twin's disturbance over the spacing of the copies: about the size of the errors that the simulation has anyway, by
// simplification or, where all points are simulated, by time stepping.
constexpr double kDisturbance = 1e-3, kDisturbanceOfFull = 1e-6;
// Distance of the twin, over the spacing, that ends the estimate. In smooth motions the disturbance grows by a few times.
constexpr double kChaoticDistance = 0.05;
// The same for a twin whose distance has other causes as well: the effect of halved steps of a damping method or, in a body,
// waves shorter than a few sub-steps after a sudden force.
constexpr double kChaoticDistanceOfOthers = 0.5;
constexpr Index kFewPoints = 1024;  // of a copy: its loops have four blocks at most
// Work of the copies over that of the simulation, from which a notice tells so, and from which the estimate ends: most copies
// take 0.2 to 0.6. What a few steps take above it does not count: so many points times sub-steps, less than a second.
constexpr double kCostly = 2.0, kTooCostly = 10.0, kFreeWork = 2e6;
// Of newtonWork(): what an iteration took beside sub-steps of Verlet, on a skirt that falls on a plane and on two planar bars.
constexpr double kNewtonShare = 0.2;
// Verlet's sub-steps of the copies are never too many if those of the simulation were not: the largest max_substeps.
constexpr Index kAnyNumber = 1000000000;

// In points times sub-steps of Verlet.
double findWork(const solve::SolveReport& taken, const Dynamics& dynamics) {
  const Index points = dynamics.state().size();
  return workOf(taken, points, kNewtonShare * newtonWork(points));
}

// Methods with numerical damping; Verlet's error is negligible beside theirs: first-order methods, and the implicit
// one, whose second order only shows in motions that it resolves.
bool isDamping(IntegratorType type) {
  return type == IntegratorType::kImplicit || type == IntegratorType::kSymplecticEuler || type == IntegratorType::kExplicitEuler;
}

// Whether its sub-steps are those that its method chose. Notices do not tell: most are given once, and a fork or a restored run
// gives them again.
bool isAsMeant(const Dynamics::Outcome& taken) {
  return taken.retried.kind == solve::StepFailure::Kind::kNone && taken.report.fallbacks == 0;
}

// The simulation points that points of the cloud in the target's regions follow, ascending.
std::vector<Index> findFollowed(const RestSurface& level, const SceneParams& params) {
  const cloud::KdTree tree(level.points);
  std::vector<char> is_followed(level.points.size(), 0);
  std::vector<cloud::Neighbor> nearest;
  for (const Vec3& p : level.dense.positions) {
    if (!isInTarget(params.accuracy, p)) continue;
    tree.nearest(p, params.transfer.k, nearest);
    for (const cloud::Neighbor& neighbor : nearest) is_followed[neighbor.index] = 1;
  }
  std::vector<Index> followed;
  for (std::size_t i = 0; i < is_followed.size(); ++i)
    if (is_followed[i] != 0) followed.push_back(static_cast<Index>(i));
  return followed;
}

}  // namespace

template <class Visit>
void ErrorEstimator::forEachCopy(const Visit& visit) {
  for (Dynamics* copy : {shadow_.get(), twin_.get(), verlet_.get()})
    if (copy) visit(*copy);
}

ErrorEstimator::ErrorEstimator(const Dynamics& dynamics) {
  step_ = dynamics.params().integrator.time_step;
  const SceneParams& params = dynamics.params();
  const RestSurface& level = dynamics.rest();
  const Index num_full = static_cast<Index>(level.dense.positions.size());
  SceneParams coarse = params;
  coarse.accuracy = AccuracyParams{};
  coarse.accuracy.estimate = false;
  coarse.output.resample = coarse.output.error = false;
  if (!dynamics.loads().self_contact) coarse.contact.self = false;
  CoarserLevel copies = dynamics.kind().makeCopies(coarse, level);
  const RestSurface& surface = copies.surface;
  common_ = std::move(copies.common);
  refine_ = std::move(copies.refine);
  is_body_ = copies.is_body;
  is_simplified_ = copies.is_simplified;
  unresolved_ = copies.unresolved;
  is_calibrated_ =
      static_cast<Index>(level.points.size()) >= kFewestCalibrated && (!is_simplified_ || 1.0 - unresolved_ <= kMostCalibrated);
  spacing_ = findSpacing(surface.area, surface.points.size());
  disturbance_ = (is_simplified_ || is_body_ ? kDisturbance : kDisturbanceOfFull) * spacing_;
  level_spacing_ = findSpacing(level.area, level.points.size());
  has_hinged_pins_ = level.has_hinged_pins;
  is_local_ = (params.output.error || !params.accuracy.regions.empty()) && (is_simplified_ || is_body_);
  if (is_local_ && !params.accuracy.regions.empty()) watched_ = findFollowed(level, params);
  coarse_now_ = surface.points;
  const IntegratorType type = params.integrator.type;
  const Index max_substeps = coarse.integrator.max_substeps;
  // A copy can be far stiffer than the simulation if few points show a rough surface: auto then leaves Verlet.
  if (type != IntegratorType::kAuto) coarse.integrator.max_substeps = kAnyNumber;
  twin_ = std::make_unique<Dynamics>(coarse, copyCoarser(coarse, surface));
  shadow_ = std::make_unique<Dynamics>(coarse, copyCoarser(coarse, surface));
  if (isDamping(type) || type == IntegratorType::kAuto) {
    // Auto leaves Verlet where it would need too many sub-steps.
    coarse.integrator.type = IntegratorType::kAuto;
    coarse.integrator.max_substeps = max_substeps;
    verlet_ = std::make_unique<Dynamics>(coarse, copyCoarser(coarse, surface));
  }
  if (dynamics.kind().mayDent(params)) {
    if (const model::Links* links = dynamics.model().links()) links->refreshDisplay(dynamics.state());
    dents_ = DentWatch(params.material, level.points, trianglesOf(dynamics.model()), level.area, num_full);
  }
  reset();
}

ErrorEstimator::ErrorEstimator(const ErrorEstimator& other)
    : CopiedEstimate(other),
      shadow_(other.shadow_->fork()),
      twin_(other.twin_->fork()),
      verlet_(other.verlet_ ? other.verlet_->fork() : nullptr),
      depth_(other.depth_ ? std::make_unique<ToolDepth>(*other.depth_) : nullptr) {}

void ErrorEstimator::reset() {
  forEachCopy([](Dynamics& copy) { copy.reset(); });
  twin_->disturb(disturbance_);
  dents_.reset();
  dents_.softenMembrane(shadow_->membraneShare());
  seen_ = Seen();
}

void ErrorEstimator::softenMembrane(double share) {
  forEachCopy([&](Dynamics& copy) { copy.softenMembrane(share); });
  reset();
}

void ErrorEstimator::stiffenMembrane() {
  forEachCopy([](Dynamics& copy) { copy.stiffenMembrane(); });
  dents_.softenMembrane(1.0);
}

std::shared_ptr<const ErrorEstimator::Memory> ErrorEstimator::memory() const {
  auto memory = std::make_shared<Memory>();
  memory->seen = seen_;
  memory->dents = dents_.growth();
  memory->shadow = shadow_->save();
  memory->twin = twin_->save();
  if (verlet_) memory->verlet = verlet_->save();
  return memory;
}

std::size_t ErrorEstimator::Memory::bytes() const {
  return dents.size() * sizeof(double) + seen.apart.size() * sizeof(float) + shadow.bytes() + twin.bytes() +
         (verlet ? verlet->bytes() : 0);
}

void ErrorEstimator::setMemory(const Memory& saved) {
  seen_ = saved.seen;
  dents_.setGrowth(saved.dents);
  shadow_->restore(saved.shadow);
  twin_->restore(saved.twin);
  if (verlet_) verlet_->restore(*saved.verlet);
  dents_.softenMembrane(shadow_->membraneShare());
}

void ErrorEstimator::apply(const Command& command) {
  if (const auto* given = std::get_if<command::SetState>(&command)) return setState(given->state);
  if (std::holds_alternative<command::EditParticles>(command) || std::holds_alternative<command::GrowSurface>(command))
    return lose();
  forEachCopy([&](Dynamics& copy) { copy.apply(command); });
}

void ErrorEstimator::setInterrupt(const std::atomic<bool>* interrupt) {
  forEachCopy([&](Dynamics& copy) { copy.setInterrupt(interrupt); });
}

void ErrorEstimator::adoptArrivals(const ContactLoad& contact) {
  forEachCopy([&](Dynamics& copy) { copy.adoptArrivals(contact); });
}

void ErrorEstimator::pass() {
  forEachCopy([](Dynamics& copy) { copy.passStep(); });
}

void ErrorEstimator::setState(const model::State& state) {
  if (seen_.is_lost) return;
  if (common_.empty() || std::count(common_.begin(), common_.end(), Index{-1}) > 0) return lose();
  forEachCopy([&](Dynamics& copy) {
    model::State coarse;
    for (std::size_t i = 0; i < common_.size(); ++i) {
      coarse.positions.push_back(state.positions[common_[i]]);
      coarse.velocities.push_back(copy.pinned()[i] ? Vec3::Zero().eval() : state.velocities[common_[i]]);
      if (!state.plastic.empty()) coarse.plastic.push_back(state.plastic[common_[i]]);
    }
    coarse.dissipated = state.dissipated;
    copy.apply(Command(command::SetState{std::move(coarse)}));
  });
  twin_->disturb(disturbance_);
  dents_.reset();
  const bool followed_verlet = seen_.follows_verlet;
  const std::uint64_t steps = seen_.steps;
  seen_ = Seen();
  seen_.steps = steps;
  seen_.follows_verlet = followed_verlet;
}

// Verlet steps of a copy and of the twin, beside those of a damping method. If one of these leaves Verlet, the twin continues
// from the shadow; also if the simulation itself takes Verlet steps.
void ErrorEstimator::followVerlet(IntegratorType type) {
  twin_->setIntegrator(IntegratorType::kAuto);
  twin_->setFineness(1);
  seen_.follows_verlet = isDamping(type);
  if (seen_.follows_verlet) {
    const auto [verlet, twin] = stepBoth(*verlet_, *twin_);
    const auto isVerlet = [](const Dynamics& copy) { return copy.lastIntegrator() == IntegratorType::kVerlet; };
    if (verlet.ok && twin.ok && isVerlet(*verlet_) && isVerlet(*twin_)) return;
    seen_.follows_verlet = false;
    twin_->undoStep();
  }
  twin_left_ = twin_->save();
  twin_->restore(shadow_->save());
  twin_->disturb(disturbance_);
}

// Returns why the estimate ends with this step; empty: it does not.
std::string ErrorEstimator::stepCopies(IntegratorType type, Index substeps) {
  if (seen_.steps++ == 0) seen_.follows_verlet = verlet_ && isDamping(type);
  if (seen_.follows_verlet) followVerlet(type);
  // If Verlet steps fail, auto repeats them implicitly.
  const bool is_verlet = type == IntegratorType::kVerlet;
  shadow_->setIntegrator(is_verlet ? IntegratorType::kAuto : type);
  Dynamics::Outcome shadow, twin;
  seen_.is_halved = isDamping(type) && !seen_.follows_verlet;
  if (seen_.follows_verlet) {
    stepped_.push_back(shadow_.get());
    shadow = shadow_->step();
  } else {
    twin_->setIntegrator(is_verlet ? IntegratorType::kAuto : type);
    twin_->setFineness(is_verlet || seen_.is_halved ? kFineness : 1);
    std::tie(shadow, twin) = stepBoth(*shadow_, *twin_);
  }
  const bool both_moved = shadow_->lastSubsteps() > 0 && twin_->lastSubsteps() > 0;
  if (isAsMeant(shadow) && isAsMeant(twin) && both_moved) {
    seen_.substeps += substeps;
    seen_.shadow_substeps += shadow_->lastSubsteps();
    seen_.twin_substeps += twin_->lastSubsteps();
  }
  if (!shadow.ok || !twin.ok) return "a step of a coarser copy failed";
  return shadow.leaves_copies || twin.leaves_copies ? "bonds of a coarser copy broke" : "";
}

// Counts the work of the copies beside Verlet's steps of the simulation: a surface of few points can be far stiffer. Equilibria
// are few. Beside damping methods integrator.max_substeps limits it, and their steps take next to no iterations near rest, unlike
// the twin's.
void ErrorEstimator::followWork(const Dynamics& level, const solve::SolveReport& taken) {
  if (level.lastIntegrator() != IntegratorType::kVerlet) return;
  const double own = std::max(1.0, findWork(taken, level));
  const auto add = [&](double times, double& excess) { excess = std::max(0.0, excess + copies_work_ - times * own); };
  add(kCostly, seen_.excess);
  add(kTooCostly, seen_.far_excess);
  times_own_ = copies_work_ / own;
}

// Returns a sentence, once, when the copies take more work than the simulation.
std::string ErrorEstimator::describeCost() {
  if (seen_.is_costly || seen_.excess <= kFreeWork) return "";
  seen_.is_costly = true;
  return "the error estimate takes " + formatShort(times_own_) +
         " times the work of the simulation, as its coarser copies are stiffer; accuracy.estimate: false saves it";
}

// In steps dents are watched as they grow; in equilibria the load counts; forces that press in count in both.
Buckling ErrorEstimator::judgeBuckling(const Dynamics& level) {
  const Points& positions = level.state().positions;
  Buckling worst = level.lastIntegrator() == IntegratorType::kStatic ? dents_.judgeEquilibrium(positions)
                                                                     : dents_.followStep(positions, step_);
  for (const NamedForces::Named& force : level.loads().forces.all())
    if (force.started)
      worst = std::max(worst, dents_.judgeForce(force.points, force.shares, force.params.force.norm(), force.params.radius));
  return worst;
}

// Returns a sentence when a tool is first in the surface without a force on it.
std::string ErrorEstimator::followTools(const Dynamics& level, double lasting) {
  const bool has_tools = !level.loads().contact.isEmpty();
  if (has_tools && !depth_) depth_ = std::make_unique<ToolDepth>(level);
  seen_.depth = std::max(lasting * seen_.depth, has_tools ? depth_->measure(level) : 0.0);
  const auto [unfelt, is_needle] =
      has_tools && !seen_.has_unfelt ? depth_->findUnfelt(level, level_spacing_) : ToolDepth::Unfelt();
  if (!unfelt) {
    const std::string& passed = level.loads().contact.goneThrough();
    if (seen_.has_unfelt || passed.empty()) return "";
    seen_.has_unfelt = true;
    return "error_estimate is no bound until the next reset: tool " + quote(passed) + " has passed through the surface";
  }
  seen_.has_unfelt = true;
  return "error_estimate is no bound until the next reset: tool " + quote(unfelt->id) +
         (is_needle ? " is narrower than one and a half spacings of the cloud, and may pass between its points or hang on one"
                    : " is in the surface, between the points that touch tools");
}

// Returns a sentence when parts of a body first touch: its copies' parts do so at other times and places.
std::string ErrorEstimator::followMeeting(const Dynamics& level) {
  SelfContactLoads* const self = level.loads().self_contact.get();
  if (!is_body_ || seen_.has_met || !self || !self->mayAct()) return "";
  if (self->contact.countTouching(level.state().positions) == 0) return "";
  seen_.has_met = true;
  return "error_estimate is far above the error until the next reset: parts of the body have met, and those of its coarser "
         "copies meet at other times";
}

// Of few points two steps at once take less time than each on several threads.
std::pair<Dynamics::Outcome, Dynamics::Outcome> ErrorEstimator::stepBoth(Dynamics& a, Dynamics& b) {
  stepped_.insert(stepped_.end(), {&a, &b});
  Dynamics::Outcome of_a, of_b;
  const auto step = [&](Index copy) { copy == 0 ? of_a = a.step() : of_b = b.step(); };
  if (a.state().size() > kFewPoints) {
    step(0);
    step(1);
  } else {
    // An interrupt ends the copies' steps, not the loop: both copies must be told of it.
    static const std::atomic<bool> never{false};
    const std::atomic<bool>* const interrupt = currentInterrupt();
    std::optional<InterruptScope> whole;
    if (interrupt) whole.emplace(never);
    parallelFor(2, 1, [&](Index copy, Index) {
      std::optional<InterruptScope> scope;
      if (interrupt) scope.emplace(*interrupt);
      step(copy);
    });
  }
  copies_work_ = findWork(of_a.report, a) + findWork(of_b.report, b);
  return {std::move(of_a), std::move(of_b)};
}

std::string ErrorEstimator::follow(const Dynamics& level, const solve::SolveReport& taken, bool ends) {
  seen_before_ = seen_;
  seen_.is_lost = seen_.is_lost || ends;
  dents_before_ = dents_.growth();
  stepped_.clear();
  twin_left_.reset();
  std::string said = followStep(level, taken);
  if (!(level.interrupt() && *level.interrupt())) return said;
  for (Dynamics* copy : stepped_)
    if (copy != twin_.get() || !twin_left_) copy->undoStep();
  if (twin_left_) twin_->restore(*twin_left_);
  seen_ = seen_before_;
  dents_.setGrowth(dents_before_);
  throw Interrupted();
}

std::string ErrorEstimator::followStep(const Dynamics& level, const solve::SolveReport& taken) {
  const Points& positions = level.state().positions;
  const IntegratorType type = level.lastIntegrator();
  const Buckling buckling = seen_.has_dented ? Buckling::kLikely : judgeBuckling(level);
  seen_.may_buckle = seen_.may_buckle || buckling != Buckling::kUnlikely;
  if (seen_.is_lost) return "";
  // Searches by particles end far apart where there is more than one equilibrium, also without dents.
  seen_.may_end_elsewhere = common_.empty() && type == IntegratorType::kStatic && seen_.may_buckle;
  const bool was_halved = seen_.is_halved;
  std::string why = stepCopies(type, level.lastSubsteps());
  followWork(level, taken);
  if (why.empty() && seen_.far_excess > kFreeWork)
    why = "its coarser copies are far stiffer than the simulation, and their last step took " + formatShort(times_own_) +
          " times its work; another simplification.target_points may have an estimate";
  if (!why.empty()) {
    seen_.is_lost = true;
    return "the error cannot be estimated until the next reset: " + why;
  }

  // Distance of the simulation from its shadow at their common points, and the loss at the points that follow these; or at all
  // points from where they would follow the shadow.
  const Points& shadow = shadow_->state().positions;
  double apart = 0.0, lost = 0.0;
  if (is_simplified_ && common_.empty()) {
    refine_(shadow, refined_);
    apart = findLargestDistance(refined_, positions);
  } else if (is_simplified_ || is_body_) {
    for (std::size_t i = 0; i < shadow.size(); ++i) {
      if (common_[i] < 0) continue;
      coarse_now_[i] = positions[common_[i]];
      apart = std::max(apart, (coarse_now_[i] - shadow[i]).norm());
    }
    refine_(coarse_now_, refined_);
    lost = findLargestDistance(refined_, positions);
  }

  // An oscillating difference passes through zero, unlike the error: the largest value so far counts as long as damping allows.
  const double lasting = type == IntegratorType::kStatic ? 0.0 : std::exp(-0.5 * level.system().damping() * step_);
  const auto hold = [&](double& held, double now) { held = std::max(lasting * held, now); };
  const double factor = is_body_ ? kSolidFactor : common_.empty() ? kParticleFactor : 1.0;
  hold(seen_.space, factor * (is_body_ ? 1.0 : unresolved_) * apart);
  hold(seen_.transfer, factor * unresolved_ * lost);
  if (type != IntegratorType::kStatic) hold(seen_.time, measureTime(type));
  if (is_local_) followPlaces(level, lasting);
  std::string notice = followTools(level, lasting);
  appendNotice(notice, followMeeting(level));
  appendNotice(notice, describeCost());
  hold(seen_.twin_distance, findLargestDistance(besideTwin().state().positions, twin_->state().positions));

  const bool was_chaotic = seen_.is_chaotic;
  const double far = seen_.is_halved || is_body_ ? kChaoticDistanceOfOthers : kChaoticDistance;
  seen_.is_chaotic = seen_.twin_distance > far * spacing_;
  seen_.may_buckle = seen_.may_buckle || seen_.is_chaotic;
  if (!seen_.has_dented && buckling == Buckling::kLikely) {
    seen_.has_dented = true;
    appendNotice(notice,
                 "error_estimate is no bound until the next reset: compressed, or loaded by a force, as the surface is, it may "
                 "buckle in dents too short for its points to show");
    return notice;
  }
  if (!seen_.is_chaotic && seen_.is_halved && !was_halved)
    appendNotice(
        notice,
        "error_time is estimated against steps half as long from now on, not against Verlet's, which would need more than "
        "integrator.max_substeps");
  if (!seen_.is_chaotic || was_chaotic) return notice;
  appendNotice(notice, "error_estimate is no bound: two runs on fewer points that began " + formatShort(1e3 * disturbance_) +
                           " mm apart are " + formatShort(1e3 * seen_.twin_distance) +
                           " mm apart, as where a surface buckles or crumples");
  return notice;
}

// Held points are where they should be.
void ErrorEstimator::followPlaces(const Dynamics& level, double lasting) {
  const Points& positions = level.state().positions;
  refine_(shadow_->state().positions, refined_);
  seen_.apart.resize(positions.size(), 0.0f);
  const double share = is_body_ ? 1.0 : unresolved_;
  for (std::size_t i = 0; i < positions.size(); ++i) {
    const double now = level.held()[i] ? 0.0 : share * (refined_[i] - positions[i]).norm();
    seen_.apart[i] = static_cast<float>(std::max(lasting * seen_.apart[i], now));
  }
}

double ErrorEstimator::searchDisturbance() const { return kDisturbance * level_spacing_; }

std::string ErrorEstimator::learnSecondSearch(double distance) {
  seen_.has_searched = true;
  seen_.has_others = distance > kChaoticDistance * level_spacing_;
  if (!seen_.has_others) return "";
  seen_.others = distance;
  seen_.may_buckle = true;
  const std::string end = std::isfinite(distance) ? "ended " + formatShort(1e3 * distance) + " mm away" : "found no equilibrium";
  return "error_estimate is no bound until the next reset: a search from positions " + formatShort(1e3 * searchDisturbance()) +
         " mm away " + end + ", as where a surface has more than one";
}

// Beside a damping method Verlet's error is negligible, and the method's own is proportional to its sub-steps. If Verlet does
// not fit, half of the error is the difference between the method and itself with halved steps. Else errors of shadow and twin
// are proportional to the squares of their sub-steps.
double ErrorEstimator::measureTime(IntegratorType type) const {
  const Points& shadow = shadow_->state().positions;
  const double own = static_cast<double>(std::max<std::uint64_t>(1, seen_.substeps));
  const double coarse = seen_.substeps > 0 ? static_cast<double>(seen_.shadow_substeps) / own : 1.0;
  if (isDamping(type)) {
    const double error = seen_.is_halved ? 2.0 * findLargestDistance(shadow, twin_->state().positions)
                                         : findLargestDistance(shadow, verlet_->state().positions);
    return kDampingFactor * coarse * error;
  }
  const double taken = seen_.substeps > 0 ? static_cast<double>(seen_.twin_substeps) / own : static_cast<double>(kFineness);
  const double fine = std::max(taken, kLeastFineness * coarse);
  return kVerletFactor * findLargestDistance(shadow, twin_->state().positions) / (1.0 / (coarse * coarse) - 1.0 / (fine * fine));
}

bool ErrorEstimator::isBounded() const {
  return !(seen_.is_lost || has_hinged_pins_ || seen_.is_chaotic || seen_.has_unfelt || seen_.has_dented || seen_.has_others ||
           seen_.is_unbalanced || seen_.may_end_elsewhere);
}

// Copies that share what is wrong with the simulation say nothing: pins that hinge in both, and a search of all points that ended
// out of balance, which no copy is compared with.
double ErrorEstimator::total() const {
  const bool is_unknown = seen_.is_lost || has_hinged_pins_ || (seen_.is_unbalanced && !is_simplified_ && !is_body_);
  if (is_unknown) return std::numeric_limits<double>::infinity();
  return std::max(boundFactor() * (seen_.space + seen_.transfer + seen_.time + seen_.others), kDepthFactor * seen_.depth);
}

double ErrorEstimator::inRegions() const {
  const double all = total();
  if (watched_.empty() || !std::isfinite(all)) return all;
  float apart = 0.0f;
  if (!seen_.apart.empty())
    for (const Index i : watched_) apart = std::max(apart, seen_.apart[i]);
  return std::min(all, std::max(boundFactor() * (kRegionFactor * apart + seen_.time + seen_.others), kDepthFactor * seen_.depth));
}

}  // namespace deformable_surface::simulation
