// Surfaces by CGAL: growth_by_cgal (front | scale_space) SAMPLES MESH. Built on request only, never installed: what is linked
// here is under the GPL (growth_files.h).
#include "growth_files.h"

#include <CGAL/Advancing_front_surface_reconstruction.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Scale_space_reconstruction_3/Advancing_front_mesher.h>
#include <CGAL/Scale_space_surface_reconstruction_3.h>

#include <cstdio>
#include <ctime>
#include <exception>
#include <iterator>

namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Point = Kernel::Point_3;

growth_peers::Mesh reconstruct(const std::string& method, const growth_peers::Samples& samples) {
  std::vector<Point> points;
  for (const auto& p : samples.positions) points.emplace_back(p[0], p[1], p[2]);
  growth_peers::Mesh mesh;
  const std::clock_t begin = std::clock();
  if (method == "front") {
    CGAL::advancing_front_surface_reconstruction(points.begin(), points.end(), std::back_inserter(mesh.triangles));
  } else {
    CGAL::Scale_space_surface_reconstruction_3<Kernel> space(points.begin(), points.end());
    space.increase_scale(4);  // as in its manual
    space.reconstruct_surface(CGAL::Scale_space_reconstruction_3::Advancing_front_mesher<Kernel>());
    mesh.triangles.assign(space.facets_begin(), space.facets_end());  // of the given points: smoothed ones contract
  }
  mesh.seconds = static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC;
  for (const Point& p : points) mesh.vertices.push_back({p.x(), p.y(), p.z()});
  return mesh;
}

}  // namespace

int main(int argc, char** argv) {
  const std::string method = argc == 4 ? argv[1] : "";
  if (method != "front" && method != "scale_space") {
    std::fprintf(stderr, "growth_by_cgal: accepted: front or scale_space, the file of samples, the file of the mesh\n");
    return 2;
  }
  try {
    growth_peers::writeMesh(argv[3], reconstruct(method, growth_peers::readSamples(argv[2])));
  } catch (const std::exception& error) {
    std::fprintf(stderr, "growth_by_cgal: %s\n", error.what());
    return 1;
  }
  return 0;
}
