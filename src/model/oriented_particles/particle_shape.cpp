// What particles remember of the shape around them: rest curvature, plastic flow, and their axes.
#include "deformable_surface/base/parallel.h"
#include "deformable_surface/model/oriented_particles/rest_shape.h"
#include "particle_loops.h"

#include <algorithm>
#include <cmath>

namespace deformable_surface::model {
namespace {

using particles::kBlock;
using particles::kTurn;
using particles::normalOf;

}  // namespace

// E = sum psi x^2 z / a^3 [Szeliski 1991, eq. 14] or psi x^2 z^2 / a^4 [eq. 15] over the neighbours, x = X cos t + Y sin t in the
// frame turned by t, a the spacing: up to a constant it is -G cos 2(t - t0). With dt/dtime = -rate dE/dt, tan(t - t0) falls as
// exp(-4 rate G time).
void OrientedParticles::turnAxes(double time, State& state) const {
  if (!(params_.axis_alignment_rate > 0.0) || params_.mode == ParticleMode::kPlane || !prepare(state)) return;
  const double inverse = 1.0 / lattice_.spacing;
  const bool is_signed = params_.principal == PrincipalDirection::kSigned;
  parallelFor(state.size(), kBlock, [&](Index begin, Index end) {
    for (Index i = begin; i < end; ++i) {
      const Mat3 to_frame = inverse * state.orientations[i].conjugate().toRotationMatrix();
      double even = 0.0, odd = 0.0;  // E = even cos 2t + odd sin 2t
      forEachNear(i, lattice_.pair.cutoff, [&](Index j, double d) {
        const Vec3 r = to_frame * (state.positions[j] - state.positions[i]);
        double psi, slope;
        weighByDistance(lattice_.pair, d * d, psi, slope);
        const double weight = packed_.normal(j)[3] * psi * (is_signed ? r.z() : r.z() * r.z());
        even += 0.5 * weight * (r.x() * r.x() - r.y() * r.y());
        odd += weight * r.x() * r.y();
      });
      const double target = 0.5 * std::atan2(-odd, -even), off = state.traits[i].turn - target;
      const double kept = std::exp(-4.0 * params_.axis_alignment_rate * std::hypot(even, odd) * packed_.normal(i)[3] * time);
      // The nearer of the two directions of the axis.
      const double side = std::cos(off) < 0.0 ? -1.0 : 1.0;
      const double left = std::atan2(side * std::sin(off) * kept, side * std::cos(off));
      state.traits[i].turn = std::remainder(target + (side < 0.0 ? 0.5 * kTurn : 0.0) + left, kTurn);
    }
  });
}

// From the neighbours within the cutoff that face the same way, weighted by their bonds.
std::optional<Vec3> OrientedParticles::fitCurvature(const State& state, Index i) const {
  const Eigen::Map<const Vec3> normal(packed_.normal(i));
  CurvatureFit fit(state.orientations[i]);
  forEachNear(i, lattice_.pair.cutoff, [&](Index j, double d) {
    const Eigen::Map<const Vec3> other(packed_.normal(j));
    if (!(other.dot(normal) > 0.0)) return;
    double psi, slope;
    weighByDistance(lattice_.pair, d * d, psi, slope);
    const double weight = packed_.normal(j)[3] * std::min(packed_.place(i)[3], packed_.place(j)[3]) * psi;
    fit.add(weight, state.positions[j] - state.positions[i], other - normal);
  });
  return fit.solve();
}

void OrientedParticles::keepShape(State& state) const {
  if (!prepare(state)) return;
  parallelFor(state.size(), kBlock, [&](Index begin, Index end) {
    for (Index i = begin; i < end; ++i) {
      if (!state.traits[i].is_smooth) continue;
      const std::optional<Vec3> curvature = fitCurvature(state, i);
      if (!curvature) continue;
      const PrincipalCurvatures principal = findPrincipalCurvatures(*curvature);
      const double most = lattice_.spacing * std::max(std::abs(principal.larger), std::abs(principal.smaller));
      state.traits[i].rest_curvature = *curvature / std::max(1.0, most);
    }
  });
}

void OrientedParticles::smoothShape(Index times, State& state) const {
  if (!prepare(state)) return;
  std::vector<Mat3> curvatures(state.positions.size());
  for (; times > 0; --times) {
    for (Index i = 0; i < state.size(); ++i)
      curvatures[i] = turnCurvatureToWorld(state.orientations[i], state.traits[i].rest_curvature);
    parallelFor(state.size(), kBlock, [&](Index begin, Index end) {
      for (Index i = begin; i < end; ++i) {
        if (!state.traits[i].is_smooth) continue;
        const Vec3 normal = normalOf(state.orientations[i]);
        Mat3 sum = curvatures[i];
        double count = 1.0;
        forEachNear(i, lattice_.pair.cutoff, [&](Index j, double) {
          const Vec3 other = normalOf(state.orientations[j]);
          if (!state.traits[j].is_smooth || !(other.dot(normal) > 0.0)) return;
          const Mat3 along = Quaternion::FromTwoVectors(other, normal).toRotationMatrix();
          sum += along * curvatures[j] * along.transpose();
          count += 1.0;
        });
        state.traits[i].rest_curvature = turnCurvatureToFrame(state.orientations[i], sum / count);
      }
    });
  }
}

bool OrientedParticles::flow(State& state) const {
  if (!(params_.yield_curvature > 0.0) || !prepare(state)) return false;
  has_flowed_.assign(state.positions.size(), 0);
  parallelFor(state.size(), kBlock, [&](Index begin, Index end) {
    for (Index i = begin; i < end; ++i) {
      if (!state.traits[i].is_smooth) continue;
      const std::optional<Vec3> curvature = fitCurvature(state, i);
      if (!curvature) continue;
      const Vec3 rest = flowToYield(state.traits[i].rest_curvature, *curvature, params_.yield_curvature);
      has_flowed_[i] = rest != state.traits[i].rest_curvature;
      state.traits[i].rest_curvature = rest;
    }
  });
  return std::find(has_flowed_.begin(), has_flowed_.end(), 1) != has_flowed_.end();
}

}  // namespace deformable_surface::model
