#include "growth_shapes.h"

#include "deformable_surface/cloud/kd_tree.h"
#include "mesh_measures.h"
#include "physics/samplings.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <random>

namespace deformable_surface::benchmark {
namespace {

constexpr Index kDense = 60000;  // points that stand for a surface: a seventh of the distance of a thousand samples

// The same numbers with every standard library.
class Random {
 public:
  explicit Random(unsigned seed) : generator_(seed) {}
  double uniform(double low, double high) { return low + (high - low) * (generator_() + 0.5) / 4294967296.0; }
  double normal() { return std::sqrt(-2.0 * std::log(uniform(0.0, 1.0))) * std::cos(uniform(0.0, 2.0 * kPi)); }
  Vec3 normalVector() {
    const double x = normal(), y = normal(), z = normal();
    return {x, y, z};
  }
  std::size_t index(std::size_t n) { return generator_() % n; }

 private:
  std::mt19937 generator_;
};

struct Place {
  Vec3 position, normal;
};

// A surface as the image of a rectangle: places drawn in proportion to the area that they stand for.
using Chart = std::function<Vec3(double u, double v)>;
struct Rectangle {
  double u0, u1, v0, v1;
};

void addChart(const Chart& chart, const Rectangle& r, double share, Random& random, GrowthShape& shape) {
  constexpr Index kGrid = 200;  // cells each way for the area and its largest density
  constexpr double kStep = 1e-5;
  const auto findPlace = [&](double u, double v, Vec3& area) -> Vec3 {
    const double du = kStep * (r.u1 - r.u0), dv = kStep * (r.v1 - r.v0);
    area = ((chart(u + du, v) - chart(u - du, v)) / (2.0 * du)).cross((chart(u, v + dv) - chart(u, v - dv)) / (2.0 * dv));
    return chart(u, v);
  };
  double sum = 0.0, most = 0.0;
  for (Index i = 0; i < kGrid; ++i) {
    for (Index j = 0; j < kGrid; ++j) {
      Vec3 area;
      findPlace(r.u0 + (r.u1 - r.u0) * (i + 0.5) / kGrid, r.v0 + (r.v1 - r.v0) * (j + 0.5) / kGrid, area);
      sum += area.norm();
      most = std::max(most, area.norm());
    }
  }
  shape.area += sum / (kGrid * kGrid) * (r.u1 - r.u0) * (r.v1 - r.v0);
  constexpr double kSafe = 1.05;  // the largest density lies between the places of the grid
  const Index wanted = static_cast<Index>(std::lround(share * kDense));
  for (Index made = 0; made < wanted;) {
    const double u = random.uniform(r.u0, r.u1), v = random.uniform(r.v0, r.v1);
    Vec3 area;
    const Vec3 position = findPlace(u, v, area);
    if (random.uniform(0.0, kSafe * most) > area.norm()) continue;
    shape.surface.positions.push_back(position);
    shape.surface.normals.push_back(area.normalized());
    ++made;
  }
}

Chart makeBall(double radius, const Vec3& center) {
  return [=](double angle, double z) -> Vec3 {
    const double r = std::sqrt(std::max(0.0, 1.0 - z * z));
    return center + radius * Vec3(r * std::cos(angle), r * std::sin(angle), z);
  };
}

// Six faces of a box with these half sides; normals outwards.
void addBox(const Vec3& half, Random& random, GrowthShape& shape) {
  const double total = 8.0 * (half.x() * half.y() + half.y() * half.z() + half.z() * half.x());
  for (int axis = 0; axis < 3; ++axis) {
    const int a = (axis + 1) % 3, b = (axis + 2) % 3;
    for (const double side : {1.0, -1.0}) {
      const Chart face = [=](double u, double v) -> Vec3 {
        Vec3 p;
        p[axis] = side * half[axis];
        p[a] = side * u;
        p[b] = v;
        return p;
      };
      addChart(face, {-half[a], half[a], -half[b], half[b]}, 4.0 * half[a] * half[b] / total, random, shape);
    }
  }
}

// A pretzel with two holes: f = 0 with f = (x^2 (1 - x^2) - y^2)^2 + z^2 - c. Places of a thin layer about it, moved onto it.
void addPretzel(Random& random, GrowthShape& shape) {
  constexpr double kLevel = 0.012, kLayer = 0.01;
  const Vec3 half(1.15, 0.62, 0.15);
  const auto evaluate = [](const Vec3& p, Vec3& gradient) {
    const double x = p.x(), y = p.y(), g = x * x * (1.0 - x * x) - y * y;
    gradient = Vec3(2.0 * g * (2.0 * x - 4.0 * x * x * x), -4.0 * g * y, 2.0 * p.z());
    return g * g + p.z() * p.z() - kLevel;
  };
  Index tried = 0;
  Vec3 gradient;
  while (static_cast<Index>(shape.surface.positions.size()) < kDense) {
    ++tried;
    Vec3 p(random.uniform(-half.x(), half.x()), random.uniform(-half.y(), half.y()), random.uniform(-half.z(), half.z()));
    const double value = evaluate(p, gradient);
    if (!(std::abs(value) < 4.0 * kLayer * gradient.norm())) continue;
    const Vec3 start = p;
    for (int k = 0; k < 10; ++k) {
      const double now = evaluate(p, gradient);
      p -= now / gradient.squaredNorm() * gradient;
    }
    if (!((p - start).norm() < kLayer)) continue;
    evaluate(p, gradient);
    shape.surface.positions.push_back(p);
    shape.surface.normals.push_back(gradient.normalized());
  }
  shape.area = 8.0 * half.prod() * kDense / tried / (2.0 * kLayer);
}

// A tube about a trefoil knot.
Chart makeKnot(double radius) {
  return [=](double t, double angle) -> Vec3 {
    const auto at = [](double s) {
      return Vec3((2.0 + std::cos(3.0 * s)) * std::cos(2.0 * s), (2.0 + std::cos(3.0 * s)) * std::sin(2.0 * s),
                  std::sin(3.0 * s));
    };
    constexpr double kStep = 1e-4;
    const Vec3 tangent = (at(t + kStep) - at(t - kStep)).normalized();
    Vec3 side = Vec3::UnitZ() - tangent.z() * tangent;
    side.normalize();
    return at(t) + radius * (std::cos(angle) * side + std::sin(angle) * side.cross(tangent));
  };
}

void shuffle(Random& random, OrientedPoints& points) {
  for (std::size_t i = points.positions.size(); i > 1; --i) {
    const std::size_t j = random.index(i);
    std::swap(points.positions[i - 1], points.positions[j]);
    std::swap(points.normals[i - 1], points.normals[j]);
  }
}

struct Formula {
  const char* name;
  SurfaceKind kind;
  void (*add)(Random&, GrowthShape&);
};

const Formula kFormulas[] = {
    {"sphere",
     {1, 0, 2},
     [](Random& r, GrowthShape& s) {
       addChart(makeBall(1.0, Vec3::Zero()), {0.0, 2.0 * kPi, -1.0, 1.0}, 1.0, r, s);
     }},
    {"torus",
     {1, 0, 0},
     [](Random& r, GrowthShape& s) {
       const Chart torus = [](double u, double v) -> Vec3 {
         const double ring = 1.0 + 0.4 * std::cos(v);
         return {ring * std::cos(u), ring * std::sin(u), 0.4 * std::sin(v)};
       };
       addChart(torus, {0.0, 2.0 * kPi, 0.0, 2.0 * kPi}, 1.0, r, s);
     }},
    {"saddle",
     {1, 1, 1},
     [](Random& r, GrowthShape& s) {
       addChart([](double u, double v) -> Vec3 { return {u, v, 0.5 * (u * u - v * v)}; }, {-1.0, 1.0, -1.0, 1.0}, 1.0, r, s);
     }},
    {"pretzel", {1, 0, -2}, addPretzel},
    {"cylinder",
     {1, 2, 0},
     [](Random& r, GrowthShape& s) {
       addChart(
           [](double u, double v) -> Vec3 {
             return {0.5 * std::cos(u), 0.5 * std::sin(u), v};
           },
           {0.0, 2.0 * kPi, -1.0, 1.0}, 1.0, r, s);
     }},
    {"box", {1, 0, 2}, [](Random& r, GrowthShape& s) { addBox(Vec3(0.5, 0.6, 0.7), r, s); }},
    {"plate", {1, 0, 2}, [](Random& r, GrowthShape& s) { addBox(Vec3(1.0, 0.75, 0.08), r, s); }},
    {"knot",
     {1, 0, 0},
     [](Random& r, GrowthShape& s) {
       addChart(makeKnot(0.4), {0.0, 2.0 * kPi, 0.0, 2.0 * kPi}, 1.0, r, s);
     }},
    {"two balls",
     {2, 0, 4},
     [](Random& r, GrowthShape& s) {
       const Rectangle all{0.0, 2.0 * kPi, -1.0, 1.0};
       addChart(makeBall(1.0, Vec3(1.15, 0.0, 0.0)), all, 0.5, r, s);
       addChart(makeBall(1.0, Vec3(-1.15, 0.0, 0.0)), all, 0.5, r, s);
     }},
    {"roll",
     {1, 1, 1},  // layers a fifth of a metre apart
     [](Random& r, GrowthShape& s) {
       const Chart roll = [](double u, double v) -> Vec3 {
         const double radius = 0.25 + 0.2 * u / (2.0 * kPi);
         return {radius * std::cos(u), radius * std::sin(u), v};
       };
       addChart(roll, {0.0, 4.0 * kPi, 0.0, 1.0}, 1.0, r, s);
     }},
    {"ring",
     {1, 2, 0},  // flat, with a hole
     [](Random& r, GrowthShape& s) {
       addChart(
           [](double u, double v) -> Vec3 {
             return {v * std::cos(u), v * std::sin(u), 0.0};
           },
           {0.0, 2.0 * kPi, 0.5, 1.2}, 1.0, r, s);
     }},
    {"bowl",
     {1, 1, 1},
     [](Random& r, GrowthShape& s) {
       addChart(makeBall(1.0, Vec3::Zero()), {0.0, 2.0 * kPi, -1.0, 0.2}, 1.0, r, s);
     }},
};

const char* const kScans[] = {"cgal_points/elephant.off", "cgal_points/bear.off", "odedstein_meshes/spot_low_resolution.obj"};

// Places drawn evenly on the triangles of a mesh.
void addMesh(const TriangleMesh& mesh, Random& random, GrowthShape& shape) {
  std::vector<double> until;  // sums of areas
  Points normals;
  for (const auto& t : mesh.triangles) {
    const Vec3& a = mesh.vertices[t[0]];
    const Vec3 normal = (mesh.vertices[t[1]] - a).cross(mesh.vertices[t[2]] - a);
    shape.area += 0.5 * normal.norm();
    until.push_back(shape.area);
    normals.push_back(normal.normalized());
  }
  for (Index i = 0; i < kDense; ++i) {
    const double place = random.uniform(0.0, shape.area);
    const std::size_t k =
        std::min<std::size_t>(std::upper_bound(until.begin(), until.end(), place) - until.begin(), until.size() - 1);
    const auto& t = mesh.triangles[k];
    const double s = std::sqrt(random.uniform(0.0, 1.0)), w = random.uniform(0.0, 1.0);
    shape.surface.positions.push_back((1.0 - s) * mesh.vertices[t[0]] + s * (1.0 - w) * mesh.vertices[t[1]] +
                                      s * w * mesh.vertices[t[2]]);
    shape.surface.normals.push_back(normals[k]);
  }
}

}  // namespace

std::vector<std::string> listGrowthShapes() {
  std::vector<std::string> names;
  for (const Formula& formula : kFormulas) names.emplace_back(formula.name);
  for (const char* scan : kScans) names.emplace_back(scan);
  return names;
}

GrowthShape makeGrowthShape(const std::string& name) {
  GrowthShape shape;
  shape.name = name;
  Random random(7);
  for (const Formula& formula : kFormulas) {
    if (name != formula.name) continue;
    shape.kind = formula.kind;
    formula.add(random, shape);
  }
  if (shape.surface.positions.empty() && !physics::dataFolder().empty()) {
    TriangleMesh mesh = readTriangles(physics::dataFolder() + "/" + name);
    if (mesh.triangles.empty()) return shape;
    // One metre across.
    Vec3 low = mesh.vertices[0], high = low;
    for (const Vec3& v : mesh.vertices) {
      low = low.cwiseMin(v);
      high = high.cwiseMax(v);
    }
    for (Vec3& v : mesh.vertices) v = (v - low) / (high - low).maxCoeff();
    shape.kind = countKind(mesh).kind;
    addMesh(mesh, random, shape);
  }
  shuffle(random, shape.surface);
  return shape;
}

GrowthSamples takeSamples(const GrowthShape& shape, Index num_samples, double noise, unsigned seed) {
  Random random(seed);
  OrientedPoints all = shape.surface;
  shuffle(random, all);
  const Index n = static_cast<Index>(all.positions.size());
  // The samples that are taken with a least distance, one after the other.
  const auto choose = [&](double apart) {
    const cloud::KdTree tree(all.positions);
    std::vector<char> is_near(n, 0);
    std::vector<Index> chosen;
    std::vector<cloud::Neighbor> near;
    for (Index i = 0; i < n; ++i) {
      if (is_near[i]) continue;
      chosen.push_back(i);
      tree.withinRadius(all.positions[i], apart, near);
      for (const cloud::Neighbor& q : near) is_near[q.index] = 1;
    }
    return chosen;
  };
  GrowthSamples samples;
  samples.spacing = std::sqrt(shape.area / (num_samples * std::sqrt(0.75)));
  double low = 0.5 * samples.spacing, high = 1.2 * samples.spacing;
  std::vector<Index> chosen;
  constexpr int kHalvings = 8;
  for (int k = 0; k < kHalvings; ++k) {
    const double middle = 0.5 * (low + high);
    chosen = choose(middle);
    (static_cast<Index>(chosen.size()) > num_samples ? low : high) = middle;
  }
  for (const Index i : chosen) {
    samples.points.positions.push_back(all.positions[i] + noise * samples.spacing * random.normalVector());
    samples.points.normals.push_back((all.normals[i] + noise * random.normalVector()).normalized());
  }
  return samples;
}

}  // namespace deformable_surface::benchmark
