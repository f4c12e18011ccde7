// The bound of a pair's stiffness holds against second differences of its energy, and ends with the forces.
#include "pairs.h"

#include <algorithm>

namespace deformable_surface::test {
namespace {

using Move = TwoParticles (TwoParticles::*)(int, const Vec3&) const;

// The largest second difference of the energy, by positions or rotations of either particle. Bonds beyond their largest force
// count as not stiff.
double findLargest(const model::PairPotentials& pair, const TwoParticles& two, Move move, double h) {
  double largest = 0.0;
  for (int i = 0; i < 2; ++i)
    for (int c = 0; c < 3; ++c) {
      const Vec3 step = h * Vec3::Unit(c);
      const double bent = (two.*move)(i, step).energy(pair) - 2.0 * two.energy(pair) + (two.*move)(i, -step).energy(pair);
      largest = std::max(largest, bent / (h * h));
    }
  return largest;
}

TEST(PairStiffness, IsNoLessThanTheSecondDerivativesOfTheEnergy) {
  for (const bool is_anisotropic : {false, true})
    for (const double distance : {0.5, 0.8, 1.0, 1.2, 1.5}) {
      const model::PairPotentials pair = makePair(is_anisotropic);
      TwoParticles two = askew();
      two.places[1] *= distance * pair.distance / two.places[1].norm();
      const model::PackedParticles packed = two.pack();
      const model::PairStiffness bound = model::boundStiffness(pair, packed, 0, 1);
      EXPECT_GE(bound.x * 1.001, findLargest(pair, two, &TwoParticles::moved, 1e-6)) << is_anisotropic << " " << distance;
      EXPECT_GE(bound.z * 1.001, findLargest(pair, two, &TwoParticles::turned, 1e-4)) << is_anisotropic << " " << distance;
    }
}

TEST(PairStiffness, IsNothingBeyondTheCutoff) {
  const model::PairPotentials pair = makePair(false);
  TwoParticles two = askew();
  two.places[1] = Vec3(1.001 * pair.cutoff, 0.0, 0.0);
  const model::PairStiffness bound = model::boundStiffness(pair, two.pack(), 0, 1);
  EXPECT_EQ(bound.x, 0.0);
  EXPECT_EQ(bound.y, 0.0);
  EXPECT_EQ(bound.z, 0.0);
}

}  // namespace
}  // namespace deformable_surface::test
