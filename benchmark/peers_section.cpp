// Part 14: other programs beside this one in the same run, each with its error: a hanging sheet with Bullet's deformable bodies,
// and what peers_clouds.cpp and peers_contact.cpp compare. Only what is installed when the benchmark is configured takes part;
// nothing of it is linked into the package.
#include "../src/simulation/dynamics.h"
#include "deformable_surface/base/parallel.h"
#include "peers_clouds.h"
#include "peers_contact.h"
#include "sections.h"
#include "swinging_sheet.h"

#include <algorithm>
#include <cmath>

#ifdef DEFORMABLE_SURFACE_WITH_BULLET
#include <BulletSoftBody/btDeformableBodySolver.h>
#include <BulletSoftBody/btDeformableGravityForce.h>
#include <BulletSoftBody/btDeformableMassSpringForce.h>
#include <BulletSoftBody/btDeformableMultiBodyConstraintSolver.h>
#include <BulletSoftBody/btDeformableMultiBodyDynamicsWorld.h>
#include <BulletSoftBody/btSoftBodyHelpers.h>
#include <BulletSoftBody/btSoftBodyRigidBodyCollisionConfiguration.h>
#include <btBulletCollisionCommon.h>
#endif

namespace deformable_surface::benchmark {
namespace {

using simulation::SceneParams;
using simulation::Simulation;

constexpr Index kSide = 64;
constexpr double kMass = 0.2;          // kg
constexpr double kDuration = 0.5;      // s: it swings through its lowest place
constexpr double kFrame = 1.0 / 60.0;  // s

struct Forces {
  model::Membrane membrane;
  model::Bending bending;
};

SceneParams makeScene(const Forces& forces, double time_step) {
  SceneParams scene = makeHangingScene(time_step);
  scene.mass_spring.membrane = forces.membrane;
  scene.mass_spring.bending = forces.bending;
  return scene;
}

// Sub-steps taken, positions at the end and the processor time that a simulated second took.
struct Run {
  long substeps = 0;
  Points end;
  double seconds = 0.0;
};

// In so many times as many sub-steps as the stable step asks for.
Run runOurs(const Forces& forces, Index fineness) {
  Simulation sheet(makeScene(forces, kFrame), makeHangingSheet(kSide));
  sheet.dynamics().setFineness(fineness);
  const long steps = std::lround(kDuration / kFrame);
  Run run;
  const double before = processorSeconds();
  for (long k = 0; k < steps; ++k) {
    if (!sheet.step().ok) return run;
    run.substeps += sheet.dynamics().lastSubsteps();
  }
  run.seconds = (processorSeconds() - before) / kDuration;
  run.end = sheet.state().positions;
  return run;
}

void addOurs(const char* name, const Forces& forces, Report& report) {
  // Not extrapolated: without bending the sheet wrinkles so that no two runs agree, however fine.
  constexpr Index kFine = 8, kFinest = 16;
  Run timed = runOurs(forces, 1);
  for (int again = 0; again < 2; ++again) timed.seconds = std::min(timed.seconds, runOurs(forces, 1).seconds);
  const Run fine = runOurs(forces, kFine), finest = runOurs(forces, kFinest);
  if (timed.end.empty() || fine.end.empty() || finest.end.empty())
    return report.add({name, std::to_string(kSide * kSide), "-", "-", "failed", "-"});
  report.add({name, std::to_string(kSide * kSide), std::to_string(timed.substeps), show(timed.seconds),
              show(rmsDistance(timed.end, finest.end)), show(rmsDistance(fine.end, finest.end))});
}

#ifdef DEFORMABLE_SURFACE_WITH_BULLET
// Bullet's springs between neighbours along both axes and both diagonals, explicit, with so many sub-steps a frame.
Run runBullet(int substeps) {
  btSoftBodyRigidBodyCollisionConfiguration configuration;
  btCollisionDispatcher dispatcher(&configuration);
  btDbvtBroadphase broadphase;
  btDeformableBodySolver bodies;
  btDeformableMultiBodyConstraintSolver constraints;
  constraints.setDeformableSolver(&bodies);
  btDeformableMultiBodyDynamicsWorld world(&dispatcher, &broadphase, &constraints, &configuration, &bodies);
  const btVector3 gravity(0.0f, 0.0f, -9.81f);
  world.setGravity(gravity);
  world.getWorldInfo().m_gravity = gravity;
  world.setImplicit(false);
  btSoftBody* sheet =
      btSoftBodyHelpers::CreatePatch(world.getWorldInfo(), btVector3(-0.5f, -0.5f, 0.0f), btVector3(0.5f, -0.5f, 0.0f),
                                     btVector3(-0.5f, 0.5f, 0.0f), btVector3(0.5f, 0.5f, 0.0f), kSide, kSide, 0, true);
  sheet->setTotalMass(static_cast<btScalar>(kMass));
  for (int i = 0; i < sheet->m_nodes.size(); ++i) {
    const btVector3& x = sheet->m_nodes[i].m_x;
    if (x.x() < -0.499f && std::abs(x.y()) > 0.499f) sheet->setMass(i, 0.0f);
  }
  sheet->m_cfg.collisions = 0;
  sheet->m_sleepingThreshold = 0.0f;
  sheet->setActivationState(DISABLE_DEACTIVATION);
  world.addSoftBody(sheet);
  const model::MaterialParams material = makeHangingScene(kFrame).material;
  btDeformableMassSpringForce springs(static_cast<btScalar>(material.young_modulus * material.thickness), 0.0f, true);
  btDeformableGravityForce weight(gravity);
  world.addForce(sheet, &springs);
  world.addForce(sheet, &weight);
  Run run;
  const double before = processorSeconds();
  const int frames = static_cast<int>(std::lround(kDuration / kFrame));
  for (int k = 0; k < frames; ++k)
    world.stepSimulation(static_cast<btScalar>(kFrame), substeps, static_cast<btScalar>(kFrame / substeps));
  run.seconds = (processorSeconds() - before) / kDuration;
  run.substeps = static_cast<long>(frames) * substeps;
  for (int i = 0; i < sheet->m_nodes.size(); ++i) {
    const btVector3& x = sheet->m_nodes[i].m_x;
    run.end.emplace_back(x.x(), x.y(), x.z());
  }
  world.removeSoftBody(sheet);
  delete sheet;
  return run;
}
#endif

void addBullet(Report& report) {
#ifdef DEFORMABLE_SURFACE_WITH_BULLET
  // Its error is of first order in the step: extrapolated from the two finest.
  constexpr int kSubsteps[] = {64, 128, 256};
  std::vector<Run> runs;
  for (const int substeps : kSubsteps) runs.push_back(runBullet(substeps));
  Points converged(runs[2].end.size());
  for (std::size_t i = 0; i < converged.size(); ++i) converged[i] = 2.0 * runs[2].end[i] - runs[1].end[i];
  for (const Run& run : runs) {
    const double error = rmsDistance(run.end, converged);
    report.add({"Bullet " + std::to_string(btGetVersion() / 100) + "." + std::to_string(btGetVersion() % 100) +
                    ", springs, explicit, float",
                std::to_string(kSide * kSide), std::to_string(run.substeps), show(run.seconds),
                std::isfinite(error) ? show(error) : "diverges", show(rmsDistance(runs[2].end, converged))});
  }
#else
  report.add({"Bullet", "-", "-", "-", "not installed (libbullet-dev)", "-"});
#endif
}

}  // namespace

void runPeersSection(const Options& options, Report& report) {
  setNumThreads(1);
  if (options.scene == "contact") {
    compareContact(report);
    return setNumThreads(0);
  }
  report.begin("peers_sheet",
               "14. A sheet of " + std::to_string(kSide * kSide) + " points that hangs from two corners, " + show(kDuration) +
                   " s, frames of 1/60 s, one thread",
               {"program", "points", "substeps", "cpu_s_per_simulated_s", "rms_error_m", "error_uncertain_by_m"});
  addOurs("deformable_surface, springs", {model::Membrane::kSprings, model::Bending::kNone}, report);
  addOurs("deformable_surface, springs and curvature", {model::Membrane::kSprings, model::Bending::kCurvature}, report);
  addOurs("deformable_surface, triangles and curvature (default)", {model::Membrane::kTriangles, model::Bending::kCurvature},
          report);
  addBullet(report);
  report.end();
  report.note(
      "error: rms against the same program's own finer runs, since the networks are not the same: of this one the finest, in "
      "16 times as "
      "many sub-steps, uncertain by its distance from that in 8 times as many; of Bullet Richardson's extrapolation");
  compareNeighbors(options, report);
  compareNormals(options, report);
  if (options.large) compareContact(report);
  setNumThreads(0);
}

}  // namespace deformable_surface::benchmark
