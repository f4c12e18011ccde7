// The triangles of contact that are still part of a surface.
#pragma once

#include <vector>

#include "../../src/simulation/contact_skin.h"

namespace deformable_surface::test {

inline std::vector<contact::Triangle> listWhole(const simulation::ContactSkin& skin, const model::DeformableModel& model) {
  const std::vector<char> is_whole = skin.findWhole(trianglesOf(model));
  std::vector<contact::Triangle> whole;
  for (std::size_t t = 0; t < is_whole.size(); ++t)
    if (is_whole[t] != 0) whole.push_back(skin.triangles[t]);
  return whole;
}

}  // namespace deformable_surface::test
