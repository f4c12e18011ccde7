// Forces in a part of an elastic solid are those in the whole solid.
#include "model_checks.h"
#include "solids.h"

#include <gtest/gtest.h>

namespace deformable_surface::test {
namespace {

using model::ElasticSolid;
using model::Hessian;

struct Variant {
  const char* name;
  model::SolidLaw law;
  bool is_planar;
};

const Variant kVariants[] = {
    {"Corotated", model::SolidLaw::kCorotated, false},   {"Linear", model::SolidLaw::kLinear, false},
    {"NeoHookean", model::SolidLaw::kNeoHookean, false}, {"CorotatedInAPlane", model::SolidLaw::kCorotated, true},
    {"LinearInAPlane", model::SolidLaw::kLinear, true},
};

class ElasticSolidPart : public testing::TestWithParam<Variant> {
 protected:
  static constexpr double kSpacing = 0.1;

  ElasticSolidPart()
      : rest(GetParam().is_planar ? makeBox(30, 12, 1, kSpacing, 0.2) : makeBox(20, 6, 6, kSpacing, 0.2)), whole(make(rest)) {
    // The body is rotated as a whole, and every point is displaced.
    std::mt19937 generator(5);
    const Mat3 turn =
        Eigen::AngleAxisd(0.7, GetParam().is_planar ? Vec3(0.0, 0.0, 1.0) : Vec3(1.0, 2.0, 2.0).normalized()).toRotationMatrix();
    for (const Vec3& x : rest) {
      Vec3 shift = 0.1 * kSpacing * randomVector(generator);
      if (GetParam().is_planar) shift.z() = 0.0;
      state.positions.push_back(turn * x + shift);
      wanted.push_back(x.x() < 4.6 * kSpacing);
    }
    state.velocities.assign(rest.size(), Vec3::Zero());
  }

  static ElasticSolid make(const Points& points) {
    SolidOptions options;
    options.params.law = GetParam().law;
    return GetParam().is_planar ? makePlanarSolid(points, options) : makeSolid(points, options);
  }

  static Points forcesOf(const model::DeformableModel& m, const State& s) {
    Points forces(s.positions.size(), Vec3::Zero());
    m.addForces(s, forces);
    return forces;
  }

  // The largest difference on the wanted points, relative to the largest value.
  double compare(const Points& all, const Points& some, const std::vector<Index>& points) const {
    double difference = 0.0, largest = 0.0;
    for (std::size_t k = 0; k < points.size(); ++k) {
      if (!wanted[points[k]]) continue;
      difference = std::max(difference, (some[k] - all[points[k]]).norm());
      largest = std::max(largest, all[points[k]].norm());
    }
    EXPECT_GT(largest, 0.0);
    return difference / largest;
  }

  Points rest;
  ElasticSolid whole;
  State state;
  std::vector<char> wanted;
};

// Four points are rotated together until the last of them has converged. In a part other points are in the group: equal up to
// rounding.
constexpr double kRounding = 1e-12;

TEST_P(ElasticSolidPart, PushesItsPointsAsTheWholeDoes) {
  const model::Partition::Part part = whole.makePart(wanted);
  ASSERT_TRUE(part.model);
  ASSERT_LT(part.points.size(), 0.6 * rest.size());
  State partial;
  for (const Index i : part.points) partial.positions.push_back(state.positions[i]);
  partial.velocities.assign(part.points.size(), Vec3::Zero());
  EXPECT_LT(compare(forcesOf(whole, state), forcesOf(*part.model, partial), part.points), kRounding);

  // The same for the stiffness.
  std::mt19937 generator(9);
  Points motion(rest.size()), partial_motion;
  for (Vec3& v : motion) v = randomVector(generator);
  for (const Index i : part.points) partial_motion.push_back(motion[i]);
  Points product(rest.size(), Vec3::Zero()), partial_product(part.points.size(), Vec3::Zero());
  whole.prepareStiffness(state, Hessian::kExact);
  whole.addStiffnessProduct(motion, product);
  part.model->stiffnessProducts()->prepareStiffness(partial, Hessian::kExact);
  part.model->stiffnessProducts()->addStiffnessProduct(partial_motion, partial_product);
  EXPECT_LT(compare(product, partial_product, part.points), kRounding);

  for (std::size_t k = 0; k < part.points.size(); ++k) EXPECT_EQ(part.model->masses()[k], whole.masses()[part.points[k]]);
  if (GetParam().law == model::SolidLaw::kNeoHookean) {  // the stiffest point may lie outside of the part
    EXPECT_GE(part.model->findStableStep(partial), whole.findStableStep(state));
  } else {
    EXPECT_EQ(part.model->findStableStep(partial), whole.findStableStep(state));
  }
}

// Motion in the part changes the energy of the part as it changes that of the whole.
TEST_P(ElasticSolidPart, HasTheEnergyOfWhatItMoves) {
  const model::Partition::Part part = whole.makePart(wanted);
  State partial;
  for (const Index i : part.points) partial.positions.push_back(state.positions[i]);
  partial.velocities.assign(part.points.size(), Vec3::Zero());
  const double before = whole.elasticEnergy(state), partial_before = part.model->elasticEnergy(partial);
  std::mt19937 generator(11);
  for (std::size_t k = 0; k < part.points.size(); ++k) {
    if (!wanted[part.points[k]]) continue;
    const Vec3 shift = 0.05 * kSpacing * randomVector(generator);
    state.positions[part.points[k]] += shift;
    partial.positions[k] += shift;
  }
  const double change = whole.elasticEnergy(state) - before;
  EXPECT_GT(std::abs(change), 1e-3 * before);
  EXPECT_NEAR(part.model->elasticEnergy(partial) - partial_before, change, 1e-11 * before);
}

// A poke changes nothing beyond the marked partners.
TEST_P(ElasticSolidPart, MarksAllOnWhichAPointsForceDepends) {
  const Index poked = static_cast<Index>(rest.size() / 2) + (GetParam().is_planar ? 6 : 0);  // inside
  std::vector<char> marked(rest.size(), 0);
  ASSERT_TRUE(whole.markPartners({poked}, marked));
  EXPECT_TRUE(marked[poked]);
  const Points before = forcesOf(whole, state);
  state.positions[poked] += Vec3(0.02, 0.01, 0.0) * kSpacing;
  const Points after = forcesOf(whole, state);
  const double largest = after[poked].norm();
  Index changed = 0;
  for (std::size_t i = 0; i < rest.size(); ++i) {
    if (marked[i]) {
      changed += (after[i] - before[i]).norm() > kRounding * largest;
    } else {
      EXPECT_LE((after[i] - before[i]).norm(), kRounding * largest) << i;
    }
  }
  EXPECT_GT(changed, 20);
}

INSTANTIATE_TEST_SUITE_P(, ElasticSolidPart, testing::ValuesIn(kVariants),
                         [](const auto& info) { return std::string(info.param.name); });

TEST(ElasticSolidParts, ThereAreNoneOfASolidThatMayFlow) {
  SolidOptions options;
  options.params.plasticity.yield_stress = 1e3;
  const Points rest = makeBox(8, 3, 3, 0.1);
  const ElasticSolid solid = makeSolid(rest, options);
  std::vector<char> marked(rest.size(), 0);
  EXPECT_FALSE(solid.markPartners({0}, marked));
  EXPECT_FALSE(solid.makePart(std::vector<char>(rest.size(), 1)).model);
}

}  // namespace
}  // namespace deformable_surface::test
