// The strip of scenes/knot.yaml is knotted at its end, and is not without self-contact. Apart from the other scenes, because no
// quantity of `expect` tells a knot.
#include "deformable_surface/io/scene.h"
#include "deformable_surface/io/shapes.h"
#include "deformable_surface/simulation/simulation.h"

#include <gtest/gtest.h>
#include <Eigen/LU>

#include <algorithm>
#include <cmath>
#include <vector>

namespace deformable_surface {
namespace {

// Means of the points in slices along the strip at rest, with ends far away, closed beyond all else.
Points findMidline(const Points& rest, const Points& now) {
  constexpr int kSlices = 100;
  Points sums(kSlices, Vec3::Zero());
  std::vector<int> counts(kSlices, 0);
  for (std::size_t i = 0; i < rest.size(); ++i) {
    const int slice = std::clamp(static_cast<int>((rest[i].x() + 0.5) * kSlices), 0, kSlices - 1);
    sums[slice] += now[i];
    ++counts[slice];
  }
  Points line{{-9.0, 0.0, 0.0}};
  for (int k = 0; k < kSlices; ++k)
    if (counts[k] > 0) line.push_back(sums[k] / counts[k]);
  line.insert(line.end(), {{9.0, 0.0, 0.0}, {9.0, 0.0, 50.0}, {-9.0, 0.0, 50.0}});
  return line;
}

// The determinant of a closed line as a knot: 1 without a knot, 3 of an overhand knot. It is that of the equations 2 over = under
// before + under after, one for each crossing in a view, for the arcs between undercrossings (Fox's colourings).
int findDeterminant(const Points& line, const Mat3& view) {
  struct Passing {
    double place;  // along the line
    int crossing;
    bool is_over;
  };
  std::vector<Passing> passings;
  const int n = static_cast<int>(line.size());
  const auto seen = [&](int i) -> Vec3 { return view * line[i % n]; };
  int crossings = 0;
  for (int i = 0; i < n; ++i)
    for (int j = i + 2; j < n; ++j) {
      if (i == 0 && j == n - 1) continue;
      const Vec3 a = seen(i), b = seen(j), r = seen(i + 1) - a, s = seen(j + 1) - b, c = b - a;
      const double area = r.x() * s.y() - r.y() * s.x();
      const double t = (c.x() * s.y() - c.y() * s.x()) / area, u = (c.x() * r.y() - c.y() * r.x()) / area;
      if (!(t > 0.0 && t < 1.0 && u > 0.0 && u < 1.0)) continue;
      const bool is_over = a.z() + t * r.z() > b.z() + u * s.z();
      passings.push_back({i + t, crossings, is_over});
      passings.push_back({j + u, crossings, !is_over});
      ++crossings;
    }
  if (crossings < 3) return 1;
  std::sort(passings.begin(), passings.end(), [](const Passing& a, const Passing& b) { return a.place < b.place; });
  Eigen::MatrixXd equations = Eigen::MatrixXd::Zero(crossings, crossings);
  int arc = 0;
  for (const Passing& passing : passings) {
    if (passing.is_over) {
      equations(passing.crossing, arc) += 2.0;
    } else {
      equations(passing.crossing, arc) -= 1.0;
      arc = (arc + 1) % crossings;
      equations(passing.crossing, arc) -= 1.0;
    }
  }
  return static_cast<int>(std::lround(std::abs(equations.bottomRightCorner(crossings - 1, crossings - 1).determinant())));
}

int findKnot(const simulation::SceneParams& params) {
  simulation::Simulation strip(params, io::makeShape(params.cloud));
  const Points rest = strip.state().positions;
  const long steps = std::lround(params.duration / params.integrator.time_step);
  for (long k = 0; k < steps; ++k) EXPECT_TRUE(strip.step().ok);
  const Points line = findMidline(rest, strip.state().positions);
  std::vector<int> found;
  for (const double angle : {0.3, 0.9}) {
    const Mat3 view =
        (Eigen::AngleAxisd(angle, Vec3::UnitX()) * Eigen::AngleAxisd(0.7 * angle, Vec3::UnitY())).toRotationMatrix();
    found.push_back(findDeterminant(line, view));
  }
  EXPECT_EQ(found[0], found[1]);
  return found[0];
}

TEST(Knot, IsTiedWithSelfContactAlone) {
  simulation::SceneParams params =
      io::readScene(io::loadYamlFile(std::string(DEFORMABLE_SURFACE_SOURCE_DIR) + "/scenes/knot.yaml"));
  EXPECT_EQ(findKnot(params), 3);
  params.contact.self = false;
  EXPECT_EQ(findKnot(params), 1);
}

}  // namespace
}  // namespace deformable_surface
