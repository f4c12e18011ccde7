#include "peers_contact.h"

#include "../src/simulation/self_contact_load.h"
#include "../test/support/crossings.h"
#include "deformable_surface/simulation/simulation.h"
#include "swinging_sheet.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

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

using contact::Triangle;

constexpr Index kSide = 64;            // points of the square metre
constexpr double kFrame = 1.0 / 60.0;  // s
constexpr double kMass = 0.2;          // kg
constexpr double kStiffness = 1000.0;  // N/m, E h
constexpr double kDamping = 2.0;       // 1/s, force over mass and velocity
constexpr double kFriction = 0.3;      // between layers, and of the sphere and the table
constexpr double kThickness = 0.006;   // m, at which layers push each other apart
constexpr double kRadius = 0.25;       // m, of the sphere about the origin
constexpr double kGravity = 9.81;      // m/s^2
constexpr double kPatience = 300.0;    // s of processor time for a run

struct Scene {
  const char* name;
  double height;    // m, of the level sheet at the beginning
  bool is_fold;     // on a table at z = 0, with one edge that is carried over the sheet; else above the sphere
  double duration;  // s
};
constexpr Scene kDrape{"drape", kRadius + 0.05, false, 1.0};
constexpr Scene kFold{"fold", 0.005, true, 1.5};

// The carried edge: half an ellipse, in equal times.
constexpr double kCarried = 1.0;  // s
constexpr int kPieces = 20;
Vec3 findWaypoint(int k) {
  const double s = static_cast<double>(k) / kPieces;
  return {0.05 + 0.45 * std::cos(M_PI * s), 0.0, 0.02 * s + 0.4 * std::sin(M_PI * s)};
}

cloud::PointCloud makeSheet(const Scene& scene) {
  cloud::PointCloud sheet = makeHangingSheet(kSide);
  for (Vec3& p : sheet.positions) p.z() = scene.height;
  return sheet;
}

double findDistance(const Vec3& p, const Vec3& a, const Vec3& b) {
  const Vec3 along = b - a;
  return (a + std::clamp((p - a).dot(along) / along.squaredNorm(), 0.0, 1.0) * along - p).norm();
}

double findDistance(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c) {
  const Vec3 normal = (b - a).cross(c - a);
  const bool is_above = (b - a).cross(p - a).dot(normal) >= 0.0 && (c - b).cross(p - b).dot(normal) >= 0.0 &&
                        (a - c).cross(p - c).dot(normal) >= 0.0;
  if (is_above) return std::abs((p - a).dot(normal)) / normal.norm();
  return std::min({findDistance(p, a, b), findDistance(p, b, c), findDistance(p, c, a)});
}

// What both programs are measured by, from their positions in m at the end of each frame.
class Measures {
 public:
  Measures(const Scene& scene, std::vector<Triangle> triangles) : scene_(scene), triangles_(std::move(triangles)) {}

  void look(const Points& positions) {
    ++frames_;
    const auto crossings = static_cast<Index>(test::findCrossings(positions, triangles_).size());
    crossed_ += crossings > 0;
    most_ = std::max(most_, crossings);
    last_ = crossings;
    double points = 0.0, triangles = 0.0;
    for (const Vec3& p : positions) points = std::max(points, scene_.is_fold ? -p.z() : kRadius - p.norm());
    triangles = points;
    if (!scene_.is_fold)
      for (const auto& [a, b, c] : triangles_)
        triangles = std::max(triangles, kRadius - findDistance(Vec3::Zero(), positions[a], positions[b], positions[c]));
    deepest_points_ = std::max(deepest_points_, points);
    deepest_triangles_ = std::max(deepest_triangles_, triangles);
    last_depth_ = triangles;
    double sum = 0.0, largest = 0.0;
    const auto add = [&](Index i, Index j) {
      const double stretch = (positions[i] - positions[j]).norm() * (kSide - 1) - 1.0;
      sum += std::abs(stretch);
      largest = std::max(largest, stretch);
    };
    for (Index i = 0; i < kSide; ++i)
      for (Index j = 0; j + 1 < kSide; ++j) {
        add(i * kSide + j, i * kSide + j + 1);
        add(j * kSide + i, (j + 1) * kSide + i);
      }
    is_finite_ = is_finite_ && std::isfinite(sum);
    most_stretch_ = std::max(most_stretch_, largest);
    last_stretch_ = largest;
    last_mean_ = sum / (2 * kSide * (kSide - 1));
    if (!before_.empty()) last_speed_ = rmsDistance(positions, before_) / kFrame;
    before_ = positions;
  }

