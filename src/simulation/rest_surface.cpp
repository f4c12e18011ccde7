#include "deformable_surface/simulation/rest_surface.h"

#include "deformable_surface/base/value.h"
#include "deformable_surface/cloud/kd_tree.h"
#include "deformable_surface/cloud/near_points.h"
#include "deformable_surface/simulation/model_kind.h"

#include <cmath>
#include <utility>

#include "joined_layers.h"
#include "narrow_gaps.h"
#include "open_seams.h"
#include "rest_parts.h"
#include "unconstrained_parts.h"

namespace deformable_surface::simulation {
namespace {

constexpr double kFarPoint = 5.0;   // spacings: the nearest simulation point is nearer also where few points are simulated
constexpr double kHalfTurn = 2e-3;  // rad from 180 degrees: orientations are written with three digits and more

// Forces with a radius are noted as they begin.
void noteFarPoints(const SceneParams& params, RestSurface& s) {
  std::vector<std::pair<std::string, Vec3>> points;
  for (std::size_t a = 0; a < params.anchors.size(); ++a)
    points.emplace_back("anchors[" + std::to_string(a) + "]", params.anchors[a].point);
  for (std::size_t f = 0; f < params.forces.size(); ++f)
    if (params.forces[f].radius == 0.0) points.emplace_back("forces[" + std::to_string(f) + "]", params.forces[f].point);
  if (points.empty() || s.points.empty()) return;
  const double reach = kFarPoint * cloud::findTypicalSpacing(s.points);
  const cloud::KdTree tree(s.points);
  std::vector<cloud::Neighbor> nearest;
  for (const auto& [name, point] : points) {
    tree.nearest(point, 1, nearest);
    const double distance = std::sqrt(nearest[0].squared_distance);
    if (!(distance > reach)) continue;
    s.notes.push_back(name + ": no simulation point lies within " + formatShort(kFarPoint) + " spacings, " + formatShort(reach) +
                      " m; it acts on the nearest one, " + formatShort(distance) + " m from its point");
  }
}

// Quaternions cannot tell turns by 180 degrees and more apart.
void noteHalfTurns(const std::string& name, const std::vector<tool::WaypointParams>& path, RestSurface& s) {
  for (std::size_t k = 1; k < path.size(); ++k)
    if (std::abs(path[k].orientation.normalized().dot(path[k - 1].orientation.normalized())) < std::sin(0.5 * kHalfTurn))
      s.notes.push_back(name + ": from " + formatReal(path[k - 1].time) + " to " + formatReal(path[k].time) +
                        " s the path turns by 180 degrees, and both ways round are as short: a waypoint between tells which");
}

void noteHalfTurns(const SceneParams& params, RestSurface& s) {
  for (const tool::ToolParams& tool : params.tools) noteHalfTurns("tool " + quote(tool.id), tool.path, s);
  for (std::size_t p = 0; p < params.pins.size(); ++p) noteHalfTurns("pins[" + std::to_string(p) + "]", params.pins[p].path, s);
}

void addNotes(const SceneParams& params, RestSurface& s) {
  noteHalfTurns(params, s);
  noteUnconstrained(params, s);
  noteStaticContact(params, s);
  noteFarPoints(params, s);
  warnOfClosePoints(s);
  noteNarrowGaps(s);
  warnOfOpenSeams(s);
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
