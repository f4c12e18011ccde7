// Components, boundary, Euler characteristic and genus of the triangles and links of particles, counted as in
// cloud/rings.h.
#include "deformable_surface/cloud/links.h"
#include "deformable_surface/cloud/rings.h"
#include "deformable_surface/model/oriented_particles/particle_triangles.h"

#include <algorithm>

namespace deformable_surface::model {
namespace {

using Link = std::pair<Index, Index>;

// Lists of each particle's distinct partners, ascending, from links in both directions.
Lists listPartners(Index num_particles, std::vector<Link> links) {
  std::sort(links.begin(), links.end());
  links.erase(std::unique(links.begin(), links.end()), links.end());
  Lists partners;
  auto link = links.begin();
  for (Index i = 0; i < num_particles; ++i) {
    for (; link != links.end() && link->first == i; ++link) partners.items.push_back(link->second);
    partners.offsets.push_back(static_cast<Index>(partners.items.size()));
  }
  return partners;
}

Index countIsolated(const Lists& partners) {
  Index isolated = 0;
  for (Index i = 0; i < partners.size(); ++i) isolated += partners.count(i) == 0;
  return isolated;
}

}  // namespace

ParticleTopology measureTopology(Index num_particles, const std::vector<WeightedTriangle>& triangles) {
  std::vector<Link> directed, both;
  cloud::Rings rings;
  for (const WeightedTriangle& t : triangles) {
    rings.triangles.push_back({{t.corner[0], t.corner[1], t.corner[2]}, t.weight});
    for (int s = 0; s < 3; ++s) {
      const Link edge{t.corner[s], t.corner[(s + 1) % 3]};
      directed.push_back(edge);
      both.insert(both.end(), {edge, {edge.second, edge.first}});
    }
  }
  std::sort(directed.begin(), directed.end());
  rings.ring = listPartners(num_particles, std::move(both));
  rings.open.assign(num_particles, 0);
  for (const Link& edge : directed) {
    if (!std::binary_search(directed.begin(), directed.end(), Link{edge.second, edge.first})) {
      rings.open[edge.first] = rings.open[edge.second] = 1;
    }
  }
  const cloud::Topology counted = cloud::measureTopology(rings);

  ParticleTopology topology;
  topology.components = counted.components;
  topology.boundary_loops = counted.boundary_loops;
  topology.euler_characteristic = counted.euler_characteristic;
  topology.isolated = countIsolated(rings.ring);
  topology.closed = !triangles.empty() && counted.boundary_loops == 0;
  if (topology.closed) topology.genus = counted.components - counted.euler_characteristic / 2;
  return topology;
}

ParticleTopology measureTopology(Index num_particles, const std::vector<Link>& links) {
  std::vector<Link> both = links;
  for (const Link& link : links) both.push_back({link.second, link.first});
  const Lists partners = listPartners(num_particles, std::move(both));

  ParticleTopology topology;
  topology.isolated = countIsolated(partners);
  cloud::labelComponents(partners, topology.components);
  topology.components -= topology.isolated;
  for (Index i = 0; i < num_particles; ++i) topology.boundary_loops += partners.count(i) == 1;
  topology.euler_characteristic = num_particles - topology.isolated - static_cast<Index>(links.size());
  topology.closed = !links.empty() && topology.boundary_loops == 0;
  return topology;
}

}  // namespace deformable_surface::model
