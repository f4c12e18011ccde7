#include "deformable_surface/simulation/model_kind.h"

#include "deformable_surface/base/error.h"
#include "deformable_surface/simulation/evolution.h"

#include "cloud_follower.h"
#include "copied_points.h"
#include "rest_parts.h"

namespace deformable_surface::simulation {
namespace {

[[noreturn]] void refuse(const char* what, const ModelKind& kind) {
  throw InputError(std::string("found ") + kind.name() + ", which has no " + what + "; accepted: another model");
}

}  // namespace

RestSurface ModelKind::makeRest(const SceneParams& params, const cloud::PointCloud& input, Index coarsest,
                                const Choose& choose) const {
  return finishRest(params, prepareSurface(params, input, coarsest, choose != nullptr), choose);
}

RestSurface ModelKind::prepare(const SceneParams&, const cloud::PointCloud&, Index, bool) const {
  refuse("part of a surface to share", *this);
}

RestSurface ModelKind::finishRest(const SceneParams&, RestSurface, const Choose&) const {
  refuse("part of a surface to share", *this);
}

RestSurface ModelKind::makeTrial(const SceneParams&, const RestSurface&, Index) const { refuse("trials", *this); }

RestSurface ModelKind::makeCoarser(const SceneParams&, const RestSurface&, Index) const { refuse("coarser copies", *this); }

std::string ModelKind::refuseEstimate(const SceneParams&) const {
  return traits().has_estimate ? "" : "has none; runs with other numbers of simulation points show how far results depend on it";
}

CoarserLevel ModelKind::makeCopies(const SceneParams&, const RestSurface&) const { refuse("coarser copies", *this); }

RestSurface ModelKind::copyCoarser(const SceneParams& params, const RestSurface& of) const {
  RestSurface s = copyPointsAndModel(of);
  applyPins(params, s);
  return s;
}

std::vector<model::WeightedTriangle> ModelKind::findSkin(const RestSurface&, const model::DeformableModel& model) const {
  return trianglesOf(model);
}

std::shared_ptr<const transfer::SampledPoints> ModelKind::makeBetween(const SceneParams&, const RestSurface&,
                                                                      const std::vector<model::WeightedTriangle>&) const {
  return nullptr;
}

std::shared_ptr<const LoadPoints> ModelKind::makeLoadPoints(const SceneParams&, const RestSurface&) const { return nullptr; }

std::unique_ptr<CloudFollower> ModelKind::makeFollower(const RestSurface&, const SceneParams&,
                                                       const model::DeformableModel&) const {
  return nullptr;
}

std::unique_ptr<Evolution> ModelKind::makeEvolution(model::DeformableModel&, const RestSurface&, const SceneParams&) const {
  return std::make_unique<Evolution>();
}

}  // namespace deformable_surface::simulation
