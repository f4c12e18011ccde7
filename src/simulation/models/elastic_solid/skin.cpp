// The outside of a body as triangles, for contact of its parts with each other.
#include "deformable_surface/model/elastic_solid/body_skin.h"
#include "deformable_surface/model/elastic_solid/elastic_solid.h"
#include "deformable_surface/model/elastic_solid/point_volumes.h"

#include "rest.h"

namespace deformable_surface::simulation {
namespace {

// Of a filled surface: those of the surface that was filled, whose points come first.
std::vector<model::WeightedTriangle> findFilledSkin(const RestSurface& rest) {
  const Index n = static_cast<Index>(rest.dense_index.size());
  const Points positions(rest.points.begin(), rest.points.begin() + n), normals(rest.normals.begin(), rest.normals.begin() + n);
  Lists neighbors;
  for (Index i = 0; i < n; ++i) {
    for (const Index* j = rest.solid_neighbors.begin(i); j != rest.solid_neighbors.end(i); ++j)
      if (*j < n) neighbors.items.push_back(*j);
    neighbors.offsets.push_back(static_cast<Index>(neighbors.items.size()));
  }
  std::vector<model::WeightedTriangle> triangles;
  for (const cloud::Triangle& t : cloud::buildRings(positions, normals, neighbors).triangles)
    triangles.push_back({{t.corner[0], t.corner[1], t.corner[2]}, t.weight});
  return triangles;
}

}  // namespace

std::vector<model::WeightedTriangle> findSolidSkin(const RestSurface& rest, const model::ElasticSolid& solid) {
  if (!rest.across.isZero(0.0))
    throw InputError(
        "contact.self: found true with a planar solid, whose outside is a line; accepted: a solid in space, or false");
  if (rest.dense_index.size() < rest.points.size()) return findFilledSkin(rest);
  std::vector<double> empty = model::findPointSpacing(rest.points, rest.solid_neighbors, solid.volumes(), false);
  for (double& radius : empty) radius *= model::kEmptySphere;
  return model::findBodySkin(rest.points, rest.solid_neighbors, empty);
}

}  // namespace deformable_surface::simulation
