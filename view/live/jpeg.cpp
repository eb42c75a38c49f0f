#include <algorithm>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "musher/messages/sensor_msgs/compressed_image.hpp"
#include "musher/messages/sensor_msgs/image.hpp"
#include "musher/view/live/camera_view.hpp"

namespace musher::view {
namespace {

constexpr int kQuality = 80;
constexpr std::uint32_t kMostPixelsASide = 8192;

struct Encoding {
  std::string_view name;
  int type;    // OpenCV's
  int to_bgr;  // its conversion; -1: none
  int bytes;   // of a pixel
};
constexpr std::array<Encoding, 6> kEncodings = {{
    {"bgr8", CV_8UC3, -1, 3},
    {"rgb8", CV_8UC3, cv::COLOR_RGB2BGR, 3},
    {"bgra8", CV_8UC4, cv::COLOR_BGRA2BGR, 4},
    {"rgba8", CV_8UC4, cv::COLOR_RGBA2BGR, 4},
    {"mono8", CV_8UC1, -1, 1},
    {"mono16", CV_16UC1, -1, 2},
}};

Error NoPicture(const std::string& why) {
  return {kCodeParametersInvalid, "the picture cannot be shown: " + why};
}

Result<cv::Mat> Pixels(msg::Image& image) {
  const auto* const encoding =
      std::find_if(kEncodings.begin(), kEncodings.end(),
                   [&image](const Encoding& each) { return each.name == image.encoding; });
  if (encoding == kEncodings.end()) {
    return NoPicture("its encoding is '" + image.encoding +
                     "'; known are bgr8, rgb8, bgra8, rgba8, mono8, mono16");
  }
  const std::size_t row = std::size_t{image.width} * static_cast<std::size_t>(encoding->bytes);
  if (image.width == 0 || image.height == 0 || image.width > kMostPixelsASide ||
      image.height > kMostPixelsASide || image.step < row ||
      image.data.size() < std::size_t{image.step} * image.height) {
    return NoPicture("it has " + std::to_string(image.data.size()) + " bytes for " +
                     std::to_string(image.width) + " × " + std::to_string(image.height) +
                     " pixels of " + image.encoding);
  }
  const cv::Mat raw(static_cast<int>(image.height), static_cast<int>(image.width), encoding->type,
                    image.data.data(), image.step);
  cv::Mat pixels;
  if (encoding->to_bgr >= 0) {
    cv::cvtColor(raw, pixels, encoding->to_bgr);
  } else if (encoding->type == CV_16UC1) {
    raw.convertTo(pixels, CV_8UC1, 1.0 / 256);
  } else {
    pixels = raw.clone();
  }
  return pixels;
}

Result<cv::Mat> Pixels(const msg::CompressedImage& image) {
  const std::vector<std::uint8_t> data(image.data.begin(), image.data.end());
  cv::Mat pixels = cv::imdecode(data, cv::IMREAD_COLOR);
  if (pixels.empty()) return NoPicture("its format '" + image.format + "' cannot be read");
  return pixels;
}

template <class M>
Result<std::string> JpegOf(std::span<const std::byte> cdr, int width) {
  auto message = msg::Decode<M>(cdr);
  if (!message) return NoPicture("its message is malformed");
  auto pixels = Pixels(*message);
  if (!pixels) return pixels.error();
  cv::Mat picture = std::move(pixels).value();
  if (width > 0 && picture.cols > width) {
    const double scale = static_cast<double>(width) / picture.cols;
    cv::resize(picture, picture, {}, scale, scale, cv::INTER_AREA);
  }
  std::vector<std::uint8_t> jpeg;
  if (!cv::imencode(".jpg", picture, jpeg, {cv::IMWRITE_JPEG_QUALITY, kQuality})) {
    return NoPicture("it cannot be encoded as JPEG");
  }
  return std::string(jpeg.begin(), jpeg.end());
}

}  // namespace

bool IsPicture(std::string_view dds_type) {
  return dds_type == msg::Image::kTypeName || dds_type == msg::CompressedImage::kTypeName;
}

Result<std::string> JpegOf(std::string_view dds_type, std::span<const std::byte> cdr, int width) {
  try {
    return dds_type == msg::Image::kTypeName ? JpegOf<msg::Image>(cdr, width)
                                             : JpegOf<msg::CompressedImage>(cdr, width);
  } catch (const cv::Exception& e) {
    return NoPicture(e.what());
  }
}

}  // namespace musher::view