  bool isSound() const { return is_finite_ && most_stretch_ < 10.0; }

  /// problem: why not all frames were taken; empty: they were.
  void addTo(Report& report, const std::string& program, const std::string& steps, double seconds,
             const std::string& problem) const {
    std::vector<std::string> cells{scene_.name,
                                   program,
                                   steps,
                                   show(seconds / (frames_ * kFrame)),
                                   std::to_string(crossed_) + " of " + std::to_string(frames_),
                                   std::to_string(most_)};
    if (problem.empty()) {
      for (const std::string& cell :
           {std::to_string(last_), show(1e3 * deepest_points_), show(1e3 * deepest_triangles_), show(1e3 * last_depth_),
            showPercent(most_stretch_), showPercent(last_stretch_), showPercent(last_mean_), show(last_speed_)})
        cells.push_back(cell);
    } else {
      cells[4] = problem + " after frame " + std::to_string(frames_);
      cells.resize(14, "-");
    }
    report.add(cells);
  }

 private:
  Scene scene_;
  std::vector<Triangle> triangles_;
  Index frames_ = 0, crossed_ = 0, most_ = 0, last_ = 0;
  double deepest_points_ = 0.0, deepest_triangles_ = 0.0, last_depth_ = 0.0;  // m
  double most_stretch_ = 0.0, last_stretch_ = 0.0, last_mean_ = 0.0, last_speed_ = 0.0;
  bool is_finite_ = true;
  Points before_;
};

simulation::SceneParams makeParams(const Scene& scene, model::Bending bending, int steps) {
  simulation::SceneParams p = makeSwingingScene(solve::IntegratorType::kVerlet, kFrame / steps);
  p.pins.clear();
  p.mass_spring.bending = bending;
  p.material.young_modulus = kStiffness / p.material.thickness;
  p.material.density = kMass / p.material.thickness;
  p.material.damping = kDamping;
  p.contact.self = true;
  p.contact.thickness.is_auto = false;
  p.contact.thickness.value = kThickness;
  p.contact.friction = kFriction;
  p.threads = 1;
  tool::ToolParams obstacle;
  obstacle.id = "obstacle";
  obstacle.friction = kFriction;
  obstacle.shape.kind = scene.is_fold ? geometry::Solid::Kind::kPlane : geometry::Solid::Kind::kSphere;
  obstacle.shape.radius = kRadius;
  obstacle.path.emplace_back();
  p.tools.push_back(obstacle);
  if (scene.is_fold) {
    tool::ToolParams hand;
    hand.id = "hand";
    hand.mode = tool::Mode::kMove;
    hand.shape.kind = geometry::Solid::Kind::kBox;
    hand.shape.size = Vec3(0.01, 2.0, 0.01);
    hand.end = kCarried;
    for (int k = 0; k <= kPieces; ++k)
      hand.path.push_back({kCarried * k / kPieces, findWaypoint(k) + Vec3(0.0, 0.0, scene.height), Vec4(0.0, 0.0, 0.0, 1.0)});
    p.tools.push_back(hand);
  }
  return p;
}

// A frame: whether it could be taken, in less time than anyone would wait for.
void watch(const std::string& program, const std::string& steps, const std::function<bool()>& takeFrame,
           const std::function<Points()>& findPositions, Measures measures, const Scene& scene, Report& report) {
  double seconds = 0.0;
  std::string problem;
  for (long frame = std::lround(scene.duration / kFrame); frame > 0 && problem.empty(); --frame) {
    const double before = processorSeconds();
    const bool is_taken = takeFrame();
    seconds += processorSeconds() - before;
    if (is_taken) measures.look(findPositions());
    if (!is_taken || !measures.isSound()) problem = "diverges";
    if (seconds > kPatience) problem = "stopped";
  }
  measures.addTo(report, program, steps, seconds, problem);
}

