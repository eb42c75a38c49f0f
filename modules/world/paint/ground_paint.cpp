#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <exception>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <string>
#include <vector>

#include "musher/modules/world/paint/mat_pictures.hpp"
#include "musher/modules/world/paint/palette.hpp"
#include "musher/modules/world/paint/surface_paint.hpp"

namespace musher::world {
namespace {

using Eigen::Rotation2Dd;
using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kMostTexels = 8e6;
constexpr int kGroundFractionBits = 4;
constexpr double kSoftEdgeM = 0.04;  // of shadows

using Points = std::vector<Vector2d>;

Points RoundOf(const Vector2d& center, double radius) {
  constexpr int kCorners = 32;
  Points points;
  for (int i = 0; i < kCorners; ++i) {
    const double angle = 2 * M_PI * i / kCorners;
    points.emplace_back(center + radius * Vector2d(std::cos(angle), std::sin(angle)));
  }
  return points;
}

Points CornersOf(const Vector2d& center, const Vector2d& half, double yaw_rad) {
  const Rotation2Dd turn(yaw_rad);
  Points points;
  for (const auto& [x, y] :
       {std::pair(1, 1), std::pair(-1, 1), std::pair(-1, -1), std::pair(1, -1)}) {
    points.emplace_back(center + turn * Vector2d(x * half.x(), y * half.y()));
  }
  return points;
}

class GroundPainter {
 public:
  explicit GroundPainter(const Scene& scene) : scene_(scene) {
    const Vector2d size = scene.most_m - scene.least_m;
    per_m_ = std::min(scene.ground.finest_per_m, std::sqrt(kMostTexels / size.prod()));
    const auto pixels = [&](double length_m) {
      return std::max(1, static_cast<int>(std::ceil(length_m * per_m_)));
    };
    image_ = Plain(pixels(size.y()), pixels(size.x()), scene.ground.color);
  }

  Result<Texture> Paint() {
    if (Result<> laid = Lay(); !laid) return laid.error();
    for (const Pad& pad : scene_.pads) PaintPad(pad);
    for (const Line& line : scene_.lines) PaintLine(line);
    if (scene_.light.shadows) Shade();
    return TextureOf(image_);
  }

 private:
  cv::Point Fine(const Vector2d& point_m) const {
    const Vector2d pixel = (point_m - scene_.least_m) * per_m_ - Vector2d(0.5, 0.5);
    const auto fine = [](double value) {
      return static_cast<int>(std::lround(value * (1 << kGroundFractionBits)));
    };
    return {fine(pixel.x()), fine(pixel.y())};
  }
  std::vector<cv::Point> Fine(const Points& points_m) const {
    std::vector<cv::Point> points;
    points.reserve(points_m.size());
    for (const Vector2d& point : points_m) points.push_back(Fine(point));
    return points;
  }
  void Fill(const Points& corners_m, const Color& color) {
    cv::fillConvexPoly(image_, Fine(corners_m), Bgr<cv::Scalar>(color), cv::LINE_AA,
                       kGroundFractionBits);
  }

  Result<> Lay() {
    switch (scene_.ground.texture) {
      case Ground::Texture::kPlain:
        break;
      case Ground::Texture::kChecker:
        LayChecker();
        break;
      case Ground::Texture::kGrass:
        LayGrass();
        break;
      case Ground::Texture::kPicture:
        return LayPicture();
    }
    return Ok();
  }

  void LayChecker() {
    const double tile = scene_.ground.tile_m;
    const Eigen::Array2i first = (scene_.least_m / tile).array().floor().cast<int>();
    const Eigen::Array2i last = (scene_.most_m / tile).array().ceil().cast<int>();
    const Eigen::Array2d tiles = (last - first).cast<double>();
    if (tiles.prod() > kMostTexels) return;  // finer than can be painted
    for (int y = first.y(); y < last.y(); ++y) {
      for (int x = first.x(); x < last.x(); ++x) {
        if ((x + y) % 2 == 0) continue;
        const Vector2d middle = Vector2d(x + 0.5, y + 0.5) * tile;
        Fill(CornersOf(middle, Vector2d::Constant(tile / 2), 0), scene_.ground.other_color);
      }
    }
  }

