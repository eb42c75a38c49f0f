// The statistics of musher-camera on a series of pictures.

#include "musher/modules/camera/tool/picture_count.hpp"
#include "musher/messages/stamp.hpp"

#include <gtest/gtest.h>

namespace musher::camera::tool::picture_count_test {

void Add(PictureCount& count, std::int64_t ms, std::int64_t age_ms = 1) {
  msg::Image picture;
  picture.width = 640;
  picture.height = 480;
  picture.encoding = "bgr8";
  picture.header.stamp = msg::ToStamp(Milliseconds(ms));
  count.Add(picture, Milliseconds(age_ms), Time{} + Milliseconds(ms + age_ms));
}

TEST(PictureCount, MeasuresRateShapeAndAge) {
  PictureCount count;
  for (int i = 0; i <= 100; ++i) Add(count, i * 50, i);
  EXPECT_EQ(count.shape(), "640x480 bgr8");
  EXPECT_NEAR(count.RateHz(), 100 / 5.1, 0.01);
  EXPECT_DOUBLE_EQ(count.AgeMs(0.5), 50);
  EXPECT_DOUBLE_EQ(count.AgeMs(0.99), 99);
  EXPECT_EQ(count.Lost(), 0u);
}

TEST(PictureCount, SeesWhatIsMissingByTheGapItLeaves) {
  PictureCount count;
  for (const int number : {0, 1, 2, 5, 6, 7, 9}) Add(count, number * 33);
  EXPECT_EQ(count.Lost(), 3u);
}

TEST(PictureCount, ReportsNoRateOfNoneOrOne) {
  PictureCount count;
  EXPECT_EQ(count.AgeMs(0.5), 0);
  EXPECT_EQ(count.Lost(), 0u);
  Add(count, 7);
  EXPECT_EQ(count.RateHz(), 0);
  EXPECT_EQ(count.Lost(), 0u);
}

}  // namespace musher::camera::tool::picture_count_test
