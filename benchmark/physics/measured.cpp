// Measured sheets: knitted fabrics pulled between two clamps [singal2024], by a linear membrane whose modulus and Poisson's
// ratio are read off at the first newtons; and the law of rubber beside the model's at the moduli of silicone mixes.
#include "experiment.h"

#include <cmath>
#include <fstream>
#include <sstream>
#include <stdexcept>

namespace deformable_surface::physics {
namespace {

constexpr double kRead = 1.5;  // N: where the modulus is read; below it some repeats are slack
constexpr double kTiny = 1e-9;

struct Fabric {
  const char* name;
  double width, length;  // m, at rest: at the clamp and between the clamps
};
// From samples.csv of the data, first repeat.
constexpr Fabric kFabrics[] = {{"Acrylic_Yarn_Seed_X", 0.06675, 0.1075},
                               {"Acrylic_Yarn_Garter_X", 0.03516, 0.0917},
                               {"Acrylic_Yarn_Stockinette_Y", 0.09587, 0.0455}};

struct Strain {
  double along = 0.0, across = 0.0;
};

// The mean over the repeats at a force, N.
Strain readStrain(const std::string& fabric, double force) {
  std::ifstream file(dataFolder() + "/stitch_by_stitch_force/force_extension_binned.csv");
  Strain mean;
  double count = 0.0;
  for (std::string line; std::getline(file, line);) {
    std::vector<std::string> cells;
    std::istringstream row(line);
    for (std::string cell; std::getline(row, cell, ',');) cells.push_back(cell);
    if (cells.size() != 8 || cells[0] != fabric || std::abs(std::stod(cells[2]) - force) > 0.01) continue;
    mean.along += std::stod(cells[6]);
    mean.across += std::stod(cells[7]);
    count += 1.0;
  }
  if (count == 0.0) throw std::runtime_error("there are no measurements of " + fabric);
  return {mean.along / count, mean.across / count};
}

struct Pulled {
  double force = 0.0, narrowing = 0.0;  // N; strain across at mid-length
  Index points = 0;
};

// A sheet whose ends are held straight at full width, one of them drawn away.
Pulled pull(simulation::SceneParams scene, double length, double width, double strain, const Variant& variant, double spacing) {
  const Sampled sampled = sampleRectangle(Vec2(0.0, -0.5 * width), Vec2(length, 0.5 * width), spacing, variant.sampling);
  scene.pins = {pinBehind(Vec3::Zero(), Vec3::UnitX(), length)};
  const double holder = 100.0 * scene.material.young_modulus * scene.material.thickness;
  for (const Vec3& p : sampled.points)
    if (p.x() > length - kTiny) {
      simulation::AnchorParams anchor;
      anchor.point = p;
      anchor.target = p + Vec3(strain * length, 0.0, 0.0);
      anchor.stiffness = holder;
      scene.anchors.push_back(anchor);
    }
  Experiment sheet(scene, sampled, variant);
  sheet.settle();
  const Points now = sheet.now();
  Pulled result;
  result.points = static_cast<Index>(now.size());
  double across = 0.0, rest_across = 0.0;
  for (std::size_t i = 0; i < now.size(); ++i) {
    const Vec3& rest = sheet.rest()[i];
    if (rest.x() > length - kTiny) result.force += holder * (rest.x() + strain * length - now[i].x());
    if (std::abs(rest.x() - 0.5 * length) < spacing) {
      across += now[i].y() * rest.y();
      rest_across += rest.y() * rest.y();
    }
  }
  result.narrowing = across / rest_across - 1.0;
  return result;
}

enum class What { kForce, kNarrowing };

Answer pullFabric(const Fabric& fabric, double force, What what, const Variant& variant, double spacing) {
  const Strain read = readStrain(fabric.name, kRead), wanted = readStrain(fabric.name, force);
  simulation::SceneParams scene = makeStaticScene();
  scene.material.thickness = 1e-3;
  scene.material.young_modulus = kRead / (read.along * fabric.width * scene.material.thickness);
  scene.material.poisson_ratio = -read.across / read.along;
  const Pulled pulled = pull(scene, fabric.length, fabric.width, wanted.along, variant, spacing);
  Answer answer;
  answer.points = pulled.points;
  answer.value = what == What::kForce ? pulled.force : pulled.narrowing;
  answer.reference = what == What::kForce ? force : wanted.across;
  answer.error = std::abs(answer.value / answer.reference - 1.0);
  return answer;
}

// Incompressible rubber (neo-Hookean): nominal stress E / 3 (s - 1 / s^2) at the stretch s; the model's law is E (s - 1).
Answer pullSilicone(double stretch, const Variant& variant, double spacing) {
  const double length = 0.1, width = 0.02;
  simulation::SceneParams scene = makeStaticScene();
  scene.material.young_modulus = 97.26e3;  // EF30_0T of the phantoms; the share does not depend on it
  scene.material.thickness = 2e-3;
  scene.material.poisson_ratio = 0.49;
  const Pulled pulled = pull(scene, length, width, stretch - 1.0, variant, spacing);
  Answer answer;
  answer.points = pulled.points;
  answer.value = pulled.force;
  const double stress = scene.material.young_modulus / 3.0 * (stretch - 1.0 / (stretch * stretch));
  answer.reference = stress * scene.material.thickness * width;
  answer.error = std::abs(answer.value / answer.reference - 1.0);
  return answer;
}

}  // namespace

std::vector<Problem> listMeasured() {
  std::vector<Problem> list;
  const std::vector<Variant> jittered{{model::Membrane::kTriangles, model::Bending::kNone, Sampling::kJittered, true}};
  const bool has_data = static_cast<bool>(std::ifstream(dataFolder() + "/stitch_by_stitch_force/force_extension_binned.csv"));
  for (const Fabric& fabric : kFabrics)
    for (const double force : {kRead, 10.5})
      for (const What what : {What::kForce, What::kNarrowing}) {
        Problem p;
        p.name = std::string("knit ") + fabric.name + (what == What::kForce ? ", force" : ", narrowing") + " at the strain of " +
                 (force == kRead ? "1.5 N" : "10.5 N");
        p.value = what == What::kForce ? "force, N" : "strain across at mid-length";
        p.scale = "measured value";
        p.other_law = true;
        p.source = "measured, Singal et al. 2024, mean of the repeats";
        if (has_data) p.variants = jittered;
        p.sizes = {fabric.width / 6.0, fabric.width / 9.0, fabric.width / 14.0};
        p.run = [fabric, force, what](const Variant& variant, double spacing) {
          return pullFabric(fabric, force, what, variant, spacing);
        };
        list.push_back(p);
      }
  for (const double stretch : {1.02, 1.3}) {
    Problem p;
    p.name = stretch < 1.1 ? "silicone at 2 % stretch" : "silicone at 30 % stretch";
    p.value = "force, N";
    p.scale = "force";
    p.other_law = true;
    p.source = "neo-Hookean law at a measured modulus (97 kPa)";
    p.variants = jittered;
    p.sizes = {0.005, 0.0033333, 0.002};
    p.run = [stretch](const Variant& variant, double spacing) { return pullSilicone(stretch, variant, spacing); };
    list.push_back(p);
  }
  return list;
}

}  // namespace deformable_surface::physics
