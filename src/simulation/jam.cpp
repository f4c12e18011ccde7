#include "jam.h"

#include "deformable_surface/base/notice.h"
#include "deformable_surface/base/value.h"

#include <algorithm>

#include "rest_parts.h"

namespace deformable_surface::simulation {
namespace {

constexpr std::size_t kMostNamed = 4;  // more names make no line that is read

std::string list(const std::vector<Jam::Actor>& actors) {
  const std::size_t named = std::min(actors.size(), kMostNamed), more = actors.size() - named;
  std::string text;
  for (std::size_t k = 0; k < named; ++k) {
    const Jam::Actor& actor = actors[k];
    if (k > 0) text += k + 1 == named && more == 0 ? " and " : ", ";
    text += (actor.moves ? "moving " : "resting ") + actor.name +
            (actor.act == Jam::Actor::Act::kPushes  ? " pushes"
             : actor.act == Jam::Actor::Act::kPulls ? " pulls"
             : actor.act == Jam::Actor::Act::kHolds ? " holds"
                                                    : " is near");
  }
  return text + (more > 0 ? " and " + std::to_string(more) + " more act" : "");
}

}  // namespace

std::string describeJam(const Jam& jam) {
  const std::string told = "contact limited the motion of " + formatCount(jam.points, "points, ") + "one of them at " +
                           formatPlace(jam.place) + " m, ";
  if (jam.actors.empty())
    return told + "where no tool or pin is near, nor acts on the same part: parts meet by their own motion, or under other loads";
  if (jam.are_near) {
    const bool may_lag = std::any_of(jam.actors.begin(), jam.actors.end(),
                                     [](const Jam::Actor& actor) { return actor.moves && actor.act == Jam::Actor::Act::kHolds; });
    return told + "where " + list(jam.actors) + (may_lag ? "; held points may lag behind the paths of what holds them" : "");
  }
  return told + "where no tool or pin is near; on the same part of the surface, " + list(jam.actors);
}

}  // namespace deformable_surface::simulation
