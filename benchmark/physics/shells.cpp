// Curved shells under point loads: the hemisphere with a hole, pulled apart along one axis and pushed together along the other,
// and the cylinder with open ends that is pulled apart at its middle.
#include "experiment.h"

#include <algorithm>
#include <cmath>
#include <random>
#include <stdexcept>

namespace deformable_surface::physics {
namespace {

constexpr double kRadius = 10.0, kHole = 18.0;  // the hole's angle about the pole, degrees

// [sze2004, hemispherical shell with a hole]: E = 6.825e7, nu = 0.3, R = 10, h = 0.04; radial forces outward at both ends of
// one axis, inward at both ends of the other. Displacements outward and inward at shares of the force kLoad.
constexpr double kLoad = 400.0;
struct Row {
  double share, outward, inward;
};
constexpr Row kTenth{0.10, 1.499, 1.840}, kHalf{0.50, 3.406, 5.902}, kFull{1.00, 4.067, 8.178};

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
      sampled.points.push_back(
          kRadius * Vec3(std::cos(latitude) * std::cos(longitude), std::cos(latitude) * std::sin(longitude), std::sin(latitude)));
    }
  }
  return sampled;
}

// Forces that press the shell together let it turn away under them, and the published computation forbids that by symmetry. So
// its inward points are held here, at a distance that is sought until they are pressed with the load; forces act at the outward
// ones. Load by load, as the published table has it: each begins from what the last two foretell, by which the shell stays
// symmetric. In longer steps it finds equilibria of less energy that are not.
Answer pinchHemisphere(const Row& row, const Variant& variant, double spacing) {
  constexpr double kStep = 0.05;    // of kLoad
  constexpr double kEnough = 1e-3;  // of the load: how well the inward points are pressed with it
  constexpr int kTries = 8;         // distances before a load counts as not found
  constexpr double kFirst = 0.05;   // of the radius: the displacement that is tried first
  simulation::SceneParams scene = makeStaticScene();
  scene.integrator.tolerance = 1e-6;
  scene.material.young_modulus = 6.825e7;
  scene.material.poisson_ratio = 0.3;
  scene.material.thickness = 0.04;
  Experiment shell(scene, sampleHemisphere(spacing, variant.sampling), variant);
  const Points& rest = shell.rest();
  const auto find = [&](double x, double y) {
    return static_cast<Index>(std::min_element(rest.begin(), rest.end(),
                                               [&](const Vec3& a, const Vec3& b) {
                                                 return (a - Vec3(x, y, 0.0)).squaredNorm() < (b - Vec3(x, y, 0.0)).squaredNorm();
                                               }) -
                              rest.begin());
  };
  const Index pulled[2] = {find(kRadius, 0.0), find(-kRadius, 0.0)}, pressed[2] = {find(0.0, kRadius), find(0.0, -kRadius)};
  shell.hold([&](const Vec3& p) { return p == rest[pressed[0]] || p == rest[pressed[1]]; });
  // By how much the held points are in, and the force with which the shell resists.
  struct Found {
    double inward = 0.0, force = 0.0;
  } last, found;
  Points before = rest, places = rest;
  for (int step = 1; step <= std::lround(row.share / kStep); ++step) {
    const double load = kLoad * kStep * step;
    for (int side = 0; side < 2; ++side) shell.push(pulled[side], Vec3(side == 0 ? load : -load, 0.0, 0.0));
    double inward = step == 1 ? kFirst * kRadius : 2.0 * found.inward - last.inward;
    const Points now = shell.now();
    for (std::size_t i = 0; i < now.size(); ++i) places[i] = 2.0 * now[i] - before[i];
    before = now;
    const Found start = found;
    for (int tried = 0; std::abs(found.force - load) > kEnough * load; ++tried) {
      if (tried == kTries) throw std::runtime_error("no place of the held points at which they are pressed with the load");
      for (int side = 0; side < 2; ++side) places[pressed[side]] = Vec3(0.0, (side == 0 ? 1.0 : -1.0) * (kRadius - inward), 0.0);
      shell.place(places);
      shell.settle();
      const Found previous = tried == 0 ? start : found;
      found = {inward, 0.5 * (shell.forceOn(pressed[0]).y() - shell.forceOn(pressed[1]).y())};
      inward += (load - found.force) * (found.inward - previous.inward) / (found.force - previous.force);
      places = shell.now();
    }
    last = start;
  }
  const Points now = shell.now();
  const double outward = 0.5 * (now[pulled[0]] - now[pulled[1]]).norm() - kRadius;
  Answer answer;
  answer.points = static_cast<Index>(rest.size());
  answer.value = found.inward;
  answer.reference = row.inward;
  answer.error = std::hypot(outward - row.outward, found.inward - row.inward) / std::hypot(row.outward, row.inward);
  return answer;
}

