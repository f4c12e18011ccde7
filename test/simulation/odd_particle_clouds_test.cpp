// Clouds that are hardly a surface, as oriented particles, also grown: refused with a sentence, or sound.
#include "deformable_surface/base/error.h"
#include "deformable_surface/io/shapes.h"
#include "deformable_surface/simulation/expectations.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace deformable_surface::simulation {
namespace {

constexpr double kSpacing = 0.1;
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

enum class Fitting { kNone, kAtStart, kLater };
constexpr Fitting kFittings[] = {Fitting::kNone, Fitting::kAtStart, Fitting::kLater};

SceneParams makeParams(Fitting fitting) {
  SceneParams p;
  p.model = "oriented_particles";
  p.simplification.method = cloud::SimplificationMethod::kNone;
  p.gravity.setZero();
  p.oriented_particles.spacing = kSpacing;
  p.oriented_particles.grow_surface = fitting == Fitting::kAtStart;
  p.material.bending_rigidity = 0.3 * p.material.young_modulus * p.material.thickness * kSpacing * kSpacing;
  return p;
}

Simulation make(const SceneParams& params, const Points& points) {
  cloud::PointCloud cloud;
  cloud.positions = points;
  cloud.width = static_cast<std::uint32_t>(points.size());
  return {params, cloud};
}

std::string refusal(const SceneParams& params, const Points& points) {
  try {
    make(params, points);
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

// Grown if asked, then stepped. The result is at rest, or as far as bonds let a particle fly in that time.
void expectSound(Fitting fitting, const Points& points, Index expected) {
  Simulation s = make(makeParams(fitting), points);
  if (fitting == Fitting::kLater) s.growSurface(s.params().oriented_particles.growth);
  EXPECT_EQ(s.state().size(), expected) << static_cast<int>(fitting);
  const Points before = s.state().positions;
  for (int k = 0; k < 10; ++k) {
    const StepOutcome outcome = s.step();
    ASSERT_TRUE(outcome.ok) << outcome.problem;
  }
  for (Index i = 0; i < s.state().size(); ++i) EXPECT_LT((s.state().positions[i] - before[i]).norm(), 0.01 * kSpacing);
}

Points makeSheet() {
  Points sheet;
  for (int j = 0; j < 8; ++j)
    for (int i = 0; i < 8; ++i) sheet.emplace_back(kSpacing * (i + 0.5 * (j % 2)), kSpacing * std::sqrt(0.75) * j, 0.0);
  return sheet;
}

TEST(OddParticleClouds, OfFewerThanThreePlacesAreRefused) {
  for (const Fitting fitting : kFittings) {
    const SceneParams params = makeParams(fitting);
    const Vec3 a(1.0, 2.0, 3.0), nowhere(kNaN, 0.0, 0.0);
    const std::vector<std::pair<Points, std::string>> cases{{{}, "found 0 finite"},
                                                            {{a}, "found 1 finite"},
                                                            {{a, a, a, a}, "found 1 finite"},
                                                            {{a, a, 2.0 * a}, "found 2 finite"},
                                                            {{nowhere, nowhere, nowhere}, "found 0 finite"}};
    for (const auto& [points, found] : cases) {
      const std::string sentence = refusal(params, points);
      EXPECT_NE(sentence.find(found), std::string::npos) << sentence;
      EXPECT_NE(sentence.find("accepted: at least 3"), std::string::npos) << sentence;
    }
  }
}

TEST(OddParticleClouds, OfThreePointsAreATriangleOrPointsOnTheirOwn) {
  const Vec3 a = Vec3::Zero(), b(kSpacing, 0.0, 0.0), c(0.5 * kSpacing, std::sqrt(0.75) * kSpacing, 0.0), nowhere(0.0, kNaN, 0.0);
  for (const Fitting fitting : kFittings) {
    expectSound(fitting, {a, b, c}, 3);
    expectSound(fitting, {a, nowhere, b, c, c}, 3);
    expectSound(fitting, {a, b, 2.0 * b}, 3);        // in line
    expectSound(fitting, {a, 5.0 * b, 5.0 * c}, 3);  // out of each other's reach, and farther than max_gap
  }
  SceneParams params = makeParams(Fitting::kNone);
  params.oriented_particles.spacing = {};
  EXPECT_NE(refusal(params, {a, b, 2.0 * b}).find("span no surface"), std::string::npos);
}

// Points that are not finite leave holes, which growth closes as far as it may. Duplicates exist once.
TEST(OddParticleClouds, WithHolesAndDoublesAreASheetLikeAnyOther) {
  Points sheet = makeSheet();
  sheet[27] = Vec3(0.0, 0.0, std::numeric_limits<double>::infinity());  // in the middle
  const Points once = sheet;
  sheet.insert(sheet.end(), once.begin(), once.end());
  expectSound(Fitting::kNone, sheet, 63);
  expectSound(Fitting::kAtStart, sheet, 64);
  expectSound(Fitting::kLater, sheet, 64);
  sheet[3].x() = 2e6;  // its double is still there
  expectSound(Fitting::kNone, sheet, 63);
  const Simulation s = make(makeParams(Fitting::kNone), sheet);
  const auto tells = [](const std::string& note) { return note.find("3 input points are not finite, or beyond 1e6 m") == 0; };
  EXPECT_TRUE(std::any_of(s.buildNotes().begin(), s.buildNotes().end(), tells));
}

TEST(OddParticleClouds, OfWhichOneParticleIsLeftGoOnAndCanBeFitted) {
  Simulation s = make(makeParams(Fitting::kNone), makeSheet());
  ParticleEdit edit;
  edit.action = ParticleAction::kDelete;
  for (int id = 1; id < 64; ++id) edit.ids.push_back(id);
  s.editParticles(edit);
  ASSERT_EQ(s.state().size(), 1);
  ASSERT_TRUE(s.step().ok);
  s.growSurface(s.params().oriented_particles.growth);
  EXPECT_EQ(s.state().size(), 1);
  ASSERT_TRUE(s.step().ok);
  EXPECT_EQ(computeQuantity("isolated", s), 1.0);
  // It grows into the open where rows are requested.
  model::GrowthParams growth;
  growth.edge_rows = 2;
  s.growSurface(growth);
  EXPECT_EQ(s.state().size(), 19);  // a hexagon of two rows
  EXPECT_EQ(computeQuantity("euler_characteristic", s), 1.0);
}

TEST(OddParticleClouds, AreGrownThroughWhateverNoiseIsStated) {
  SceneParams params = makeParams(Fitting::kAtStart);
  params.cloud.shape = CloudParams::Shape::kSphere;
  params.cloud.points = 80;
  params.cloud.jitter = 0.2;
  params.oriented_particles.spacing = 0.16;
  params.material.bending_rigidity = params.material.young_modulus * params.material.thickness * 0.16 * 0.16;
  model::GrowthParams& growth = params.oriented_particles.growth;
  growth.min_gap = 1.6;
  growth.max_gap = 5.0;
  growth.clearance = 0.65;
  for (const double noise : {0.0, 1e-300, 1.0}) {
    growth.noise = noise;
    Simulation s(params, io::makeShape(params.cloud));
    EXPECT_EQ(computeQuantity("euler_characteristic", s), 2.0) << noise;
    EXPECT_EQ(computeQuantity("isolated", s), 0.0) << noise;
    ASSERT_TRUE(s.step().ok);
    EXPECT_LT(computeQuantity("distance_to_shape_rms", s), 0.1 * 0.16) << noise;
  }
  Simulation s = make(makeParams(Fitting::kNone), makeSheet());
  for (const double noise : {-0.1, 1.1, kNaN}) {
    growth.noise = noise;
    EXPECT_THROW(s.growSurface(growth), InputError) << noise;
  }
}

}  // namespace
}  // namespace deformable_surface::simulation
