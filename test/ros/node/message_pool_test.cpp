// Messages are reused, but never while somebody holds them.
#include "deformable_surface/ros/node/message_pool.h"

#include <gtest/gtest.h>

#include <set>
#include <string>

namespace deformable_surface::node {
namespace {

TEST(MessagePool, GivesTheSameMessageAgainOnceNobodyHoldsIt) {
  MessagePool<std::string> pool;
  const std::string* first = pool.take().get();
  EXPECT_EQ(pool.take().get(), first);
}

TEST(MessagePool, NeverGivesOneThatSomebodyHoldsHoweverManyAreHeld) {
  MessagePool<std::string> pool;
  std::vector<boost::shared_ptr<const std::string>> held;
  std::set<const std::string*> known;
  for (int k = 0; k < 10; ++k) {
    const auto message = pool.take();
    *message = std::to_string(k);
    held.push_back(message);
    known.insert(message.get());
  }
  EXPECT_EQ(known.size(), held.size());
  for (int k = 0; k < 10; ++k) EXPECT_EQ(*held[k], std::to_string(k));
}

}  // namespace
}  // namespace deformable_surface::node