  // Patches of many sizes between the two colours, and lighter and darker blades over them.
  void LayGrass() {
    cv::Mat share(image_.size(), CV_32F, cv::Scalar(0));
    cv::RNG random(scene_.seed + 1);
    for (const auto& [patch_m, strength] :
         {std::pair(1.6, 0.16), std::pair(0.3, 0.12), std::pair(0.06, 0.16), std::pair(0.012, 0.3),
          std::pair(0.0, 0.2)}) {
      const double cell = std::max(1.0, patch_m * per_m_);
      const auto cells = [cell](int length) { return static_cast<int>(length / cell) + 2; };
      cv::Mat coarse(cells(image_.rows), cells(image_.cols), CV_32F);
      random.fill(coarse, cv::RNG::NORMAL, 0.0, strength);
      cv::Mat full;
      cv::resize(coarse, full, image_.size(), 0, 0, cv::INTER_CUBIC);
      share += full;
    }
    // From one colour to the other in steps that fit a table.
    cv::Mat steps;
    share.convertTo(steps, CV_8U, 255, 127.5);
    cv::Mat mixed(1, 256, CV_8UC3);
    for (int i = 0; i < 256; ++i) {
      const Color color = Mix(scene_.ground.color, scene_.ground.other_color, i / 255.0);
      mixed.at<cv::Vec3b>(i) = {color.blue, color.green, color.red};
    }
    cv::cvtColor(steps, image_, cv::COLOR_GRAY2BGR);
    cv::LUT(image_, mixed, image_);
  }

  Result<> LayPicture() {
    const Ground& ground = scene_.ground;
    cv::Mat picture = cv::imread(ground.file, cv::IMREAD_COLOR);
    if (picture.empty()) {
      return Error{kCodeFailed, "the picture " + ground.file + " does not exist any more"};
    }
    cv::flip(picture, picture, 0);  // its upper edge lies along the larger y
    Vector2d least = ground.least_m;
    Vector2d most = ground.most_m;
    if (!ground.once) {
      least = scene_.least_m;
      most = least + Vector2d(ground.tile_m, ground.tile_m * picture.rows / picture.cols);
    }
    const cv::Size size(PixelsOf(most.x() - least.x()), PixelsOf(most.y() - least.y()));
    constexpr double kMostTile = 4 * kMostTexels;
    if (double(size.width) * size.height > kMostTile) {
      return Error{kCodeFailed, "the picture " + ground.file +
                                    " is laid out much larger than the "
                                    "place"};
    }
    cv::resize(picture, picture, size, 0, 0, cv::INTER_AREA);
    const cv::Rect all({0, 0}, image_.size());
    const cv::Point first(PixelsFrom(least.x() - scene_.least_m.x()),
                          PixelsFrom(least.y() - scene_.least_m.y()));
    for (int y = first.y; y < all.height; y += size.height) {
      for (int x = first.x; x < all.width; x += size.width) {
        const cv::Rect here = cv::Rect({x, y}, size) & all;
        if (!here.empty()) picture(here - cv::Point(x, y)).copyTo(image_(here));
        if (ground.once) return Ok();
      }
    }
    return Ok();
  }
  int PixelsOf(double length_m) const { return std::max(1, PixelsFrom(length_m)); }
  int PixelsFrom(double length_m) const { return static_cast<int>(std::lround(length_m * per_m_)); }

  void PaintPad(const Pad& pad) {
    const Vector2d half = Vector2d::Constant(pad.size_m / 2);
    Fill(CornersOf(pad.center_m, half, 0), kPadEdge);
    Fill(CornersOf(pad.center_m, half * 0.9, 0), kPad);
    Points bolt;
    for (const auto& [x, y] : {std::pair(0.2, 1.2), std::pair(-0.7, -0.2), std::pair(-0.1, -0.2),
                               std::pair(-0.2, -1.2), std::pair(0.7, 0.2), std::pair(0.1, 0.2)}) {
      bolt.emplace_back(pad.center_m + Vector2d(x, y) * pad.size_m / 4);
    }
    cv::fillPoly(image_, std::vector{Fine(bolt)}, Bgr<cv::Scalar>(kPadEdge), cv::LINE_AA,
                 kGroundFractionBits);
  }

  // Each piece a rectangle, and a disc at each point, so that the width is right at every scale.
  void PaintLine(const Line& line) {
    const double radius = line.width_m / 2;
    for (std::size_t i = 0; i + 1 < line.points_m.size(); ++i) {
      const Vector2d along = line.points_m[i + 1] - line.points_m[i];
      const Vector2d middle = (line.points_m[i] + line.points_m[i + 1]) / 2;
      Fill(CornersOf(middle, {along.norm() / 2, radius}, std::atan2(along.y(), along.x())),
           line.color);
      if (i > 0) Fill(RoundOf(line.points_m[i], radius), line.color);
    }
    const bool closed = line.points_m.size() > 2 && line.points_m.front() == line.points_m.back();
    if (closed) Fill(RoundOf(line.points_m.front(), radius), line.color);
  }

