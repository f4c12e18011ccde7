#include "deformable_surface/simulation/rest_surface.h"

#include "deformable_surface/simulation/model_kind.h"

#include <utility>

#include "joined_layers.h"
#include "narrow_gaps.h"
#include "rest_parts.h"
#include "unconstrained_parts.h"

namespace deformable_surface::simulation {
namespace {

void addNotes(const SceneParams& params, RestSurface& s) {
  noteUnconstrained(params, s);
  warnOfClosePoints(s);
  noteNarrowGaps(s);
  noteJoinedLayers(s);
}

}  // namespace

RestSurface buildRestSurface(const SceneParams& params, const cloud::PointCloud& input, Index coarsest,
                             const std::function<Index(const RestSurface&)>& choose) {
  RestSurface s = findModel(params.model).makeRest(params, input, coarsest, choose);
  addNotes(params, s);
  return s;
}

RestSurface buildRestSurface(const SceneParams& params, RestSurface prepared,
                             const std::function<Index(const RestSurface&)>& choose) {
  RestSurface s = findModel(params.model).finishRest(params, std::move(prepared), choose);
  addNotes(params, s);
  return s;
}

RestSurface buildTrial(const SceneParams& params, const RestSurface& full, Index points) {
  return findModel(params.model).makeTrial(params, full, points);
}

RestSurface buildCoarser(const SceneParams& params, const RestSurface& of, Index target) {
  return findModel(params.model).makeCoarser(params, of, target);
}

RestSurface copyCoarser(const SceneParams& params, const RestSurface& of) {
  return findModel(params.model).copyCoarser(params, of);
}

}  // namespace deformable_surface::simulation
