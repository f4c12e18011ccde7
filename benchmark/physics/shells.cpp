// A shell of double curvature: the hemisphere with a hole, pulled apart along one axis and pushed together along the other.
#include "experiment.h"

#include <algorithm>
#include <cmath>
#include <random>

namespace deformable_surface::physics {
namespace {

const double kPi = std::acos(-1.0);
constexpr double kRadius = 10.0, kHole = 18.0;  // the hole's angle about the pole, degrees

// [sze2004, hemispherical shell with a hole]: E = 6.825e7, nu = 0.3, R = 10, h = 0.04; radial forces outward at both ends of
// one axis, inward at both ends of the other. Force over kLoad, displacement outward, inward.
constexpr double kLoad = 400.0;
struct Row {
  double share, outward, inward;
};
constexpr Row kTenth{0.10, 1.499, 1.840};

// Circles of latitude from the equator to the hole; points at both ends of both axes.
Sampled sampleHemisphere(double spacing, Sampling sampling) {
  const double top = (90.0 - kHole) * kPi / 180.0;
  const int circles = std::max(2, static_cast<int>(std::lround(kRadius * top / spacing)));
  std::mt19937 generator(1);
  const auto draw = [&] { return 0.25 * (static_cast<double>(generator()) / 2147483648.0 - 1.0); };
  Sampled sampled;
  for (int c = 0; c <= circles; ++c) {
    const int n = 4 * std::max(1, static_cast<int>(std::lround(0.5 * kPi * kRadius * std::cos(top * c / circles) / spacing)));
    for (int k = 0; k < n; ++k) {
      const bool loaded = c == 0 && k % (n / 4) == 0;
      double latitude = top * c / circles, longitude = 2.0 * kPi * (k + 0.5 * (c % 2)) / n;
      if (sampling != Sampling::kRegular && !loaded) {
        const double north = draw(), east = draw();
        if (c > 0 && c < circles) latitude += north * top / circles;
        longitude += east * 2.0 * kPi / n;
      }
      sampled.points.push_back(kRadius * Vec3(std::cos(latitude) * std::cos(longitude), std::cos(latitude) * std::sin(longitude),
                                              std::sin(latitude)));
    }
  }
  return sampled;
}

// Nothing holds the shell but its loads, and forces that press it together let it turn away under them. The published
// computation forbids that by symmetry; here the inward forces come from world springs to far targets, which pull back what
// leaves the axis. Their targets are moved until the spring force is the wanted one along the axis, and none across. rigidity:
// over that of the published shell. The model's curvatures do not feel each other (bending with Poisson's ratio 0). A shell
// that bends without stretching keeps its Gaussian curvature, so that both change by the same amount, oppositely, and the true
// energy is (1 - nu) of the model's: with that share of the rigidity the model is the published shell.
Answer pinchHemisphere(double rigidity, const Variant& variant, double spacing) {
  simulation::SceneParams scene = makeStaticScene();
  scene.material.young_modulus = 6.825e7;
  scene.material.poisson_ratio = variant.membrane == model::Membrane::kSprings ? 1.0 / 3.0 : 0.3;
  scene.material.thickness = 0.04;
  const double cubed = std::pow(scene.material.thickness, 3);
  scene.material.bending_rigidity = rigidity * scene.material.young_modulus * cubed / (12.0 * (1.0 - 0.3 * 0.3));
  const Row row = kTenth;
  const double load = kLoad * row.share, holder = 2.0 * load / kRadius;
  constexpr int kCorrections = 2;  // each leaves an eighth of the error in the force
  const Sampled sampled = sampleHemisphere(spacing, variant.sampling);
  Vec3 target(0.0, kRadius - row.inward - load / holder, 0.0);
  double height = 0.0;
  Answer answer;
  for (int correction = 0; correction <= kCorrections; ++correction) {
    scene.anchors.clear();
    for (const double side : {1.0, -1.0}) {
      simulation::AnchorParams anchor;
      anchor.point = Vec3(0.0, side * kRadius, 0.0);
      anchor.target = Vec3(0.0, side * target.y(), height);
      anchor.stiffness = holder;
      scene.anchors.push_back(anchor);
    }
    Experiment shell(scene, sampled, variant);
    const auto find = [&](const Vec3& place) {
      Index nearest = 0;
      for (Index i = 0; i < static_cast<Index>(shell.rest().size()); ++i)
        if ((shell.rest()[i] - place).squaredNorm() < (shell.rest()[nearest] - place).squaredNorm()) nearest = i;
      return nearest;
    };
    const Index a = find(Vec3(kRadius, 0.0, 0.0)), b = find(Vec3(-kRadius, 0.0, 0.0));
    const Index c = find(Vec3(0.0, kRadius, 0.0)), d = find(Vec3(0.0, -kRadius, 0.0));
    shell.push(a, Vec3(load, 0.0, 0.0));
    shell.push(b, Vec3(-load, 0.0, 0.0));
    shell.settle();
    const Points now = shell.now();
    const double outward = 0.5 * (now[a] - now[b]).norm() - kRadius, pressed = 0.5 * (now[c].y() - now[d].y());
    const double force = holder * (pressed - target.y());
    height = 0.5 * (now[c].z() + now[d].z());
    // The force that is missing, by the stiffness that the holder has itself: the shell's adds to it.
    target.y() -= (load - force) / holder;
    answer.points = static_cast<Index>(now.size());
    answer.value = kRadius - pressed;
    answer.reference = row.inward;
    answer.error = std::hypot(outward - row.outward, answer.value - row.inward) / std::hypot(row.outward, row.inward);
  }
  return answer;
}

}  // namespace

std::vector<Problem> listShells() {
  std::vector<Problem> list;
  struct Case {
    const char* name;
    double rigidity;
  };
  for (const Case& c : {Case{"hemisphere, tenth of the load", 0.7}, Case{"hemisphere, tenth of the load, D as published", 1.0}}) {
    Problem p;
    p.name = c.name;
    p.value = "inward displacement, m";
    p.scale = "displacement (both loaded points)";
    p.source = "Sze, Liu, Lo 2004, hemispherical shell with a hole";
    const model::Bending bending = model::Bending::kCurvature;
    if (c.rigidity < 1.0) p.variants = {{model::Membrane::kTriangles, bending, Sampling::kRegular, false}};
    p.variants.push_back({model::Membrane::kTriangles, bending, Sampling::kJittered, true});
    p.sizes = {2.0, 1.4, 1.0};
    p.run = [c](const Variant& variant, double spacing) { return pinchHemisphere(c.rigidity, variant, spacing); };
    list.push_back(p);
  }
  return list;
}

}  // namespace deformable_surface::physics
