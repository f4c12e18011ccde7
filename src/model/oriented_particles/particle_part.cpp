// Parts of a surface of oriented particles for sleeping: fewer particles with the same potentials, so that a step costs only the
// part.
#include "particle_loops.h"

#include <algorithm>

namespace deformable_surface::model {

bool OrientedParticles::followPartners(const State& state) {
  partners_.forget();
  // The state may have no orientations.
  if (kept_ && !has_bonds_) particles::updateBonds(*kept_, state.traits, cuts_, bonds_, links_, triangles_);
  has_partners_ = partners_.update(state.positions, state.traits);
  return true;
}

double OrientedParticles::maxPartMotion() const { return lists_.margin(); }

// Calls visit(j), for some particles twice.
template <class Visit>
void OrientedParticles::forEachPartner(Index i, const Visit& visit) const {
  for (const Index* j = kept_ ? bonds_.begin(i) : nullptr; kept_ && j != bonds_.end(i); ++j) visit(*j);
  for (const Index* j = partners_.begin(i); j != partners_.end(i); ++j) visit(*j);
  for (const NeighborList::Apart* j = partners_.beginApart(i); j != partners_.endApart(i); ++j) visit(j->particle);
}

bool OrientedParticles::markPartners(const std::vector<Index>& points, std::vector<char>& marked) const {
  if (!has_partners_) std::fill(marked.begin(), marked.end(), 1);
  for (const Index i : points) {
    marked[i] = 1;
    if (has_partners_) forEachPartner(i, [&](Index j) { marked[j] = 1; });
  }
  return true;
}

std::vector<std::pair<Index, Index>> OrientedParticles::linkPartners() const {
  std::vector<std::pair<Index, Index>> links;
  for (Index i = 0; i < static_cast<Index>(masses_.size()); ++i) {
    if (has_partners_)
      forEachPartner(i, [&](Index j) { links.emplace_back(i, j); });
    else if (i > 0)
      links.emplace_back(i - 1, i);
  }
  return links;
}

OrientedParticles::OrientedParticles(const OrientedParticles& whole, std::size_t count)
    : params_(whole.params_),
      material_(whole.material_),
      stated_spacing_(whole.stated_spacing_),
      lattice_(whole.lattice_),
      mass_(whole.mass_),
      cuts_(whole.cuts_),
      kept_(whole.kept_),
      is_bent_(whole.is_bent_),
      masses_(count),
      inertias_(count),
      lists_(whole.lists_.alike()),
      partners_(lists_) {}

Partition::Part OrientedParticles::makePart(const std::vector<char>& wanted) const {
  std::vector<Index> wanted_points;
  for (Index i = 0; i < static_cast<Index>(wanted.size()); ++i)
    if (wanted[i]) wanted_points.push_back(i);
  std::vector<char> present = wanted;
  markPartners(wanted_points, present);
  Part part;
  for (Index i = 0; i < static_cast<Index>(present.size()); ++i)
    if (present[i]) part.points.push_back(i);
  auto* const model = new OrientedParticles(*this, part.points.size());
  part.model.reset(model);
  for (std::size_t k = 0; k < part.points.size(); ++k) {
    model->masses_[k] = masses_[part.points[k]];
    model->inertias_[k] = inertias_[part.points[k]];
  }
  return part;
}

}  // namespace deformable_surface::model
