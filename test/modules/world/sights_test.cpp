// The cameras' pictures are good enough for detectors: codes are read, faces found.

#include <ZXing/ReadBarcode.h>
#include <gmock/gmock.h>

#include <cmath>
#include <opencv2/imgproc.hpp>
#include <opencv2/objdetect.hpp>

#include "musher/test/modules/world/scenes.hpp"
#include "musher/test/modules/world/shots.hpp"

namespace musher::world::sights_test {

// A board that far before the front camera, turned by `yaw_rad` from it.
Scene WithBoard(const Sign& sign, double size_m, double far_m, double yaw_rad = 0) {
  Scene scene = EmptyYard();
  scene.ground.finest_per_m = 30;
  scene.ground.texture = Ground::Texture::kGrass;
  const double from_m = FrontCamera().position_m.x();
  Board board{"", {from_m + far_m, 0}, M_PI + yaw_rad, size_m, size_m, 0.2};
  board.sign = sign;
  scene.boards = {board};
  return scene;
}

Image NoisyShot(const Scene& scene) {
  return ShotOf(scene, CameraSet().cameras[0], Standing());
}

std::string Read(const Image& image) {
  const cv::Mat grey = GreyOf(image);
  return ZXing::ReadBarcode({grey.data, grey.cols, grey.rows, ZXing::ImageFormat::Lum}).text();
}

TEST(Code, OfTwentyCentimetresIsReadFromAMetreAndMore) {
  const Sign sign{Sign::Kind::kQr, "A-1"};
  for (const double far_m : {0.5, 1.0, 1.5}) {
    EXPECT_EQ(Read(NoisyShot(WithBoard(sign, 0.2, far_m))), "A-1") << far_m << " m";
  }
  for (const double degrees : {-15.0, 15.0}) {
    EXPECT_EQ(Read(NoisyShot(WithBoard(sign, 0.2, 1, degrees * M_PI / 180))), "A-1") << degrees;
  }
}

TEST(Code, MayBeLongAndOfAnyLetters) {
  const std::string text = "https://example.org/robots/dog1?greeting=\u4f60\u597d";
  EXPECT_EQ(Read(NoisyShot(WithBoard({Sign::Kind::kQr, text}, 0.4, 1))), text);
}

TEST(Face, IsFoundByAUsualDetectorAtSpeakingDistance) {
  cv::CascadeClassifier cascade;
  ASSERT_TRUE(cascade.load("/usr/share/opencv4/haarcascades/haarcascade_frontalface_alt.xml"))
      << "from Debian's opencv-data";
  for (const auto& [face, far_m] : {std::pair(0, 1.0), std::pair(1, 1.5), std::pair(2, 2.0),
                                    std::pair(3, 1.5), std::pair(4, 1.5), std::pair(11, 1.5)}) {
    const Scene scene = WithBoard({Sign::Kind::kFace, "", face}, 0.35, far_m);
    std::vector<cv::Rect> found;
    cascade.detectMultiScale(GreyOf(NoisyShot(scene)), found, 1.2, 3, 0, {40, 40});
    EXPECT_EQ(found.size(), 1U) << "face " << face << " at " << far_m << " m";
  }
}

TEST(Face, IsNoneWhereABoardIsBlank) {
  cv::CascadeClassifier cascade;
  ASSERT_TRUE(cascade.load("/usr/share/opencv4/haarcascades/haarcascade_frontalface_alt.xml"));
  std::vector<cv::Rect> found;
  cascade.detectMultiScale(GreyOf(NoisyShot(WithBoard({}, 0.35, 1))), found, 1.1, 3, 0, {30, 30});
  EXPECT_TRUE(found.empty());
}

// How much of the board's middle is ink.
double InkOf(const std::string& text) {
  const Image image = FrontShot(WithBoard({Sign::Kind::kText, text}, 0.4, 1));
  const auto corner = PixelOf({1.27, 0.19, 0.59});
  const auto opposite = PixelOf({1.27, -0.19, 0.21});
  int dark = 0, all = 0;
  for (int y = corner.y(); y < opposite.y(); ++y) {
    for (int x = corner.x(); x < opposite.x(); ++x, ++all) dark += image.At(x, y)[1] < 90 ? 1 : 0;
  }
  return double(dark) / all;
}

TEST(Text, IsWrittenAsLargeAsTheBoardAllowsInAnyLetters) {
  for (const std::string text : {"STOP", "two\nlines", "\u505c\u6b62"}) {
    EXPECT_GT(InkOf(text), 0.05) << text;
    EXPECT_LT(InkOf(text), 0.5) << text;
  }
}

// The number of green pixels to the left of the board's middle, and to the right of it.
std::pair<int, int> GreenOf(const std::string& arrow) {
  const Image image = FrontShot(WithBoard({Sign::Kind::kArrow, arrow, 0, {32, 150, 60}}, 0.4, 1));
  std::pair<int, int> green;
  const int middle = PixelOf({1.27, 0, 0.4}).x();
  const auto corner = PixelOf({1.27, 0.19, 0.59}), opposite = PixelOf({1.27, -0.19, 0.21});
  for (int y = corner.y(); y < opposite.y(); ++y) {
    for (int x = corner.x(); x < opposite.x(); ++x) {
      const std::uint8_t* bgr = image.At(x, y);
      if (bgr[1] > bgr[0] + 40 && bgr[1] > bgr[2] + 40) ++(x < middle ? green.first : green.second);
    }
  }
  return green;
}

TEST(Arrow, HasItsHeadOnTheSideOfItsDirection) {
  const auto [left_of_left, right_of_left] = GreenOf("left");
  EXPECT_GT(left_of_left, 1.2 * right_of_left);
  EXPECT_GT(right_of_left, 1000);
  const auto [left_of_right, right_of_right] = GreenOf("right");
  EXPECT_NEAR(left_of_right, right_of_left, 0.05 * right_of_left);
  EXPECT_NEAR(right_of_right, left_of_left, 0.05 * left_of_left);
}

}  // namespace musher::world::sights_test
