#include "deformable_surface/model/deformable_model.h"

namespace deformable_surface::model {
namespace {

const std::vector<std::pair<Index, Index>> kNoLinks;
const std::vector<WeightedTriangle> kNoTriangles;

}  // namespace

const std::vector<std::pair<Index, Index>>& stretchLinksOf(const DeformableModel& model) {
  return model.links() ? model.links()->stretchLinks() : kNoLinks;
}

const std::vector<std::pair<Index, Index>>& bendLinksOf(const DeformableModel& model) {
  return model.links() ? model.links()->bendLinks() : kNoLinks;
}

const std::vector<WeightedTriangle>& trianglesOf(const DeformableModel& model) {
  return model.sides() ? model.sides()->triangles() : kNoTriangles;
}

double maxStretchOf(const DeformableModel& model, const State& state) {
  return model.links() ? model.links()->maxStretch(state) : 0.0;
}

void computePointStrain(const DeformableModel& model, const State& state, std::vector<double>& strain) {
  if (model.links()) return model.links()->computePointStrain(state, strain);
  strain.assign(state.positions.size(), 0.0);
}

void computeAreaVectors(const DeformableModel& model, const State& state, Points& area_vectors) {
  if (model.sides()) return model.sides()->computeAreaVectors(state, area_vectors);
  area_vectors.assign(state.positions.size(), Vec3::Zero());
}

void beginAtRest(DeformableModel& model, State& state) {
  if (InnerState* inner = model.innerState()) inner->beginAtRest(state);
}

void adopt(DeformableModel& model, const State& state) {
  if (InnerState* inner = model.innerState()) inner->adopt(state);
}

}  // namespace deformable_surface::model
