#include <gmock/gmock.h>

#include <opencv2/imgcodecs.hpp>

#include "musher/messages/sensor_msgs/compressed_image.hpp"
#include "musher/messages/sensor_msgs/image.hpp"
#include "musher/view/live/camera_view.hpp"

namespace musher::view::picture_test {

using ::testing::HasSubstr;

msg::Image Red(std::uint32_t width, std::uint32_t height) {
  msg::Image image;
  image.width = width;
  image.height = height;
  image.encoding = "rgb8";
  image.step = width * 3;
  for (std::uint32_t i = 0; i < width * height; ++i) {
    for (const int value : {255, 0, 0}) image.data.push_back(static_cast<std::uint8_t>(value));
  }
  return image;
}

Result<std::string> Jpeg(const msg::Image& image, int width = 0) {
  return JpegOf(msg::Image::kTypeName, msg::Encode(image), width);
}

cv::Mat Read(const std::string& jpeg) {
  return cv::imdecode(std::vector<std::uint8_t>(jpeg.begin(), jpeg.end()), cv::IMREAD_COLOR);
}

TEST(PictureTest, KeepsItsColours) {
  const cv::Mat picture = Read(Jpeg(Red(64, 48)).value());
  EXPECT_EQ(picture.cols, 64);
  const auto pixel = picture.at<cv::Vec3b>(24, 32);
  EXPECT_GT(pixel[2], 240) << "red";
  EXPECT_LT(pixel[0], 15) << "blue";
}

TEST(PictureTest, IsNotWiderThanRequested) {
  EXPECT_EQ(Read(Jpeg(Red(64, 48), 32).value()).size(), cv::Size(32, 24));
  EXPECT_EQ(Read(Jpeg(Red(64, 48), 640).value()).size(), cv::Size(64, 48));
}

TEST(PictureTest, ThatIsShorterThanItSaysIsRefused) {
  msg::Image image = Red(64, 48);
  image.data.resize(100);
  EXPECT_THAT(Jpeg(image).error().message, HasSubstr("100 bytes for 64 × 48 pixels of rgb8"));
  image = Red(64, 48);
  image.height = 4'000'000'000;
  EXPECT_FALSE(Jpeg(image));
  image = Red(64, 48);
  image.step = 1;
  EXPECT_FALSE(Jpeg(image));
  EXPECT_FALSE(Jpeg(Red(0, 0)));
}

TEST(PictureTest, OfAnUnknownEncodingIsRefusedWithTheKnownOnes) {
  msg::Image image = Red(64, 48);
  image.encoding = "bayer_rggb8";
  EXPECT_THAT(Jpeg(image).error().message, HasSubstr("'bayer_rggb8'; known are bgr8"));
}

TEST(PictureTest, ThatIsCompressedIsReadToo) {
  std::vector<std::uint8_t> png;
  cv::imencode(".png", cv::Mat(10, 20, CV_8UC3, cv::Scalar(0, 255, 0)), png);
  msg::CompressedImage image;
  image.format = "png";
  image.data.assign(png.begin(), png.end());
  const auto jpeg = JpegOf(msg::CompressedImage::kTypeName, msg::Encode(image), 0);
  EXPECT_EQ(Read(jpeg.value()).size(), cv::Size(20, 10));
  image.data = {1, 2, 3};
  EXPECT_THAT(JpegOf(msg::CompressedImage::kTypeName, msg::Encode(image), 0).error().message,
              HasSubstr("its format 'png' cannot be read"));
}

TEST(PictureTest, ThatIsNoMessageIsRefused) {
  EXPECT_FALSE(JpegOf(msg::Image::kTypeName, {}, 0));
}

}  // namespace musher::view::picture_test
