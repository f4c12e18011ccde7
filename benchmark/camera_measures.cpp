#include "camera_measures.h"

#include "deformable_surface/base/error.h"
#include "deformable_surface/cloud/kd_tree.h"
#include "deformable_surface/cloud/links.h"
#include "deformable_surface/cloud/rings.h"
#include "deformable_surface/simulation/simulation.h"
#include "report.h"

#include <algorithm>
#include <cmath>

namespace deformable_surface::benchmark {
namespace {

simulation::SceneParams makeParams(const Neighborhoods& how) {
  simulation::SceneParams params;
  params.simplification.target_points = kTargetPoints;
  params.neighbors.geodesic_exponent = how.geodesic_exponent;
  params.input.noise = how.noise;
  return params;
}

// Pieces that the lists connect, largest first.
std::vector<Index> findSizes(const Lists& neighbors) {
  Index count = 0;
  const std::vector<Index> label = cloud::labelComponents(neighbors, count);
  std::vector<Index> sizes(count, 0);
  for (const Index l : label) ++sizes[l];
  std::sort(sizes.rbegin(), sizes.rend());
  return sizes;
}

// The pixel of every dense point; -1: it flies.
std::vector<Index> findPixels(const test::CameraFrame& frame, const cloud::CleanCloud& dense) {
  std::vector<Index> pixel(dense.positions.size(), -1);
  for (Index i = 0; i < frame.size(); ++i)
    if (dense.point_of_input[i] >= 0 && !frame.flies[i]) pixel[dense.point_of_input[i]] = i;
  return pixel;
}

bool lists(const Lists& lists, Index i, Index j) { return std::find(lists.begin(i), lists.end(i), j) != lists.end(i); }

}  // namespace

SetUp setUp(const cloud::PointCloud& cloud, const Neighborhoods& how) {
  const simulation::SceneParams params = makeParams(how);
  SetUp made;
  const double before = processorSeconds();
  made.rest = simulation::buildRestSurface(params, cloud);
  made.cpu = processorSeconds() - before;

  const cloud::CleanCloud& dense = made.rest.dense;
  made.pieces = findSizes(made.rest.dense_neighbors);
  made.pieces.erase(std::find_if(made.pieces.begin(), made.pieces.end(), [](Index size) { return size < kPiecePoints; }),
                    made.pieces.end());
  cloud::labelComponents(made.numSimulated(), stretchLinksOf(*made.rest.model), made.parts);
  const cloud::Boundary boundary =
      cloud::findBoundary(dense.positions, dense.normals, made.rest.dense_neighbors, params.neighbors.k);
  made.corners = static_cast<Index>(std::count(boundary.is_corner.begin(), boundary.is_corner.end(), 1));
  return made;
}

PairCounts countPairs(const test::CameraFrame& frame, const SetUp& made) {
  constexpr Index kNearest = 8;
  const Index listed_each = 2 * cloud::NeighborsParams().k;
  const Lists& kept = made.rest.dense_neighbors;
  const std::vector<Index>& leader = made.rest.leader;
  const std::vector<Index> pixel = findPixels(frame, made.rest.dense);
  // In a large frame lists are among every second pixel of every second row. Each other pixel follows one of these.
  const auto isListed = [&](Index i) { return leader.empty() || leader[i] == i; };
  Points positions, true_positions;
  std::vector<Index> listed;
  for (Index i = 0; i < kept.size(); ++i) {
    if (!isListed(i)) continue;
    listed.push_back(i);
    positions.push_back(made.rest.dense.positions[i]);
    true_positions.push_back(pixel[i] < 0 ? made.rest.dense.positions[i] : frame.positions[pixel[i]]);
  }
  const Lists candidates = cloud::nearestNeighbors(positions, listed_each);
  const Lists nearest = cloud::nearestNeighbors(true_positions, kNearest);
  PairCounts counts;
  const auto areTrue = [&](Index i, Index j) { return test::areTrueNeighbors(frame, pixel[i], pixel[j]); };
  const auto count = [&](const Lists& pairs, Index k, Index& all, Index& missing) {
    for (const Index* c = pairs.begin(k); c != pairs.end(k); ++c) {
      const Index i = listed[k], j = listed[*c];
      if (pixel[j] < 0 || !areTrue(i, j)) continue;
      ++all;
      missing += !lists(kept, i, j);
    }
  };
  for (Index k = 0; k < static_cast<Index>(listed.size()); ++k) {
    if (pixel[listed[k]] < 0) continue;
    count(candidates, k, counts.candidates, counts.refused);
    count(nearest, k, counts.nearest, counts.missed);
  }
  for (Index i = 0; i < kept.size(); ++i) {
    if (pixel[i] < 0) continue;
    for (const Index* j = kept.begin(i); j != kept.end(i); ++j) counts.across += pixel[*j] >= 0 && !areTrue(i, *j);
    if (isListed(i)) continue;
    // One pair: the pixel that it follows. Without one it is lost.
    ++counts.candidates;
    ++counts.nearest;
    counts.refused += leader[i] < 0;
    counts.missed += leader[i] < 0;
  }
  return counts;
}

double findNormalError(const test::CameraFrame& frame, const SetUp& made) {
  const std::vector<Index> pixel = findPixels(frame, made.rest.dense);
  double sum = 0.0;
  Index count = 0;
  for (std::size_t i = 0; i < pixel.size(); ++i) {
    if (pixel[i] < 0) continue;
    const Vec3 &normal = made.rest.dense.normals[i], &truth = frame.normals[pixel[i]];
    const double angle = std::atan2(normal.cross(truth).norm(), std::abs(normal.dot(truth)));
    sum += angle * angle;
    ++count;
  }
  return std::sqrt(sum / count) * 180.0 / M_PI;
}

PullTest::PullTest(const test::CameraScene& scene, const test::CameraFrame& frame) : scene_(scene), frame_(frame) {
  constexpr double kTrial = 1e-5, kMotion = 0.01;  // N, m
  const auto measure = [&] {
    double largest = 0.0;
    for (const Vec3& u : moved_)
      if (u.allFinite()) largest = std::max(largest, u.norm());
    return largest;
  };
  moved_ = move(frame.clean, {}, kTrial);
  force_ = kTrial * kMotion / measure();
  moved_ = move(frame.clean, {}, force_);
  largest_ = measure();
}

Points PullTest::move(const cloud::PointCloud& cloud, const Neighborhoods& how, double force) const {
  simulation::SceneParams params = makeParams(how);
  params.accuracy.estimate = false;
  params.integrator.type = solve::IntegratorType::kStatic;
  params.gravity.setZero();
  params.material.bending_rigidity = 1e-3;  // N m: a thick towel, that noise does not stiffen much
  // As deep as the noise scatters what lies there.
  const double depth = test::kHeldRadius + 4.0 * frame_.camera.depthNoise(scene_.distance);
  for (const Vec3& held : scene_.held) {
    simulation::PinParams pin;
    const Vec3 half(test::kHeldRadius, test::kHeldRadius, depth);
    pin.region.min = held - half;
    pin.region.max = held + half;
    params.pins.push_back(pin);
  }
  simulation::ForceParams pull;
  pull.id = "pull";
  pull.point = scene_.pulled;
  pull.force = force * scene_.direction;
  pull.radius = depth;
  params.forces.push_back(pull);
  simulation::Simulation simulation(params, cloud);
  const simulation::StepOutcome outcome = simulation.step();
  if (!outcome.ok) throw InputError(outcome.problem);
  Points moved = simulation.surface(false).positions;
  for (std::size_t i = 0; i < moved.size(); ++i) moved[i] -= cloud.positions[i];
  return moved;
}

std::string PullTest::compare(const Neighborhoods& how) const {
  try {
    const Points moved = move(frame_.cloud, how, force_);
    double sum = 0.0;
    Index count = 0;
    for (Index i = 0; i < frame_.size(); ++i) {
      if (!frame_.isSeen(i) || frame_.flies[i]) continue;
      sum += (moved[i] - moved_[i]).squaredNorm();
      ++count;
    }
    return show(100.0 * std::sqrt(sum / count) / largest_);
  } catch (const InputError& problem) {
    return problem.what();
  }
}

}  // namespace deformable_surface::benchmark
