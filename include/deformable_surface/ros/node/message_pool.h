// Reuses large messages once nobody holds them any more. A message that was published within its process without a copy
// belongs to its readers until they release it.
#pragma once

#include <boost/make_shared.hpp>
#include <boost/shared_ptr.hpp>

#include <atomic>
#include <vector>

namespace deformable_surface::node {

/// For one thread; any thread may release the messages.
template <class Message>
class MessagePool {
 public:
  /// A message that nobody else holds, with its former content.
  boost::shared_ptr<Message> take() {
    for (const boost::shared_ptr<Message>& message : messages_) {
      if (message.use_count() != 1) continue;
      // Its last holder read it before releasing it.
      std::atomic_thread_fence(std::memory_order_acquire);
      return message;
    }
    auto message = boost::make_shared<Message>();
    if (messages_.size() < kMost) messages_.push_back(message);
    return message;
  }

 private:
  // One in work, one on its way, one with a listener. If listeners hold more, each message costs an allocation.
  static constexpr std::size_t kMost = 3;

  std::vector<boost::shared_ptr<Message>> messages_;
};

}  // namespace deformable_surface::node