void addOurs(const Scene& scene, const char* name, model::Bending bending, int steps, Report& report) {
  simulation::Simulation sheet(makeParams(scene, bending, steps), makeSheet(scene));
  const auto takeFrame = [&] {
    for (int k = 0; k < steps; ++k)
      if (!sheet.step().ok) return false;
    return true;
  };
  watch(
      std::string("deformable_surface, ") + name, std::to_string(steps) + " steps", takeFrame,
      [&] { return sheet.state().positions; },
      Measures(scene, simulation::ContactSkin(sheet.state().positions, trianglesOf(sheet.model())).triangles), scene, report);
}

#ifdef DEFORMABLE_SURFACE_WITH_BULLET
struct BulletSettings {
  std::string name;
  int substeps;              // of a frame
  double bending = 0.0;      // N/m, of links over two spacings
  double repulsion = 0.5;    // N/m, of pairs; Bullet's default
  bool is_implicit = false;  // elastic forces
  bool faces_touch = false;  // the obstacle, beside nodes
};

// Bullet's tolerances are absolute, for bodies of about one unit. It finds no pair of a sheet with itself if the squared double
// area of its triangles is below FLT_EPSILON, as it is here in metres.
constexpr double kUnit = 0.1;  // m

class BulletSheet {
 public:
  BulletSheet(const Scene& scene, const BulletSettings& settings)
      : scene_(scene),
        settings_(settings),
        step_(kFrame / settings.substeps),
        world_(&dispatcher_, &broadphase_, &constraints_, &configuration_, &bodies_) {
    constraints_.setDeformableSolver(&bodies_);
    const btVector3 gravity(0.0f, 0.0f, scale(-kGravity));
    world_.setGravity(gravity);
    world_.getWorldInfo().m_gravity = gravity;
    world_.getWorldInfo().m_sparsesdf.setDefaultVoxelsz(scale(0.02));
    world_.getWorldInfo().m_sparsesdf.Reset();
    world_.setImplicit(settings.is_implicit);
    world_.setLineSearch(false);
    world_.setUseProjection(true);
    addObstacle();
    addSheet(gravity);
    world_.setInternalTickCallback(
        [](btDynamicsWorld* world, btScalar) { static_cast<BulletSheet*>(world->getWorldUserInfo())->carry(); }, this, true);
  }
  ~BulletSheet() {
    world_.removeSoftBody(sheet_.get());
    world_.removeRigidBody(obstacle_.get());
  }

  /// Takes one sub-step. Whether its positions are still those of a sheet.
  bool step() {
    world_.stepSimulation(static_cast<btScalar>(step_), 0);
    const btVector3& first = sheet_->m_nodes[0].m_x;
    for (int i = 0; i < sheet_->m_nodes.size(); ++i)
      if (const btScalar distance = (sheet_->m_nodes[i].m_x - first).length(); !(distance < scale(10.0))) return false;
    return true;
  }

  Points positions() const {  // m
    Points all;
    for (int i = 0; i < sheet_->m_nodes.size(); ++i) {
      const btVector3& x = sheet_->m_nodes[i].m_x;
      all.push_back(kUnit * Vec3(x.x(), x.y(), x.z()));
    }
    return all;
  }

  std::vector<Triangle> triangles() const {
    std::vector<Triangle> all;
    const btSoftBody::Node* first = &sheet_->m_nodes[0];
    for (int k = 0; k < sheet_->m_faces.size(); ++k) {
      const auto& n = sheet_->m_faces[k].m_n;
      all.push_back({static_cast<Index>(n[0] - first), static_cast<Index>(n[1] - first), static_cast<Index>(n[2] - first)});
    }
    return all;
  }

 private:
  btScalar scale(double metres) const { return static_cast<btScalar>(metres / kUnit); }

