#include "waiting_clouds.h"

#include <utility>

namespace deformable_surface::node {
namespace {

// Two seconds of a camera: the largest delay of a working transform, and of input.delay. Clouds must not fill the
// memory.
constexpr std::size_t kMaxClouds = 64;
constexpr std::int64_t kMaxPoints = 4'000'000;  // of all together, unless it is one
// A sensor's transform comes a little after its first cloud. A latched cloud would be lost.
constexpr std::chrono::seconds kPatience(5);

}  // namespace

void WaitingClouds::put(IncomingCloud&& cloud) {
  clouds_.push_back({std::move(cloud), std::chrono::steady_clock::now() + kPatience});
  std::int64_t points = 0;
  for (const Entry& entry : clouds_) points += entry.cloud.decoded.cloud.size();
  for (; clouds_.size() > kMaxClouds || (clouds_.size() > 1 && points > kMaxPoints); ++num_dropped_) {
    points -= clouds_.front().cloud.decoded.cloud.size();
    clouds_.pop_front();
  }
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
