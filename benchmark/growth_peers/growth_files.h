// Samples in, triangles out: the files between the part "growth" of the benchmark and the programs that reconstruct surfaces by
// other libraries. They are programs of their own, because CGAL's packages are under the GPL: nothing of the package, not even
// its benchmark, is linked with them.
#pragma once

#include <array>
#include <cstddef>
#include <fstream>
#include <stdexcept>
#include <string>
#include <vector>

namespace growth_peers {

struct Samples {
  std::vector<std::array<double, 3>> positions, normals;  // m; unit, of a common side
};

/// Lines of x y z nx ny nz.
inline Samples readSamples(const std::string& name) {
  std::ifstream file(name);
  Samples samples;
  std::array<double, 3> p, n;
  while (file >> p[0] >> p[1] >> p[2] >> n[0] >> n[1] >> n[2]) {
    samples.positions.push_back(p);
    samples.normals.push_back(n);
  }
  if (samples.positions.empty()) throw std::runtime_error(name + ": found no sample; accepted: lines of x y z nx ny nz");
  return samples;
}

struct Mesh {
  std::vector<std::array<double, 3>> vertices;
  std::vector<std::array<std::size_t, 3>> triangles;
  double seconds = 0.0;  // of processor time
};

/// The seconds, then lines of v x y z and f a b c, from zero.
inline void writeMesh(const std::string& name, const Mesh& mesh) {
  std::ofstream file(name);
  file.precision(17);
  file << mesh.seconds << '\n';
  for (const auto& v : mesh.vertices) file << "v " << v[0] << ' ' << v[1] << ' ' << v[2] << '\n';
  for (const auto& t : mesh.triangles) file << "f " << t[0] << ' ' << t[1] << ' ' << t[2] << '\n';
  if (!file.flush()) throw std::runtime_error(name + ": found no way to write it; accepted: a file in a folder that exists");
}

}  // namespace growth_peers
