// The registry of models: the one place that names them all, together with the options in scenes (model_params.h).
#include "deformable_surface/base/error.h"
#include "deformable_surface/base/value.h"
#include "deformable_surface/simulation/model_kind.h"

#include <algorithm>

#include "elastic_solid/kind.h"
#include "mass_spring/kind.h"
#include "oriented_particles/kind.h"

namespace deformable_surface::simulation {
namespace {

std::vector<const ModelKind*>& registry() {
  static std::vector<const ModelKind*> kinds = {&massSpringKind(), &orientedParticlesKind(), &elasticSolidKind()};
  return kinds;
}

}  // namespace

const std::vector<const ModelKind*>& modelKinds() { return registry(); }

void registerModel(const ModelKind& kind) { registry().push_back(&kind); }

const ModelKind& findModel(const std::string& name) {
  std::string names;
  for (const ModelKind* kind : modelKinds()) {
    if (name == kind->name()) return *kind;
    names += (names.empty() ? "" : ", ") + std::string(kind->name());
  }
  throw InputError("model: found " + quote(name) + "; accepted: " + names);
}

std::string listModels(bool ModelTraits::*trait) {
  std::string names;
  for (const ModelKind* kind : modelKinds())
    if (kind->traits().*trait) names += (names.empty() ? "" : ", ") + std::string(kind->name());
  return names;
}

}  // namespace deformable_surface::simulation
