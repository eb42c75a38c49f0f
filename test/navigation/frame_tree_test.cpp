// How frames lie in each other, by /tf and /tf_static.

#include "musher/navigation/frames/frame_tree.hpp"

#include <gmock/gmock.h>

#include <cmath>
#include <limits>

namespace musher::navigation::frame_tree_test {

using ::testing::HasSubstr;

FrameTransform At(double x_m, double y_m, double yaw_rad) {
  return {{x_m, y_m, 0}, 0, 0, std::sin(yaw_rad / 2), std::cos(yaw_rad / 2)};
}

class Frames : public ::testing::Test {
 protected:
  std::string WhyNot(std::string_view parent, std::string_view child) const {
    const auto found = tree_.Find(parent, child, now_);
    return found ? "" : found.error().message;
  }

  FrameTree tree_{std::chrono::seconds(1)};
  Time now_ = Time{} + std::chrono::seconds(100);
};

TEST_F(Frames, AreFoundAlongTheirParents) {
  EXPECT_TRUE(tree_.Set("map", "odom", At(1, 2, M_PI / 2), false, now_));
  EXPECT_TRUE(tree_.Set("/odom", "/base_link", At(3, 0, 0), false, now_));
  const auto found = tree_.Find("map", "base_link", now_);
  ASSERT_TRUE(found) << found.error().message;
  EXPECT_NEAR(found.value().pose.at.x_m, 1, 1e-9);
  EXPECT_NEAR(found.value().pose.at.y_m, 5, 1e-9);
  EXPECT_NEAR(found.value().pose.yaw_rad, M_PI / 2, 1e-9);
  EXPECT_EQ(tree_.Find("map", "map", now_).value().pose, Pose{});
}

TEST_F(Frames, AreNotUsedOnceTheyAreOldUnlessTheyAreFixed) {
  tree_.Set("map", "odom", At(1, 2, 0), false, now_);
  tree_.Set("base_link", "laser", At(0.1, 0, 0), true, now_);
  now_ += Milliseconds(1500);
  EXPECT_THAT(WhyNot("map", "odom"),
              HasSubstr("no transform from map to odom: that of odom in map is 1.5 s old"));
  EXPECT_EQ(WhyNot("base_link", "laser"), "");
}

TEST_F(Frames, MayBeUpsideDownAndNotTilted) {
  tree_.Set("base_link", "hanging", {{0, 0, 1}, 1, 0, 0, 0}, true, now_);
  EXPECT_TRUE(tree_.Find("base_link", "hanging", now_).value().upside_down);
  tree_.Set("base_link", "camera", {{0, 0, 1}, 0, std::sin(0.4), 0, std::cos(0.4)}, true, now_);
  EXPECT_THAT(WhyNot("base_link", "camera"), HasSubstr("it is tilted by 46 degrees"));
}

TEST_F(Frames, RefuseWhatIsNoTransform) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(tree_.Set("map", "odom", {{nan, 0, 0}}, false, now_));
  EXPECT_FALSE(tree_.Set("map", "odom", {{}, 0, 0, 0, 0}, false, now_));
  EXPECT_FALSE(tree_.Set("map", "odom", {{}, 0, nan, 0, 1}, false, now_));
  EXPECT_FALSE(tree_.Set("", "odom", {}, false, now_));
  EXPECT_FALSE(tree_.Set("odom", "/odom", {}, false, now_));
  EXPECT_THAT(WhyNot("map", "odom"), HasSubstr("odom has no known parent"));
}

TEST_F(Frames, AreForgottenWithTheTimeUnlessTheyAreFixed) {
  tree_.Set("map", "odom", {}, false, now_);
  tree_.Set("base_link", "laser", {}, true, now_);
  tree_.Forget();
  EXPECT_NE(WhyNot("map", "odom"), "");
  EXPECT_EQ(WhyNot("base_link", "laser"), "") << "they are sent only once";
}

TEST_F(Frames, AreNotUsedAfterTheTimeWasSetBackUntilTheyComeAgain) {
  tree_.Set("map", "odom", {}, false, now_);
  now_ -= std::chrono::seconds(50);
  EXPECT_THAT(WhyNot("map", "odom"), HasSubstr("the time was set back"));
  tree_.Set("map", "odom", {}, false, now_);
  EXPECT_EQ(WhyNot("map", "odom"), "");
}

TEST_F(Frames, EndAlsoInACircle) {
  tree_.Set("a", "b", {}, true, now_);
  tree_.Set("b", "a", {}, true, now_);
  EXPECT_THAT(WhyNot("map", "a"), HasSubstr("no transform from map to a"));
}

}  // namespace musher::navigation::frame_tree_test