// [sze2004, 3.5]: E = 10.5e6, nu = 0.3125, R = 4.953, L = 10.35, h = 0.094; outward forces of 40000 at both ends of a diameter in
// the middle. How far these points move, and inwards those beside them in the middle and at the ends, at shares of the force.
struct PulledRow {
  double share, outward, inward, inward_at_end;
};
constexpr PulledRow kPulledTenth{0.1, 1.707, 2.217, 2.293}, kPulledFull{1.0, 2.768, 4.551, 3.269};

// Circles, the loaded and the compared points on them.
Sampled sampleCylinder(double radius, double length, double spacing, Sampling sampling) {
  const int half = std::max(1, static_cast<int>(std::lround(0.5 * length / spacing)));
  const int quarter = std::max(2, static_cast<int>(std::lround(0.5 * kPi * radius / spacing)));
  std::mt19937 generator(1);
  const auto draw = [&] { return 0.25 * (static_cast<double>(generator()) / 2147483648.0 - 1.0); };
  Sampled sampled;
  for (int c = -half; c <= half; ++c)
    for (int k = 0; k < 4 * quarter; ++k) {
      double x = 0.5 * length * c / half, angle = 0.5 * kPi * k / quarter;
      const double along = draw(), around = draw();
      const bool is_named = k % quarter == 0 && (c == 0 || std::abs(c) == half);
      if (sampling != Sampling::kRegular && !is_named) {
        if (std::abs(c) < half) x += along * 0.5 * length / half;
        angle += around * 0.5 * kPi / quarter;
      }
      sampled.points.emplace_back(x, radius * std::cos(angle), radius * std::sin(angle));
    }
  return sampled;
}