  // The mask has a quarter of the ground's resolution: the edges of shadows are soft.
  void Shade() {
    constexpr int kCoarser = 4;
    cv::Mat mask(image_.rows / kCoarser + 1, image_.cols / kCoarser + 1, CV_8U, cv::Scalar(0));
    const double per_m = per_m_;
    per_m_ /= kCoarser;
    for (const Box& box : scene_.boxes) {
      Cast(CornersOf(box.center_m, box.half_m, box.yaw_rad), box.bottom_m, box.height_m, mask);
    }
    for (const Circle& circle : scene_.circles) {
      Cast(RoundOf(circle.center_m, circle.radius_m), circle.bottom_m, circle.height_m, mask);
    }
    for (const Board& board : scene_.boards) {
      if (board.round) {
        CastRound(board, mask);
        continue;
      }
      Cast(CornersOf(board.center_m, {0.005, board.width_m / 2}, board.yaw_rad), board.bottom_m,
           board.height_m, mask);
    }
    for (const Ball& ball : scene_.balls) {
      if (ball.name.empty()) CastOf(ball, mask);
    }
    CastFence(mask);
    cv::blur(mask, mask, cv::Size(1, 1) * (2 * PixelsFrom(kSoftEdgeM) + 1));
    per_m_ = per_m;
    cv::Mat full;
    cv::resize(mask, full, mask.size() * kCoarser, 0, 0, cv::INTER_LINEAR);
    // The light that is left, in 255ths.
    const double missing = 1 - LightInShadow(scene_.light);
    full.convertTo(full, CV_8U, -missing, 255);
    Darken(full(cv::Rect({0, 0}, image_.size())));
  }

  // By the light that is left, in 255ths. In most of a place that is all of it.
  void Darken(const cv::Mat& left) {
    constexpr int kTile = 128;
    for (int y = 0; y < left.rows; y += kTile) {
      for (int x = 0; x < left.cols; x += kTile) {
        const cv::Rect tile = cv::Rect(x, y, kTile, kTile) & cv::Rect({0, 0}, left.size());
        double least = 0;
        cv::minMaxLoc(left(tile), &least);
        if (least == 255) continue;
        cv::Mat each, part = image_(tile);
        cv::cvtColor(left(tile), each, cv::COLOR_GRAY2BGR);
        cv::multiply(part, each, part, 1 / 255.0);
      }
    }
  }

  // An object from `bottom_m` on: its outline there, its outline above, and all between.
  void Cast(const Points& outline_m, double bottom_m, double height_m, cv::Mat& mask) const {
    Points all;
    for (const Vector2d& point : outline_m) {
      all.push_back(point + ShadowOffset(bottom_m));
      all.push_back(point + ShadowOffset(bottom_m + height_m));
    }
    FillHull(all, mask);
  }
  void CastRound(const Board& board, cv::Mat& mask) const {
    const Vector2d across = Rotation2Dd(board.yaw_rad) * Vector2d(0, board.width_m / 2);
    Points all;
    for (const Vector2d& on_unit : RoundOf({0, 0}, 1)) {
      const double height = board.bottom_m + board.height_m / 2 * (1 + on_unit.y());
      all.push_back(board.center_m + across * on_unit.x() + ShadowOffset(height));
    }
    FillHull(all, mask);
  }
  void CastOf(const Ball& ball, cv::Mat& mask) const {
    const double height = scene_.light.height_rad;
    const Rotation2Dd turn(scene_.light.yaw_rad);
    Points all = RoundOf({0, 0}, ball.radius_m);
    for (Vector2d& point : all) {
      point = ball.center_m.head<2>() + ShadowOffset(ball.center_m.z()) +
              turn * Vector2d(point.x() / std::sin(height), point.y());
    }
    FillHull(all, mask);
  }
  void CastFence(cv::Mat& mask) const {
    const Points corners =
        CornersOf((scene_.least_m + scene_.most_m) / 2, (scene_.most_m - scene_.least_m) / 2, 0);
    for (std::size_t i = 0; i < corners.size(); ++i) {
      Cast({corners[i], corners[(i + 1) % corners.size()]}, 0, scene_.fence_height_m, mask);
    }
  }
  void FillHull(const Points& points_m, cv::Mat& mask) const {
    std::vector<cv::Point> hull;
    cv::convexHull(Fine(points_m), hull);
    cv::fillConvexPoly(mask, hull, cv::Scalar(255), cv::LINE_AA, kGroundFractionBits);
  }
  // Of the shadow of a point at that height.
  Vector2d ShadowOffset(double height_m) const {
    const Vector3d light = TowardsLight(scene_.light);
    return -light.head<2>() / light.z() * height_m;
  }

  const Scene& scene_;
  double per_m_ = 1;  // texels in a metre
  cv::Mat image_;
};

}  // namespace

Vector3d TowardsLight(const Lighting& light) {
  const double across = std::cos(light.height_rad);
  return {across * std::cos(light.yaw_rad), across * std::sin(light.yaw_rad),
          std::sin(light.height_rad)};
}

double LightInShadow(const Lighting& light) {
  const double half = 0.5 + 0.5 * std::sin(light.height_rad);
  const double direct = (1 - light.ambient) * half * half;
  return light.ambient + direct > 0 ? light.ambient / (light.ambient + direct) : 1;
}

Result<Texture> PaintGround(const Scene& scene) {
  try {
    return GroundPainter(scene).Paint();
  } catch (const std::exception& error) {  // OpenCV's, out of memory
    return Error{kCodeFailed, std::string("the ground cannot be painted: ") + error.what()};
  }
}

}  // namespace musher::world
