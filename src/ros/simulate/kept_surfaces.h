// Prepared surfaces that a server of runs keeps, so that runs of one cloud with other loads and materials begin with them. Apart
// from the server, which knows nothing of scenes.
#pragma once

#include "deformable_surface/cloud/point_cloud.h"
#include "deformable_surface/simulation/prepared_surface.h"

#include <list>
#include <optional>
#include <string>
#include <vector>

namespace deformable_surface::node {

/// What a scene without a bag has before its materials and loads act.
struct KeptSurface {
  std::string key;                   // all that it depends on
  cloud::PointCloud cloud;           // filtered
  std::vector<std::string> notices;  // of the filters
  simulation::RestSurface prepared;
};

class KeptSurfaces {
 public:
  /// Makes that of this scene, if it is one that can be shared and is not there yet. Throws InputError.
  void make(const simulation::SceneParams& params);
  /// Takes that of this scene out; nothing if there is none.
  std::optional<KeptSurface> take(const simulation::SceneParams& params);

 private:
  std::list<KeptSurface>::iterator find(const std::string& key);

  std::list<KeptSurface> kept_;  // those used last are in front
};

}  // namespace deformable_surface::node