// The loaded points are held at the distance at which they are pulled with the load: under forces alone nothing keeps a shell of
// irregular points from tilting. Load by load, each from what the last two foretell. Springs that are too weak to count keep it
// from turning about the line between them.
Answer pullCylinder(const PulledRow& row, const Variant& variant, double spacing) {
  constexpr double kRadius = 4.953, kLength = 10.35, kPull = 40000.0, kStep = 0.025, kWeak = 1.0;
  constexpr double kEnough = 1e-3;  // of the load
  constexpr int kTries = 12;        // distances before a load counts as not found
  constexpr double kFirst = 0.1;    // of the radius: the displacement that is tried first
  simulation::SceneParams scene = makeStaticScene();
  scene.integrator.tolerance = 1e-6;
  scene.material.young_modulus = 10.5e6;
  scene.material.poisson_ratio = 0.3125;
  scene.material.thickness = 0.094;
  for (const double side : {-1.0, 1.0})
    for (const double end : {-1.0, 1.0}) {
      simulation::AnchorParams anchor;
      anchor.point = anchor.target = Vec3(0.5 * end * kLength, side * kRadius, 0.0);
      anchor.stiffness = kWeak;
      scene.anchors.push_back(anchor);
    }
  Experiment shell(scene, sampleCylinder(kRadius, kLength, spacing, variant.sampling), variant);
  const Points& rest = shell.rest();
  const auto find = [&](double x, double y, double z) {
    const Vec3 place(x, y, z);
    return static_cast<Index>(
        std::min_element(rest.begin(), rest.end(),
                         [&](const Vec3& a, const Vec3& b) { return (a - place).squaredNorm() < (b - place).squaredNorm(); }) -
        rest.begin());
  };
  const Index pulled[2] = {find(0.0, 0.0, kRadius), find(0.0, 0.0, -kRadius)};
  shell.hold([&](const Vec3& p) { return p == rest[pulled[0]] || p == rest[pulled[1]]; });
  struct Found {
    double outward = 0.0, force = 0.0;
  } last, found;
  const auto shrink = [&](double x) {
    const Points now = shell.now();
    const Index a = find(x, kRadius, 0.0), b = find(x, -kRadius, 0.0);
    return kRadius - 0.5 * (now[a].y() - now[b].y());
  };
  Points before = rest, places = rest;
  for (int step = 1; step <= std::lround(row.share / kStep); ++step) {
    const double load = kPull * kStep * step;
    double outward = step == 1 ? kFirst * kRadius : 2.0 * found.outward - last.outward;
    const Points now = shell.now();
    if (step > 1)
      for (std::size_t i = 0; i < now.size(); ++i) places[i] = 2.0 * now[i] - before[i];
    before = now;
    const Found start = found;
    Found less, more;  // than the load; of force 0: none yet
    for (int tried = 0; std::abs(found.force - load) > kEnough * load; ++tried) {
      if (tried == kTries) throw std::runtime_error("no place of the held points at which they are pulled with the load");
      for (int side = 0; side < 2; ++side) places[pulled[side]] = Vec3(0.0, 0.0, (side == 0 ? 1.0 : -1.0) * (kRadius + outward));
      shell.place(places);
      shell.settle();
      const Found previous = tried == 0 ? start : found;
      found = {outward, 0.5 * (shell.forceOn(pulled[1]).z() - shell.forceOn(pulled[0]).z())};
      (found.force < load ? less : more) = found;
      outward += (load - found.force) * (found.outward - previous.outward) / (found.force - previous.force);
      if (less.force > 0.0 && more.force > 0.0 && !(outward > less.outward && outward < more.outward))
        outward = 0.5 * (less.outward + more.outward);
      places = shell.now();
    }
    last = start;
  }
  const Vec3 there(found.outward, shrink(0.0), 0.5 * (shrink(0.5 * kLength) + shrink(-0.5 * kLength)));
  const Vec3 published(row.outward, row.inward, row.inward_at_end);
  Answer answer;
  answer.points = static_cast<Index>(rest.size());
  answer.value = there[0];
  answer.reference = row.outward;
  answer.error = (there - published).norm() / published.norm();
  return answer;
}

}  // namespace

std::vector<Problem> listShells() {
  std::vector<Problem> list;
  struct Case {
    const char* name;
    Row row;
    std::vector<double> sizes;
  };
  for (const Case& c : {Case{"hemisphere, tenth of the load", kTenth, {1.4, 1.0, 0.7}},
                        Case{"hemisphere, half of the load", kHalf, {1.0, 0.7, 0.5}},
                        Case{"hemisphere, full load", kFull, {0.7, 0.6, 0.5, 0.4}}}) {
    Problem p;
    p.name = c.name;
    p.value = "inward displacement, m";
    p.scale = "displacement (both loaded points)";
    p.source = "Sze, Liu, Lo 2004, hemispherical shell with a hole";
    for (const Sampling sampling : {Sampling::kRegular, Sampling::kJittered})
      p.variants.push_back({model::Membrane::kTriangles, model::Bending::kCurvature, sampling, sampling != Sampling::kRegular});
    p.sizes = c.sizes;
    p.run = [row = c.row](const Variant& variant, double spacing) { return pinchHemisphere(row, variant, spacing); };
    list.push_back(p);
  }
  // Under the full load a grid finds another equilibrium, in which the ends pass through themselves.
  const std::vector<Variant> variants = list.front().variants;
  for (const bool is_full : {false, true}) {
    Problem pulled;
    pulled.name = is_full ? "pulled open cylinder, full load" : "pulled open cylinder, tenth of the load";
    pulled.value = "outward displacement, m";
    pulled.scale = "displacement (the loaded points and those beside them)";
    pulled.source = "Sze, Liu, Lo 2004, 3.5";
    pulled.variants = is_full ? std::vector<Variant>{variants.back()} : variants;
    pulled.sizes = is_full ? std::vector<double>{0.7, 0.5} : std::vector<double>{1.0, 0.7, 0.5, 0.35};
    pulled.run = [row = is_full ? kPulledFull : kPulledTenth](const Variant& variant, double spacing) {
      return pullCylinder(row, variant, spacing);
    };
    list.push_back(pulled);
  }
  return list;
}

}  // namespace deformable_surface::physics
