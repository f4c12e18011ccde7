#include "self_contact_load.h"

#include "deformable_surface/cloud/links.h"
#include "deformable_surface/simulation/model_kind.h"

#include <cmath>
#include <utility>

#include "spacing.h"

namespace deformable_surface::simulation {
namespace {

constexpr double kOfSpacing = 0.2;  // thickness of the skin of a solid, which has none of its own

}  // namespace

double findContactThickness(const SceneParams& params, const RestSurface& rest) {
  if (!params.contact.thickness.is_auto) return params.contact.thickness.value;
  if (findModel(params.model).traits().is_surface) return params.material.thickness;
  return kOfSpacing * findSpacing(rest.area, rest.points.size());
}

namespace {

// The parts that links and whole triangles connect. The points within a body are in none of the triangles.
std::vector<Index> labelParts(Index n, const std::vector<contact::Triangle>& triangles, const std::vector<char>& is_whole,
                              std::vector<std::pair<Index, Index>> links) {
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    if (!is_whole[t]) continue;
    links.emplace_back(triangles[t][0], triangles[t][1]);
    links.emplace_back(triangles[t][0], triangles[t][2]);
  }
  Index num_parts = 0;
  return cloud::labelComponents(n, links, num_parts);
}

}  // namespace

SelfContactLoads::SelfContactLoads(const Points& rest, std::shared_ptr<const ContactSkin> skin,
                                   const model::DeformableModel& model, const contact::SelfContactParams& params)
    : contact(rest, skin->triangles, model.masses(), params),
      limit(contact, labelParts(static_cast<Index>(rest.size()), skin->triangles, std::vector<char>(skin->triangles.size(), 1),
                                stretchLinksOf(model))),
      skin_(std::move(skin)),
      is_whole_(skin_->triangles.size(), 1),
      rubs_(params.friction > 0.0) {}

void SelfContactLoads::followCut(const model::DeformableModel& model) {
  std::vector<char> is_whole = skin_->findWhole(trianglesOf(model));
  if (is_whole != is_whole_) {
    is_whole_ = std::move(is_whole);
    contact.keepWhole(is_whole_);
  }
  // Also where only links are cut that lie in none of these triangles.
  limit.setParts(labelParts(static_cast<Index>(limit.parts().size()), skin_->triangles, is_whole_, stretchLinksOf(model)));
}

void SelfContactLoads::setMemory(const Memory& memory) {
  may_act_ = memory.may_act;
  contact.setProven(memory.proven);
}

// Where the loads do not act, the limit still does: parts that come faster than predicted are stopped, not bounced.
bool SelfContactLoads::beginStep(const model::State& state, double step, bool untangles) {
  limit.forgetStopped();
  const bool may_act = contact.mayTouch(state.positions, state.velocities, step);
  const bool pushes = untangles && contact.beginPushing(state.positions);
  const bool has_changed = pushes != pushes_ || may_act != may_act_;
  may_act_ = may_act;
  pushes_ = pushes;
  return has_changed;
}

void SelfContactLoads::followCrossings(const Points& positions) {
  contact.findCrossed(positions);
  contact.endPushing();
  pushes_ = false;
}

}  // namespace deformable_surface::simulation
