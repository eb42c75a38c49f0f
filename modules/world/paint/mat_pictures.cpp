#include "musher/modules/world/paint/mat_pictures.hpp"

#include <unistd.h>

#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <string_view>
#include <utility>

#include "musher/base/check.hpp"
#include "musher/base/files.hpp"

namespace musher::world {

cv::Mat Plain(int rows, int cols, const Color& color) {
  cv::Mat image(rows, cols, CV_8UC3);
  image.setTo(cv::Scalar(color.blue, color.green, color.red));
  return image;
}

Texture TextureOf(const cv::Mat& image) {
  MUSHER_CHECK(image.type() == CV_8UC3);
  std::vector<Texel> texels(image.total());
  for (int y = 0; y < image.rows; ++y) {
    const std::uint8_t* bgr = image.ptr(y);
    Texel* row = &texels[static_cast<std::size_t>(y) * static_cast<std::size_t>(image.cols)];
    for (int x = 0; x < image.cols; ++x, bgr += 3) {
      row[x] = Texel{bgr[0]} | Texel{bgr[1]} << 8 | Texel{bgr[2]} << 16;
    }
  }
  return {image.cols, image.rows, std::move(texels)};
}

Result<> SavePng(const cv::Mat& image, const std::string& path) {
  std::vector<std::uint8_t> bytes;
  if (!cv::imencode(".png", image, bytes)) return Error{kCodeFailed, "PNG could not be encoded"};
  const std::string_view content(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  const std::string draft = ".part" + std::to_string(gettid());  // two may draw at once
  return ReplaceFile(path, content, {.synced = false, .draft = draft});
}

}  // namespace musher::world
