// Part "growth": surfaces of oriented particles grown through samples of known shapes, beside other programs that reconstruct
// surfaces from the same samples (growth_peers): what kind of surface each makes, its distance from the true one, its normals,
// and its time.
#include "deformable_surface/base/error.h"
#include "deformable_surface/base/parallel.h"
#include "deformable_surface/cloud/kd_tree.h"
#include "deformable_surface/cloud/normals.h"
#include "deformable_surface/cloud/rings.h"
#include "deformable_surface/model/capabilities.h"
#include "deformable_surface/simulation/simulation.h"
#include "mesh_measures.h"
#include "sections.h"

#include <sys/stat.h>
#include <unistd.h>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <sstream>

namespace deformable_surface::benchmark {
namespace {

// Particles are that much nearer to each other than the samples, so that the surface is curved between these.
constexpr double kFineness = 0.6;

struct Result {
  TriangleMesh mesh;
  double seconds = 0.0;
  std::string problem;
};

struct Method {
  const char *name, *program, *argument;  // ours: no program
};
const char kHeld[] = "held";
const Method kMethods[] = {{"particles", nullptr, "released"},
                           {"particles, samples held", nullptr, kHeld},
                           {"CGAL, advancing front", "growth_by_cgal", "front"},
                           {"CGAL, scale space", "growth_by_cgal", "scale_space"},
                           {"PCL, greedy projection", "growth_by_pcl", "greedy"},
                           {"PCL, Poisson", "growth_by_pcl", "poisson"}};

// The settings do not depend on the shape; noise is not stated.
Result growParticles(const GrowthSamples& samples, bool has_normals, bool holds_samples) {
  Result result;
  simulation::SceneParams scene;
  scene.model = "oriented_particles";
  scene.accuracy.estimate = false;
  scene.gravity.setZero();
  scene.simplification.method = cloud::SimplificationMethod::kNone;
  model::OrientedParticlesParams& particles = scene.oriented_particles;
  particles.spacing = kFineness * samples.spacing;
  scene.material.young_modulus = 1e5;
  scene.material.thickness = 0.001;
  scene.material.bending_rigidity =
      scene.material.young_modulus * scene.material.thickness * std::pow(kFineness * samples.spacing, 2);
  particles.grow_surface = true;
  particles.growth.min_gap = 1.6;
  particles.growth.max_gap = 5.0;
  particles.growth.clearance = 0.65;
  particles.growth.sample_gap = 1.7;
  particles.growth.release_samples = !holds_samples;
  cloud::PointCloud cloud;
  cloud.positions = samples.points.positions;
  if (has_normals) cloud.normals = samples.points.normals;
  cloud.width = static_cast<std::uint32_t>(cloud.positions.size());
  const double before = processorSeconds();
  try {
    simulation::Simulation grown(scene, cloud);
    result.seconds = processorSeconds() - before;
    if (grown.model().links()) grown.model().links()->refreshDisplay(grown.state());
    result.mesh.vertices = grown.state().positions;
    for (const Quaternion& q : grown.state().orientations) result.mesh.normals.push_back(q * Vec3::UnitZ());
    for (const model::WeightedTriangle& t : model::trianglesOf(grown.model()))
      result.mesh.triangles.push_back({t.corner[0], t.corner[1], t.corner[2]});
  } catch (const InputError& error) {
    result.problem = error.what();
  }
  return result;
}

std::string findProgram(const char* name) {
  char path[4096];
  const ssize_t length = readlink("/proc/self/exe", path, sizeof path - 1);
  const std::string own(path, length > 0 ? length : 0);
  return own.substr(0, own.rfind('/') + 1) + name;
}

Result runProgram(const Method& method, const std::string& folder, const OrientedPoints& samples) {
  Result result;
  const std::string program = findProgram(method.program), in = folder + "/growth_samples.txt", out = folder + "/growth_mesh.txt";
  struct stat ignored;
  if (stat(program.c_str(), &ignored) != 0) {
    result.problem = "not built";
    return result;
  }
  std::ofstream file(in);
  file.precision(17);
  for (std::size_t i = 0; i < samples.positions.size(); ++i)
    file << samples.positions[i].transpose() << ' ' << samples.normals[i].transpose() << '\n';
  file.close();
  std::remove(out.c_str());
  const std::string command =
      "'" + program + "' " + method.argument + " '" + in + "' '" + out + "' > '" + folder + "/growth_log.txt' 2>&1";
  const int code = std::system(command.c_str());
  std::ifstream mesh(out);
  if (code != 0 || !(mesh >> result.seconds)) {
    result.problem = "failed";
    return result;
  }
  for (std::string kind; mesh >> kind;) {
    if (kind == "v") {
      Vec3 v;
      mesh >> v.x() >> v.y() >> v.z();
      result.mesh.vertices.push_back(v);
    } else {
      std::array<Index, 3> t;
      mesh >> t[0] >> t[1] >> t[2];
      result.mesh.triangles.push_back(t);
    }
  }
  return result;
}

// For the programs that need normals where none are given: estimated and propagated as the package does.
Points estimate(const Points& positions) {
  constexpr Index kNeighbors = 16;
  const Lists neighbors = cloud::nearestNeighbors(positions, 2 * kNeighbors);
  Lists near = cloud::nearestNeighbors(positions, kNeighbors);
  Points normals = cloud::estimateNormals(positions, near);
  const cloud::Boundary boundary = cloud::findBoundary(positions, normals, neighbors, kNeighbors);
  cloud::orientNormals(positions, near, boundary.is_boundary, {}, {}, normals);
  return normals;
}

// Sums over the cases of one method.
struct Total {
  Index cases = 0, right = 0, nearest = 0, failed = 0;
  double log_distance = 0.0, log_normal = 0.0, seconds = 0.0, slowest = 0.0;
};

std::string showKind(const SurfaceKind& kind) {
  return std::to_string(kind.pieces) + " " + std::to_string(kind.loops) + " " + std::to_string(kind.euler_characteristic);
}

}  // namespace

void runGrowthSection(const Options& options, Report& report) {
  setNumThreads(1);
  const std::vector<Index> counts = options.large ? std::vector<Index>{300, 1000, 3000} : std::vector<Index>{600};
  const std::vector<double> noises = options.large ? std::vector<double>{0.0, 0.1, 0.25} : std::vector<double>{0.0, 0.1};
  report.begin(
      "growth",
      "Surfaces grown through samples of known shapes, one thread. Lengths in spacings of the samples. Kind: pieces, boundary "
      "loops, Euler characteristic",
      {"shape", "samples", "noise", "normals", "program", "kind", "true_kind", "right", "unused", "crooked", "pinched",
       "to_surface", "from_surface", "farthest", "normals_off_deg", "turned", "vertices", "cpu_s"});
  constexpr std::size_t kNumMethods = std::size(kMethods);
  std::vector<Total> totals(2 * kNumMethods);
  std::string left_out;
  for (const std::string& name : listGrowthShapes()) {
    if (name.rfind(options.scene, 0) != 0) continue;
    const GrowthShape shape = makeGrowthShape(name);
    if (shape.surface.positions.empty()) {
      left_out += (left_out.empty() ? "left out, without triangles: " : ", ") + name;
      continue;
    }
    for (const Index count : counts) {
      for (const double noise : noises) {
        const GrowthSamples samples = takeSamples(shape, count, noise, static_cast<unsigned>(count));
        for (const bool has_normals : {true, false}) {
          OrientedPoints points = samples.points;
          if (!has_normals) points.normals = estimate(points.positions);
          std::vector<double> distances(kNumMethods, HUGE_VAL);
          for (std::size_t m = 0; m < kNumMethods; ++m) {
            const Method& method = kMethods[m];
            const Result result = method.program ? runProgram(method, options.folder, points)
                                                 : growParticles(samples, has_normals, method.argument == kHeld);
            Total& total = totals[2 * m + !has_normals];
            std::vector<std::string> row{name, std::to_string(points.positions.size()), show(noise),
                                         has_normals ? "given" : "none", method.name};
            if (!result.problem.empty() || result.mesh.triangles.empty()) {
              if (result.problem != "not built") ++total.cases, ++total.failed;
              row.resize(17, "-");
              row.push_back(result.problem.empty() ? "no triangle" : result.problem);
              report.add(row);
              continue;
            }
            const MeshCount counted = countKind(result.mesh);
            const MeshDistance distance = measureDistance(result.mesh, shape);
            // A vertex of no triangle is wrong where the method makes its vertices itself.
            const bool is_right = counted.kind == shape.kind && counted.crooked == 0 && (method.program || counted.unused == 0);
            distances[m] = std::max(distance.to_surface, distance.from_surface);
            ++total.cases;
            total.right += is_right;
            total.log_distance += std::log(std::max(distances[m] / samples.spacing, 1e-6));
            total.log_normal += std::log(std::max(distance.normal_angle, 1e-6));
            total.seconds += result.seconds;
            total.slowest = std::max(total.slowest, result.seconds);
            row.insert(row.end(),
                       {showKind(counted.kind), showKind(shape.kind), is_right ? "yes" : "no", std::to_string(counted.unused),
                        std::to_string(counted.crooked), std::to_string(counted.pinched),
                        show(distance.to_surface / samples.spacing), show(distance.from_surface / samples.spacing),
                        show(distance.farthest / samples.spacing), show(distance.normal_angle * 180.0 / kPi),
                        show(distance.turned), std::to_string(result.mesh.vertices.size()), show(result.seconds)});
            report.add(row);
          }
          const auto best = std::min_element(distances.begin(), distances.end());
          if (std::isfinite(*best)) ++totals[2 * (best - distances.begin()) + !has_normals].nearest;
        }
      }
    }
  }
  report.end();
  report.begin("growth_totals",
               "The same, over all cases: geometric means of the larger of both distances and of the normals' angles",
               {"program", "normals", "cases", "right_kind", "nearest", "failed", "distance", "normals_off_deg", "mean_cpu_s",
                "most_cpu_s"});
  for (std::size_t k = 0; k < totals.size(); ++k) {
    const Total& t = totals[k];
    const double made = std::max<double>(1.0, t.cases - t.failed);
    report.add({kMethods[k / 2].name, k % 2 == 0 ? "given" : "none", std::to_string(t.cases), std::to_string(t.right),
                std::to_string(t.nearest), std::to_string(t.failed), show(std::exp(t.log_distance / made)),
                show(std::exp(t.log_normal / made) * 180.0 / kPi), show(t.seconds / made), show(t.slowest)});
  }
  report.end();
  if (!left_out.empty()) report.note(left_out);
  report.note(
      "normals none: the front and the scale space use none; for greedy projection and Poisson they are estimated and "
      "turned to one side as the package does");
  setNumThreads(0);
}

}  // namespace deformable_surface::benchmark
