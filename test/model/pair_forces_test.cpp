// Forces and torques of one pair of particles: minus the gradient of the energy, equal and opposite, none beyond the cutoff.
#include "pairs.h"

namespace deformable_surface::test {
namespace {

struct Pull {
  explicit Pull(const model::PairPotentials& pair, const TwoParticles& two) : forces(2, Vec3::Zero()), torques(2, Vec3::Zero()) {
    model::NeighborList lists(pair.cutoff, 0.1 * pair.cutoff);
    EXPECT_TRUE(lists.update(two.places));
    model::gatherForces(pair, lists, two.pack(), 0, 2, forces.data(), torques.data());
  }
  Points forces, torques;
};

TEST(PairForces, AreMinusTheGradientOfTheEnergyByPlaceAndTurn) {
  for (const bool is_anisotropic : {false, true}) {
    const model::PairPotentials pair = makePair(is_anisotropic);
    const TwoParticles two = askew();
    const Pull pull(pair, two);
    const double h = 1e-6;
    for (int i = 0; i < 2; ++i)
      for (int c = 0; c < 3; ++c) {
        const Vec3 step = h * Vec3::Unit(c);
        const double by_place = (two.moved(i, step).energy(pair) - two.moved(i, -step).energy(pair)) / (2.0 * h);
        const double by_turn = (two.turned(i, step).energy(pair) - two.turned(i, -step).energy(pair)) / (2.0 * h);
        EXPECT_NEAR(pull.forces[i][c], -by_place, 1e-6 * pull.forces[i].norm()) << is_anisotropic << i << c;
        EXPECT_NEAR(pull.torques[i][c], -by_turn, 1e-6 * pull.torques[i].norm()) << is_anisotropic << i << c;
      }
  }
}

TEST(PairForces, KeepMomentumAndAngularMomentum) {
  const TwoParticles two = askew();
  const Pull pull(makePair(false), two);
  EXPECT_LT((pull.forces[0] + pull.forces[1]).norm(), 1e-12 * pull.forces[0].norm());
  const Vec3 moment = two.places[1].cross(pull.forces[1]) + pull.torques[0] + pull.torques[1];
  EXPECT_LT(moment.norm(), 1e-12 * pull.torques[0].norm());
}

TEST(PairForces, EndAtTheCutoff) {
  const model::PairPotentials pair = makePair(false);
  TwoParticles two = askew();
  two.places[1] = Vec3(1.001 * pair.cutoff, 0.0, 0.0);
  const Pull pull(pair, two);
  for (int i = 0; i < 2; ++i) {
    EXPECT_TRUE(pull.forces[i].isZero(0.0));
    EXPECT_TRUE(pull.torques[i].isZero(0.0));
  }
  EXPECT_EQ(two.energy(pair), 0.0);
}

TEST(PairForces, OfMeltedParticlesRepelAndDoNotAttract) {
  const model::PairPotentials pair = makePair(false);
  for (const double distance : {0.9, 1.1}) {
    TwoParticles two{{Vec3::Zero(), Vec3(distance * pair.distance, 0.0, 0.0)}, Points(2, Vec3::UnitZ())};
    const double solid = Pull(pair, two).forces[0].x();
    two.strength = 0.0;
    EXPECT_DOUBLE_EQ(Pull(pair, two).forces[0].x(), distance < 1.0 ? solid : 0.0) << distance;
    EXPECT_EQ(solid > 0.0, distance > 1.0);
  }
}

TEST(PairForces, StayFiniteHoweverNearTheParticlesCome) {
  const model::PairPotentials pair = makePair(false);
  TwoParticles two = askew();
  two.places[1] = Vec3(1e-9, 0.0, 0.0);
  const Pull pull(pair, two);
  EXPECT_TRUE(pull.forces[0].allFinite());
  EXPECT_LT(pull.forces[0].x(), 0.0) << "it is pushed away from the other";
}

}  // namespace
}  // namespace deformable_surface::test
