// Links of every second pixel lead across the pixels between them.
#include "deformable_surface/cloud/pixel_lattice.h"

#include "deformable_surface/base/parallel.h"

#include <algorithm>
#include <array>
#include <utility>

namespace deformable_surface::cloud {
namespace {

constexpr Index kBlock = 4096;  // pixels per task: less than a millisecond of work
constexpr int kMostLinks = 3;   // links to the pixel that one follows: longer chains lead along hairs only
constexpr int kMostBeside = 4;  // lattice pixels beside one pixel

// Steps from pixel to pixel of an image.
class Steps {
 public:
  explicit Steps(const PixelLinks& image) : image_(image) {
    for (int d = 0; d < 8; ++d) to_[d] = kPixelSteps[d][1] * image.width + kPixelSteps[d][0];
  }

  // Whether two links lead twice as far in that direction: straight or, along rows and columns, around a missing pixel.
  bool leadTwice(Index p, int d) const {
    const int right = (d + 1) % 8, left = (d + 7) % 8;
    return lead(p, d, d) || (d % 2 == 0 && (lead(p, right, left) || lead(p, left, right)));
  }

  template <class Visit>
  void forLinked(Index p, const Visit& visit) const {
    for (unsigned left = image_.links[p]; left != 0; left &= left - 1) visit(p + to_[__builtin_ctz(left)]);
  }

 private:
  bool isLinked(Index p, int d) const { return (image_.links[p] >> d & 1) != 0; }
  bool lead(Index p, int first, int second) const { return isLinked(p, first) && isLinked(p + to_[first], second); }

  const PixelLinks& image_;
  Index to_[8];
};

}  // namespace

PixelLattice takeEverySecond(const PixelLinks& image, const std::vector<Index>& point, const Points& positions) {
  const Index n = static_cast<Index>(positions.size()), num_pixels = static_cast<Index>(image.links.size());
  const Index width = (image.width + 1) / 2, height = (image.height + 1) / 2;
  PixelLattice lattice;
  lattice.links = {width, height, std::vector<std::uint8_t>(std::size_t(width) * height), {}};
  lattice.place.assign(lattice.links.links.size(), -1);
  const auto isOnLattice = [&](Index p) { return p % image.width % 2 == 0 && p / image.width % 2 == 0; };

  // Points in the order of the cloud, and the lattice points in the same order.
  std::vector<Index> pixel(n, -1), place_of(n, -1);
  for (Index p = 0; p < num_pixels; ++p)
    if (point[p] >= 0 && pixel[point[p]] < 0) pixel[point[p]] = p;
  for (Index i = 0; i < n; ++i) {
    const Index p = pixel[i];
    if (p < 0 || !isOnLattice(p)) continue;
    place_of[i] = lattice.place[p / image.width / 2 * width + p % image.width / 2] = static_cast<Index>(lattice.points.size());
    lattice.points.push_back(i);
  }

  const Steps steps(image);
  parallelFor(static_cast<Index>(lattice.points.size()), kBlock, [&](Index begin, Index end) {
    for (Index k = begin; k < end; ++k) {
      const Index p = pixel[lattice.points[k]];
      std::uint8_t& links = lattice.links.links[p / image.width / 2 * width + p % image.width / 2];
      for (int d = 0; d < 8; ++d) links |= steps.leadTwice(p, d) << d;
    }
  });

  // The lattice points that each pixel follows over one link.
  std::vector<std::array<Index, kMostBeside>> beside(n);
  std::vector<std::uint8_t> count(n);
  const auto isNearer = [&](Index i, Index a, Index b) {
    return std::make_pair((positions[lattice.points[a]] - positions[i]).squaredNorm(), a) <
           std::make_pair((positions[lattice.points[b]] - positions[i]).squaredNorm(), b);
  };
  parallelFor(n, kBlock, [&](Index begin, Index end) {
    for (Index i = begin; i < end; ++i) {
      if (place_of[i] >= 0) {
        beside[i][count[i]++] = place_of[i];
      } else if (pixel[i] >= 0) {
        steps.forLinked(pixel[i], [&](Index q) {
          if (point[q] >= 0 && pixel[point[q]] == q && place_of[point[q]] >= 0) beside[i][count[i]++] = place_of[point[q]];
        });
        std::sort(beside[i].begin(), beside[i].begin() + count[i], [&](Index a, Index b) { return isNearer(i, a, b); });
      }
    }
  });
  // Over more links: for few points.
  std::vector<Index> left;
  for (Index i = 0; i < n; ++i)
    if (count[i] == 0 && pixel[i] >= 0) left.push_back(i);
  for (int links = 2; links <= kMostLinks; ++links) {
    std::vector<Index> found(left.size(), -1);
    for (std::size_t l = 0; l < left.size(); ++l) {
      steps.forLinked(pixel[left[l]], [&](Index q) {
        const Index j = point[q];
        if (j >= 0 && count[j] > 0 && (found[l] < 0 || isNearer(left[l], beside[j][0], found[l]))) found[l] = beside[j][0];
      });
    }
    for (std::size_t l = 0; l < left.size(); ++l)
      if (count[left[l]] == 0 && found[l] >= 0) beside[left[l]][count[left[l]]++] = found[l];
  }

  lattice.followed.offsets.resize(n + 1);
  for (Index i = 0; i < n; ++i) lattice.followed.offsets[i + 1] = lattice.followed.offsets[i] + count[i];
  lattice.followed.items.resize(lattice.followed.offsets[n]);
  parallelFor(n, kBlock, [&](Index begin, Index end) {
    for (Index i = begin; i < end; ++i)
      std::copy_n(beside[i].begin(), count[i], lattice.followed.items.begin() + lattice.followed.offsets[i]);
  });
  return lattice;
}

}  // namespace deformable_surface::cloud
