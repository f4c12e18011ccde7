#include "deformable_surface/cloud/equal_clouds.h"

#include <algorithm>
#include <cstring>

namespace deformable_surface::cloud {
namespace {

// Bit for bit, since NaN equals nothing.
bool areSame(const Points& a, const Points& b) {
  return a.size() == b.size() && (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(Vec3)) == 0);
}

bool areSame(const ExtraField& a, const ExtraField& b) {
  return a.name == b.name && a.type == b.type && a.count == b.count && a.bytes == b.bytes;
}

}  // namespace

bool areEqual(const PointCloud& a, const PointCloud& b) {
  return a.width == b.width && a.height == b.height && a.viewpoint == b.viewpoint && a.origin == b.origin &&
         areSame(a.positions, b.positions) && areSame(a.normals, b.normals) && a.extra_fields.size() == b.extra_fields.size() &&
         std::equal(a.extra_fields.begin(), a.extra_fields.end(), b.extra_fields.begin(),
                    [](const ExtraField& x, const ExtraField& y) { return areSame(x, y); });
}

}  // namespace deformable_surface::cloud
