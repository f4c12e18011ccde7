// Normals from the covariance of neighbourhoods, and their common side by a spanning tree of the neighbour graph.
#include "deformable_surface/cloud/normals.h"

#include "deformable_surface/base/error.h"
#include "deformable_surface/base/parallel.h"
#include "fit_plane.h"
#include "own_part.h"
#include "signed_sets.h"
#include "spanning_forest.h"

#include <Eigen/Eigenvalues>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
#include <tuple>

namespace deformable_surface::cloud {
namespace {

// Points per block of a parallel loop: about a millisecond of work.
constexpr Index kBlock = 1024;
// A sum of n signed terms that is smaller than this share of the sum of their magnitudes is rounding, and does not decide.
constexpr double kTie = 1e-9;
// A closed surface that encloses less than this share of (area x extent) is flat, and has no outside.
constexpr double kFlat = 1e-6;
// Ratio of the two smaller variances above which a neighbourhood may hold more than one layer. A sphere whose radius is that of
// the neighbourhood has 0.1.
constexpr double kThick = 0.03;
constexpr std::size_t kFewestOwn = 6;    // neighbours on this side of a gap, for a plane of their own
constexpr double kClearlyFlatter = 0.5;  // of the thickness, that the own part must be
constexpr double kLine = 0.01;           // ratio of the two larger variances below which points lie on a line
// Beside a crease a window on one side of it is flat: one of the nearest points, or that of a neighbour on whose plane the point
// lies.
constexpr Index kFew = 12;             // points of a small window
constexpr double kFlatWindow = 0.01;   // thickness of a flat window, at most,
constexpr double kMuchFlatter = 0.25;  // and of that of what it replaces
constexpr double kOnPlane = 0.15;      // sine of the line from the neighbour to the point with its plane, at most

void checkSizes(const char* function, const Points& positions, const Lists& neighbors) {
  if (neighbors.size() == static_cast<Index>(positions.size())) return;
  throw InputError(std::string(function) + ": found " + std::to_string(neighbors.size()) + " lists of neighbours for " +
                   std::to_string(positions.size()) + " points; accepted: one for each");
}

struct Link {
  float weight;
  Index i, j;
  bool are_opposite;  // the normals point to different sides
  bool operator<(const Link& other) const { return std::tie(weight, i, j) < std::tie(other.weight, other.i, other.j); }
};

// The side of each normal by the given normals: 1, -1, or 0 where these lie in the surface; empty if none are given.
std::vector<signed char> findGivenSides(const Points& given, const Points& normals) {
  std::vector<signed char> sides(given.size());
  for (std::size_t i = 0; i < sides.size(); ++i) {
    const double cosine = given[i].dot(normals[i]);
    sides[i] = static_cast<signed char>((cosine > 0.0) - (cosine < 0.0));
  }
  return sides;
}

// The flatter the link, the smaller its weight. With given normals, links weigh least whose given normals agree with the
// surface at both ends. On a thin body, where flat links join its two sides, nothing contradicts the given ones along each side;
// one wrong normal contradicts all of its neighbours, so that it is joined last, as the surface requires.
Link weighLink(double cosine, double weight, const std::vector<signed char>& given_sides, Index i, Index j) {
  constexpr float kDoubt = 2.0f;  // more than any link weighs without it
  const bool are_opposite = cosine < 0.0;
  const bool is_doubtful = !given_sides.empty() && given_sides[i] * given_sides[j] * (are_opposite ? -1 : 1) <= 0;
  return {std::max(static_cast<float>(weight), 0.0f) + (is_doubtful ? kDoubt : 0.0f), std::min(i, j), std::max(i, j),
          are_opposite};
}
Link makeLink(const Points& normals, const std::vector<signed char>& given_sides, Index i, Index j) {
  const double cosine = normals[i].dot(normals[j]);
  return weighLink(cosine, 1.0 - std::abs(cosine), given_sides, i, j);
}

// Sparse samples of a bend or an edge turn far from one to the next. On a circle through both, the normal of one is that of the
// other mirrored at the plane halfway between them. The same holds across a thin body; such links,
// steep against both tangent planes, weigh more than any along the surface.
Link makeMirrorLink(const Points& positions, const Points& normals, const std::vector<signed char>& given_sides, Index i,
                    Index j) {
  constexpr double kSteep = 0.8;  // of a link along the normals: that around a right angle then weighs half of it
  const Vec3 line = positions[j] - positions[i];
  const double squared = line.squaredNorm();
  if (!(squared > 0.0)) return makeLink(normals, given_sides, i, j);
  const double slope_i = normals[i].dot(line), slope_j = normals[j].dot(line);
  const double cosine = normals[i].dot(normals[j]) - 2.0 * slope_i * slope_j / squared;
  const double steep = std::max(slope_i * slope_i, slope_j * slope_j) / squared;
  return weighLink(cosine, 1.0 - std::abs(cosine) + kSteep * steep, given_sides, i, j);
}

// Joins flat links to the nearest neighbours of all points in any order. Returns whether all flat links among the joined points
// agree: the flattest spanning forest then gives the same sides. are_all: no link leads out of the joined points.
bool joinFlat(const Lists& neighbors, const Points& normals, const std::vector<signed char>& given_sides, SignedSets& sets,
              bool& are_all) {
  constexpr float kFlatWeight = 0.1f;  // 26 degrees: sides are beyond doubt in most clouds
  constexpr Index kFew = 6;            // of them join nearly everything
  const Index n = neighbors.size();
  parallelFor(n, kBlock, [&](Index begin, Index end) {
    for (Index i = begin; i < end; ++i) {
      const Index* last = neighbors.begin(i) + std::min(kFew, neighbors.count(i));
      for (const Index* j = neighbors.begin(i); j != last; ++j) {
        const Link link = makeLink(normals, given_sides, i, *j);
        if (link.weight <= kFlatWeight) sets.join(i, *j, link.are_opposite);
      }
    }
  });
  // Asked for once, and not for each link: the root of each point, and whether the point is on the opposite side of it.
  std::vector<Index> root(n);
  std::vector<char> is_turned(n);
  parallelFor(n, kBlock, [&](Index begin, Index end) {
    for (Index i = begin; i < end; ++i) {
      root[i] = sets.find(i);
      is_turned[i] = sets.areOpposite(i, root[i]);
    }
  });
  std::atomic<bool> agree{true}, leads_out{false};
  parallelFor(n, kBlock, [&](Index begin, Index end) {
    for (Index i = begin; i < end && agree.load(std::memory_order_relaxed); ++i) {
      for (const Index* j = neighbors.begin(i); j != neighbors.end(i); ++j) {
        const Link link = makeLink(normals, given_sides, i, *j);
        if (root[i] != root[*j]) {
          leads_out.store(true, std::memory_order_relaxed);
        } else if (link.weight <= kFlatWeight && (is_turned[i] != is_turned[*j]) != link.are_opposite) {
          agree.store(false, std::memory_order_relaxed);
        }
      }
    }
  });
  are_all = !leads_out;
  return agree;
}

// Minimum spanning forest (Kruskal): the flattest links decide first. Where all flat links agree it does not matter which of them
// decide.
void joinSides(const Points& positions, const Lists& neighbors, const Points& normals,
               const std::vector<signed char>& given_sides, SideLinks links, SignedSets& sets) {
  bool are_all = false;
  const bool mirrored = links == SideLinks::kMirrored;
  const auto forLinks = [&](Index i, const auto& visit) {
    for (const Index* j = neighbors.begin(i); j != neighbors.end(i); ++j)
      visit(mirrored ? makeMirrorLink(positions, normals, given_sides, i, *j) : makeLink(normals, given_sides, i, *j));
  };
  const auto joinRest = [&] {
    visitSpanningForest<Link>(
        neighbors.size(), forLinks, [&](Index i) { return sets.find(i); },
        [&](const Link& link) { sets.join(link.i, link.j, link.are_opposite); });
  };
  if (mirrored) return joinRest();
  if (joinFlat(neighbors, normals, given_sides, sets, are_all)) {
    if (are_all) return;
    joinRest();
    if (joinFlat(neighbors, normals, given_sides, sets, are_all)) return;
  }
  sets.reset();
  joinRest();
}

// Quantities that decide the side of a component.
struct Component {
  Index count = 0;
  bool closed = true;
  Index votes = 0;  // reference normals that agree minus those that disagree
  double area = 0.0;
  Vec3 centroid = Vec3::Zero();
  double volume = 0.0, volume_scale = 0.0;  // three times the enclosed volume, and the same without signs
  double towards_viewpoint = 0.0;
  Vec3 mean_normal = Vec3::Zero();
};

}  // namespace

Plane fitPlane(const Points& positions, Index i, const Index* first, const Index* last) {
  // Offsets from the point keep their digits far from the origin; scaled to one they neither overflow nor underflow.
  const Vec3 p = positions[i];
  Vec3 mean = Vec3::Zero();
  double extent = 0.0;
  for (const Index* j = first; j != last; ++j) {
    const Vec3 d = positions[*j] - p;
    mean += d;
    extent = std::max(extent, d.cwiseAbs().maxCoeff());
  }
  if (!(extent > 0.0)) return {Vec3::UnitZ()};
  mean /= static_cast<Index>(last - first) + 1;

  // Covariance of the point and its neighbours: six sums that stay in registers, half the time of a matrix.
  const double scale = 1.0 / extent;
  double xx = 0.0, xy = 0.0, xz = 0.0, yy = 0.0, yz = 0.0, zz = 0.0;
  const auto add = [&](const Vec3& d) {
    xx += d.x() * d.x();
    xy += d.x() * d.y();
    xz += d.x() * d.z();
    yy += d.y() * d.y();
    yz += d.y() * d.z();
    zz += d.z() * d.z();
  };
  add(-mean * scale);
  for (const Index* j = first; j != last; ++j) add((positions[*j] - p - mean) * scale);
  Mat3 covariance;
  covariance << xx, xy, xz, xy, yy, yz, xz, yz, zz;
  // The iterative solver: the closed form loses half the digits where a neighbourhood is thin.
  const Eigen::SelfAdjointEigenSolver<Mat3> solver(covariance);
  if (!covariance.allFinite() || !solver.eigenvectors().allFinite()) {
    throw InputError("normals: the neighbourhood of point " + std::to_string(i) +
                     " is not finite; only finite points have a normal");
  }
  const Vec3& variance = solver.eigenvalues();
  return {solver.eigenvectors().col(0).normalized(), variance[1] > 0.0 ? variance[0] / variance[1] : 0.0,
          variance[2] > 0.0 ? variance[1] / variance[2] : 0.0};
}

namespace {

// Replaces the plane of a thick neighbourhood by that of the points that no gap parts from point i, if this is clearly flatter.
bool fitOwnPlane(const Points& positions, Index i, const Index* first, const Index* last, OwnPart& part, Plane& plane) {
  const std::vector<Index>& own = part.find(positions, i, first, last);
  if (own.size() < kFewestOwn) return false;
  const Plane of_own = fitPlane(positions, i, own.data(), own.data() + own.size());
  if (!(of_own.width > kLine && of_own.thickness < kClearlyFlatter * plane.thickness)) return false;
  plane = of_own;
  return true;
}

}  // namespace

Points estimateNormals(const Points& positions, const Lists& neighbors) {
  Points normals(positions.size());
  estimateNormals(positions, neighbors, std::vector<char>(positions.size(), 1), normals);
  return normals;
}

void estimateNormals(const Points& positions, const Lists& neighbors, const std::vector<char>& is_marked, Points& normals) {
  checkSizes("estimateNormals", positions, neighbors);
  if (is_marked.size() != positions.size() || normals.size() != positions.size())
    throw InputError("estimateNormals: found " + std::to_string(is_marked.size()) + " marks and " +
                     std::to_string(normals.size()) + " normals for " + std::to_string(positions.size()) +
                     " points; accepted: one of each for every point");
  parallelFor(static_cast<Index>(positions.size()), kBlock, [&](Index begin, Index end) {
    for (Index i = begin; i < end; ++i)
      if (is_marked[i]) normals[i] = fitPlane(positions, i, neighbors.begin(i), neighbors.end(i)).normal;
  });
}

NormalsInSpace estimateNormalsInSpace(const Points& positions, const Lists& neighbors) {
  checkSizes("estimateNormalsInSpace", positions, neighbors);
  const Index n = static_cast<Index>(positions.size());
  NormalsInSpace found;
  found.normals.resize(n);
  found.is_own.resize(n);
  Points near(n);                                      // of the flattest window around each point
  std::vector<float> thickness(n), near_thickness(n);  // of the whole neighbourhood, and of that window
  parallelFor(n, kBlock, [&](Index begin, Index end) {
    OwnPart part;
    for (Index i = begin; i < end; ++i) {
      const Index *first = neighbors.begin(i), *last = neighbors.end(i);
      Plane plane = fitPlane(positions, i, first, last);
      const bool is_own = plane.thickness > kThick && fitOwnPlane(positions, i, first, last, part, plane);
      Plane flattest = plane;
      if (plane.thickness > kThick && !is_own && last - first > kFew) {
        const Plane of_few = fitPlane(positions, i, first, first + kFew);
        if (of_few.width > kLine && of_few.thickness < std::min(kFlatWindow, kMuchFlatter * plane.thickness)) flattest = of_few;
      }
      found.normals[i] = plane.normal;
      found.is_own[i] = is_own;
      thickness[i] = static_cast<float>(plane.thickness);
      near[i] = flattest.normal;
      near_thickness[i] = static_cast<float>(flattest.thickness);
    }
  });
  if (std::none_of(thickness.begin(), thickness.end(), [](float t) { return t > kThick; })) return found;
  found.at_creases = near;
  parallelFor(n, kBlock, [&](Index begin, Index end) {
    for (Index i = begin; i < end; ++i) {
      if (!(thickness[i] > kThick)) continue;
      double least = std::min(kFlatWindow, kMuchFlatter * near_thickness[i]);
      for (const Index* j = neighbors.begin(i); j != neighbors.end(i); ++j) {
        if (!(near_thickness[*j] < least)) continue;
        const Vec3 d = positions[i] - positions[*j];
        const double height = d.dot(near[*j]);
        if (height * height > kOnPlane * kOnPlane * d.squaredNorm()) continue;
        least = near_thickness[*j];
        found.at_creases[i] = near[*j];
      }
    }
  });
  return found;
}

Points fitNormals(const Points& positions, const Lists& neighbors, const Points& normals) {
  checkSizes("fitNormals", positions, neighbors);
  constexpr Index kTerms = 6;
  constexpr Index kFewest = 7;       // neighbours and the point: one more than the terms
  constexpr double kSide = 0.2;      // least cosine of two normals of one side, 78 degrees
  constexpr double kSteepest = 0.7;  // of the line to a neighbour against the tangent plane: beyond it a fold or another sheet
  constexpr double kRidge = 1e-3;    // of the weights: lines of neighbours have no curvature across them
  Points fitted(positions.size());
  parallelFor(static_cast<Index>(positions.size()), kBlock, [&](Index begin, Index end) {
    using Matrix = Eigen::Matrix<double, kTerms, kTerms>;
    using Vector = Eigen::Matrix<double, kTerms, 1>;
    std::vector<Vec3> offsets;
    for (Index i = begin; i < end; ++i) {
      const Vec3& n = normals[i];
      fitted[i] = n;
      offsets.assign(1, Vec3::Zero());
      double reach = 0.0;
      for (const Index* j = neighbors.begin(i); j != neighbors.end(i); ++j) {
        const Vec3 d = positions[*j] - positions[i];
        if (!(normals[*j].dot(n) >= kSide) || !(std::abs(d.dot(n)) <= kSteepest * d.norm())) continue;
        offsets.push_back(d);
        reach = std::max(reach, d.norm());
      }
      if (static_cast<Index>(offsets.size()) < kFewest || !(reach > 0.0)) continue;
      const Vec3 u = n.unitOrthogonal(), v = n.cross(u);
      Matrix matrix = Matrix::Zero();
      Vector right = Vector::Zero();
      for (const Vec3& d : offsets) {
        const double x = d.dot(u) / reach, y = d.dot(v) / reach, z = d.dot(n) / reach;
        const double weight = std::exp(-2.0 * d.squaredNorm() / (reach * reach));  // about a seventh for the farthest
        Vector terms;
        terms << 1.0, x, y, x * x, x * y, y * y;
        matrix += weight * terms * terms.transpose();
        right += weight * z * terms;
      }
      const double ridge = kRidge * matrix(0, 0);
      for (Index k = 3; k < kTerms; ++k) matrix(k, k) += ridge;
      const Vector height = matrix.ldlt().solve(right);
      const Vec3 normal = (n - height[1] * u - height[2] * v).normalized();
      if (normal.allFinite()) fitted[i] = normal;
    }
  });
  return fitted;
}

void faceEye(const Points& positions, const Vec3& eye, Points& normals) {
  for (std::size_t i = 0; i < normals.size(); ++i)
    if (normals[i].dot(eye - positions[i]) < 0.0) normals[i] = -normals[i];
}

OrientationRule orientNormals(const Points& positions, const Lists& neighbors, const std::vector<char>& is_boundary,
                              const Points& reference_normals, const std::optional<Vec3>& viewpoint, Points& normals,
                              SideLinks links) {
  const Index n = static_cast<Index>(positions.size());
  checkSizes("orientNormals", positions, neighbors);
  if (is_boundary.size() != positions.size() || normals.size() != positions.size() ||
      (!reference_normals.empty() && reference_normals.size() != positions.size())) {
    throw InputError("orientNormals: found " + std::to_string(n) + " points with " + std::to_string(is_boundary.size()) +
                     " boundary marks, " + std::to_string(normals.size()) + " normals and " +
                     std::to_string(reference_normals.size()) +
                     " reference normals; accepted: one of each for every point, or no reference normals");
  }

  SignedSets sets(n);
  joinSides(positions, neighbors, normals, findGivenSides(reference_normals, normals), links, sets);
  // The root of a component is its smallest index.
  std::vector<Index> root(n), component(n);
  Index num_components = 0;
  for (Index i = 0; i < n; ++i) {
    root[i] = sets.find(i);
    component[i] = root[i] == i ? num_components++ : component[root[i]];
    if (sets.areOpposite(i, root[i])) normals[i] = -normals[i];
  }

  // Areas up to a common factor: the squared distance of the farthest listed neighbour.
  std::vector<double> area(n, 0.0);
  parallelFor(n, kBlock, [&](Index begin, Index end) {
    for (Index i = begin; i < end; ++i) {
      for (const Index* j = neighbors.begin(i); j != neighbors.end(i); ++j) {
        area[i] = std::max(area[i], (positions[*j] - positions[i]).squaredNorm());
      }
    }
  });

  // Sums over each component, in the order of the points.
  std::vector<Component> components(num_components);
  for (Index i = 0; i < n; ++i) {
    Component& c = components[component[i]];
    ++c.count;
    c.closed = c.closed && !is_boundary[i];
    c.area += area[i];
    c.centroid += area[i] * (positions[i] - positions[root[i]]);
    c.mean_normal += area[i] * normals[i];
    if (!reference_normals.empty()) {
      const double agreement = reference_normals[i].dot(normals[i]);
      c.votes += (agreement > 0.0) - (agreement < 0.0);
    }
    if (viewpoint) c.towards_viewpoint += area[i] * normals[i].dot((*viewpoint - positions[i]).normalized());
  }
  for (Index i = 0; i < n; ++i) {
    Component& c = components[component[i]];
    const Vec3 arm = positions[i] - positions[root[i]] - c.centroid / std::max(c.area, std::numeric_limits<double>::min());
    c.volume += area[i] * normals[i].dot(arm);
    c.volume_scale += area[i] * arm.norm();
  }

  // The side of each component.
  OrientationRule rule_of_largest = OrientationRule::kUp;
  Index largest = 0;
  std::vector<char> flip(num_components, 0);
  for (Index r = 0; r < n; ++r) {
    if (root[r] != r) continue;
    const Component& c = components[component[r]];
    OrientationRule rule;
    double side = 0.0;
    if (c.votes != 0) {
      rule = OrientationRule::kInputNormals;
      side = c.votes;
    } else if (c.closed && std::abs(c.volume) > kFlat * c.volume_scale) {
      rule = OrientationRule::kOutward;
      side = c.volume;
    } else if (viewpoint && std::abs(c.towards_viewpoint) > kTie * c.area) {
      rule = OrientationRule::kViewpoint;
      side = c.towards_viewpoint;
    } else {
      rule = OrientationRule::kUp;
      // Without any area (single points) the component's own first normal decides.
      const Vec3 mean = c.area > 0.0 ? Vec3(c.mean_normal / c.area) : normals[r];
      for (int axis : {2, 1, 0}) {
        if (side == 0.0 && std::abs(mean[axis]) > kTie) side = mean[axis];
      }
    }
    flip[component[r]] = side < 0.0;
    if (c.count > largest) {
      largest = c.count;
      rule_of_largest = rule;
    }
  }
  for (Index i = 0; i < n; ++i) {
    if (flip[component[i]]) normals[i] = -normals[i];
  }
  return rule_of_largest;
}

}  // namespace deformable_surface::cloud
