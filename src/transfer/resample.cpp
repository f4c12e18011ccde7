// Inserts points into links that have become too long. The links are treated like the edges of a triangulation: halving one also
// links its middle to the corners opposite to it, so that the new triangles can be halved in turn.
#include "deformable_surface/transfer/resample.h"

#include "deformable_surface/base/error.h"
#include "deformable_surface/base/parallel.h"
#include "deformable_surface/base/value.h"

#include <Eigen/QR>

#include <algorithm>
#include <cmath>
#include <iterator>

namespace deformable_surface::transfer {
namespace {

// Links per block of a parallel loop: a few ten microseconds of work.
constexpr Index kBlock = 4096;
// A point this near to the middle of a link, in lengths of the link, already samples it: the diagonals of a grid's squares cross
// in their middles, where only the first may insert one.
constexpr double kCovered = 0.25;
// Smallest pivot, relative to the largest, of a coefficient that the neighbours determine: above rounding and noise, below
// that of scattered neighbours.
constexpr double kMinPivot = 1e-3;
// Coefficients of a quadratic height field.
constexpr Index kCoefficients = 6;
// The projection stays within this share of the link from its middle: even a half circle over the link bulges by a half.
constexpr double kMaxBulge = 0.5;

void insertSorted(std::vector<Index>& list, Index value) {
  const auto at = std::lower_bound(list.begin(), list.end(), value);
  if (at == list.end() || *at != value) list.insert(at, value);
}

void eraseSorted(std::vector<Index>& list, Index value) {
  const auto at = std::lower_bound(list.begin(), list.end(), value);
  if (at != list.end() && *at == value) list.erase(at);
}

}  // namespace

Resampler::Resampler(const Points& dense, const Points& normals, const cloud::Rings& dense_rings, double max_stretch,
                     Index max_points)
    : num_dense_(static_cast<Index>(dense.size())),
      max_stretch_(max_stretch),
      max_points_(max_points),
      dense_(dense),
      normals_(normals),
      adjacent_(dense.size()),
      spacing_(dense.size(), 0.0) {
  const Lists& ring = dense_rings.ring;
  std::vector<std::string> problems;
  if (normals.size() != dense.size() || ring.size() != num_dense_) {
    problems.push_back("resampler: found " + std::to_string(normals.size()) + " normals and " + std::to_string(ring.size()) +
                       " rings for " + std::to_string(num_dense_) + " points; accepted: one of each for every point");
  }
  if (!(max_stretch > 1.0 && std::isfinite(max_stretch))) {
    problems.push_back("resampler: max_stretch: found " + formatShort(max_stretch) + "; accepted: above 1");
  }
  if (!(max_points >= 0)) {
    problems.push_back("resampler: max_points: found " + std::to_string(max_points) + "; accepted: 0 or more");
  }
  if (!problems.empty()) throw InputError(problems);

  for (Index i = 0; i < num_dense_; ++i) {
    for (const Index* j = ring.begin(i); j != ring.end(i); ++j) {
      const double length = (dense[*j] - dense[i]).norm();
      spacing_[i] += length / ring.count(i);
      if (i < *j) links_.push_back({i, *j, length});
    }
    adjacent_[i].assign(ring.begin(i), ring.end(i));
    std::sort(adjacent_[i].begin(), adjacent_[i].end());
  }
}

Index Resampler::update(const Points& dense_now) {
  const std::size_t num_points = static_cast<std::size_t>(num_dense_) + inserted_rest_.size();
  if (dense_now.size() != num_points) {
    throw InputError("resampler: found " + std::to_string(dense_now.size()) + " deformed positions for " +
                     std::to_string(num_points) + " points; accepted: one for each, the inserted ones included");
  }
  if (static_cast<Index>(inserted_rest_.size()) >= max_points_) return 0;

  // The lengths of links that are too long, compared with the spacing around them, and with their length at rest so that nothing
  // happens at rest.
  const Index num_links = static_cast<Index>(links_.size());
  too_long_.resize(num_links);
  parallelFor(num_links, kBlock, [&](Index begin, Index end) {
    for (Index l = begin; l < end; ++l) {
      const Link& link = links_[l];
      const double spacing = std::max(0.5 * (spacing_[link.a] + spacing_[link.b]), link.rest_length);
      const double length = (dense_now[link.b] - dense_now[link.a]).norm();
      too_long_[l] = length > max_stretch_ * spacing && std::isfinite(length) ? length : 0.0;
    }
  });
  std::vector<Index> longest;
  for (Index l = 0; l < num_links; ++l) {
    if (too_long_[l] > 0.0) longest.push_back(l);
  }
  if (longest.empty()) return 0;
  ++revision_;

  // The longest first; a stable sort breaks ties by the order of the links.
  std::stable_sort(longest.begin(), longest.end(), [&](Index l, Index m) { return too_long_[l] > too_long_[m]; });
  std::vector<char> gone(num_links, 0);
  for (Index l : longest) {
    if (static_cast<Index>(inserted_rest_.size()) >= max_points_) break;
    halve(links_[l]);
    gone[l] = 1;
  }
  Index kept = 0;
  for (std::size_t l = 0; l < links_.size(); ++l) {
    if (static_cast<Index>(l) >= num_links || !gone[l]) links_[kept++] = links_[l];
  }
  links_.resize(kept);
  return static_cast<Index>(static_cast<std::size_t>(num_dense_) + inserted_rest_.size() - num_points);
}

// Replaces the link by its halves, with a new point between them unless one is there. links_ itself is cleared by update().
void Resampler::halve(Link link) {
  const Index a = link.a, b = link.b;
  const Vec3 middle = 0.5 * (restPosition(a) + restPosition(b));
  std::vector<Index> opposite;
  std::set_intersection(adjacent_[a].begin(), adjacent_[a].end(), adjacent_[b].begin(), adjacent_[b].end(),
                        std::back_inserter(opposite));
  eraseSorted(adjacent_[a], b);
  eraseSorted(adjacent_[b], a);
  const Index covering = findNear(middle, kCovered * link.rest_length, a, b);
  if (covering >= 0) {
    addLink(a, covering);
    addLink(b, covering);
    return;
  }

  Vec3 normal;
  const Vec3 position = project(middle, normal, a, b);
  const Index inserted = num_dense_ + static_cast<Index>(inserted_rest_.size());
  inserted_rest_.push_back(position);
  inserted_normals_.push_back(normal);
  parents_.emplace_back(a, b);
  adjacent_.emplace_back();
  spacing_.push_back(0.5 * (spacing_[a] + spacing_[b]));
  addLink(a, inserted);
  addLink(b, inserted);
  for (Index c : opposite) addLink(c, inserted);
}

// The first point within the distance of a place between a and b, among their neighbours and the neighbours of these; -1 if none.
Index Resampler::findNear(const Vec3& place, double distance, Index a, Index b) const {
  for (Index end : {a, b}) {
    for (Index j : adjacent_[end]) {
      if ((restPosition(j) - place).norm() < distance) return j;
      for (Index m : adjacent_[j]) {
        if (m != a && m != b && (restPosition(m) - place).norm() < distance) return m;
      }
    }
  }
  return -1;
}

void Resampler::addLink(Index a, Index b) {
  if (std::binary_search(adjacent_[a].begin(), adjacent_[a].end(), b)) return;
  links_.push_back({std::min(a, b), std::max(a, b), (restPosition(b) - restPosition(a)).norm()});
  insertSorted(adjacent_[a], b);
  insertSorted(adjacent_[b], a);
}

// The point of the moving-least-squares surface over the middle of a link, and its normal: heights over the plane of the ends'
// mean normal are fitted by a quadratic over the two ends and their neighbours [Alexa 2003, the polynomial step].
Vec3 Resampler::project(const Vec3& middle, Vec3& normal, Index a, Index b) const {
  const Vec3 n_a = restNormal(a), n_b = restNormal(b), sum = n_a + n_b;
  // Ends that face away from each other have no common side: the first one's counts.
  normal = sum.norm() > 0.1 ? sum.normalized() : n_a;
  std::vector<Index> around = adjacent_[a];
  for (Index j : adjacent_[b]) insertSorted(around, j);
  insertSorted(around, a);
  insertSorted(around, b);
  const Index count = static_cast<Index>(around.size());

  // Coordinates in units of the farthest neighbour, weighted by a Gaussian that has fallen to a seventh there.
  const Vec3 t_x = normal.unitOrthogonal(), t_y = normal.cross(t_x);
  double reach = 0.0;
  for (Index j : around) reach = std::max(reach, (restPosition(j) - middle).norm());
  Eigen::Matrix<double, Eigen::Dynamic, kCoefficients> basis(count, kCoefficients);
  Eigen::VectorXd height(count);
  for (Index r = 0; r < count; ++r) {
    const Vec3 d = (restPosition(around[r]) - middle) / reach;
    const double x = t_x.dot(d), y = t_y.dot(d), weight = std::exp(-d.squaredNorm());
    basis.row(r) << weight, weight * x, weight * y, weight * x * x, weight * x * y, weight * y * y;
    height[r] = weight * normal.dot(d);
  }

  // Undetermined coefficients stay zero (the smallest solution is taken); a fit that leaves the link's
  // surroundings is not used.
  Eigen::CompleteOrthogonalDecomposition<decltype(basis)> decomposition;
  decomposition.setThreshold(kMinPivot);
  const Eigen::Matrix<double, kCoefficients, 1> c = decomposition.compute(basis).solve(height);
  const double bulge = c[0] * reach;
  if (!(std::abs(bulge) <= kMaxBulge * (restPosition(b) - restPosition(a)).norm())) return middle;
  const Vec3 position = middle + bulge * normal;
  normal = (normal - c[1] * t_x - c[2] * t_y).normalized();
  return position;
}

const Points& Resampler::insertedRest() const { return inserted_rest_; }
const Points& Resampler::insertedNormals() const { return inserted_normals_; }
const std::vector<std::pair<Index, Index>>& Resampler::parents() const { return parents_; }

std::size_t Resampler::bytes() const {
  std::size_t links = 0;
  for (const std::vector<Index>& list : adjacent_) links += list.size();
  return sizeof(Vec3) * (dense_.size() + normals_.size() + inserted_rest_.size() + inserted_normals_.size()) +
         sizeof(std::pair<Index, Index>) * parents_.size() + sizeof(std::vector<Index>) * adjacent_.size() +
         sizeof(Index) * links + sizeof(double) * (spacing_.size() + too_long_.size()) + sizeof(Link) * links_.size();
}

}  // namespace deformable_surface::transfer
