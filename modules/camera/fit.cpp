#include "musher/modules/camera/fit.hpp"

#include <map>
#include <opencv2/imgproc.hpp>
#include <string>
#include <utility>

#include "musher/modules/camera/camera_code.hpp"

namespace musher::camera {
namespace {

constexpr std::int32_t kUnreadable = CameraCode(KeyCode::kParametersInvalid);

int ChannelsOf(const std::string& encoding) {
  if (encoding == "mono8") return 1;
  if (encoding == "bgr8" || encoding == "rgb8") return 3;
  if (encoding == "bgra8" || encoding == "rgba8") return 4;
  return 0;
}

// OpenCV's code for a conversion of encodings; nothing: not supported.
std::optional<int> Conversion(const std::string& from, const std::string& to) {
  static const std::map<std::pair<std::string, std::string>, int> conversions = {
      {{"bgr8", "rgb8"}, cv::COLOR_BGR2RGB},     {{"bgr8", "mono8"}, cv::COLOR_BGR2GRAY},
      {{"rgb8", "bgr8"}, cv::COLOR_RGB2BGR},     {{"rgb8", "mono8"}, cv::COLOR_RGB2GRAY},
      {{"mono8", "bgr8"}, cv::COLOR_GRAY2BGR},   {{"mono8", "rgb8"}, cv::COLOR_GRAY2RGB},
      {{"bgra8", "bgr8"}, cv::COLOR_BGRA2BGR},   {{"bgra8", "rgb8"}, cv::COLOR_BGRA2RGB},
      {{"bgra8", "mono8"}, cv::COLOR_BGRA2GRAY}, {{"rgba8", "rgb8"}, cv::COLOR_RGBA2RGB},
      {{"rgba8", "bgr8"}, cv::COLOR_RGBA2BGR},   {{"rgba8", "mono8"}, cv::COLOR_RGBA2GRAY}};
  const auto found = conversions.find({from, to});
  if (found == conversions.end()) return std::nullopt;
  return found->second;
}

// A cv::Mat over the picture's own bytes.
cv::Mat View(msg::Image& picture) {
  return {static_cast<int>(picture.height), static_cast<int>(picture.width),
          CV_MAKETYPE(CV_8U, ChannelsOf(picture.encoding)), picture.data.data(), picture.step};
}

// A picture of that size and encoding, whose bytes are still to be written.
msg::Image BlankImage(const msg::Image& like, std::uint32_t width_px, std::uint32_t height_px,
                      const std::string& encoding) {
  msg::Image room;
  room.header = like.header;
  room.width = width_px;
  room.height = height_px;
  room.encoding = encoding;
  room.step = width_px * static_cast<std::uint32_t>(ChannelsOf(encoding));
  room.data.resize(std::size_t{room.step} * height_px);
  return room;
}

}  // namespace

Result<> CheckPicture(const msg::Image& picture) {
  const int channels = ChannelsOf(picture.encoding);
  if (channels == 0) {
    return Error{kUnreadable, "a picture of encoding \"" + picture.encoding.substr(0, 32) +
                                  "\", which is not supported"};
  }
  const bool fits = picture.width > 0 && picture.height > 0 &&
                    picture.width <= picture.step / static_cast<std::uint32_t>(channels) &&
                    picture.data.size() / picture.step >= picture.height;
  if (!fits) {
    return Error{kUnreadable, "a picture of " + std::to_string(picture.width) + "x" +
                                  std::to_string(picture.height) + " with " +
                                  std::to_string(picture.data.size()) + " bytes"};
  }
  return Ok();
}

Result<msg::Image> Fit(msg::Image picture, const Format& format) {
  if (Result<> good = CheckPicture(picture); !good) return good.error();
  const std::uint32_t width = format.width_px == 0 ? picture.width : format.width_px;
  const std::uint32_t height = format.height_px == 0 ? picture.height : format.height_px;
  const std::string encoding = format.encoding.empty() ? picture.encoding : format.encoding;
  if (encoding != picture.encoding) {
    const auto conversion = Conversion(picture.encoding, encoding);
    if (!conversion) {
      return Error{kUnreadable, "cannot convert " + picture.encoding + " to " + encoding};
    }
    msg::Image converted = BlankImage(picture, picture.width, picture.height, encoding);
    cv::cvtColor(View(picture), View(converted), *conversion);
    picture = std::move(converted);
  }
  if (width == picture.width && height == picture.height) return picture;
  msg::Image resized = BlankImage(picture, width, height, encoding);
  const bool smaller = width <= picture.width && height <= picture.height;
  const cv::Mat target = View(resized);
  cv::resize(View(picture), target, target.size(), 0, 0,
             smaller ? cv::INTER_AREA : cv::INTER_LINEAR);
  return resized;
}

}  // namespace musher::camera
