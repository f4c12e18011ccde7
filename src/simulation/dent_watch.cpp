#include "dent_watch.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "spacing.h"

namespace deformable_surface::simulation {
namespace {

// Range of wave lengths, in spacings. Copies with a quarter of the points show waves longer than eight spacings of the
// simulation points, and the full cloud none shorter than four of its own. Of folds that the points show in part, the twin
// detects the longer ones.
constexpr double kLongest = 8.0, kLongestFold = 4.0, kShortest = 4.0;
constexpr int kDirections = 8;  // along which waves are looked at, over half a turn

// Fitted on scenes that benchmark/calibration_section.cpp draws; see docs/accuracy_control.md.
constexpr double kGrown = 3.0;       // logarithm of a growth: twenty times; the full cloud's forces peak higher
constexpr double kGrownFold = 10.0;  // the same for folds: those of one triangle that grow less have no effect
constexpr double kOverloaded = 1.6;  // of an equilibrium, over the load at which dents begin
// Of the classical buckling pressure under a force: imperfect spheres bear a part of it.
constexpr double kPushed = 0.12;
// The same limits for possible buckling: a growth by fifty times, after which a disturbance counts, and the loads that very
// imperfect shells may bear.
constexpr double kMayHaveGrown = 3.9, kMayBeOverloaded = 0.4, kMayBePushed = 0.03;
constexpr double kSharp = 0.96;      // |n_i - n_j| of unit normals a radian apart
constexpr double kShortDents = 1.4;  // (D / (S k^2))^(1/4) over the spacing, below which dents are too short for the points
// Along and across a wave, in the tangent plane.
struct Direction {
  Vec2 along, across;
};

std::array<Direction, kDirections> makeDirections() {
  std::array<Direction, kDirections> directions;
  for (int d = 0; d < kDirections; ++d) {
    const double angle = kPi * d / kDirections;
    directions[d] = {Vec2(std::cos(angle), std::sin(angle)), Vec2(-std::sin(angle), std::cos(angle))};
  }
  return directions;
}

const std::array<Direction, kDirections> kDirectionsOfWaves = makeDirections();

}  // namespace

DentWatch::DentWatch(const model::MaterialParams& material, const Points& points,
                     const std::vector<model::WeightedTriangle>& triangles, double area, Index num_full)
    : stretching_(material.young_modulus * material.thickness),
      stated_stretching_(stretching_),
      rigidity_(material.bendingRigidity()),
      poisson_(material.poisson_ratio),
      mass_(material.density * material.thickness),
      damping_(material.damping) {
  for (const model::WeightedTriangle& t : triangles) {
    const Vec3 first = points[t.corner[1]] - points[t.corner[0]], second = points[t.corner[2]] - points[t.corner[0]];
    const double length = first.norm(), along = second.dot(first) / length, height = (second - along / length * first).norm();
    if (!(height > 1e-6 * length)) continue;  // of no area
    Mat2 edges;
    edges << length, along, 0.0, height;
    triangles_.push_back({{t.corner[0], t.corner[1], t.corner[2]}, edges.inverse(), t.weight, {}});
  }
  normals_.resize(points.size());
  findNormals(points);
  double curvature = 0.0;  // the mean of the mean curvature's size
  curvature_.assign(points.size(), 0.0);
  std::vector<double> count(points.size(), 0.0);
  for (Triangle& t : triangles_) {
    for (int c = 0; c < 3; ++c) t.turned[c] = (normals_[t.corner[(c + 1) % 3]] - normals_[t.corner[c]]).norm();
    const double here = 0.5 * std::abs(measure(t, points).curvature.trace());
    curvature += here / static_cast<double>(triangles_.size());
    for (Index i : t.corner) {
      curvature_[i] += here;
      count[i] += 1.0;
    }
  }
  for (std::size_t i = 0; i < points.size(); ++i) curvature_[i] /= std::max(1.0, count[i]);
  spacing_ = findSpacing(area, points.size());
  full_spacing_ = findSpacing(area, num_full);
  has_short_dents_ = hasShortDents(curvature);
  if (!has_short_dents_ && static_cast<Index>(points.size()) >= num_full) triangles_.clear();
  const auto squareOf = [](double length) { return 4.0 * kPi * kPi / (length * length); };
  least_ = squareOf(kLongest * spacing_);
  least_fold_ = squareOf(kLongestFold * spacing_);
  largest_ = squareOf(kShortest * full_spacing_);
  reset();
}

void DentWatch::reset() { growth_.assign((has_short_dents_ ? 1 : 2) * triangles_.size(), 0.0); }

// The sum of the cross products of the edges at a point, each divided by the squares of their lengths: on a sphere it is the
// normal, whatever the triangles [Max 1999].
void DentWatch::findNormals(const Points& positions) {
  std::fill(normals_.begin(), normals_.end(), Vec3::Zero());
  for (const Triangle& t : triangles_) {
    Vec3 edge[3];  // opposite each corner
    for (int c = 0; c < 3; ++c) edge[c] = positions[t.corner[(c + 2) % 3]] - positions[t.corner[(c + 1) % 3]];
    const Vec3 area = t.weight * edge[0].cross(edge[1]);
    const double squared[3] = {edge[0].squaredNorm(), edge[1].squaredNorm(), edge[2].squaredNorm()};
    for (int c = 0; c < 3; ++c) normals_[t.corner[c]] += area / (squared[(c + 1) % 3] * squared[(c + 2) % 3]);
  }
  for (Vec3& normal : normals_) {
    const double size = normal.norm();
    if (size > 0.0) normal /= size;
  }
}

// The membrane force from Green's strain, and the change of the normals along the surface.
DentWatch::Local DentWatch::measure(const Triangle& t, const Points& positions) const {
  Eigen::Matrix<double, 3, 2> edges, turns;
  for (int c = 0; c < 2; ++c) {
    edges.col(c) = positions[t.corner[c + 1]] - positions[t.corner[0]];
    turns.col(c) = normals_[t.corner[c + 1]] - normals_[t.corner[0]];
  }
  const Eigen::Matrix<double, 3, 2> gradient = edges * t.inverse;
  const Mat2 strain = 0.5 * (gradient.transpose() * gradient - Mat2::Identity());
  const Mat2 bent = gradient.transpose() * (turns * t.inverse);
  return {stretching_ / (1.0 - poisson_ * poisson_) * ((1.0 - poisson_) * strain + poisson_ * strain.trace() * Mat2::Identity()),
          0.5 * (bent + bent.transpose())};
}

// How far the normals of neighbouring points have turned against each other, as the length of their difference.
double DentWatch::findTurn(const Triangle& t) const {
  double largest = 0.0;
  for (int c = 0; c < 3; ++c)
    largest = std::max(largest, (normals_[t.corner[(c + 1) % 3]] - normals_[t.corner[c]]).norm() - t.turned[c]);
  return largest;
}

// The largest value of the right side of the equation over rho, over directions and k, 1/s^2. least: of k^2.
double DentWatch::findAcceleration(const Local& local, double least) const {
  double largest = -std::numeric_limits<double>::infinity();
  for (const Direction& d : kDirectionsOfWaves) {
    const double force = d.along.dot(local.force * d.along), b = d.across.dot(local.curvature * d.across);
    const double k2 = std::min(std::max(-0.5 * force / rigidity_, least), largest_);
    largest = std::max(largest, -(rigidity_ * k2 * k2 + stretching_ * b * b + force * k2) / mass_);
  }
  return largest;
}

// The compression over the least at which a wave of some k grows, in the direction where that is largest.
double DentWatch::findLoad(const Local& local) const {
  double largest = 0.0;
  for (const Direction& d : kDirectionsOfWaves) {
    const double force = d.along.dot(local.force * d.along), b = d.across.dot(local.curvature * d.across);
    const double k2 = std::min(std::max(std::sqrt(stretching_ / rigidity_) * std::abs(b), least_), largest_);
    largest = std::max(largest, -force * k2 / (rigidity_ * k2 * k2 + stretching_ * b * b));
  }
  return largest;
}

bool DentWatch::hasShortDents(double curvature) const {
  return std::pow(rigidity_ / stretching_, 0.25) < kShortDents * std::sqrt(curvature) * spacing_;
}

Buckling DentWatch::judgeForce(const std::vector<Index>& loaded, const std::vector<double>& shares, double force,
                               double radius) const {
  if (!has_short_dents_) return Buckling::kUnlikely;
  double curvature = 0.0;
  for (std::size_t k = 0; k < loaded.size(); ++k) curvature += shares[k] * curvature_[loaded[k]];
  if (!hasShortDents(curvature)) return Buckling::kUnlikely;
  const double patch = std::max(kPi * radius * radius, full_spacing_ * full_spacing_);
  const double classical = 4.0 * std::sqrt(stretching_ * rigidity_) * curvature * curvature * patch;
  return force > kPushed * classical        ? Buckling::kLikely
         : force > kMayBePushed * classical ? Buckling::kPossible
                                            : Buckling::kUnlikely;
}

Buckling DentWatch::followStep(const Points& positions, double step) {
  if (triangles_.empty()) return Buckling::kUnlikely;
  findNormals(positions);
  Buckling worst = Buckling::kUnlikely;
  // Waves from this length on have grown by this much at triangle i, kept at `place`.
  const auto grow = [&](const Local& local, bool is_tense, double least, std::size_t place) {
    const double acceleration = is_tense ? 0.0 : std::max(0.0, findAcceleration(local, least));
    const double rate = std::sqrt(0.25 * damping_ * damping_ + acceleration) - 0.5 * damping_;
    return growth_[place] = std::max(0.0, growth_[place] + (acceleration > 0.0 ? rate : -0.5 * damping_) * step);
  };
  const std::size_t n = triangles_.size();
  for (std::size_t i = 0; i < n; ++i) {
    const Local local = measure(triangles_[i], positions);
    const bool is_tense = local.force.determinant() >= 0.0 && local.force.trace() >= 0.0;
    const bool has_grown =
        has_short_dents_ ? grow(local, is_tense, least_, i) > kGrown : grow(local, is_tense, least_fold_, i) > kGrownFold;
    const bool may_have = !has_short_dents_ && grow(local, is_tense, least_, n + i) > kMayHaveGrown;
    if (has_grown) worst = Buckling::kLikely;
    if (worst == Buckling::kUnlikely && (may_have || findTurn(triangles_[i]) > kSharp)) worst = Buckling::kPossible;
  }
  return worst;
}

Buckling DentWatch::judgeEquilibrium(const Points& positions) {
  findNormals(positions);
  double load = 0.0;
  bool is_sharp = false;
  for (const Triangle& t : triangles_) {
    load = std::max(load, findLoad(measure(t, positions)));
    is_sharp = is_sharp || findTurn(t) > kSharp;
  }
  if (has_short_dents_ && load > kOverloaded) return Buckling::kLikely;
  return is_sharp || load > kMayBeOverloaded ? Buckling::kPossible : Buckling::kUnlikely;
}

}  // namespace deformable_surface::simulation
