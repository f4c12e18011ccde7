// Kruskal's minimum spanning forest, sorting little: most links are longer than what joins everything. One place, because the
// side of normals and the trust radii of geodesics both need it.
#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

namespace deformable_surface::cloud {

/// Calls join(link) in ascending order for every link of the forest, and for some of the others, whose ends are joined by then.
/// isJoined(link): the ends are joined already. links is used up. portion: how many are sorted first, about the number of points.
template <class Link, class IsJoined, class Join>
void visitSpanningForest(std::vector<Link>& links, std::ptrdiff_t portion, const IsJoined& isJoined, const Join& join) {
  // The lightest links join nearly all points, so the others are mostly dropped before they are sorted. Portions double, so that
  // there are few of them where the weights tie and little can be dropped.
  for (std::ptrdiff_t begin = 0; begin < static_cast<std::ptrdiff_t>(links.size()); portion *= 2) {
    const auto first = links.begin() + begin, last = first + std::min(portion, links.end() - first);
    std::nth_element(first, last, links.end());
    std::sort(first, last);
    for (auto link = first; link != last; ++link) join(*link);
    begin = last - links.begin();
    links.erase(std::remove_if(last, links.end(), isJoined), links.end());
  }
}

}  // namespace deformable_surface::cloud
