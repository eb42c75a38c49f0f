// Conversion of size and encoding, and the CameraInfo of the result.

#include "musher/modules/camera/fit.hpp"

#include <gmock/gmock.h>

#include <cmath>
#include <numbers>

#include "musher/modules/camera/camera_info.hpp"
#include "musher/modules/camera/tool/strip_picture.hpp"

namespace musher::camera::fit_test {

// Of one colour.
msg::Image Plain(std::uint32_t width, std::uint32_t height, const std::string& encoding,
                 const std::vector<std::uint8_t>& pixel) {
  msg::Image picture;
  picture.header = {{12, 5}, "camera_front"};
  picture.width = width;
  picture.height = height;
  picture.encoding = encoding;
  picture.step = width * static_cast<std::uint32_t>(pixel.size());
  for (std::uint32_t i = 0; i < width * height; ++i) {
    picture.data.insert(picture.data.end(), pixel.begin(), pixel.end());
  }
  return picture;
}

TEST(Fit, MovesAPictureThroughThatFitsAlready) {
  msg::Image picture = Plain(640, 480, "bgr8", {1, 2, 3});
  const std::uint8_t* bytes = picture.data.data();
  const auto same = Fit(std::move(picture), {640, 480, "bgr8"});
  ASSERT_TRUE(same);
  EXPECT_EQ(same.value().data.data(), bytes) << "nothing was copied";
}

TEST(Fit, ChangesSizeAndEncodingAndKeepsTheHeader) {
  const auto small = Fit(Plain(640, 480, "bgr8", {10, 20, 30}), {320, 240, "rgb8"});
  ASSERT_TRUE(small);
  EXPECT_EQ(small.value(), Plain(320, 240, "rgb8", {30, 20, 10}));
  const auto gray = Fit(Plain(4, 4, "rgba8", {200, 200, 200, 7}), {8, 8, "mono8"});
  ASSERT_TRUE(gray);
  EXPECT_EQ(gray.value(), Plain(8, 8, "mono8", {200}));
}

TEST(Fit, TakesRowsWithRoomBetweenThem) {
  msg::Image padded = Plain(2, 2, "mono8", {9});
  padded.step = 4;
  padded.data = {9, 9, 0, 0, 9, 9, 0, 0};
  const auto colour = Fit(padded, {0, 0, "bgr8"});
  ASSERT_TRUE(colour);
  EXPECT_EQ(colour.value(), Plain(2, 2, "bgr8", {9, 9, 9}));
}

TEST(Fit, RefusesInvalidPictures) {
  EXPECT_EQ(Fit(Plain(4, 4, "16UC1", {1, 2}), {}).error().code, 4410);
  msg::Image short_of_bytes = Plain(4, 4, "bgr8", {1, 2, 3});
  short_of_bytes.data.pop_back();
  EXPECT_FALSE(Fit(short_of_bytes, {}));
  msg::Image lying = Plain(4, 4, "bgr8", {1, 2, 3});
  lying.width = 0xFFFF'FFFF;  // times 3 is small again
  EXPECT_FALSE(Fit(lying, {}));
  msg::Image empty = Plain(4, 4, "bgr8", {1, 2, 3});
  empty.step = 0;
  EXPECT_FALSE(Fit(empty, {}));
  EXPECT_FALSE(Fit({}, {320, 240, "bgr8"}));
}

TEST(CameraInfo, IsScaledWithThePicture) {
  const msg::CameraInfo full = Pinhole(640, 480, std::numbers::pi / 2);
  EXPECT_DOUBLE_EQ(full.k[0], 320) << "90 degrees: half the width";
  EXPECT_DOUBLE_EQ(full.k[2], 319.5);
  const msg::CameraInfo half = Scaled(full, 320, 240);
  const msg::CameraInfo made = Pinhole(320, 240, std::numbers::pi / 2);
  EXPECT_EQ(half.width, 320u);
  for (std::size_t i = 0; i < half.k.size(); ++i) EXPECT_NEAR(half.k[i], made.k[i], 1e-9) << i;
  for (std::size_t i = 0; i < half.p.size(); ++i) EXPECT_NEAR(half.p[i], made.p[i], 1e-9) << i;
  EXPECT_EQ(half.d, full.d);
}

TEST(CameraInfo, OfASourceWithoutASizeStays) {
  EXPECT_EQ(Scaled({}, 320, 240), msg::CameraInfo{});
}

TEST(Strip, SetsPicturesSideBySideInRows) {
  std::vector<tool::StripTile> tiles;
  for (std::uint8_t i = 0; i < 3; ++i) {
    auto tile = tool::TileOf(Plain(64, 48, "bgr8", {i, 0, 200}), 32);
    ASSERT_TRUE(tile);
    EXPECT_EQ(tile.value().height, 24u);
    tiles.push_back({std::move(tile).value(), tool::LabelOf(1'500'000'000, 0)});
  }
  EXPECT_EQ(tiles[0].label, "1.5 s");
  const msg::Image strip = tool::DrawStrip(tiles, 2);
  EXPECT_EQ(strip.width, 2 * 36u + 4);
  EXPECT_EQ(strip.height, 2 * 50u + 4);
  EXPECT_EQ(strip.data[strip.step * 10 + 3 * 10 + 2], 200) << "in the first tile";
  EXPECT_EQ(strip.data[strip.step * 60 + 3 * 10], 2) << "the third is below";
  EXPECT_EQ(tool::DrawStrip({}, 2).width, 0u);
}

TEST(Strip, LabelsADateRelativeToTheFirstPicture) {
  const std::int64_t date = 1'700'000'000'000'000'000;
  EXPECT_EQ(tool::LabelOf(date + 2'000'000'000, date), "+2.0 s");
}

}  // namespace musher::camera::fit_test
