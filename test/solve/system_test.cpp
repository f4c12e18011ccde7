// The interface of solvers: forces of material and loads together, energies, bounds.
#include "deformable_surface/solve/system.h"

#include <gtest/gtest.h>

#include "oscillators.h"

namespace deformable_surface::test {
namespace {

struct Setting {
  Setting() : model({4.0, 9.0}, 0.5), field(model.masses(), Vec3(0.0, 0.0, -10.0)), system(model, loads, held, 0.0) {
    loads.push_back(&field);
  }

  Oscillators model;
  ConstantField field;
  std::vector<const solve::ExternalLoad*> loads;
  std::vector<char> held{0, 1};
  solve::System system;
  State state{{Vec3(1.0, 0.0, 0.0), Vec3(0.0, 2.0, 0.0)}, {Vec3(0.0, 3.0, 0.0), Vec3::Zero()}};
};

TEST(System, AddsLoadsToTheMaterialAndLeavesHeldPointsAlone) {
  Setting s;
  Points forces;
  s.system.computeForces(0.0, s.state, forces);
  EXPECT_EQ(forces, (Points{Vec3(-4.0, 0.0, -5.0), Vec3::Zero()}));
  s.system.computeForcesOnAll(0.0, s.state, forces);
  EXPECT_EQ(forces, (Points{Vec3(-4.0, 0.0, -5.0), Vec3(0.0, -18.0, -5.0)}));
  s.system.computeFastForces(s.state, forces);  // a model without slow forces has no others
  EXPECT_EQ(forces, (Points{Vec3(-4.0, 0.0, 0.0), Vec3(0.0, -18.0, 0.0)}));
  EXPECT_DOUBLE_EQ(s.system.largestForce(0.0, s.state), 18.0);
}

// As on a table: nothing is left of the sum, but the weight has to be borne.
TEST(System, TheLargestForceIsThatOfEachLoadAlsoWhereLoadsCancel) {
  Setting s;
  const ConstantField table(s.model.masses(), Vec3(0.0, 0.0, 10.0));
  s.loads.push_back(&table);
  s.state.positions = {Vec3::Zero(), Vec3::Zero()};
  Points forces;
  EXPECT_DOUBLE_EQ(s.system.computeForcesAndLargest(0.0, s.state, forces), 5.0);
  EXPECT_EQ(forces, (Points{Vec3::Zero(), Vec3::Zero()}));
}

TEST(System, KnowsEnergiesAndTheWorkOfWhatCarriesHeldPoints) {
  Setting s;
  EXPECT_DOUBLE_EQ(s.system.elasticEnergy(s.state), 0.5 * 4.0 + 0.5 * 9.0 * 4.0);
  EXPECT_DOUBLE_EQ(s.system.kineticEnergy(s.state), 0.5 * 0.5 * 9.0);
  State lifted = s.state;
  lifted.positions[0].z() += 1.0;  // free: it is not carried, so there is no such work
  EXPECT_EQ(s.system.carryingWork(0.0, 0.1, s.state, lifted), 0.0);
  lifted.positions[1].y() += 1.0;
  // Against a spring, whose mean force along the path is exact by the trapezoidal rule, and across gravity.
  EXPECT_DOUBLE_EQ(s.system.carryingWork(0.0, 0.1, s.state, lifted), 0.5 * 9.0 * (9.0 - 4.0));
}

TEST(System, TellsWhatItDissipatesAndWhichMethodsItsModelAllows) {
  Setting s;
  EXPECT_FALSE(s.system.dissipates());
  EXPECT_TRUE(s.system.hasStiffness());
  EXPECT_FALSE(s.system.hasStiffnessProducts());
  EXPECT_FALSE(s.system.hasSlowForces());
  EXPECT_FALSE(s.system.hasElasticityAlone(0.0, s.state)) << "no couplings are known";
  const Oscillators viscous({4.0, 9.0}, 0.5, 2.0);
  const solve::System damped(viscous, s.loads, s.held, 0.0);
  EXPECT_TRUE(damped.dissipatesInForces());
  EXPECT_DOUBLE_EQ(damped.dampingRate(0.0, s.state), 4.0);
}

}  // namespace
}  // namespace deformable_surface::test
