// Contact of a surface with itself where it is cut or torn.
#include "../../src/simulation/self_contact_load.h"
#include "deformable_surface/model/mass_spring/mass_spring.h"
#include "deformable_surface/simulation/rest_surface.h"
#include "self_contact_runs.h"

#include "../support/whole_triangles.h"

namespace deformable_surface::test {
namespace {

using simulation::Simulation;
using Type = solve::IntegratorType;

// The number of triangles that are cut or torn, and the largest number of contacts, in a run in which nothing may cross.
std::pair<std::size_t, Index> runWithCuts(const ContactScene& scene, int steps) {
  Simulation s(scene.params, scene.cloud);
  const simulation::ContactSkin skin(s.state().positions, trianglesOf(s.model()));
  std::size_t cut = 0;
  Index touched = 0;
  for (int k = 0; k < steps; ++k) {
    const simulation::StepOutcome outcome = s.step();
    EXPECT_TRUE(outcome.ok) << k << ": " << outcome.problem;
    if (!outcome.ok) break;
    const std::vector<contact::Triangle> whole = listWhole(skin, s.model());
    cut = std::max(cut, skin.triangles.size() - whole.size());
    EXPECT_TRUE(findCrossings(s.state().positions, whole).empty()) << k;
    touched = std::max(touched, static_cast<Index>(s.statistics().self_contacts));
  }
  return {cut, touched};
}

TEST(SelfContactCuts, WhatIsCutOrTornDoesNotCrossItself) {
  for (const char* name : {"cut_and_drop", "tear_twisted"}) {
    const auto [cut, touched] = runWithCuts(makeScene(name, 3, 0.8), 160);
    EXPECT_GT(cut, 0u) << name;
    EXPECT_GT(touched, 0) << name;
  }
  EXPECT_GT(runWithCuts(makeScene("cut_and_drop", 3, 0.8, Type::kImplicit), 80).first, 0u);
}

// Overlapping triangles are left out of contact. What hangs on links of these alone is a part of its own once they are cut.
TEST(SelfContactCuts, PartsAreThoseOfTheLinksAlsoWhereAllTrianglesOfContactAreWhole) {
  simulation::RestSurface rest = simulation::buildRestSurface(hangingSheet(), sheetCloud());
  auto& model = dynamic_cast<model::MassSpring&>(*rest.model);
  std::vector<model::WeightedTriangle> left;
  for (const model::WeightedTriangle& t : model.triangles())
    if (std::all_of(t.corner, t.corner + 3, [&](Index i) { return rest.points[i].x() < 0.5; })) left.push_back(t);
  contact::SelfContactParams params;
  params.thickness = 1e-3;
  simulation::SelfContactLoads loads(rest.points, std::make_shared<const simulation::ContactSkin>(rest.points, left), model,
                                     params);
  const auto countParts = [&] { return 1 + *std::max_element(loads.limit.parts().begin(), loads.limit.parts().end()); };
  EXPECT_EQ(countParts(), 1);
  std::vector<model::MassSpring::Link> cuts;
  for (const auto& [i, j] : model.stretchLinks())
    if ((rest.points[i].x() < 0.7) != (rest.points[j].x() < 0.7)) cuts.emplace_back(i, j);
  model.setCuts(cuts);
  loads.followCut(model);
  EXPECT_EQ(countParts(), 2);
  model.setCuts({});
  loads.followCut(model);
  EXPECT_EQ(countParts(), 1);
}

TEST(SelfContactCuts, TheRunOfACutSurfaceCanBeContinuedCopiedAndReset) {
  ContactScene scene = makeScene("cut_and_drop", 5, 0.8);
  scene.params.contact.friction = 0.3;
  std::uint64_t hash = 0;
  for (const Index threads : {1, 2}) {
    scene.params.threads = threads;
    Simulation s(scene.params, scene.cloud);
    run(s, 40);
    const simulation::Snapshot before = s.snapshot();
    run(s, 80);
    const simulation::Snapshot snapshot = s.snapshot();
    Simulation fork = s.fork();
    run(s, 30);
    run(fork, 30);
    EXPECT_EQ(s.stateHash(), fork.stateHash());
    if (threads == 1) hash = s.stateHash();
    EXPECT_EQ(s.stateHash(), hash);
    s.restore(before);
    run(s, 80);
    Simulation again = s.fork();
    run(again, 30);
    EXPECT_EQ(again.stateHash(), hash);
    s.restore(snapshot);
    run(s, 30);
    EXPECT_EQ(s.stateHash(), hash);
    s.reset();
    run(s, 150);
    EXPECT_EQ(s.stateHash(), hash);
  }
}

}  // namespace
}  // namespace deformable_surface::test
