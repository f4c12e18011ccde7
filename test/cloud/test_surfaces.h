// Point sets with known area, outline and topology, with their exact normals, for the tests of rings and simplification.
#pragma once

#include "deformable_surface/base/types.h"

#include <cmath>
#include <random>

namespace deformable_surface::cloud {

struct TestSurface {
  Points positions, normals;

  Index size() const { return static_cast<Index>(positions.size()); }
  void add(const Vec3& position, const Vec3& normal) {
    positions.push_back(position);
    normals.push_back(normal.normalized());
  }
  void append(const TestSurface& other, const Vec3& offset) {
    for (Index i = 0; i < other.size(); ++i) add(other.positions[i] + offset, other.normals[i]);
  }
  void rotate(const Mat3& rotation) {
    for (Vec3& p : positions) p = rotation * p;
    for (Vec3& n : normals) n = rotation * n;
  }
};

inline Mat3 makeRotation(double about_x, double about_z) {
  Mat3 x, z;
  x << 1.0, 0.0, 0.0, 0.0, std::cos(about_x), -std::sin(about_x), 0.0, std::sin(about_x), std::cos(about_x);
  z << std::cos(about_z), -std::sin(about_z), 0.0, std::sin(about_z), std::cos(about_z), 0.0, 0.0, 0.0, 1.0;
  return z * x;
}

/// Unit square in z = 0, index x * side + y; points move by up to jitter times the spacing, those on the outline along it.
inline TestSurface makeSheet(int side, double jitter = 0.0, unsigned seed = 1) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> shift(-jitter, jitter);
  TestSurface sheet;
  for (int i = 0; i < side; ++i) {
    for (int j = 0; j < side; ++j) {
      const double dx = shift(random), dy = shift(random);
      const double x = i + (i > 0 && i < side - 1 ? dx : 0.0), y = j + (j > 0 && j < side - 1 ? dy : 0.0);
      sheet.add(Vec3(x, y, 0.0) / (side - 1), Vec3::UnitZ());
    }
  }
  return sheet;
}

/// Unit sphere, evenly sampled along a spiral.
inline TestSurface makeSphere(int n) {
  TestSurface sphere;
  for (int i = 0; i < n; ++i) {
    const double z = 1.0 - (2.0 * i + 1.0) / n, r = std::sqrt(1.0 - z * z), angle = kPi * (3.0 - std::sqrt(5.0)) * i;
    const Vec3 p(r * std::cos(angle), r * std::sin(angle), z);
    sphere.add(p, p);
  }
  return sphere;
}

/// Torus of radii 1 and 0.4, a jittered grid of its two angles.
inline TestSurface makeTorus(int around, int across, double jitter, unsigned seed = 1) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> shift(-jitter, jitter);
  TestSurface torus;
  for (int i = 0; i < around; ++i) {
    for (int j = 0; j < across; ++j) {
      const double u = 2.0 * kPi * (i + shift(random)) / around, v = 2.0 * kPi * (j + shift(random)) / across;
      const Vec3 outward(std::cos(u) * std::cos(v), std::sin(u) * std::cos(v), std::sin(v));
      torus.add(Vec3(std::cos(u), std::sin(u), 0.0) + 0.4 * outward, outward);
    }
  }
  return torus;
}

/// Unit disc of concentric rings, `rings` of them, each with six points more than the last.
inline TestSurface makeDisc(int rings) {
  TestSurface disc;
  disc.add(Vec3::Zero(), Vec3::UnitZ());
  for (int r = 1; r <= rings; ++r) {
    for (int s = 0; s < 6 * r; ++s) {
      const double angle = 2.0 * kPi * (s + 0.37 * r) / (6 * r);
      disc.add(Vec3(std::cos(angle), std::sin(angle), 0.0) * r / rings, Vec3::UnitZ());
    }
  }
  return disc;
}

}  // namespace deformable_surface::cloud
