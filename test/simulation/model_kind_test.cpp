// The registry of models and its answers for each of them.
#include "deformable_surface/simulation/model_kind.h"

#include <gtest/gtest.h>

#include "deformable_surface/base/error.h"

namespace deformable_surface::test {
namespace {

using simulation::ModelTraits;

TEST(ModelKinds, AreListedInTheOrderOfTheRegistry) {
  std::vector<std::string> names;
  for (const simulation::ModelKind* kind : simulation::modelKinds()) {
    names.push_back(kind->name());
    EXPECT_EQ(&simulation::findModel(kind->name()), kind);
  }
  EXPECT_EQ(names, (std::vector<std::string>{"mass_spring", "oriented_particles", "elastic_solid"}));
}

TEST(ModelKinds, AreFoundByNameOnly) {
  try {
    simulation::findModel("masspring");
    FAIL();
  } catch (const InputError& problem) {
    EXPECT_STREQ(problem.what(), "model: found 'masspring'; accepted: mass_spring, oriented_particles, elastic_solid");
  }
}

TEST(ModelKinds, AreListedByWhatTheyOffer) {
  EXPECT_EQ(simulation::listModels(&ModelTraits::is_surface), "mass_spring, oriented_particles");
  EXPECT_EQ(simulation::listModels(&ModelTraits::meets_itself), "mass_spring, elastic_solid");
  EXPECT_EQ(simulation::listModels(&ModelTraits::has_population), "oriented_particles");
  EXPECT_EQ(simulation::listModels(&ModelTraits::has_local_estimate), "mass_spring");
  EXPECT_EQ(simulation::listModels(&ModelTraits::has_estimate), "mass_spring, oriented_particles, elastic_solid");
}

}  // namespace
}  // namespace deformable_surface::test
