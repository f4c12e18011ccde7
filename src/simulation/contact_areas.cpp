#include "contact_areas.h"

#include "deformable_surface/base/error.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "self_contact_load.h"

namespace deformable_surface::simulation {
namespace {

// At an edge of a box this is what one of its faces shows, where the sum over both would be twice as much.
std::vector<double> findSkinAreas(const Points& rest, const std::vector<contact::Triangle>& skin) {
  struct Facet {
    Index point;
    Vec3 area;  // m^2, along the normal
  };
  std::vector<Facet> facets;
  for (const contact::Triangle& t : skin) {
    const Vec3 third = (rest[t[1]] - rest[t[0]]).cross(rest[t[2]] - rest[t[0]]) / 6.0;
    for (const Index point : t) facets.push_back({point, third});
  }
  std::stable_sort(facets.begin(), facets.end(), [](const Facet& a, const Facet& b) { return a.point < b.point; });
  std::vector<double> areas(rest.size(), 0.0);
  for (auto from = facets.begin(); from != facets.end();) {
    const auto to = std::find_if(from, facets.end(), [&](const Facet& facet) { return facet.point != from->point; });
    double sum = 0.0, whole = 0.0;
    for (auto one = from; one != to; ++one) {
      for (auto other = from; other != to; ++other) sum += std::max(0.0, other->area.dot(one->area));
      whole += one->area.norm();
    }
    if (whole > 0.0) areas[from->point] = sum / whole;
    from = to;
  }
  return areas;
}

}  // namespace

ContactPoints::Areas findContactAreas(const SceneParams& params, const RestSurface& rest, const model::DeformableModel& model) {
  const ModelKind& kind = findModel(params.model);
  const ModelTraits traits = kind.traits();
  const std::vector<double>& masses = model.masses();
  if (traits.has_population) return {{}, rest.area / std::accumulate(masses.begin(), masses.end(), 0.0)};
  if (!traits.is_surface) {
    if (!rest.across.isZero(0.0))
      throw InputError("contact.compliance: found one above 0 with a planar solid, whose outside is a line; accepted: 0");
    return {findSkinAreas(rest.points, ContactSkin(rest.points, kind.findSkin(rest, model)).triangles), 0.0};
  }
  std::vector<double> areas = masses;
  for (std::size_t i = 0; i < rest.values.size(); ++i)
    if (!std::isnan(rest.values[i].density)) areas[i] *= params.material.density / rest.values[i].density;
  const double scale = rest.area / std::accumulate(areas.begin(), areas.end(), 0.0);
  for (double& area : areas) area *= scale;
  return {areas, 0.0};
}

}  // namespace deformable_surface::simulation
