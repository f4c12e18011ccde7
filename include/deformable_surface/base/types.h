// Types that every room uses: the index type, the arrays of points and pi. The rooms base and linear use the namespace
// deformable_surface itself.
#pragma once

#include <Eigen/Geometry>
#include <Eigen/LU>

#include <cstdint>
#include <vector>

// Eigen's alignment is part of the binary interface: a program built with -mavx and a library built without it disagree on the
// layout of fixed-size matrices and corrupt memory silently. Define DEFORMABLE_SURFACE_ALLOW_AVX if every library involved
// agrees.
#if !defined(DEFORMABLE_SURFACE_ALLOW_AVX) && EIGEN_MAX_ALIGN_BYTES > 16
#error "deformable_surface and the distribution's libraries are built without AVX: remove -march=native, -mavx or -mavx2"
#endif

namespace deformable_surface {

using Index = std::int32_t;

constexpr double kPi = 3.14159265358979323846;

using Vec2 = Eigen::Vector2d;
using Vec3 = Eigen::Vector3d;
using Vec4 = Eigen::Vector4d;
using Mat2 = Eigen::Matrix2d;
using Mat3 = Eigen::Matrix3d;

using Quaternion = Eigen::Quaterniond;
using Orientations = std::vector<Quaternion>;  // (n); coefficients x, y, z, w

/// (n x 3), contiguous: points.data()->data() is the flat array x0 y0 z0 x1 ...
using Points = std::vector<Vec3>;

/// Flat lists of lists: the members of list i are items[offsets[i]] .. items[offsets[i + 1] - 1].
struct Lists {
  std::vector<Index> offsets{0};  // (n + 1)
  std::vector<Index> items;

  Index size() const { return static_cast<Index>(offsets.size()) - 1; }
  const Index* begin(Index i) const { return items.data() + offsets[i]; }
  const Index* end(Index i) const { return items.data() + offsets[i + 1]; }
  Index count(Index i) const { return offsets[i + 1] - offsets[i]; }
};

}  // namespace deformable_surface
