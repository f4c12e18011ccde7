// Which modes of tools a model has, and what to say of the others.
#include "deformable_surface/simulation/scene_params.h"

#include <array>

namespace deformable_surface::simulation {
namespace {

using tool::Mode;

constexpr std::array<const char*, 6> kModes = {"solid", "attract", "move", "erase", "cut", "heat"};  // in the order of Mode
constexpr std::array<const char*, 3> kModels = {"mass_spring", "oriented_particles", "elastic_solid"};

}  // namespace

bool hasToolMode(ModelKind model, Mode mode) {
  return model == ModelKind::kOrientedParticles || mode == Mode::kSolid || mode == Mode::kAttract || mode == Mode::kMove ||
         (mode == Mode::kCut && model == ModelKind::kMassSpring);
}

std::string describeWrongToolMode(ModelKind model, Mode mode) {
  std::string accepted;
  for (std::size_t k = 0; k < kModes.size(); ++k)
    if (hasToolMode(model, static_cast<Mode>(k))) accepted += (accepted.empty() ? "" : ", ") + std::string(kModes[k]);
  return std::string("found ") + kModes[static_cast<std::size_t>(mode)] + ", which " + kModels[static_cast<std::size_t>(model)] +
         " does not have; accepted: " + accepted;
}

}  // namespace deformable_surface::simulation
