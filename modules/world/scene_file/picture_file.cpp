#include "musher/modules/world/scene_file/picture_file.hpp"

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <opencv2/imgcodecs.hpp>
#include <system_error>

namespace musher::world {
namespace {

constexpr std::uintmax_t kLargestFile = 64U << 20;

Error Bad(const std::string& why) {
  return {kCodeFailed, why};
}

}  // namespace

Result<> CheckPicture(const std::string& path) {
  std::error_code error;
  if (std::filesystem::is_directory(path, error)) return Bad("it is a folder");
  errno = 0;
  if (!std::ifstream(path, std::ios::binary)) {
    return Bad(errno != 0 ? std::strerror(errno) : "it cannot be opened");
  }
  if (std::filesystem::file_size(path, error) > kLargestFile && !error) {
    return Bad("it is larger than 64 MiB");
  }
  try {
    const cv::Mat image = cv::imread(path, cv::IMREAD_COLOR);
    if (image.empty()) return Bad("it is no picture that can be decoded");
    if (image.cols > kMostPicturePx || image.rows > kMostPicturePx) {
      return Bad("it has more than 8192 pixels on a side");
    }
  } catch (const std::exception& fault) {  // OpenCV's, out of memory
    return Bad("it is no picture that can be decoded");
  }
  return Ok();
}

}  // namespace musher::world
