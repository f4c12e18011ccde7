#include "deformable_surface/transfer/solid_transfer.h"

#include "deformable_surface/base/parallel.h"

#include <Eigen/Eigenvalues>

#include <algorithm>
#include <cmath>

namespace deformable_surface::transfer {
namespace {

constexpr Index kBlock = 1024;
constexpr double kReach = 1.1;         // of the farthest neighbour's distance: it keeps a little weight
constexpr double kCoincident = 1e-12;  // squared distance over the reach's, below which a point is the simulation point
constexpr double kLeastSpread = 1e-3;  // squared, over that in the main direction: below it the slope cannot be determined

}  // namespace

SolidTransfer::SolidTransfer(const Points& dense, const Points& normals, const Points& simulation, const Lists& followed)
    : rest_(dense), normals_(normals), simulation_rest_(simulation), followed_(followed), row_(4 * followed.items.size(), 0.0) {
  parallelFor(static_cast<Index>(dense.size()), kBlock, [&](Index begin, Index end) {
    std::vector<double> weight;
    Eigen::SelfAdjointEigenSolver<Mat3> solver;
    for (Index i = begin; i < end; ++i) {
      const Index first = followed_.offsets[i], count = followed_.count(i);
      const auto away = [&](Index k) { return Vec3(simulation[followed_.items[first + k]] - dense[i]); };
      double reach = 0.0, sum = 0.0;
      for (Index k = 0; k < count; ++k) reach = std::max(reach, kReach * kReach * away(k).squaredNorm());
      weight.assign(count, 1.0);
      Vec3 mean = Vec3::Zero();
      for (Index k = 0; k < count && reach > 0.0; ++k) {
        const double s = away(k).squaredNorm() / reach;
        weight[k] = (1.0 - s) * (1.0 - s) / std::max(s, kCoincident);
        sum += weight[k];
        mean += weight[k] * away(k);
      }
      if (!(reach > 0.0)) sum = count;
      mean /= std::max(sum, 1e-300);
      Mat3 K = Mat3::Zero();
      for (Index k = 0; k < count; ++k) K += weight[k] * (away(k) - mean) * (away(k) - mean).transpose();
      solver.compute(K);
      Mat3 inverse = Mat3::Zero();
      for (int c = 0; c < 3; ++c)
        if (solver.eigenvalues()[c] > kLeastSpread * solver.eigenvalues()[2])
          inverse += solver.eigenvectors().col(c) * solver.eigenvectors().col(c).transpose() / solver.eigenvalues()[c];
      for (Index k = 0; k < count; ++k) {
        const Vec3 slope = weight[k] * (inverse * (away(k) - mean));
        Eigen::Map<Vec4>(row_.data() + 4 * static_cast<std::size_t>(first + k)) << weight[k] / sum - mean.dot(slope), slope;
      }
    }
  });
}

void SolidTransfer::apply(const Points& simulation_now, Points& dense_now, std::vector<Eigen::Vector3f>* normals_now) const {
  const Index n = static_cast<Index>(rest_.size());
  dense_now.resize(n);
  if (normals_now) normals_now->resize(n);
  parallelFor(n, kBlock, [&](Index begin, Index end) {
    for (Index i = begin; i < end; ++i) {
      Vec3 u = Vec3::Zero();
      Mat3 F = Mat3::Identity();
      for (Index k = followed_.offsets[i]; k < followed_.offsets[i + 1]; ++k) {
        const Index j = followed_.items[k];
        const double* row = row_.data() + 4 * static_cast<std::size_t>(k);
        const Vec3 moved = simulation_now[j] - simulation_rest_[j];
        u += row[0] * moved;
        if (normals_now) F += moved * Eigen::Map<const Vec3>(row + 1).transpose();
      }
      dense_now[i] = rest_[i] + u;
      if (!normals_now) continue;
      Mat3 cofactor;
      cofactor << F.col(1).cross(F.col(2)), F.col(2).cross(F.col(0)), F.col(0).cross(F.col(1));
      const Vec3 normal = cofactor * normals_[i];
      const double length = normal.norm();
      (*normals_now)[i] = (length > 0.0 ? Vec3(normal / length) : normals_[i]).cast<float>();
    }
  });
}

}  // namespace deformable_surface::transfer
