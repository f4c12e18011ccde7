// Large messages that are used again once nobody holds them any more. A file of its own, because a message that was published in
// its process without a copy belongs to whoever still looks at it.
#pragma once

#include <boost/make_shared.hpp>
#include <boost/shared_ptr.hpp>

#include <atomic>
#include <vector>

namespace deformable_surface::node {

/// For one thread; the messages may be let go of by any.
template <class Message>
class MessagePool {
 public:
  /// One that nobody else holds, with whatever it held before.
  boost::shared_ptr<Message> take() {
    for (const boost::shared_ptr<Message>& message : messages_) {
      if (message.use_count() != 1) continue;
      // Whoever let go of it last has read it before.
      std::atomic_thread_fence(std::memory_order_acquire);
      return message;
    }
    auto message = boost::make_shared<Message>();
    if (messages_.size() < kMost) messages_.push_back(message);
    return message;
  }

 private:
  // One in work, one on its way, one that a listener looks at; who holds more than that costs an allocation a message.
  static constexpr std::size_t kMost = 3;

  std::vector<boost::shared_ptr<Message>> messages_;
};

}  // namespace deformable_surface::node