  void addObstacle() {
    if (scene_.is_fold) {
      shape_ = std::make_unique<btBoxShape>(btVector3(scale(2.0), scale(2.0), scale(0.5)));
      shape_->setMargin(scale(0.5 * kThickness));
    } else {
      shape_ = std::make_unique<btSphereShape>(scale(kRadius));
    }
    obstacle_ = std::make_unique<btRigidBody>(btRigidBody::btRigidBodyConstructionInfo(0.0f, nullptr, shape_.get()));
    btTransform pose = btTransform::getIdentity();
    if (scene_.is_fold) pose.setOrigin(btVector3(0.0f, 0.0f, scale(-0.5)));
    obstacle_->setWorldTransform(pose);
    obstacle_->setFriction(static_cast<btScalar>(std::sqrt(kFriction)));  // a pair has the product of two
    world_.addRigidBody(obstacle_.get());
  }

  void addSheet(const btVector3& gravity) {
    const btScalar low = scale(-0.5), high = scale(0.5), z = scale(scene_.height);
    // Its nodes count along y first, if the corners come in this order.
    sheet_.reset(btSoftBodyHelpers::CreatePatch(world_.getWorldInfo(), btVector3(low, low, z), btVector3(low, high, z),
                                                btVector3(high, low, z), btVector3(high, high, z), kSide, kSide, 0, true));
    if (settings_.bending > 0.0) sheet_->generateBendingConstraints(2);
    for (Index i = 0; i < kSide; ++i)
      for (Index j = 0; j < kSide; ++j) setMass(i, j);
    sheet_->getCollisionShape()->setMargin(scale(0.5 * kThickness));
    using Collision = btSoftBody::fCollision;
    sheet_->m_cfg.collisions = Collision::SDF_RD | Collision::SDF_RDN | Collision::VF_DD;
    if (settings_.faces_touch) sheet_->m_cfg.collisions |= Collision::SDF_RDF;
    sheet_->setSelfCollision(true);
    sheet_->setSpringStiffness(static_cast<btScalar>(settings_.repulsion));
    sheet_->m_cfg.kKHR = 1.0f;
    sheet_->m_cfg.kCHR = 1.0f;
    sheet_->m_cfg.kDF = static_cast<btScalar>(std::sqrt(kFriction));
    sheet_->m_cfg.drag = static_cast<btScalar>(kDamping * step_);
    sheet_->m_sleepingThreshold = 0.0f;
    sheet_->setActivationState(DISABLE_DEACTIVATION);
    world_.addSoftBody(sheet_.get());
    // Links along rows and one diagonal of each cell, in turn, are an isotropic sheet of E h = 4/3 k and nu = 1/3.
    springs_ =
        std::make_unique<btDeformableMassSpringForce>(static_cast<btScalar>(0.75 * kStiffness), 0.0f, true, settings_.bending);
    weight_ = std::make_unique<btDeformableGravityForce>(gravity);
    world_.addForce(sheet_.get(), springs_.get());
    world_.addForce(sheet_.get(), weight_.get());
    if (scene_.is_fold)
      for (Index j = 0; j < kSide; ++j) sheet_->setMass((kSide - 1) * kSide + j, 0.0f);
  }

  // By the area of a point.
  void setMass(Index i, Index j) {
    const auto share = [](Index k) { return k == 0 || k == kSide - 1 ? 0.5 : 1.0; };
    sheet_->setMass(i * kSide + j, static_cast<btScalar>(kMass * share(i) * share(j) / ((kSide - 1) * (kSide - 1))));
  }

