#include "nested_start.h"

#include "deformable_surface/base/error.h"

#include "dynamics.h"

namespace deformable_surface::simulation {
namespace {

constexpr Index kRatios[] = {16, 4};  // points of the level for one of a coarser surface
constexpr Index kFewestPoints = 16;   // fewer hardly carry a shape

// Positions of all points, if those of a coarser surface are known; pinned ones stay.
Points follow(const SceneParams& params, const RestSurface& fine, const RestSurface& coarse, const Points& coarse_now) {
  const transfer::Transfer transfer(fine.points, fine.normals, coarse.points, std::vector<char>(coarse.points.size(), 1),
                                    params.transfer);
  Points now;
  transfer.apply(coarse_now, now);
  for (std::size_t i = 0; i < now.size(); ++i)
    if (fine.pinned[i]) now[i] = fine.points[i];
  return now;
}

}  // namespace

Points findNestedStart(const SceneParams& params, const RestSurface& level, const std::atomic<bool>* interrupt) {
  const Index n = static_cast<Index>(level.points.size());
  if (n < kFewestPoints * kRatios[0] || level.dense.positions.empty()) return {};
  SceneParams coarse = params;
  coarse.accuracy = AccuracyParams{};
  coarse.accuracy.estimate = false;
  coarse.output.resample = false;
  coarse.contact.self = false;  // the way to the equilibrium is checked on the level itself
  RestSurface known;            // the coarser surface solved last, without its model
  Points known_now;
  try {
    for (Index ratio : kRatios) {
      RestSurface surface = buildCoarser(coarse, level, n / ratio);
      RestSurface shape;
      shape.points = surface.points;
      shape.normals = surface.normals;
      shape.pinned = surface.pinned;
      Dynamics dynamics(coarse, std::move(surface));
      dynamics.setInterrupt(interrupt);
      if (!known_now.empty())
        dynamics.apply(command::SetState{{follow(params, shape, known, known_now), Points(shape.points.size(), Vec3::Zero())}});
      const Dynamics::Outcome outcome = dynamics.step();
      // A notice: a force that finds no point there.
      if (!outcome.ok || !outcome.report.converged || !outcome.notice.empty()) return {};
      known = std::move(shape);
      known_now = dynamics.state().positions;
      // If cheap steps found it here, they also find it from further away, sooner than the next surface is built.
      if (outcome.report.is_quasi_newton) break;
    }
  } catch (const InputError&) {
    return {};  // so few points span no surface, or the model has no such surfaces
  }
  return follow(params, level, known, known_now);
}

}  // namespace deformable_surface::simulation
