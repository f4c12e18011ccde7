// Forces in a part of a mass-spring surface are exactly those in the whole surface.
#include "deformable_surface/model/mass_spring/mass_spring.h"
#include "model_checks.h"

#include <gtest/gtest.h>

namespace deformable_surface::test {
namespace {

using model::Bending;
using model::MassSpring;
using model::MassSpringParams;
using model::Membrane;

struct Variant {
  const char* name;
  Membrane membrane;
  Bending bending;
  model::Damping damping;
  bool sphere;
  double jitter = 0.3;  // of the sheet, in spacings; without it every cell has four triangles on four points
};

const Variant kVariants[] = {
    {"TrianglesAndCurvature", Membrane::kTriangles, Bending::kCurvature, model::Damping::kAlongSpring, false},
    {"TrianglesAndCurvatureOnASphere", Membrane::kTriangles, Bending::kCurvature, model::Damping::kAlongSpring, true},
    {"SpringsAsPublished", Membrane::kSprings, Bending::kSprings, model::Damping::kRelativeVelocity, false},
    {"TrianglesAlone", Membrane::kTriangles, Bending::kNone, model::Damping::kAlongSpring, true},
    {"TrianglesOnAGrid", Membrane::kTriangles, Bending::kNone, model::Damping::kAlongSpring, false, 0.0},
    {"TrianglesAndCurvatureOnAGrid", Membrane::kTriangles, Bending::kCurvature, model::Damping::kAlongSpring, false, 0.0},
};

class MassSpringParts : public testing::TestWithParam<Variant> {
 protected:
  static constexpr double kLength = 0.05;  // spacing

  MassSpringParts() : surface(GetParam().sphere ? makeSphere(400, 0.3) : makeSheet(17, 16, 0.8, 0.75, GetParam().jitter)) {
    material.thickness = 0.02;
    material.spring_damping = 1e-3;
    material.poisson_ratio = 1.0 / 3.0;
    params.membrane = GetParam().membrane;
    params.bending = GetParam().bending;
    params.damping = GetParam().damping;
    whole = build();
    state = stateAt(perturb(surface.points, 0.3 * kLength));
    std::mt19937 generator(3);
    for (Vec3& v : state.velocities) v = randomVector(generator);
    for (const Vec3& x : surface.points) wanted.push_back(x.x() > 0.1 && x.x() < 0.26 && x.y() < 0.1);
  }

  std::unique_ptr<MassSpring> build() const {
    return std::make_unique<MassSpring>(surface.points, surface.normals, surface.rings, surface.area, surface.isClosed(),
                                        material, params);
  }

  // Some points are wanted, fewer than the part has. Their forces are the same.
  void checkPart() {
    const model::Partition::Part part = whole->makePart(wanted);
    ASSERT_TRUE(part.model);
    ASSERT_LT(part.points.size(), surface.points.size());
    State partial;
    for (const Index i : part.points) {
      partial.positions.push_back(state.positions[i]);
      partial.velocities.push_back(state.velocities[i]);
    }
    const auto compare = [&](const char* what, const auto& compute) {
      Points all(surface.points.size(), Vec3::Zero()), some(part.points.size(), Vec3::Zero());
      compute(*whole, state, all);
      compute(*part.model, partial, some);
      Index compared = 0;
      for (std::size_t k = 0; k < part.points.size(); ++k) {
        if (!wanted[part.points[k]]) continue;
        EXPECT_EQ(some[k], all[part.points[k]]) << what << " of point " << part.points[k];
        ++compared;
      }
      EXPECT_GT(compared, 10);
    };
    using Model = model::DeformableModel;
    compare("force", [](const Model& m, const State& s, Points& f) { m.addForces(s, f); });
    compare("area", [](const Model& m, const State& s, Points& f) { m.sides()->computeAreaVectors(s, f); });
    ASSERT_EQ(part.model->splitForces() != nullptr, whole->splitForces() != nullptr);
    if (whole->splitForces()) {
      compare("fast force", [](const Model& m, const State& s, Points& f) { m.splitForces()->addFastForces(s, f); });
      compare("slow force", [](const Model& m, const State& s, Points& f) { m.splitForces()->addSlowForces(s, f); });
    }
    EXPECT_EQ(part.model->forcesReadVelocities(), whole->forcesReadVelocities());
    for (std::size_t k = 0; k < part.points.size(); ++k) EXPECT_EQ(part.model->masses()[k], whole->masses()[part.points[k]]);
  }

  Surface surface;
  model::MaterialParams material;
  MassSpringParams params;
  std::unique_ptr<MassSpring> whole;
  State state;
  std::vector<char> wanted;
};

TEST_P(MassSpringParts, WantedPointsAreForcedBitForBitAsByTheWhole) { checkPart(); }

TEST_P(MassSpringParts, SoTheyAreWhereAPatchIsHeld) {
  std::vector<char> held;
  for (const Vec3& x : surface.points) held.push_back(x.x() > 0.2);
  whole->setHeld(held, edgesAtPoints(surface, held));
  checkPart();
}

TEST_P(MassSpringParts, ForcesDependOnTheMarkedPartnersAlone) {
  std::vector<Index> points;
  for (std::size_t i = 0; i < wanted.size(); ++i)
    if (wanted[i]) points.push_back(static_cast<Index>(i));
  std::vector<char> marked = wanted;
  ASSERT_TRUE(whole->markPartners(points, marked));
  ASSERT_LT(std::count(marked.begin(), marked.end(), 1), static_cast<long>(marked.size()));
  Points before(wanted.size(), Vec3::Zero()), after = before;
  whole->addForces(state, before);
  for (std::size_t i = 0; i < marked.size(); ++i)
    if (!marked[i]) state.positions[i] += Vec3(0.1, -0.2, 0.3) * kLength;
  whole->addForces(state, after);
  for (const Index i : points) EXPECT_EQ(after[i], before[i]);
}

INSTANTIATE_TEST_SUITE_P(, MassSpringParts, testing::ValuesIn(kVariants),
                         [](const auto& info) { return std::string(info.param.name); });

TEST(MassSpringPartsOfAKeptVolume, ThereAreNone) {
  const Surface sphere = makeSphere(200, 0.3);
  MassSpringParams params;
  params.volume_stiffness = 1e4;
  const MassSpring whole(sphere.points, sphere.normals, sphere.rings, sphere.area, true, model::MaterialParams(), params);
  std::vector<char> marked(sphere.points.size(), 0);
  EXPECT_FALSE(whole.markPartners({0}, marked));
  marked[0] = 1;
  EXPECT_FALSE(whole.makePart(marked).model);
}

}  // namespace
}  // namespace deformable_surface::test