  // Before each sub-step: the velocity that brings the edge to its next place.
  void carry() {
    if (!scene_.is_fold || is_released_) return;
    time_ += step_;
    if (time_ > kCarried + 0.5 * step_) {
      for (Index j = 0; j < kSide; ++j) setMass(kSide - 1, j);
      is_released_ = true;
      return;
    }
    const double at = std::min(time_ / kCarried * kPieces, kPieces - 1e-9);
    const int k = static_cast<int>(at);
    const Vec3 place = findWaypoint(k) + (at - k) * (findWaypoint(k + 1) - findWaypoint(k));
    for (Index j = 0; j < kSide; ++j) {
      btSoftBody::Node& node = sheet_->m_nodes[(kSide - 1) * kSide + j];
      const btVector3 target(scale(place.x()), scale(-0.5 + j / (kSide - 1.0)), scale(place.z() + scene_.height));
      node.m_v = (target - node.m_x) / static_cast<btScalar>(step_ * (1.0 - kDamping * step_));
      node.m_vn = node.m_v;  // from which implicit steps begin
    }
  }

  Scene scene_;
  BulletSettings settings_;
  double step_, time_ = 0.0;  // s
  bool is_released_ = false;
  btSoftBodyRigidBodyCollisionConfiguration configuration_;
  btCollisionDispatcher dispatcher_{&configuration_};
  btDbvtBroadphase broadphase_;
  btDeformableBodySolver bodies_;
  btDeformableMultiBodyConstraintSolver constraints_;
  btDeformableMultiBodyDynamicsWorld world_;
  std::unique_ptr<btCollisionShape> shape_;
  std::unique_ptr<btRigidBody> obstacle_;
  std::unique_ptr<btSoftBody> sheet_;
  std::unique_ptr<btDeformableMassSpringForce> springs_;
  std::unique_ptr<btDeformableGravityForce> weight_;
};

void addBullet(const Scene& scene, const BulletSettings& settings, Report& report) {
  BulletSheet sheet(scene, settings);
  const auto takeFrame = [&] {
    for (int k = 0; k < settings.substeps; ++k)
      if (!sheet.step()) return false;
    return true;
  };
  watch(
      "Bullet " + std::to_string(btGetVersion() / 100) + "." + std::to_string(btGetVersion() % 100) + ", " + settings.name,
      std::to_string(settings.substeps) + " sub-steps", takeFrame, [&] { return sheet.positions(); },
      Measures(scene, sheet.triangles()), scene, report);
}
#endif

}  // namespace

void compareContact(Report& report) {
  report.begin("peers_contact",
               "A sheet of " + std::to_string(kSide * kSide) +
                   " points that falls on a ball, or is folded on a table, with contact with itself, one thread",
               {"scene", "program", "in_a_frame", "cpu_s_per_simulated_s", "frames_with_crossings", "most_pairs", "pairs_at_end",
                "deepest_points_mm", "deepest_triangles_mm", "deepest_at_end_mm", "most_stretch", "most_at_end", "mean_at_end",
                "rms_speed_at_end"});
  for (const Scene& scene : {kDrape, kFold}) {
    addOurs(scene, "triangles and curvature (default)", model::Bending::kCurvature, 4, report);
    addOurs(scene, "triangles without bending", model::Bending::kNone, 4, report);
#ifdef DEFORMABLE_SURFACE_WITH_BULLET
    const BulletSettings plain{"springs", 128};
    BulletSettings fine = plain, bent = plain, stiffer = plain, faces = plain, implicit = plain;
    fine.substeps = 256;
    bent.name = "springs, bending links of 10 N/m", bent.bending = 10.0;
    stiffer.name = "springs, pairs of 10 N/m", stiffer.repulsion = 10.0;
    faces.name = "springs, faces touch the obstacle", faces.faces_touch = true;
    implicit.name = "springs, implicit", implicit.substeps = 32, implicit.is_implicit = true;
    for (const BulletSettings& settings : {plain, fine, bent, stiffer, faces, implicit}) addBullet(scene, settings, report);
#else
    report.add({scene.name, "Bullet", "-", "-", "not installed (libbullet-dev)", "-", "-", "-", "-", "-", "-", "-", "-", "-"});
#endif
  }
  report.end();
  report.note(
      "crossings: pairs of triangles of which an edge of one passes through the other, at the end of each frame of 1/60 s; "
      "stretch: of edges along rows; deepest: inside the ball or below the table, of points and of triangles");
}

}  // namespace deformable_surface::benchmark
