#include <algorithm>
#include <cmath>
#include <exception>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <opencv2/objdetect.hpp>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "musher/modules/world/paint/canvas.hpp"
#include "musher/modules/world/paint/face.hpp"
#include "musher/modules/world/paint/mat_pictures.hpp"
#include "musher/modules/world/paint/surface_paint.hpp"

namespace musher::world {
namespace {

constexpr double kLongSidePx = 512;

struct Sheet {
  explicit Sheet(const Board& board) {
    const double scale = kLongSidePx / std::max(board.width_m, board.height_m);
    width = std::max(8.0, std::round(board.width_m * scale));
    height = std::max(8.0, std::round(board.height_m * scale));
  }
  cv::Size size() const { return {static_cast<int>(width), static_cast<int>(height)}; }

  double width = 0;
  double height = 0;
};

// A code in the middle, with the white rim of four squares that readers need around it.
Texture Code(const Board& board) {
  constexpr int kEncodersRim = 2;
  constexpr int kRim = 4;
  cv::Mat squares;
  cv::QRCodeEncoder::create()->encode(board.sign.content, squares);
  const cv::Rect inner(kEncodersRim, kEncodersRim, squares.cols - 2 * kEncodersRim,
                       squares.rows - 2 * kEncodersRim);
  const Sheet sheet(board);
  const int across = inner.width + 2 * kRim;
  const int side = std::max(1, static_cast<int>(std::min(sheet.width, sheet.height)) / across);
  cv::Mat code;
  cv::resize(squares(inner), code, {}, side, side, cv::INTER_NEAREST);
  // Smaller boards than squares: the sheet grows with the code.
  const int rim = kRim * side;
  const int width = std::max(sheet.size().width, code.cols + 2 * rim);
  const int height = std::max(sheet.size().height, code.rows + 2 * rim);
  cv::Mat image = Plain(height, width, board.color);
  const cv::Rect where((width - code.cols) / 2, (height - code.rows) / 2, code.cols, code.rows);
  image(where).setTo(Bgr<cv::Scalar>(board.sign.ink), code < 128);
  return TextureOf(image);
}

// As large as the board permits.
Texture Text(const Board& board) {
  const Sheet sheet(board);
  Canvas canvas(sheet.size().width, sheet.size().height, board.color);
  std::vector<std::string> lines;
  std::istringstream text(board.sign.content);
  for (std::string line; std::getline(text, line);) lines.push_back(line);
  constexpr double kProbe = 100;
  double widest = 1;
  for (const std::string& line : lines) widest = std::max(widest, canvas.TextWidth(line, kProbe));
  constexpr double kRow = 1.3;  // from line to line, in sizes of letters
  const auto rows = static_cast<double>(lines.size());
  const double size =
      std::min(0.88 * sheet.width / widest * kProbe, 0.86 * sheet.height / (1 + kRow * (rows - 1)));
  constexpr double kMiddle = 0.36;  // of a letter over the line it stands on
  double y = sheet.height / 2 - kRow * size * (rows - 1) / 2 + kMiddle * size;
  for (const std::string& line : lines) {
    canvas.Text(line, {sheet.width / 2, y}, size, board.sign.ink, Align::kCenter);
    y += kRow * size;
  }
  return canvas.ToTexture();
}

// A bold one, from edge to edge.
Texture Arrow(const Board& board) {
  const Sheet sheet(board);
  Canvas canvas(sheet.size().width, sheet.size().height, board.color);
  const double unit = std::min(sheet.width / 1.5, sheet.height);
  const double way = board.sign.content == "left" ? -unit : unit;
  const Pixel middle(sheet.width / 2, sheet.height / 2);
  std::vector<Pixel> corners;
  for (const auto& [along, across] :
       {std::pair(0.64, 0.0), std::pair(0.04, 0.42), std::pair(0.04, 0.17), std::pair(-0.6, 0.17),
        std::pair(-0.6, -0.17), std::pair(0.04, -0.17), std::pair(0.04, -0.42)}) {
    corners.emplace_back(middle + Pixel(along * way, across * unit));
  }
  canvas.Fill(corners, board.sign.ink);
  return canvas.ToTexture();
}

Texture Face(const Board& board) {
  const Sheet sheet(board);
  Canvas canvas(sheet.size().width, sheet.size().height, board.color);
  DrawFace(board.sign.face, sheet.width, sheet.height, canvas);
  return canvas.ToTexture();
}

Result<Texture> Picture(const Board& board) {
  cv::Mat image = cv::imread(board.sign.content, cv::IMREAD_COLOR);
  if (image.empty()) {
    return Error{kCodeFailed, "the picture " + board.sign.content + " does not exist any more"};
  }
  constexpr double kMostPx = 1024;
  const double scale = kMostPx / std::max(image.cols, image.rows);
  if (scale < 1) cv::resize(image, image, {}, scale, scale, cv::INTER_AREA);
  return TextureOf(image);
}

Result<Texture> Paint(const Board& board) {
  switch (board.sign.kind) {
    case Sign::Kind::kPlain:
      break;
    case Sign::Kind::kPicture:
      return Picture(board);
    case Sign::Kind::kQr:
      return Code(board);
    case Sign::Kind::kText:
      return Text(board);
    case Sign::Kind::kFace:
      return Face(board);
    case Sign::Kind::kArrow:
      return Arrow(board);
  }
  return TextureOf(Plain(1, 1, board.color));
}

}  // namespace

Result<Texture> PaintHead(int face) {
  constexpr int kWidthPx = 256;
  constexpr int kHeightPx = 366;
  try {
    Canvas canvas(kWidthPx, kHeightPx, HairOf(face));
    DrawHead(face, kWidthPx, kHeightPx, canvas);
    return canvas.ToTexture();
  } catch (const std::exception& error) {
    return Error{kCodeFailed, std::string("a guest cannot be painted: ") + error.what()};
  }
}

Result<Texture> PaintSign(const Board& board) {
  try {
    return Paint(board);
  } catch (const std::exception& error) {  // OpenCV's, out of memory
    return Error{kCodeFailed, std::string("a board cannot be painted: ") + error.what()};
  }
}

}  // namespace musher::world
