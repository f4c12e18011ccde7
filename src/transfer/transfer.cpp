// The transfer operator: fitted once per rest state, applied in every frame. Applying it is one pass (transfer_pass.h) that moves
// as few bytes as possible, because memory bandwidth limits it, not arithmetic.
#include "deformable_surface/transfer/transfer.h"

#include "deformable_surface/base/error.h"
#include "deformable_surface/base/interrupt.h"
#include "deformable_surface/base/parallel.h"
#include "deformable_surface/base/value.h"
#include "deformable_surface/cloud/kd_tree.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>

#include "transfer_pass.h"

namespace deformable_surface::transfer {
namespace {

// Longest row: more neighbours smooth the motion and need memory without benefit.
constexpr Index kMaxNeighbors = 64;
// The compact kernel ends this much beyond the farthest neighbour, which keeps a positive weight of a few ten-thousandths: where
// the neighbours change from one dense point to the next, no step is visible.
constexpr double kKernelReach = 1.1;
// A slope along a direction is fitted if it multiplies errors of the displacements by at most this, per distance of the
// farthest neighbour: their spread must be about a hundredth of that distance.
constexpr double kMaxAmplification = 100.0;
// The share of the dense points that are simulated from which on these move as they do. Below it the plane's smooth motion of all
// points is worth more: single points would stand out.
constexpr double kNearlyAll = 0.9;
// Points per block of a parallel loop: a few milliseconds of work.
constexpr Index kFitBlock = 1024;
constexpr double kMostUnits = 9007199254740992.0;  // 2^53: beyond it a double is a whole number of units already

// (1 - s)^4 (4 s + 1), s = r / h: the C2 kernel of compact support in three dimensions [Wendland 1995].
inline double evaluateWendland(double s) {
  const double t = std::max(1.0 - s, 0.0);
  return t * t * t * t * (4.0 * s + 1.0);
}

template <class Vector>
auto* numbersOf(std::vector<Vector>& vectors) {
  return reinterpret_cast<typename Vector::Scalar*>(vectors.data());
}

// One number per neighbour, without allocating.
using Row = std::array<double, kMaxNeighbors>;

// Rounds a row to float, and adds the rounding error of its sum to its largest entry: constant displacements stay exact.
// Entry j goes to out[j * stride].
void storeRow(const Row& row, std::size_t count, double sum, float* out, std::size_t stride) {
  std::size_t largest = 0;
  double rest = sum;
  for (std::size_t j = 0; j < count; ++j) {
    out[j * stride] = static_cast<float>(row[j]);
    rest -= out[j * stride];
    if (std::abs(row[j]) > std::abs(row[largest])) largest = j;
  }
  out[largest * stride] = static_cast<float>(out[largest * stride] + rest);
}

// The first of n points that is wrong; n if none is.
template <class IsWrong>
Index findFirst(Index n, const IsWrong& isWrong) {
  // As maxima, so that the largest is the first.
  const double most = parallelMax(n, kFitBlock, [&](Index begin, Index end) {
    for (Index i = begin; i < end; ++i)
      if (isWrong(i)) return static_cast<double>(n - i);
    return 0.0;
  });
  return n - static_cast<Index>(most);
}

void check(const Points& dense, const Points& normals, const Points& simulation, const std::vector<char>& usable,
           const TransferParams& params, const Lists* followed) {
  std::vector<std::string> problems;
  if (normals.size() != dense.size()) {
    problems.push_back("transfer: found " + std::to_string(normals.size()) + " normals for " + std::to_string(dense.size()) +
                       " dense points; accepted: one for each");
  }
  if (usable.size() != simulation.size()) {
    problems.push_back("transfer: found " + std::to_string(usable.size()) + " usable marks for " +
                       std::to_string(simulation.size()) + " simulation points; accepted: one for each");
  }
  if (!(params.k >= 1 && params.k <= kMaxNeighbors)) {
    problems.push_back("transfer: k: found " + std::to_string(params.k) + "; accepted: 1 to " + std::to_string(kMaxNeighbors));
  }
  if (!(params.gaussian_width >= 0.0 && std::isfinite(params.gaussian_width))) {
    problems.push_back("transfer: gaussian_width: found " + formatShort(params.gaussian_width) +
                       " m; accepted: 0 (mean distance of the neighbours) or above");
  }
  if (followed && followed->size() != static_cast<Index>(dense.size())) {
    problems.push_back("transfer: found " + std::to_string(followed->size()) + " lists of followed points for " +
                       std::to_string(dense.size()) + " dense points; accepted: one for each");
  }
  if (!problems.empty()) throw InputError(problems);
  const Index n = static_cast<Index>(dense.size());
  const auto isUsable = [&](Index j) { return j >= 0 && static_cast<std::size_t>(j) < usable.size() && usable[j]; };
  const auto isStray = [&](Index i) {
    return followed->count(i) > params.k || !std::all_of(followed->begin(i), followed->end(i), isUsable);
  };
  const Index stray = followed ? findFirst(n, isStray) : n;
  if (stray < n)
    throw InputError("transfer: dense point " + std::to_string(stray) +
                     " follows more than k simulation points, or one that is not usable");
  // Normals of a float cloud are unit to a few 1e-7; a thousandth distinguishes them from vectors that were never normalised.
  const Index wrong =
      findFirst(n, [&](Index i) { return !(dense[i].allFinite() && std::abs(normals[i].squaredNorm() - 1.0) < 1e-3); });
  if (wrong < n)
    throw InputError("transfer: dense point " + std::to_string(wrong) + " is not finite or its normal is not a unit vector");
}

}  // namespace

Transfer::Transfer(const Points& dense, const Points& normals, const Points& simulation, const std::vector<char>& usable,
                   const TransferParams& params, const Lists* followed)
    : rest_(dense), simulation_rest_(simulation), usable_(usable) {
  check(dense, normals, simulation, usable, params, followed);

  // Neighbours are searched among the usable points only.
  std::vector<Index> used;
  Points used_positions;
  for (std::size_t j = 0; j < simulation.size(); ++j) {
    if (!usable[j]) continue;
    used.push_back(static_cast<Index>(j));
    used_positions.push_back(simulation[j]);
  }
  num_usable_ = static_cast<Index>(used.size());
  const cloud::KdTree tree(used_positions);

  k_ = params.k;
  const std::size_t num_groups = (dense.size() + kLanes - 1) / kLanes;
  static_assert(kFitBlock % kLanes == 0, "a block fills whole groups");
  index_.assign(num_groups * k_ * kLanes, 0);
  weight_.assign(num_groups * k_ * 3 * kLanes, 0.0f);
  frame_.assign(num_groups * kFrameRows * kLanes, 0.0f);
  num_degenerate_ = static_cast<Index>(parallelSum(numDense(), kFitBlock, [&](Index begin, Index end) {
    std::vector<cloud::Neighbor> nearest;
    std::vector<Index> found;
    int degenerate = 0;
    for (Index i = begin; i < end; ++i) {
      if (followed) {
        found.assign(followed->begin(i), followed->end(i));
      } else {
        tree.nearest(dense[i], k_, nearest);
        found.clear();
        for (const cloud::Neighbor& neighbor : nearest) found.push_back(used[neighbor.index]);
      }
      if (!fitRow(i, normals[i], simulation, found, params)) ++degenerate;
    }
    for (std::size_t g = begin / kLanes; g * kLanes < static_cast<std::size_t>(end); ++g)
      settleNormals(frame_.data() + g * kFrameRows * kLanes);
    return static_cast<double>(degenerate);
  }));

  tile_sources_.resize((dense.size() + kTilePoints - 1) / kTilePoints);
  parallelFor(numTiles(), 1, [&](Index begin, Index end) {
    for (Index tile = begin; tile < end; ++tile) findTileSources(tile);
  });
}

void Transfer::findTileSources(Index tile) {
  static thread_local std::vector<char> is_listed;  // all zero between calls
  is_listed.resize(std::max(is_listed.size(), simulation_rest_.size()), 0);
  std::vector<Index>& sources = tile_sources_[tile];
  sources.clear();
  const std::size_t row = static_cast<std::size_t>(k_) * kLanes,
                    first = static_cast<std::size_t>(tile) * (kTilePoints / kLanes) * row;
  for (std::size_t at = first, end = std::min(index_.size(), first + kTilePoints / kLanes * row); at < end; ++at) {
    if (simulation_rest_.empty() || is_listed[index_[at]]) continue;
    is_listed[index_[at]] = 1;
    sources.push_back(index_[at]);
  }
  for (Index j : sources) is_listed[j] = 0;
}

Transfer::PointRow Transfer::rowOf(Index dense) const {
  const std::size_t group = dense / kLanes, lane = dense % kLanes;
  const Index* const index = index_.data() + group * k_ * kLanes + lane;
  const float* const weight = weight_.data() + group * k_ * 3 * kLanes + lane;
  const float* const frame = frame_.data() + group * kFrameRows * kLanes + lane;
  const auto read3 = [&](int first) {
    return Vec3(frame[first * kLanes], frame[(first + 1) * kLanes], frame[(first + 2) * kLanes]);
  };
  PointRow row;
  for (Index j = 0; j < k_; ++j) {
    row.source.push_back(index[j * kLanes]);
    row.value.push_back(weight[3 * j * kLanes]);
    row.gradient_x.push_back(weight[(3 * j + 1) * kLanes]);
    row.gradient_y.push_back(weight[(3 * j + 2) * kLanes]);
  }
  row.rest = rest_[dense];
  row.normal = read3(kNormal);
  row.tangent_x = read3(kTangentX);
  row.tangent_y = read3(kTangentY);
  row.slope_x = frame[kSlopeX * kLanes];
  row.slope_y = frame[kSlopeY * kLanes];
  row.height = frame[kHeight * kLanes];
  return row;
}

std::vector<Index> Transfer::sourcesOf(Index dense) const {
  const Index* const index = index_.data() + dense / kLanes * k_ * kLanes + dense % kLanes;
  std::vector<Index> sources{index[0]};
  // Shorter rows are padded with the first entry.
  for (Index j = 1; j < k_ && index[j * kLanes] != index[0]; ++j) sources.push_back(index[j * kLanes]);
  return sources;
}

void Transfer::refit(const std::vector<Index>& dense, const Lists& followed, const Points& normals,
                     const TransferParams& params) {
  std::vector<Index> found;
  for (std::size_t p = 0; p < dense.size(); ++p) {
    if (p % kTilePoints == 0) endIfInterrupted();
    const std::size_t group = dense[p] / kLanes, lane = dense[p] % kLanes;
    float* const weight = weight_.data() + group * k_ * 3 * kLanes + lane;
    for (Index j = 0; j < 3 * k_; ++j) weight[j * kLanes] = 0.0f;
    found.assign(followed.begin(static_cast<Index>(p)), followed.end(static_cast<Index>(p)));
    fitRow(dense[p], normals[dense[p]], simulation_rest_, found, params);
  }
  for (Index d : dense) settleNormals(frame_.data() + static_cast<std::size_t>(d / kLanes) * kFrameRows * kLanes);
  Index last = -1;
  for (Index d : dense) {
    if (d / kTilePoints == last) continue;
    last = d / kTilePoints;
    findTileSources(last);
  }
}

bool Transfer::fitRow(Index i, const Vec3& normal, const Points& simulation, const std::vector<Index>& found,
                      const TransferParams& params) {
  const std::size_t count = found.size(), group = i / kLanes, lane = i % kLanes;
  const Vec3 n = normal.normalized();
  const Vec3 t_x = n.unitOrthogonal(), t_y = n.cross(t_x);
  double slope_x = 0.0, slope_y = 0.0, height = 0.0;
  int rank = 0;
  if (count > 0) {
    // The neighbours on the tangent plane and above it, in units of the distance of the farthest.
    Row x, y, z, distance;
    for (std::size_t j = 0; j < count; ++j) distance[j] = (simulation[found[j]] - rest_[i]).norm();
    const double farthest = *std::max_element(distance.begin(), distance.begin() + count);
    const double unit = farthest > 0.0 ? farthest : 1.0;
    for (std::size_t j = 0; j < count; ++j) {
      const Vec3 d = (simulation[found[j]] - rest_[i]) / unit;
      x[j] = t_x.dot(d);
      y[j] = t_y.dot(d);
      z[j] = n.dot(d);
      distance[j] /= unit;
    }

    // Weights, normalised. The Gaussian is relative to the nearest neighbour, so that it never vanishes for all.
    Row w;
    if (params.weighting == Weighting::kCompact) {
      for (std::size_t j = 0; j < count; ++j) w[j] = evaluateWendland(distance[j] / kKernelReach);
    } else {
      double mean = 0.0, least = std::numeric_limits<double>::infinity();
      for (std::size_t j = 0; j < count; ++j) {
        w[j] = x[j] * x[j] + y[j] * y[j];
        mean += std::sqrt(w[j]) / count;
        least = std::min(least, w[j]);
      }
      const double width = params.gaussian_width > 0.0 ? params.gaussian_width / unit : mean;
      for (std::size_t j = 0; j < count; ++j) w[j] = w[j] > least ? std::exp((least - w[j]) / (width * width)) : 1.0;
    }
    double total = 0.0;
    for (std::size_t j = 0; j < count; ++j) total += w[j];
    for (std::size_t j = 0; j < count; ++j) w[j] /= total;

    // Their centre, and their principal directions about it.
    double center_x = 0.0, center_y = 0.0;
    for (std::size_t j = 0; j < count; ++j) {
      center_x += w[j] * x[j];
      center_y += w[j] * y[j];
    }
    double c_xx = 0.0, c_xy = 0.0, c_yy = 0.0;
    for (std::size_t j = 0; j < count; ++j) {
      x[j] -= center_x;
      y[j] -= center_y;
      c_xx += w[j] * x[j] * x[j];
      c_xy += w[j] * x[j] * y[j];
      c_yy += w[j] * y[j] * y[j];
    }
    const double angle = 0.5 * std::atan2(2.0 * c_xy, c_xx - c_yy);

    // The least-squares slope along each direction in which the neighbours spread, and from it the value at the dense point.
    Row value = w, gradient_x{}, gradient_y{};
    for (const Vec2& e : {Vec2(std::cos(angle), std::sin(angle)), Vec2(-std::sin(angle), std::cos(angle))}) {
      double variance = 0.0, deviation = 0.0;
      for (std::size_t j = 0; j < count; ++j) {
        const double along = e.x() * x[j] + e.y() * y[j];
        variance += w[j] * along * along;
        deviation += w[j] * std::abs(along);
      }
      if (!(variance > 0.0 && deviation <= kMaxAmplification * variance)) continue;
      ++rank;
      const double center = e.x() * center_x + e.y() * center_y;
      for (std::size_t j = 0; j < count; ++j) {
        const double slope = w[j] * (e.x() * x[j] + e.y() * y[j]) / variance;
        value[j] -= center * slope;
        gradient_x[j] += e.x() * slope;
        gradient_y[j] += e.y() * slope;
      }
    }

    // Where nearly all points are simulated each of these moves as it does. Its slopes are still those of the plane.
    const std::size_t nearest = std::min_element(distance.begin(), distance.begin() + count) - distance.begin();
    if (num_usable_ >= kNearlyAll * numDense() && distance[nearest] == 0.0) {
      value.fill(0.0);
      value[nearest] = 1.0;
    }

    // The fitted plane at rest: its slopes against the tangent plane, and the point's height over it.
    for (std::size_t j = 0; j < count; ++j) {
      slope_x += gradient_x[j] * z[j];
      slope_y += gradient_y[j] * z[j];
      height -= value[j] * z[j] * unit;
      gradient_x[j] /= unit;
      gradient_y[j] /= unit;
    }

    // Store, filling up with the nearest neighbour at weight zero.
    Index* const index = index_.data() + group * k_ * kLanes + lane;
    float* const weight = weight_.data() + group * k_ * 3 * kLanes + lane;
    for (Index j = 0; j < k_; ++j) index[j * kLanes] = found[static_cast<std::size_t>(j) < count ? j : 0];
    storeRow(value, count, 1.0, weight, 3 * kLanes);
    storeRow(gradient_x, count, 0.0, weight + kLanes, 3 * kLanes);
    storeRow(gradient_y, count, 0.0, weight + 2 * kLanes, 3 * kLanes);
  }

  float* const frame = frame_.data() + group * kFrameRows * kLanes + lane;
  for (int axis = 0; axis < 3; ++axis) {
    frame[(kTangentX + axis) * kLanes] = static_cast<float>(t_x[axis] + slope_x * n[axis]);
    frame[(kTangentY + axis) * kLanes] = static_cast<float>(t_y[axis] + slope_y * n[axis]);
    frame[(kNormal + axis) * kLanes] = static_cast<float>(n[axis]);
  }
  frame[kSlopeX * kLanes] = static_cast<float>(slope_x);
  frame[kSlopeY * kLanes] = static_cast<float>(slope_y);
  frame[kHeight * kLanes] = static_cast<float>(height);
  return rank == 2;
}

// The reference is added back in double, so that far translations cost no digits. It is the mean, rounded to a power of two of
// the size of the differences from it. It is then constant as long as only a share of the points moves, so that no other
// displacement changes, and the rounding error is within a factor of two of the least possible.
void Transfer::findDisplacements(const Points& simulation_now, Vec3& reference, std::vector<float>& displacements) const {
  if (simulation_now.size() != simulation_rest_.size()) {
    throw InputError("transfer: found " + std::to_string(simulation_now.size()) + " positions for " +
                     std::to_string(simulation_rest_.size()) + " simulation points; accepted: one for each");
  }
  const std::size_t m = simulation_now.size();
  if (displacements.size() < 4 * std::max<std::size_t>(m, 1)) displacements.resize(4 * std::max<std::size_t>(m, 1));
  std::fill_n(displacements.begin(), 4, 0.0f);

  Vec3 mean = Vec3::Zero(), least = Vec3::Constant(std::numeric_limits<double>::infinity()), most = -least;
  for (std::size_t j = 0; j < m; ++j) {
    if (!usable_[j]) continue;
    const Vec3 u = simulation_now[j] - simulation_rest_[j];
    mean += u;
    least = least.cwiseMin(u);
    most = most.cwiseMax(u);
  }
  mean /= std::max(num_usable_, 1);
  const double size = num_usable_ > 0 ? (most - least).maxCoeff() : 0.0;
  reference = mean;
  int exponent = 0;
  std::frexp(size, &exponent);
  const double unit = std::ldexp(0.5, exponent);
  if (size > 0.0 && std::isfinite(size))
    for (int axis = 0; axis < 3; ++axis)
      if (std::abs(mean[axis]) < kMostUnits * unit) reference[axis] = unit * std::round(mean[axis] / unit);
  for (std::size_t j = 0; j < m; ++j) {
    const Vec3 u = usable_[j] ? Vec3(simulation_now[j] - simulation_rest_[j] - reference) : Vec3(0.0, 0.0, 0.0);
    for (int axis = 0; axis < 3; ++axis) displacements[4 * j + axis] = static_cast<float>(u[axis]);
    displacements[4 * j + 3] = 0.0f;
  }
}

void Transfer::run(Index begin, Index end, const float* displacements, const Vec3& reference, const PassOutput& output) const {
  const PassRows rows{
      numDense(), k_, index_.data(), weight_.data(), frame_.data(), reinterpret_cast<const double*>(rest_.data())};
  runGroups(begin, end, rows, {displacements, {reference.x(), reference.y(), reference.z()}}, output);
}

void Transfer::runAll(const Points& simulation_now, const PassOutput& output) const {
  // Kept by the thread: later calls allocate nothing, and several threads may share one operator.
  static thread_local std::vector<float> displacements;
  Vec3 reference;
  findDisplacements(simulation_now, reference, displacements);
  const float* const all = displacements.data();
  parallelFor((numDense() + kLanes - 1) / kLanes, kTilePoints / kLanes,
              [&](Index begin, Index end) { run(begin, end, all, reference, output); });
}

void Transfer::apply(const Points& simulation_now, Points& dense_now) const {
  dense_now.resize(rest_.size());
  runAll(simulation_now, {numbersOf(dense_now), nullptr, nullptr});
}

void Transfer::apply(const Points& simulation_now, Points& dense_now, std::vector<Eigen::Vector3f>& normals_now) const {
  dense_now.resize(rest_.size());
  normals_now.resize(rest_.size());
  runAll(simulation_now, {numbersOf(dense_now), numbersOf(normals_now), nullptr});
}

void Transfer::areaRatio(const Points& simulation_now, std::vector<float>& ratio) const {
  ratio.resize(rest_.size());
  runAll(simulation_now, {nullptr, nullptr, ratio.data()});
}

Index Transfer::update(const Points& simulation_now, Frame& frame, Points& dense_now, std::vector<Eigen::Vector3f>* normals_now,
                       const std::function<void(Index begin, Index end)>& after) const {
  findDisplacements(simulation_now, frame.next_reference_, frame.next_displacements_);
  const bool all = !frame.is_made_ || dense_now.size() != rest_.size() || frame.reference_ != frame.next_reference_ ||
                   (normals_now && (!frame.has_normals_ || normals_now->size() != rest_.size()));
  const Index m = numSimulation();
  frame.displacements_.resize(frame.next_displacements_.size());  // both at once, so that the next update allocates nothing
  frame.stale_.reserve(tile_sources_.size());
  frame.stale_.clear();
  frame.moved_.resize(m);
  for (Index j = 0; !all && j < m; ++j)
    frame.moved_[j] = std::memcmp(&frame.displacements_[4 * j], &frame.next_displacements_[4 * j], 3 * sizeof(float)) != 0;
  for (Index tile = 0; tile < numTiles(); ++tile) {
    const std::vector<Index>& sources = tile_sources_[tile];
    if (all || std::any_of(sources.begin(), sources.end(), [&](Index j) { return frame.moved_[j] != 0; }))
      frame.stale_.push_back(tile);
  }
  dense_now.resize(rest_.size());
  if (normals_now) normals_now->resize(rest_.size());
  const PassOutput output{numbersOf(dense_now), normals_now ? numbersOf(*normals_now) : nullptr, nullptr};
  const float* const displacements = frame.next_displacements_.data();
  const Index num_groups = (numDense() + kLanes - 1) / kLanes, groups = kTilePoints / kLanes;
  parallelFor(static_cast<Index>(frame.stale_.size()), 1, [&](Index begin, Index end) {
    for (Index s = begin; s < end; ++s) {
      const Index tile = frame.stale_[s];
      run(tile * groups, std::min((tile + 1) * groups, num_groups), displacements, frame.next_reference_, output);
      after(tile * kTilePoints, std::min((tile + 1) * kTilePoints, numDense()));
    }
  });
  std::swap(frame.displacements_, frame.next_displacements_);
  frame.reference_ = frame.next_reference_;
  frame.is_made_ = true;
  frame.has_normals_ = normals_now != nullptr;
  return static_cast<Index>(frame.stale_.size());
}

void Transfer::findLargest(const std::vector<float>& values, std::vector<float>& largest) const {
  largest.assign(rest_.size(), 0.0f);
  if (values.empty()) return;
  parallelFor(numDense(), kTilePoints, [&](Index begin, Index end) {
    for (Index i = begin; i < end; ++i) {
      const Index* const sources = index_.data() + static_cast<std::size_t>(i / kLanes) * k_ * kLanes + i % kLanes;
      for (Index j = 0; j < k_; ++j) largest[i] = std::max(largest[i], values[sources[j * kLanes]]);
    }
  });
}

Index Transfer::numDense() const { return static_cast<Index>(rest_.size()); }
Index Transfer::numSimulation() const { return static_cast<Index>(simulation_rest_.size()); }
Index Transfer::numDegenerate() const { return num_degenerate_; }

std::size_t Transfer::bytesPerPoint() const {
  return k_ * (sizeof(Index) + 3 * sizeof(float)) + kFrameRows * sizeof(float) + sizeof(Vec3);
}

}  // namespace deformable_surface::transfer
