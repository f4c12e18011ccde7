// Cuts and other materials change a mass-spring surface. Undoing them restores the surface.
#include "deformable_surface/model/mass_spring/mass_spring.h"
#include "model_checks.h"

namespace deformable_surface::test {
namespace {

using model::MassSpring;

struct Sheet {
  explicit Sheet(model::Membrane membrane = model::Membrane::kTriangles) {
    model::MassSpringParams params;
    params.membrane = membrane;
    model = std::make_unique<MassSpring>(surface.points, surface.normals, surface.rings, surface.area, false,
                                         model::MaterialParams{}, params);
    for (Vec3& p : stretched) p.x() *= 1.02;
  }
  Points forces() const { return forcesAt(*model, stateAt(stretched)); }
  // The link from a point in the middle to its neighbour.
  MassSpring::Link link() const { return std::minmax(kMiddle, surface.rings.ring.begin(kMiddle)[0]); }

  static constexpr Index kMiddle = 24;
  Surface surface = makeSheet(7, 7, 1.0, 1.0, 0.1);
  std::unique_ptr<MassSpring> model;
  Points stretched = surface.points;
};

TEST(MassSpringChanges, ScaleForcesByTheStretchingAndMassesByTheDensity) {
  Sheet s;
  const Points before = s.forces();
  const std::vector<double> masses = s.model->masses();
  s.model->setMaterial(std::vector<model::PointMaterial>(masses.size(), {2.0, 1.0, 3.0}));
  const Points after = s.forces();
  for (std::size_t i = 0; i < masses.size(); ++i) {
    EXPECT_LT((after[i] - 2.0 * before[i]).norm(), 1e-9 * largest(before)) << i;
    EXPECT_DOUBLE_EQ(s.model->masses()[i], 3.0 * masses[i]) << i;
  }
}

TEST(MassSpringChanges, TakeTheMeanBetweenPointsOfTwoMaterials) {
  Sheet s(model::Membrane::kSprings);
  const Points before = s.forces();
  std::vector<model::PointMaterial> half(s.surface.points.size());
  for (std::size_t i = 0; i < half.size(); ++i) half[i].stretching = s.surface.points[i].x() < 0.5 ? 1.0 : 3.0;
  s.model->setMaterial(half);
  checkForcesAreMinusTheGradient(*s.model, perturb(s.stretched, 0.01), 0.1);
  EXPECT_GT(largest(s.forces()), 1.5 * largest(before));
}

TEST(MassSpringChanges, CutALinkWithItsTrianglesAndMakeItWholeAgainToTheBit) {
  for (const model::Membrane membrane : {model::Membrane::kTriangles, model::Membrane::kSprings}) {
    Sheet s(membrane);
    const Points before = s.forces();
    const std::size_t triangles = s.model->triangles().size();
    s.model->setCuts({s.link()});
    EXPECT_LT(s.model->triangles().size(), triangles);
    const std::vector<MassSpring::Link>& cuts = s.model->cuts();
    EXPECT_TRUE(std::find(cuts.begin(), cuts.end(), s.link()) != cuts.end());
    EXPECT_NE(s.forces()[Sheet::kMiddle], before[Sheet::kMiddle]);
    checkForcesAreMinusTheGradient(*s.model, perturb(s.stretched, 0.01), 0.1);
    s.model->setCuts({});
    EXPECT_EQ(s.forces(), before);
  }
}

}  // namespace
}  // namespace deformable_surface::test
