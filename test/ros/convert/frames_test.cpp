#include "deformable_surface/ros/convert/frames.h"

#include <gtest/gtest.h>
#include <tf2/buffer_core.h>

#include <random>

namespace deformable_surface::test {
namespace {

// A transform that turns and moves at random, in two links.
class Moving {
 public:
  explicit Moving(unsigned seed) : generator_(seed) {}

  void addTo(tf2::BufferCore& transforms, double time) {
    for (const auto& [parent, child] : {std::pair("map", "arm"), std::pair("arm", "camera")}) {
      geometry_msgs::TransformStamped transform;
      transform.header.frame_id = parent;
      transform.header.stamp = ros::Time(time);
      transform.child_frame_id = child;
      Eigen::Quaterniond turn(draw(), draw(), draw(), draw());
      turn.normalize();
      transform.transform.rotation.w = turn.w();
      transform.transform.rotation.x = turn.x();
      transform.transform.rotation.y = turn.y();
      transform.transform.rotation.z = turn.z();
      transform.transform.translation.x = draw();
      transform.transform.translation.y = draw();
      transform.transform.translation.z = draw();
      transforms.setTransform(transform, "test", false);
    }
  }

 private:
  double draw() { return std::uniform_real_distribution<double>(-1.0, 1.0)(generator_); }
  std::mt19937 generator_;
};

TEST(Frames, ATransformHasTheSameBitsWhenLaterOnesAreKnown) {
  int changed_by_tf = 0;
  for (unsigned seed = 1; seed <= 50; ++seed) {
    Moving moving(seed);
    tf2::BufferCore transforms;
    for (const double time : {1.0, 1.02}) moving.addTo(transforms, time);
    const ros::Time stamp(1.02);
    const auto find = [&] { return node::findTransform("cloud", "camera", "map", stamp, transforms, nullptr).matrix(); };
    const Eigen::Matrix4d newest = find();
    const geometry_msgs::Quaternion before = transforms.lookupTransform("map", "camera", stamp).transform.rotation;
    moving.addTo(transforms, 1.04);
    EXPECT_EQ(find(), newest) << seed;
    const geometry_msgs::Quaternion after = transforms.lookupTransform("map", "camera", stamp).transform.rotation;
    changed_by_tf += before.w != after.w || before.x != after.x || before.y != after.y || before.z != after.z;
    EXPECT_NEAR(newest(0, 0), 1.0 - 2.0 * (after.y * after.y + after.z * after.z), 1e-8) << seed;
  }
  EXPECT_GT(changed_by_tf, 0);
}

}  // namespace
}  // namespace deformable_surface::test
