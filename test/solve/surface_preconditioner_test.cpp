// Properties of the preconditioner of surfaces: symmetric, positive, zero on constrained points, and close to the inverse of the
// stiffness.
#include "../../src/solve/surface_preconditioner.h"

#include "../support/surfaces.h"
#include "deformable_surface/model/mass_spring/mass_spring.h"

#include <gtest/gtest.h>

#include "oscillators.h"

namespace deformable_surface::test {
namespace {

constexpr Index kSide = 9;

struct Sheet {
  Sheet() {
    model::MaterialParams material;
    material.thickness = 0.002;
    model = std::make_unique<model::MassSpring>(surface.points, surface.normals, surface.rings, surface.area, false, material,
                                                model::MassSpringParams{});
    for (const Vec3& p : surface.points) held.push_back(p.x() < 1e-9);
    model->setHeld(held, {});
    system = std::make_unique<solve::System>(*model, loads, held, 0.0);
    // Tension resists motion across the surface.
    for (Vec3& p : state.positions) p *= 1.01;
    EXPECT_TRUE(preconditioner.prepare(*system, state, 0.0));
  }
  Eigen::VectorXd answer(const Eigen::VectorXd& force) {
    Eigen::VectorXd answer;
    preconditioner.apply(*system, force, answer);
    return answer;
  }
  Eigen::VectorXd someForce(unsigned seed) const {
    std::mt19937 generator(seed);
    Eigen::VectorXd force(3 * system->size());
    for (Index i = 0; i < system->size(); ++i) force.segment<3>(3 * i) = held[i] ? Vec3::Zero().eval() : randomVector(generator);
    return force;
  }

  Surface surface = makeSheet(kSide, kSide, 1.0, 1.0, 0.2);
  std::unique_ptr<model::MassSpring> model;
  std::vector<const solve::ExternalLoad*> loads;
  std::vector<char> held;
  State state{surface.points, Points(surface.points.size(), Vec3::Zero())};
  std::unique_ptr<solve::System> system;
  solve::SurfacePreconditioner preconditioner;
};

TEST(SurfacePreconditioner, IsSymmetricPositiveAndZeroOnHeldPoints) {
  Sheet s;
  const Eigen::VectorXd a = s.someForce(1), b = s.someForce(2), pa = s.answer(a), pb = s.answer(b);
  EXPECT_GT(a.dot(pa), 0.0);
  EXPECT_GT(b.dot(pb), 0.0);
  EXPECT_NEAR(a.dot(pb), b.dot(pa), 1e-9 * std::sqrt(a.dot(pa) * b.dot(pb)));
  for (Index i = 0; i < s.system->size(); ++i) EXPECT_TRUE(!s.held[i] || pa.segment<3>(3 * i).isZero(0.0)) << i;
}

// A stretch along x and a sag: two kinds of motion whose stiffnesses differ by orders of magnitude.
TEST(SurfacePreconditioner, UndoesTheStiffnessOfSmoothMotionsWithinASmallFactor) {
  Sheet s;
  BlockSparse stiffness;
  stiffness.begin(s.system->size());
  s.system->addStiffness(0.0, s.state, 0.0, model::Hessian::kExact, stiffness);
  stiffness.finish();
  for (const bool is_sag : {false, true}) {
    Eigen::VectorXd motion(3 * s.system->size()), force;
    for (Index i = 0; i < s.system->size(); ++i) {
      const double x = s.surface.points[i].x();
      motion.segment<3>(3 * i) = is_sag ? Vec3(0.0, 0.0, x * x) : Vec3(x, 0.0, 0.0);
    }
    stiffness.multiply(motion, force);
    for (Index i = 0; i < s.system->size(); ++i)
      if (s.held[i]) force.segment<3>(3 * i).setZero();
    const double ratio = force.dot(s.answer(force)) / force.dot(motion);
    EXPECT_GT(ratio, 0.2) << is_sag;
    EXPECT_LT(ratio, 5.0) << is_sag;
  }
}

TEST(SurfacePreconditioner, KnowsNothingOfModelsWithoutSprings) {
  const Oscillators model({1.0}, 1.0);
  const std::vector<const solve::ExternalLoad*> loads;
  const std::vector<char> held{0};
  const solve::System system(model, loads, held, 0.0);
  EXPECT_FALSE(solve::SurfacePreconditioner().prepare(system, {Points(1, Vec3::Zero()), Points(1, Vec3::Zero())}, 0.0));
}

}  // namespace
}  // namespace deformable_surface::test
