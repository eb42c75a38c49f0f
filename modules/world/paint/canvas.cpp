#include "musher/modules/world/paint/canvas.hpp"

#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>
#include <opencv2/freetype.hpp>
#include <opencv2/imgproc.hpp>

#include "musher/modules/world/paint/mat_pictures.hpp"

namespace musher::world {
namespace {

constexpr int kFiner = 2;         // oversampling factor
constexpr int kFractionBits = 4;  // of a pixel, that OpenCV takes

// Paths of Debian's fonts-dejavu-core and fonts-wqy-microhei. The second is for letters that the
// first lacks.
constexpr const char* kFont = "/usr/share/fonts/truetype/dejavu/DejaVuSans.ttf";
constexpr const char* kEastAsianFont = "/usr/share/fonts/truetype/wqy/wqy-microhei.ttc";

using Font = cv::Ptr<cv::freetype::FreeType2>;

// Null if it is not installed.
Font Load(const char* path) {
  if (access(path, R_OK) != 0) return {};
  Font font = cv::freetype::createFreeType2();
  font->loadFontData(path, 0);
  return font;
}

// Whether it has letters from U+2E80 on, which three bytes of UTF-8 begin with 0xE2 0xBA or more.
bool IsEastAsian(const std::string& text) {
  for (std::size_t i = 0; i + 1 < text.size(); ++i) {
    const auto lead = static_cast<unsigned char>(text[i]);
    const auto next = static_cast<unsigned char>(text[i + 1]);
    if ((lead == 0xE2 && next >= 0xBA) || (lead >= 0xE3 && lead < 0xF0)) return true;
  }
  return false;
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
  Font font = Load(kFont);
  Font east_asian = Load(kEastAsianFont);

  cv::Mat Reduced() const;  // to the requested size

  const Font& For(const std::string& text) const {
    return east_asian && IsEastAsian(text) ? east_asian : font;
  }
};

Canvas::Canvas(int width, int height, const Color& background) : impl_(new Impl) {
  impl_->image = Plain(height * kFiner, width * kFiner, background);
}

Canvas::~Canvas() = default;

void Canvas::Line(const Pixel& from, const Pixel& to, const Color& color, double width) {
  cv::line(impl_->image, Fine(from), Fine(to), Bgr<cv::Scalar>(color), Width(width), cv::LINE_AA,
           kFractionBits);
}

void Canvas::Polyline(const std::vector<Pixel>& points, const Color& color, double width) {
  cv::polylines(impl_->image, Fine(points), false, Bgr<cv::Scalar>(color), Width(width),
                cv::LINE_AA, kFractionBits);
}

void Canvas::Fill(const std::vector<Pixel>& corners, const Color& color) {
  cv::fillPoly(impl_->image, std::vector{Fine(corners)}, Bgr<cv::Scalar>(color), cv::LINE_AA,
               kFractionBits);
}

void Canvas::FillRect(const Pixel& corner, const Pixel& opposite, const Color& color) {
  const auto whole = [](double value) { return static_cast<int>(std::lround(value * kFiner)); };
  const cv::Point a(whole(corner.x()), whole(corner.y()));
  const cv::Point b(whole(opposite.x()), whole(opposite.y()));
  const cv::Rect all({0, 0}, impl_->image.size());
  impl_->image(cv::Rect(a, b) & all).setTo(Bgr<cv::Scalar>(color));
}

void Canvas::Outline(const std::vector<Pixel>& corners, const Color& color, double width) {
  cv::polylines(impl_->image, Fine(corners), true, Bgr<cv::Scalar>(color), Width(width),
                cv::LINE_AA, kFractionBits);
}

void Canvas::Disc(const Pixel& center, double radius, const Color& color) {
  cv::circle(impl_->image, Fine(center), Fine(radius), Bgr<cv::Scalar>(color), cv::FILLED,
             cv::LINE_AA, kFractionBits);
}

void Canvas::Ring(const Pixel& center, double radius, const Color& color, double width) {
  cv::circle(impl_->image, Fine(center), Fine(radius), Bgr<cv::Scalar>(color), Width(width),
             cv::LINE_AA, kFractionBits);
}

void Canvas::Text(const std::string& text, const Pixel& at, double size, const Color& color,
                  Align align) {
  if (text.empty()) return;
  const double width = align == Align::kLeft ? 0 : TextWidth(text, size);
  const double left = at.x() - (align == Align::kCenter ? width / 2 : width);
  const cv::Point corner(static_cast<int>(std::lround(left * kFiner)),
                         static_cast<int>(std::lround(at.y() * kFiner)));
  const int height = static_cast<int>(std::lround(size * kFiner));
  if (const Font& font = impl_->For(text)) {
    font->putText(impl_->image, text, corner, height, Bgr<cv::Scalar>(color), cv::FILLED,
                  cv::LINE_AA, true);
  } else {
    cv::putText(impl_->image, text, corner, cv::FONT_HERSHEY_SIMPLEX,
                cv::getFontScaleFromHeight(cv::FONT_HERSHEY_SIMPLEX, height * 2 / 3),
                Bgr<cv::Scalar>(color), 1, cv::LINE_AA);
  }
}

double Canvas::TextWidth(const std::string& text, double size) const {
  if (text.empty()) return 0;
  const int height = static_cast<int>(std::lround(size * kFiner));
  int baseline = 0;
  const Font& font = impl_->For(text);
  const cv::Size found =
      font ? font->getTextSize(text, height, cv::FILLED, &baseline)
           : cv::getTextSize(text, cv::FONT_HERSHEY_SIMPLEX,
                             cv::getFontScaleFromHeight(cv::FONT_HERSHEY_SIMPLEX, height * 2 / 3),
                             1, &baseline);
  return static_cast<double>(found.width) / kFiner;
}

void Canvas::Glow(const Pixel& center, const Eigen::Vector2d& radii, const Color& color,
                  double solid, double share) {
  const Pixel middle = center * kFiner;
  const Eigen::Vector2d reach = radii * kFiner;
  const auto whole = [](double value) { return static_cast<int>(std::lround(value)); };
  const cv::Rect area =
      cv::Rect(cv::Point(whole(middle.x() - reach.x()), whole(middle.y() - reach.y())),
               cv::Point(whole(middle.x() + reach.x()) + 1, whole(middle.y() + reach.y()) + 1)) &
      cv::Rect({0, 0}, impl_->image.size());
  const double rim = std::max(1 - solid, 0.02);
  for (int y = area.y; y < area.br().y; ++y) {
    const double up = (y - middle.y()) / reach.y();
    for (int x = area.x; x < area.br().x; ++x) {
      const double along = (x - middle.x()) / reach.x();
      const double far = std::sqrt(along * along + up * up);
      if (far >= 1) continue;
      const double part = share * std::min((1 - far) / rim, 1.0);
      auto& pixel = impl_->image.at<cv::Vec3b>(y, x);
      const Color mixed = part == 1 ? color : Mix({pixel[2], pixel[1], pixel[0]}, color, part);
      pixel = {mixed.blue, mixed.green, mixed.red};
    }
  }
}

cv::Mat Canvas::Impl::Reduced() const {
  cv::Mat small;
  cv::resize(image, small, {}, 1.0 / kFiner, 1.0 / kFiner, cv::INTER_AREA);
  return small;
}

Texture Canvas::ToTexture() const {
  return TextureOf(impl_->Reduced());
}

Result<> Canvas::Save(const std::string& path) const {
  return SavePng(impl_->Reduced(), path);
}

}  // namespace musher::world
