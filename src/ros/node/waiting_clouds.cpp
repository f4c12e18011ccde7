#include "waiting_clouds.h"

#include <utility>

#include "few_clouds.h"

namespace deformable_surface::node {
namespace {

// A sensor's transform comes a little after its first cloud. A latched cloud would be lost.
constexpr std::chrono::seconds kPatience(5);

}  // namespace

void WaitingClouds::put(IncomingCloud&& cloud) {
  clouds_.push_back({std::move(cloud), std::chrono::steady_clock::now() + kPatience});
  num_dropped_ += dropOldestClouds(clouds_, [](const Entry& entry) { return entry.cloud.decoded.cloud.size(); });
}

std::optional<IncomingCloud> WaitingClouds::take(const std::function<Answer(IncomingCloud&, bool)>& ask) {
  const auto now = std::chrono::steady_clock::now();
  for (std::size_t k = clouds_.size(); k-- > 0;) {
    const Answer answer = ask(clouds_[k].cloud, now < clouds_[k].give_up);
    const auto at = clouds_.begin() + static_cast<std::ptrdiff_t>(k);
    if (answer == Answer::kTake) {
      IncomingCloud taken = std::move(at->cloud);
      num_dropped_ += static_cast<int>(k);
      clouds_.erase(clouds_.begin(), at + 1);
      return taken;
    }
    if (answer == Answer::kRefuse) clouds_.erase(at);
  }
  return std::nullopt;
}

}  // namespace deformable_surface::node
