// Surfaces by PCL: growth_by_pcl (greedy | poisson) SAMPLES MESH. A program of its own like growth_by_cgal, by the same files.
#include "growth_files.h"

#include <pcl/point_types.h>
#include <pcl/search/kdtree.h>
#include <pcl/surface/gp3.h>
#include <pcl/surface/poisson.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <exception>

namespace {

using Cloud = pcl::PointCloud<pcl::PointNormal>;

// Mean distance of the sixth nearest neighbour: the search radius of the greedy projection follows from it.
double findReach(const Cloud::Ptr& cloud, const pcl::search::KdTree<pcl::PointNormal>::Ptr& tree) {
  constexpr int kSixth = 7;  // the sample is the first
  double sum = 0.0;
  pcl::Indices found;
  std::vector<float> squared;
  for (const pcl::PointNormal& p : *cloud) {
    tree->nearestKSearch(p, kSixth, found, squared);
    sum += std::sqrt(squared.back());
  }
  return sum / static_cast<double>(cloud->size());
}

// The greedy projection gives its triangles no side: here they take that of their samples.
void turnToNormals(const growth_peers::Samples& samples, growth_peers::Mesh& mesh) {
  for (auto& [a, b, c] : mesh.triangles) {
    Eigen::Vector3d corner[3], mean = Eigen::Vector3d::Zero();
    const std::size_t corners[3] = {a, b, c};
    for (int k = 0; k < 3; ++k) {
      corner[k] = Eigen::Vector3d(samples.positions[corners[k]].data());
      mean += Eigen::Vector3d(samples.normals[corners[k]].data());
    }
    if ((corner[1] - corner[0]).cross(corner[2] - corner[0]).dot(mean) < 0.0) std::swap(b, c);
  }
}

growth_peers::Mesh reconstruct(const std::string& method, const growth_peers::Samples& samples) {
  const Cloud::Ptr cloud(new Cloud);
  for (std::size_t i = 0; i < samples.positions.size(); ++i) {
    pcl::PointNormal p;
    for (int axis = 0; axis < 3; ++axis) {
      p.data[axis] = static_cast<float>(samples.positions[i][axis]);
      p.data_n[axis] = static_cast<float>(samples.normals[i][axis]);
    }
    cloud->push_back(p);
  }
  growth_peers::Mesh mesh;
  pcl::PolygonMesh made;
  Cloud vertices;
  const std::clock_t begin = std::clock();
  if (method == "greedy") {
    const pcl::search::KdTree<pcl::PointNormal>::Ptr tree(new pcl::search::KdTree<pcl::PointNormal>);
    tree->setInputCloud(cloud);
    // Angles as in its tutorial; a radius that all first neighbours are within.
    pcl::GreedyProjectionTriangulation<pcl::PointNormal> greedy;
    greedy.setSearchRadius(2.0 * findReach(cloud, tree));
    greedy.setMu(2.5);
    greedy.setMaximumNearestNeighbors(100);
    greedy.setMaximumSurfaceAngle(M_PI / 4.0);
    greedy.setMinimumAngle(M_PI / 18.0);
    greedy.setMaximumAngle(2.0 * M_PI / 3.0);
    greedy.setNormalConsistency(true);
    greedy.setInputCloud(cloud);
    greedy.setSearchMethod(tree);
    greedy.reconstruct(made);
    vertices = *cloud;
  } else {
    pcl::Poisson<pcl::PointNormal> poisson;
    poisson.setDepth(7);  // cells of about a fifth of the distance of a thousand samples
    poisson.setInputCloud(cloud);
    std::vector<pcl::Vertices> polygons;
    poisson.reconstruct(vertices, polygons);
    made.polygons = polygons;
  }
  mesh.seconds = static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC;
  for (const pcl::PointNormal& p : vertices) mesh.vertices.push_back({p.x, p.y, p.z});
  for (const pcl::Vertices& polygon : made.polygons)
    for (std::size_t k = 2; k < polygon.vertices.size(); ++k)
      mesh.triangles.push_back({polygon.vertices[0], polygon.vertices[k - 1], polygon.vertices[k]});
  if (method == "greedy") turnToNormals(samples, mesh);
  return mesh;
}

}  // namespace

int main(int argc, char** argv) {
  const std::string method = argc == 4 ? argv[1] : "";
  if (method != "greedy" && method != "poisson") {
    std::fprintf(stderr, "growth_by_pcl: accepted: greedy or poisson, the file of samples, the file of the mesh\n");
    return 2;
  }
  try {
    growth_peers::writeMesh(argv[3], reconstruct(method, growth_peers::readSamples(argv[2])));
  } catch (const std::exception& error) {
    std::fprintf(stderr, "growth_by_pcl: %s\n", error.what());
    return 1;
  }
  return 0;
}
