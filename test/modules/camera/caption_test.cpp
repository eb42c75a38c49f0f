// When musher-camera takes a picture by the changes of a text.

#include "musher/modules/camera/tool/caption.hpp"

#include <gtest/gtest.h>

namespace musher::camera::tool::caption_test {

constexpr std::int64_t kSecond = 1'000'000'000;

TEST(Caption, TakesOnePictureAfterAChangeOnceItHasSettled) {
  Caption caption(kSecond);
  EXPECT_FALSE(caption.Due(0)) << "no text yet";
  caption.OnText("IDLE");
  EXPECT_FALSE(caption.Due(1 * kSecond));
  EXPECT_FALSE(caption.Due(3 * kSecond / 2));
  EXPECT_TRUE(caption.Due(2 * kSecond));
  EXPECT_FALSE(caption.Due(3 * kSecond)) << "there was only one change";
}

TEST(Caption, IgnoresTheSameTextAgain) {
  Caption caption(0);
  caption.OnText("IDLE");
  EXPECT_TRUE(caption.Due(1));
  caption.OnText("IDLE");
  EXPECT_FALSE(caption.Due(2));
}

TEST(Caption, WaitsAgainWhenTheTextChangesBeforeThePicture) {
  Caption caption(kSecond);
  caption.OnText("IDLE");
  EXPECT_FALSE(caption.Due(kSecond));
  caption.OnText("TRACKING");
  EXPECT_FALSE(caption.Due(2 * kSecond));
  EXPECT_TRUE(caption.Due(3 * kSecond));
  EXPECT_EQ(caption.text(), "TRACKING");
}

TEST(Caption, IsNotStuckWhenTimeGoesBack) {
  Caption caption(kSecond);
  caption.OnText("IDLE");
  EXPECT_FALSE(caption.Due(100 * kSecond));
  EXPECT_FALSE(caption.Due(1 * kSecond));
  EXPECT_TRUE(caption.Due(2 * kSecond));
}

}  // namespace musher::camera::tool::caption_test
