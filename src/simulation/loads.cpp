#include "deformable_surface/simulation/loads.h"

#include "deformable_surface/base/notice.h"
#include "deformable_surface/base/parallel.h"
#include "deformable_surface/base/simd.h"
#include "deformable_surface/base/step_time.h"
#include "deformable_surface/base/value.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "renumber_points.h"

namespace deformable_surface::simulation {
namespace {

constexpr Index kBlock = 1024;  // points per task: about a microsecond of work
// Far more forces than scenes have. Ids that keep changing must not fill the memory.
constexpr std::size_t kMaxReported = 1000;
constexpr double kRounding = 1e-9;  // of a force: a smaller dropped part is rounding

DEFORMABLE_SURFACE_WIDE void addWeights(Index size, const double* mass, double x, double y, double z, double* force) {
#pragma GCC ivdep
  for (Index i = 0; i < size; ++i) {
    force[3 * i] += mass[i] * x;
    force[3 * i + 1] += mass[i] * y;
    force[3 * i + 2] += mass[i] * z;
  }
}

}  // namespace

void GravityLoad::addForces(double, const State&, Points& forces) const {
  parallelFor(static_cast<Index>(forces.size()), kBlock, [&](Index begin, Index end) {
    addWeights(end - begin, &masses_[begin], gravity.x(), gravity.y(), gravity.z(), forces[begin].data());
  });
}

double GravityLoad::potential(double, const State& state) const {
  return parallelSum(static_cast<Index>(masses_.size()), kBlock, [&](Index begin, Index end) {
    double sum = 0.0;
    for (Index i = begin; i < end; ++i) sum -= masses_[i] * gravity.dot(state.positions[i]);
    return sum;
  });
}

void PressureLoad::addForces(double, const State& state, Points& forces) const {
  if (isClosed(model_)) {
    model_.sides()->computeVolumeGradient(state, area_);
  } else {
    computeAreaVectors(model_, state, area_);
  }
  for (std::size_t i = 0; i < forces.size(); ++i) forces[i] += pressure_ * area_[i];
}

double PressureLoad::potential(double, const State& state) const {
  return isClosed(model_) ? -pressure_ * model_.sides()->enclosedVolume(state) : 0.0;
}

double PressureLoad::estimateWork(double, double, const State& before, const State& after) const {
  if (isClosed(model_)) return 0.0;
  const Index n = before.size();
  between_ = before;  // areas may be those of particles, which depend on orientations
  for (Index i = 0; i < n; ++i) between_.positions[i] = 0.5 * (before.positions[i] + after.positions[i]);
  for (std::size_t i = 0; i < before.orientations.size(); ++i)
    between_.orientations[i] = before.orientations[i].slerp(0.5, after.orientations[i]);
  const std::pair<const State*, double> places[] = {{&before, 1.0 / 6.0}, {&between_, 4.0 / 6.0}, {&after, 1.0 / 6.0}};
  double work = 0.0;
  for (const auto& [state, weight] : places) {
    computeAreaVectors(model_, *state, area_);
    for (Index i = 0; i < n; ++i) work += weight * pressure_ * area_[i].dot(after.positions[i] - before.positions[i]);
  }
  return work;
}

// With e_j the edge opposite to corner j, the force p/6 (x_1 - x_0) x (x_2 - x_0) on each corner changes by p/6 sum_j e_j x dx_j.
// Summed over all triangles, the skew part of the derivative remains only at boundaries. The volume of a closed surface is
// measured from the mean of its points, which is taken as fixed here: its motion matters only where the triangles do not quite
// close.
void PressureLoad::addIndefiniteStiffness(double, const State& state, BlockSparse& stiffness) const {
  if (!model_.sides()) return;
  const bool closed = isClosed(model_);
  Vec3 apex = Vec3::Zero();
  for (const Vec3& p : state.positions) apex += p / static_cast<double>(state.positions.size());
  for (const model::WeightedTriangle& t : model_.sides()->triangles()) {
    for (int i = 0; i < 3; ++i) {
      const int j = (i + 1) % 3, k = (i + 2) % 3;
      const Vec3 &a = state.positions[t.corner[i]], &b = state.positions[t.corner[j]], &c = state.positions[t.corner[k]];
      const Vec3 e = pressure_ * t.weight / 6.0 * (c - (closed ? apex : Vec3(0.5 * (a + b))));
      Mat3 block;
      block << 0.0, -e.z(), e.y(), e.z(), 0.0, -e.x(), -e.y(), e.x(), 0.0;
      stiffness.add(t.corner[i], t.corner[j], block);
    }
  }
}

void PressureLoad::addSkewProduct(double, const State& state, const Points& v, Points& product) const {
  if (!hasSkewStiffness()) return;
  for (const model::WeightedTriangle& t : model_.sides()->triangles()) {
    Vec3 edges[3], sum = Vec3::Zero(), turned = Vec3::Zero();
    for (int i = 0; i < 3; ++i) {
      edges[i] = state.positions[t.corner[(i + 2) % 3]] - state.positions[t.corner[(i + 1) % 3]];
      sum += v[t.corner[i]];
      turned += edges[i].cross(v[t.corner[i]]);
    }
    for (int i = 0; i < 3; ++i) product[t.corner[i]] -= pressure_ * t.weight / 12.0 * (edges[i].cross(sum) + turned);
  }
}

void DragLoad::addForces(double, const State& state, Points& forces) const {
  computeAreaVectors(model_, state, area_);
  for (std::size_t i = 0; i < forces.size(); ++i) {
    const double area = area_[i].norm();
    if (area > 0.0) forces[i] -= drag_ * state.velocities[i].dot(area_[i]) / area * area_[i];
  }
}

void DragLoad::addStiffness(double, const State& state, double step, BlockSparse& stiffness) const {
  if (!(step > 0.0)) return;
  computeAreaVectors(model_, state, area_);
  for (Index i = 0; i < state.size(); ++i) {
    const double area = area_[i].norm();
    stiffness.add(i, i, area > 0.0 ? Mat3(drag_ / (step * area) * area_[i] * area_[i].transpose()) : Mat3::Zero());
  }
}

void DragLoad::addRowBounds(double, const State& state, std::vector<double>&, std::vector<double>& damping) const {
  computeAreaVectors(model_, state, area_);
  for (Index i = 0; i < state.size(); ++i) damping[i] += drag_ * area_[i].norm();
}

void AnchorLoad::addForces(double, const State& state, Points& forces) const {
  for (const Anchor& a : anchors_) forces[a.point] += a.stiffness * (a.target - state.positions[a.point]);
}

double AnchorLoad::potential(double, const State& state) const {
  double sum = 0.0;
  for (const Anchor& a : anchors_) sum += 0.5 * a.stiffness * (a.target - state.positions[a.point]).squaredNorm();
  return sum;
}

void AnchorLoad::addStiffness(double, const State&, double, BlockSparse& stiffness) const {
  for (const Anchor& a : anchors_) stiffness.add(a.point, a.point, a.stiffness * Mat3::Identity());
}

void AnchorLoad::addRowBounds(double, const State&, std::vector<double>& stiffness, std::vector<double>&) const {
  for (const Anchor& a : anchors_) stiffness[a.point] += a.stiffness;
}

bool actsInAStep(const ForceParams& force, double time_step, double duration) {
  // Rounding of decimal fractions must not lose a step, as in Simulation::step().
  const double rounding = kTimeRounding * time_step;
  const double first = std::max(0.0, std::ceil((force.start - rounding) / time_step)) * time_step;
  return first + rounding < duration && first + rounding < force.end;
}

void AnchorLoad::renumber(const std::vector<Index>& new_index) {
  for (Anchor& anchor : anchors_) anchor.point = new_index[anchor.point];
  anchors_.erase(std::remove_if(anchors_.begin(), anchors_.end(), [](const Anchor& a) { return a.point < 0; }), anchors_.end());
}

void NamedForces::renumber(const std::vector<Index>& new_index) {
  for (Named& force : forces_) {
    renumberPoints(new_index, force.points, force.shares);
    const double sum = std::accumulate(force.shares.begin(), force.shares.end(), 0.0);
    for (double& share : force.shares) share /= sum;
  }
}

void NamedForces::set(const ForceParams& force) {
  remove(force.id);
  if (force.force.isZero(0.0)) return;
  const auto place = std::lower_bound(forces_.begin(), forces_.end(), force.id,
                                      [](const Named& f, const std::string& id) { return f.params.id < id; });
  Named named;
  named.params = force;
  forces_.insert(place, std::move(named));
}

void NamedForces::remove(const std::string& id) {
  forces_.erase(std::remove_if(forces_.begin(), forces_.end(), [&](const Named& f) { return f.params.id == id; }), forces_.end());
}

NamedForces::Update NamedForces::update(double time, const State& state, const std::vector<char>& pinned) {
  const auto isOver = [&](const Named& f) { return !(time < f.params.end); };
  Update update;
  for (const Named& f : forces_)
    if (isOver(f)) update.points.insert(update.points.end(), f.points.begin(), f.points.end());
  const auto over = std::remove_if(forces_.begin(), forces_.end(), isOver);
  update.changed = over != forces_.end();
  forces_.erase(over, forces_.end());
  for (Named& f : forces_) {
    if (f.started || time < f.params.start) continue;
    if (state.size() == 0) {
      report(f.params.id, "there is no simulation point that it could act on; it begins when there is one", update.notice);
      continue;
    }
    f.started = update.changed = true;
    if (load_points_ && f.params.radius > 0.0) takeCarriers(state, f);
    if (f.points.empty()) takeNearestOrWithin(state, f);
    update.points.insert(update.points.end(), f.points.begin(), f.points.end());

    const std::string problem = findProblem(f, state, pinned);
    if (problem.empty()) {
      reported_.erase(f.params.id);
    } else {
      report(f.params.id, problem, update.notice);
    }
  }
  return update;
}

bool NamedForces::needLoadPoints() const {
  return std::any_of(forces_.begin(), forces_.end(), [](const Named& f) { return f.params.radius > 0.0; });
}

// The simulation points within the radius, else the nearest one.
void NamedForces::takeNearestOrWithin(const State& state, Named& f) const {
  Index nearest = 0;
  for (Index i = 0; i < state.size(); ++i) {
    const double distance = (state.positions[i] - f.params.point).squaredNorm();
    if (distance < (state.positions[nearest] - f.params.point).squaredNorm()) nearest = i;
    if (f.params.radius > 0.0 && distance <= f.params.radius * f.params.radius) f.points.push_back(i);
  }
  if (f.points.empty()) f.points.push_back(nearest);
  double total = 0.0;
  for (Index i : f.points) total += masses_[i];
  for (Index i : f.points) f.shares.push_back(masses_[i] / total);
}

// The points of the cloud within the radius. None: the force is left as it is.
void NamedForces::takeCarriers(const State& state, Named& f) const {
  const transfer::SampledPoints& between = *load_points_->between;
  const Points& x = state.positions;
  const double radius = f.params.radius;
  double total = 0.0;
  std::vector<Named::Carrier> carriers;
  const auto take = [&](Index point, Index cell, double share) {
    carriers.push_back({point, masses_[cell] * share});
    total += masses_[cell] * share;
  };
  const auto isWithin = [&](const Vec3& place) { return (place - f.params.point).norm() <= radius; };
  for (Index i = 0; i < state.size(); ++i) {
    const double distance = (x[i] - f.params.point).norm();
    if (distance > radius + between.findReach(i, x)) continue;
    const std::size_t first = carriers.size();
    const double total_before = total;
    Index num_left_out = distance <= radius ? 0 : 1;
    if (num_left_out == 0) take(i, i, load_points_->own_share[i]);
    for (Index s = between.begin(i); s < between.end(i); ++s) {
      if (isWithin(between.place(s, x)))
        take(state.size() + s, i, load_points_->share[s]);
      else
        ++num_left_out;
    }
    if (num_left_out > 0) continue;
    // A cell that is loaded as a whole acts where its mass does.
    carriers.resize(first);
    total = total_before;
    take(i, i, 1.0);
  }
  if (!(total > 0.0)) return;
  for (Named::Carrier& carrier : carriers) carrier.share /= total;
  f.carriers = std::make_shared<const std::vector<Named::Carrier>>(std::move(carriers));
  spreadCarriers(f);
}

// On the simulation points: the transpose of the rows.
void NamedForces::spreadCarriers(Named& f) const {
  const Index m = static_cast<Index>(masses_.size());
  const transfer::SampledPoints& between = *load_points_->between;
  std::vector<double> shares(m, 0.0);
  for (const auto& [point, share] : *f.carriers) {
    const Index s = point - m;
    if (s < 0) {
      shares[point] += share;
    } else if (!is_severed_.empty() && is_severed_[s]) {
      shares[between.cellOf(s)] += share;
    } else {
      between.visitWeights(s, [&, share = share](Index j, double w) { shares[j] += share * w; });
    }
  }
  // The rows are stored in single precision.
  const double total = std::accumulate(shares.begin(), shares.end(), 0.0);
  f.points.clear();
  f.shares.clear();
  for (Index i = 0; i < m; ++i) {
    if (shares[i] == 0.0) continue;
    f.points.push_back(i);
    f.shares.push_back(shares[i] / total);
  }
}

void NamedForces::followCut() {
  for (Named& f : forces_)
    if (f.carriers) spreadCarriers(f);
}

void NamedForces::report(const std::string& id, const std::string& problem, std::string& notice) {
  if (reported_.size() >= kMaxReported) reported_.clear();
  if (reported_.insert(id).second) notice += (notice.empty() ? "force " : "; force ") + quote(id) + ": " + problem;
}

std::string NamedForces::findProblem(const Named& force, const State& state, const std::vector<char>& pinned) const {
  std::string problem = findMisplacement(force, state, pinned);
  const double dropped = std::abs(dropped_.dot(force.params.force));
  if (dropped > kRounding * force.params.force.norm())
    appendNotice(problem, formatShort(dropped) + " N of its " + formatShort(force.params.force.norm()) +
                              " N are perpendicular to the plane in which this planar solid moves, and are ignored");
  return problem;
}

std::string NamedForces::findMisplacement(const Named& force, const State& state, const std::vector<char>& pinned) {
  const bool is_held = std::all_of(force.points.begin(), force.points.end(), [&](Index i) { return pinned[i] != 0; });
  const double distance = (state.positions[force.points[0]] - force.params.point).norm();
  if (!force.carriers && force.params.radius > 0.0 && distance > force.params.radius) {
    return "no simulation point lies within its radius of " + formatReal(force.params.radius) +
           " m; it acts on the nearest one, " + formatShort(distance) + " m from its point" +
           (is_held ? ", which is pinned" : "");
  }
  if (!is_held) return "";
  return force.points.size() > 1
             ? "all " + std::to_string(force.points.size()) + " simulation points that it acts on are pinned; it moves nothing"
             : "the simulation point that it acts on is pinned; it moves nothing";
}

void NamedForces::addForces(double, const State&, Points& forces) const {
  for (const Named& f : forces_)
    for (std::size_t k = 0; k < f.points.size(); ++k) forces[f.points[k]] += f.shares[k] * f.params.force;
}

double NamedForces::potential(double, const State& state) const {
  double sum = 0.0;
  for (const Named& f : forces_)
    for (std::size_t k = 0; k < f.points.size(); ++k) sum -= f.shares[k] * f.params.force.dot(state.positions[f.points[k]]);
  return sum;
}

std::vector<std::pair<Vec3, Vec3>> NamedForces::active(const State& state) const {
  std::vector<std::pair<Vec3, Vec3>> list;
  for (const Named& f : forces_) {
    if (f.points.empty()) continue;  // not begun, or all of its points are gone
    Vec3 center = Vec3::Zero();
    for (std::size_t k = 0; k < f.points.size(); ++k) center += f.shares[k] * state.positions[f.points[k]];
    list.emplace_back(center, f.params.force);
  }
  return list;
}

}  // namespace deformable_surface::simulation
