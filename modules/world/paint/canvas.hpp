#pragma once
// A picture to draw on, in pixels from its upper left corner; all edges are anti-aliased.
//
// Threads: one at a time for each canvas.

#include <Eigen/Core>
#include <memory>
#include <string>
#include <vector>

#include "musher/base/result.hpp"
#include "musher/modules/world/paint/texture.hpp"
#include "musher/modules/world/scene/color.hpp"

namespace musher::world {

using Pixel = Eigen::Vector2d;

enum class Align { kLeft, kCenter, kRight };

class Canvas {
 public:
  Canvas(int width, int height, const Color& background);
  ~Canvas();

  void Line(const Pixel& from, const Pixel& to, const Color& color, double width = 1);
  // A line with round corners through all points.
  void Polyline(const std::vector<Pixel>& points, const Color& color, double width);
  void Fill(const std::vector<Pixel>& corners, const Color& color);
  void FillRect(const Pixel& corner, const Pixel& opposite, const Color& color);
  void Outline(const std::vector<Pixel>& corners, const Color& color, double width = 1);
  void Disc(const Pixel& center, double radius, const Color& color);
  void Ring(const Pixel& center, double radius, const Color& color, double width = 1);

  // `at`: the left end, middle or right end of the line the letters stand on. UTF-8.
  void Text(const std::string& text, const Pixel& at, double size, const Color& color,
            Align align = Align::kLeft);
  double TextWidth(const std::string& text, double size) const;

  // An ellipse that gets thinner outwards: all of it up to `solid` of the radius, nothing at its
  // end.
  void Glow(const Pixel& center, const Eigen::Vector2d& radii, const Color& color, double solid,
            double share = 1);
  // The picture as it is, for a surface.
  Texture ToTexture() const;

  // As PNG; the file is written completely or not at all.
  Result<> Save(const std::string& path) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace musher::world
