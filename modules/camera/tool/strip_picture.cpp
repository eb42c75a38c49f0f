#include "musher/modules/camera/tool/strip_picture.hpp"

#include <algorithm>
#include <opencv2/imgproc.hpp>
#include <utility>

#include "musher/base/decimal.hpp"
#include "musher/modules/camera/fit.hpp"
#include "musher/modules/camera/tool/commands.hpp"

namespace musher::camera::tool {
namespace {

constexpr int kGapPx = 4;
constexpr int kLabelPx = 22;
constexpr std::int64_t kLongestWorldNs =
    1'000'000'000'000'000;  // eleven days; a later stamp is a date

// bgr8, white.
msg::Image Blank(int width, int height) {
  msg::Image blank;
  blank.width = static_cast<std::uint32_t>(width);
  blank.height = static_cast<std::uint32_t>(height);
  blank.encoding = "bgr8";
  blank.step = blank.width * 3;
  blank.data.assign(std::size_t{blank.step} * blank.height, 255);
  return blank;
}

cv::Mat View(const msg::Image& picture) {
  return {static_cast<int>(picture.height), static_cast<int>(picture.width), CV_8UC3,
          const_cast<std::uint8_t*>(picture.data.data()), picture.step};
}

}  // namespace

Result<msg::Image> TileOf(msg::Image picture, std::uint32_t width_px) {
  if (Result<> good = CheckPicture(picture); !good) return good.error();
  const std::uint64_t height = std::uint64_t{picture.height} * width_px / picture.width;
  const auto height_px = static_cast<std::uint32_t>(std::clamp<std::uint64_t>(height, 1, 4096));
  return Fit(std::move(picture), {width_px, height_px, "bgr8"});
}

msg::Image SideBySide(const std::vector<std::optional<msg::Image>>& tiles) {
  if (tiles.size() == 1 && tiles.front()) return *tiles.front();
  int width = 0;
  int height = 0;
  for (const auto& tile : tiles) {
    if (!tile) continue;
    width = std::max(width, static_cast<int>(tile->width));
    height = std::max(height, static_cast<int>(tile->height));
  }
  const int count = static_cast<int>(tiles.size());
  msg::Image row = Blank(count * (width + kGapPx) - kGapPx, height);
  cv::Mat all = View(row);
  for (int i = 0; i < count; ++i) {
    const auto& tile = tiles[static_cast<std::size_t>(i)];
    if (!tile) continue;
    const cv::Mat picture = View(*tile);
    picture.copyTo(all(cv::Rect(i * (width + kGapPx), 0, picture.cols, picture.rows)));
  }
  return row;
}

msg::Image DrawStrip(const std::vector<StripTile>& tiles, int columns) {
  if (tiles.empty()) return {};
  int width = 0;
  int height = 0;
  for (const StripTile& tile : tiles) {
    width = std::max(width, static_cast<int>(tile.picture.width));
    height = std::max(height, static_cast<int>(tile.picture.height));
  }
  columns = std::clamp(columns, 1, static_cast<int>(tiles.size()));
  const int rows = (static_cast<int>(tiles.size()) + columns - 1) / columns;
  const int cell_width = width + kGapPx;
  const int cell_height = height + kLabelPx + kGapPx;
  msg::Image strip = Blank(columns * cell_width + kGapPx, rows * cell_height + kGapPx);
  cv::Mat all = View(strip);
  for (std::size_t i = 0; i < tiles.size(); ++i) {
    const int x = kGapPx + static_cast<int>(i) % columns * cell_width;
    const int y = kGapPx + static_cast<int>(i) / columns * cell_height;
    const cv::Mat tile = View(tiles[i].picture);
    tile.copyTo(all(cv::Rect(x, y, tile.cols, tile.rows)));
    cv::putText(all, tiles[i].label, {x + 2, y + height + kLabelPx - 6}, cv::FONT_HERSHEY_SIMPLEX,
                0.5, {60, 60, 60}, 1, cv::LINE_AA);
  }
  return strip;
}

std::string LabelOf(std::int64_t stamp_ns, std::int64_t first_ns) {
  if (stamp_ns < kLongestWorldNs) return Decimal(static_cast<double>(stamp_ns) / 1e9, 1) + " s";
  return "+" + Decimal(static_cast<double>(stamp_ns - first_ns) / 1e9, 1) + " s";
}

}  // namespace musher::camera::tool
