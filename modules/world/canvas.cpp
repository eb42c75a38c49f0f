#include "musher/modules/world/canvas.hpp"

#include <unistd.h>

#include <cmath>
#include <cstdio>
#include <fstream>
#include <opencv2/core.hpp>
#include <opencv2/freetype.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

namespace musher::world {
namespace {

constexpr int kFiner = 2;         // drawn so many times as large, then made smaller
constexpr int kFractionBits = 4;  // of a pixel, that OpenCV takes

// Where Debian's fonts-dejavu-core has it.
constexpr const char* kFont = "/usr/share/fonts/truetype/dejavu/DejaVuSans.ttf";

cv::Scalar Bgr(const Color& color) {
  return {double(color.blue), double(color.green), double(color.red)};
}

int Fine(double value) {
  return static_cast<int>(std::lround(value * kFiner * (1 << kFractionBits)));
}
cv::Point Fine(const Pixel& pixel) {
  return {Fine(pixel.x()), Fine(pixel.y())};
}
std::vector<cv::Point> Fine(const std::vector<Pixel>& pixels) {
  std::vector<cv::Point> points;
  points.reserve(pixels.size());
  for (const Pixel& pixel : pixels) points.push_back(Fine(pixel));
  return points;
}
int Width(double width) {
  return std::max(1, static_cast<int>(std::lround(width * kFiner)));
}

}  // namespace

struct Canvas::Impl {
  cv::Mat image;
  cv::Ptr<cv::freetype::FreeType2> font;  // null where the font is not installed
};

Canvas::Canvas(int width, int height, const Color& background) : impl_(new Impl) {
  impl_->image = cv::Mat(height * kFiner, width * kFiner, CV_8UC3, Bgr(background));
  if (access(kFont, R_OK) == 0) {
    impl_->font = cv::freetype::createFreeType2();
    impl_->font->loadFontData(kFont, 0);
  }
}

Canvas::~Canvas() = default;

void Canvas::Line(const Pixel& from, const Pixel& to, const Color& color, double width) {
  cv::line(impl_->image, Fine(from), Fine(to), Bgr(color), Width(width), cv::LINE_AA,
           kFractionBits);
}

void Canvas::Polyline(const std::vector<Pixel>& points, const Color& color, double width) {
  cv::polylines(impl_->image, Fine(points), false, Bgr(color), Width(width), cv::LINE_AA,
                kFractionBits);
}

void Canvas::Fill(const std::vector<Pixel>& corners, const Color& color) {
  cv::fillPoly(impl_->image, std::vector{Fine(corners)}, Bgr(color), cv::LINE_AA, kFractionBits);
}

void Canvas::FillRect(const Pixel& corner, const Pixel& opposite, const Color& color) {
  const auto whole = [](double value) { return static_cast<int>(std::lround(value * kFiner)); };
  const cv::Point a(whole(corner.x()), whole(corner.y()));
  const cv::Point b(whole(opposite.x()), whole(opposite.y()));
  const cv::Rect all({0, 0}, impl_->image.size());
  impl_->image(cv::Rect(a, b) & all).setTo(Bgr(color));
}

void Canvas::Outline(const std::vector<Pixel>& corners, const Color& color, double width) {
  cv::polylines(impl_->image, Fine(corners), true, Bgr(color), Width(width), cv::LINE_AA,
                kFractionBits);
}

void Canvas::Disc(const Pixel& center, double radius, const Color& color) {
  cv::circle(impl_->image, Fine(center), Fine(radius), Bgr(color), cv::FILLED, cv::LINE_AA,
             kFractionBits);
}

void Canvas::Ring(const Pixel& center, double radius, const Color& color, double width) {
  cv::circle(impl_->image, Fine(center), Fine(radius), Bgr(color), Width(width), cv::LINE_AA,
             kFractionBits);
}

void Canvas::Text(const std::string& text, const Pixel& at, double size, const Color& color,
                  Align align) {
  if (text.empty()) return;
  const double width = align == Align::kLeft ? 0 : TextWidth(text, size);
  const double left = at.x() - (align == Align::kCenter ? width / 2 : width);
  const cv::Point corner(static_cast<int>(std::lround(left * kFiner)),
                         static_cast<int>(std::lround(at.y() * kFiner)));
  const int height = static_cast<int>(std::lround(size * kFiner));
  if (impl_->font) {
    impl_->font->putText(impl_->image, text, corner, height, Bgr(color), cv::FILLED, cv::LINE_AA,
                         true);
  } else {
    cv::putText(impl_->image, text, corner, cv::FONT_HERSHEY_SIMPLEX,
                cv::getFontScaleFromHeight(cv::FONT_HERSHEY_SIMPLEX, height * 2 / 3), Bgr(color), 1,
                cv::LINE_AA);
  }
}

double Canvas::TextWidth(const std::string& text, double size) const {
  if (text.empty()) return 0;
  const int height = static_cast<int>(std::lround(size * kFiner));
  int baseline = 0;
  const cv::Size found =
      impl_->font
          ? impl_->font->getTextSize(text, height, cv::FILLED, &baseline)
          : cv::getTextSize(text, cv::FONT_HERSHEY_SIMPLEX,
                            cv::getFontScaleFromHeight(cv::FONT_HERSHEY_SIMPLEX, height * 2 / 3), 1,
                            &baseline);
  return static_cast<double>(found.width) / kFiner;
}

Result<> Canvas::Save(const std::string& path) const {
  cv::Mat small;
  cv::resize(impl_->image, small, {}, 1.0 / kFiner, 1.0 / kFiner, cv::INTER_AREA);
  std::vector<std::uint8_t> bytes;
  if (!cv::imencode(".png", small, bytes)) return Error{kCodeFailed, "PNG could not be encoded"};
  const std::string draft = path + ".part" + std::to_string(gettid());  // two may draw at once
  std::ofstream file(draft, std::ios::binary);
  file.write(reinterpret_cast<const char*>(bytes.data()),
             static_cast<std::streamsize>(bytes.size()));
  file.close();
  if (!file || std::rename(draft.c_str(), path.c_str()) != 0) {
    static_cast<void>(std::remove(draft.c_str()));
    return Error{kCodeFailed, path + " cannot be written"};
  }
  return Ok();
}

}  // namespace musher::world
