#include "musher/test/modules/race/drive/hall_painter.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <opencv2/imgproc.hpp>
#include <opencv2/objdetect.hpp>
#include <string>

namespace musher::race::testing {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using vision::things::Corners;
using vision::things::Face;

constexpr int kWidth = 640, kHeight = 480;
constexpr double kFloorPxPerM = 200, kWallPxPerM = 100;
constexpr double kWallHighM = 3.2, kWallLongM = 12;
const cv::Scalar kTape(0.03, 0.52, 0.83);
const Corners kArrow{{.12, .4}, {.55, .4}, {.55, .18}, {.88, .5}, {.55, .82}, {.55, .6}, {.12, .6}};

cv::Scalar LinearOf(const world::Color& color) {
  const auto linear = [](int value) { return std::pow(value / 255.0, 2.2); };
  return {linear(color.blue), linear(color.green), linear(color.red)};
}

// From the camera through each pixel, x ahead, y to the left, z up.
cv::Mat RaysOf(const world::CameraSpec& spec) {
  cv::Mat rays(kHeight, kWidth, CV_32FC3, cv::Scalar());
  const double half = spec.hfov_rad / 2;
  for (int row = 0; row < kHeight; ++row) {
    for (int column = 0; column < kWidth; ++column) {
      const double u = (column + 0.5 - kWidth / 2.0) / (kWidth / 2.0);
      const double v = (row + 0.5 - kHeight / 2.0) / (kWidth / 2.0);
      Vector3d ray(1, -u * std::tan(half), -v * std::tan(half));
      if (spec.model == world::CameraModel::kFisheye) {
        const double out = std::hypot(u, v), angle = out * half;
        if (angle > half) continue;
        const double side = out == 0 ? 0 : std::sin(angle) / out;
        ray = {std::cos(angle), -u * side, -v * side};
      }
      ray.normalize();
      rays.at<cv::Vec3f>(row, column) = {float(ray.x()), float(ray.y()), float(ray.z())};
    }
  }
  return rays;
}

std::vector<cv::Mat> LevelsOf(const cv::Mat& finest) {
  constexpr int kCoarsest = 8;
  std::vector<cv::Mat> levels{finest};
  while (levels.back().cols > kCoarsest && levels.back().rows > kCoarsest) {
    cv::Mat half;
    cv::resize(levels.back(), half, {}, 0.5, 0.5, cv::INTER_AREA);
    levels.push_back(half);
  }
  return levels;
}

// Between four pixels; those outside are 0, or the nearest inside.
template <int kChannels, bool kZeroOutside>
cv::Vec<float, kChannels> Between(const cv::Mat& mat, double x, double y) {
  using Value = cv::Vec<float, kChannels>;
  const int left = int(std::floor(x)), top = int(std::floor(y));
  const auto right_share = float(x - left), lower_share = float(y - top);
  const auto at = [&](int column, int row) -> Value {
    if (kZeroOutside && (column < 0 || row < 0 || column >= mat.cols || row >= mat.rows)) {
      return Value::all(0);
    }
    return mat.at<Value>(std::clamp(row, 0, mat.rows - 1), std::clamp(column, 0, mat.cols - 1));
  };
  const Value upper = at(left, top) * (1 - right_share) + at(left + 1, top) * right_share;
  const Value lower = at(left, top + 1) * (1 - right_share) + at(left + 1, top + 1) * right_share;
  return upper * (1 - lower_share) + lower * lower_share;
}

// At metres from the upper left corner of a texture; `pixel_m`: how large a pixel of the picture is
// there.
template <int kChannels, bool kZeroOutside>
cv::Vec<float, kChannels> At(const std::vector<cv::Mat>& levels, double px_per_m,
                             const Vector2d& at_m, double pixel_m) {
  const double level = std::log2(std::max(1.0, pixel_m * px_per_m));
  const auto i = std::min(std::size_t(level + 0.5), levels.size() - 1);
  const cv::Mat& mat = levels[i];
  const double scale_x = double(mat.cols) / levels[0].cols * px_per_m;
  const double scale_y = double(mat.rows) / levels[0].rows * px_per_m;
  return Between<kChannels, kZeroOutside>(mat, at_m.x() * scale_x - 0.5, at_m.y() * scale_y - 0.5);
}

// Side by side, each second one mirrored.
cv::Mat Repeated(const cv::Mat& square, const cv::Size& size) {
  cv::Mat row, mirrored, all;
  cv::flip(square, mirrored, 1);
  cv::hconcat(square, mirrored, row);
  cv::flip(row, mirrored, 0);
  cv::vconcat(row, mirrored, row);
  cv::repeat(row, size.height / row.rows + 1, size.width / row.cols + 1, all);
  return all(cv::Rect({0, 0}, size)).clone();
}

void Stripe(cv::Mat& mask, const Vector2d& from_px, const Vector2d& to_px, double width_px) {
  constexpr int kShift = 4;
  const Vector2d along = (to_px - from_px).normalized();
  const Vector2d aside = Vector2d(-along.y(), along.x()) * (width_px / 2);
  std::vector<cv::Point> corners;
  for (const Vector2d& corner : {Vector2d(from_px + aside), Vector2d(to_px + aside),
                                 Vector2d(to_px - aside), Vector2d(from_px - aside)}) {
    corners.emplace_back(cvRound(corner.x() * (1 << kShift)), cvRound(corner.y() * (1 << kShift)));
  }
  cv::fillPoly(mask, std::vector{corners}, 255, cv::LINE_AA, kShift);
}

void Rectangle(cv::Mat& wall, double left_m, double top_m, double wide_m, double high_m,
               const cv::Scalar& albedo) {
  cv::rectangle(wall,
                cv::Rect(int(left_m * kWallPxPerM), int(top_m * kWallPxPerM),
                         int(wide_m * kWallPxPerM), int(high_m * kWallPxPerM)),
                albedo, cv::FILLED);
}

// Plaster with a skirting, and in each three metres a door, a window or a poster.
cv::Mat PaintedWall(std::uint64_t seed) {
  cv::RNG random(seed * 59 + 7);
  const double grey = random.uniform(0.25, 0.5);
  cv::Mat wall(int(kWallHighM * kWallPxPerM), int(kWallLongM * kWallPxPerM), CV_32FC3);
  wall.setTo(cv::Scalar(grey * random.uniform(0.85, 1.0), grey, grey * random.uniform(1.0, 1.12)));
  Rectangle(wall, 0, kWallHighM - 0.1, kWallLongM, 0.1, {0.06, 0.07, 0.08});
  for (double left_m = 0.4; left_m + 2 < kWallLongM; left_m += 3) {
    switch (random.uniform(0, 3)) {
      case 0:
        Rectangle(wall, left_m, kWallHighM - 2.1, 0.95, 2.1, {0.07, 0.16, 0.28});
        break;
      case 1:
        Rectangle(wall, left_m, 0.6, 1.8, 1.3,
                  cv::Scalar(2.3, 2.1, 2.0) * random.uniform(0.5, 1.0));
        Rectangle(wall, left_m + 0.88, 0.6, 0.05, 1.3, {0.7, 0.7, 0.7});
        break;
      default:
        Rectangle(wall, left_m, 1.1, 0.7, 1.0,
                  {random.uniform(0.1, 0.7), random.uniform(0.1, 0.7), 0.6});
        Rectangle(wall, left_m + 0.1, 1.7, 0.5, 0.12, vision::things::kRed);
        Rectangle(wall, left_m + 0.1, 1.9, 0.4, 0.05, vision::things::kGreen);
        break;
    }
  }
  return wall;
}

Face FaceOf(double width_m, double height_m, const cv::Scalar& albedo, double cover = 1) {
  constexpr double kPxPerM = 500;
  const cv::Size size(std::max(8, int(width_m * kPxPerM)), std::max(8, int(height_m * kPxPerM)));
  return {cv::Mat(size, CV_32FC3, albedo), cv::Mat(size, CV_32F, cv::Scalar(cover))};
}

void PaintCode(Face& face, const std::string& word) {
  constexpr int kQuiet = 2;  // squares, beside those of the encoder
  cv::Mat code;
  cv::QRCodeEncoder::create()->encode(word, code);
  const double side = 1.0 / (code.cols + 2 * kQuiet);
  for (int y = 0; y < code.rows; ++y) {
    for (int x = 0; x < code.cols; ++x) {
      if (code.at<std::uint8_t>(y, x) != 0) continue;
      const double left = (x + kQuiet) * side, top = (y + kQuiet) * side;
      vision::things::Fill(
          face, {{left, top}, {left + side, top}, {left + side, top + side}, {left, top + side}},
          vision::things::kBlack);
    }
  }
}

cv::Mat WithCover(const Face& face) {
  cv::Mat three, colors;
  cv::merge(std::vector<cv::Mat>{face.cover, face.cover, face.cover}, three);
  cv::multiply(face.albedo, three, colors);
  cv::Mat both(face.cover.size(), CV_32FC4);
  const std::vector<cv::Mat> from{colors, face.cover};
  std::vector<cv::Mat> to{both};
  cv::mixChannels(from, to, {0, 0, 1, 1, 2, 2, 3, 3});
  return both;
}

}  // namespace

HallPainter::HallPainter(const world::Scene& scene, const HallPaint& paint)
    : light_(paint.floor.light),
      least_m_(scene.least_m),
      most_m_(scene.most_m),
      cameras_(scene.cameras.cameras),
      balls_(scene.balls) {
  for (std::size_t i = 0; i < cameras_.size(); ++i) rays_.at(i) = RaysOf(cameras_.at(i));
  PaintFloor(scene, paint.floor);
  PaintWalls(paint.wall, paint.floor.seed);
  for (const world::Board& board : scene.boards) PutBoard(board);
  for (const world::Box& box : scene.boxes) PutBox(box);
  for (const world::Circle& circle : scene.circles) PutPost(circle);
  constexpr int kMore = 256;
  cv::RNG random(paint.floor.seed + 77);
  noise_.create(kHeight + kMore, kWidth + kMore, CV_32FC3);
  random.fill(noise_, cv::RNG::NORMAL, 0, 0.01 + 0.006 / std::sqrt(std::max(0.05, light_.share)));
}

void HallPainter::PaintFloor(const world::Scene& scene, const vision::floors::Floor& floor) {
  const Vector2d size_m = most_m_ - least_m_;
  const cv::Size size(int(size_m.x() * kFloorPxPerM), int(size_m.y() * kFloorPxPerM));
  cv::Mat painted = Repeated(vision::floors::UnmarkedFloor(floor), size);
  cv::RNG random(floor.seed + 5);
  const auto pixel = [&](const Vector2d& at_m) -> Vector2d {
    return Vector2d((at_m - least_m_).x(), (most_m_ - at_m).y()) * kFloorPxPerM;
  };
  cv::Mat tape(size, CV_32FC3);
  tape.setTo(kTape);
  cv::Mat mask = cv::Mat::zeros(size, CV_8U), share;
  for (const world::Line& line : scene.lines) {
    for (std::size_t i = 1; i < line.points_m.size(); ++i) {
      Stripe(mask, pixel(line.points_m[i - 1]), pixel(line.points_m[i]),
             line.width_m * kFloorPxPerM);
    }
  }
  // Worn and dirty in places, as feet leave it.
  cv::Mat wear(size.height / 12, size.width / 12, CV_32F), worn;
  random.fill(wear, cv::RNG::UNIFORM, 0.75, 1.0);
  cv::resize(wear, worn, size, 0, 0, cv::INTER_CUBIC);
  mask.convertTo(share, CV_32F, 1 / 255.0);
  for (int row = 0; row < size.height; ++row) {
    for (int column = 0; column < size.width; ++column) {
      const float by = share.at<float>(row, column);
      if (by == 0) continue;
      auto& albedo = painted.at<cv::Vec3f>(row, column);
      albedo =
          albedo * (1 - by) + tape.at<cv::Vec3f>(row, column) * (by * worn.at<float>(row, column));
    }
  }
  floor_ = {LevelsOf(painted), kFloorPxPerM};
}

void HallPainter::PaintWalls(const cv::Mat& photograph, std::uint64_t seed) {
  cv::Mat wall = PaintedWall(seed);
  if (!photograph.empty()) {
    const double scale = kWallHighM * kWallPxPerM / photograph.rows;
    cv::resize(photograph, wall, {}, scale, scale, scale < 1 ? cv::INTER_AREA : cv::INTER_LINEAR);
  }
  wall_ = {LevelsOf(wall), kWallPxPerM};
}

void HallPainter::PutBoard(const world::Board& board) {
  Face face = FaceOf(board.width_m, board.height_m, LinearOf(board.color), board.round ? 0 : 1);
  if (board.round) vision::things::FillEllipse(face, {0, 0, 1, 1}, LinearOf(board.color));
  const world::Sign& sign = board.sign;
  if (sign.kind == world::Sign::Kind::kQr) PaintCode(face, sign.content);
  if (sign.kind == world::Sign::Kind::kText) {
    vision::things::Write(face, sign.content, 0.45, cv::FONT_HERSHEY_DUPLEX,
                          vision::things::kBlack);
  }
  if (sign.kind == world::Sign::Kind::kArrow) {
    Corners corners = kArrow;
    for (cv::Point2d& corner : corners) {
      if (sign.content == "left") corner.x = 1 - corner.x;
    }
    vision::things::Fill(face, corners, vision::things::kGreen);
  }
  const Vector3d normal(std::cos(board.yaw_rad), std::sin(board.yaw_rad), 0);
  Panel panel;
  panel.middle << board.center_m, board.bottom_m + board.height_m / 2;
  panel.right = Vector3d(-normal.y(), normal.x(), 0) * (board.width_m / 2);
  panel.up = Vector3d(0, 0, board.height_m / 2);
  panel.face = {LevelsOf(WithCover(face)), face.cover.cols / board.width_m};
  panels_.push_back(panel);
}

void HallPainter::PutBox(const world::Box& box) {
  const Vector3d ahead = Vector3d(std::cos(box.yaw_rad), std::sin(box.yaw_rad), 0) * box.half_m.x();
  const Vector3d left = Vector3d(-std::sin(box.yaw_rad), std::cos(box.yaw_rad), 0) * box.half_m.y();
  const Vector3d up(0, 0, box.height_m / 2);
  Vector3d middle;
  middle << box.center_m, box.bottom_m + box.height_m / 2;
  const auto put = [&](const Vector3d& out, const Vector3d& right, const Vector3d& upwards,
                       double shade) {
    const Face face = FaceOf(2 * right.norm(), 2 * upwards.norm(), LinearOf(box.color) * shade);
    panels_.push_back({middle + out,
                       right,
                       upwards,
                       {LevelsOf(WithCover(face)), face.cover.cols / (2 * right.norm())}});
  };
  constexpr double kSide = 0.85, kBelow = 0.5;
  put(ahead, left, up, kSide);
  put(-ahead, -left, up, kSide);
  put(left, -ahead, up, kSide);
  put(-left, ahead, up, kSide);
  put(up, left, ahead, 1);
  put(-up, left, ahead, kBelow);
}

void HallPainter::PutPost(const world::Circle& circle) {
  const Face face = FaceOf(2 * circle.radius_m, circle.height_m, LinearOf(circle.color) * 0.85);
  Panel panel;
  panel.middle << circle.center_m, circle.bottom_m + circle.height_m / 2;
  panel.right = Vector3d(0, circle.radius_m, 0);
  panel.up = Vector3d(0, 0, circle.height_m / 2);
  panel.face = {LevelsOf(WithCover(face)), face.cover.cols / (2 * circle.radius_m)};
  panel.turns = true;
  panels_.push_back(panel);
}

HallPainter::Eye HallPainter::EyeOf(std::size_t camera, const world::View& view) const {
  using Eigen::AngleAxisd;
  const world::CameraSpec& spec = cameras_.at(camera);
  const auto turned = [](double yaw, double pitch, double roll) -> Eigen::Matrix3d {
    return (AngleAxisd(yaw, Vector3d::UnitZ()) * AngleAxisd(pitch, Vector3d::UnitY()) *
            AngleAxisd(roll, Vector3d::UnitX()))
        .toRotationMatrix();
  };
  const Eigen::Matrix3d body =
      turned(view.body.yaw_rad, view.attitude.pitch_rad, view.attitude.roll_rad);
  Eye eye;
  eye.spec = &spec;
  eye.turn = body * turned(spec.yaw_rad, spec.pitch_rad, spec.roll_rad);
  eye.at << view.body.position_m, view.attitude.height_m;
  eye.at += body * spec.position_m;
  const double half = spec.hfov_rad / 2;
  eye.px_per_rad =
      kWidth / 2.0 / (spec.model == world::CameraModel::kFisheye ? half : std::tan(half));
  return eye;
}

// The floor and the walls.
HallPainter::Scenery HallPainter::Empty(std::size_t camera, const Eye& eye) const {
  Scenery scenery;
  cv::Matx33f turn;
  for (int i = 0; i < 9; ++i) turn(i / 3, i % 3) = float(eye.turn(i / 3, i % 3));
  cv::transform(rays_.at(camera), scenery.rays, turn);
  scenery.light = cv::Mat::zeros(kHeight, kWidth, CV_32FC3);
  scenery.far = cv::Mat::zeros(kHeight, kWidth, CV_32F);
  constexpr double kNever = 1e9;
  for (int row = 0; row < kHeight; ++row) {
    for (int column = 0; column < kWidth; ++column) {
      const auto& seen = scenery.rays.at<cv::Vec3f>(row, column);
      const Vector3d ray(seen[0], seen[1], seen[2]);
      if (ray.squaredNorm() < 0.5) continue;
      const auto to_wall = [&](int axis) {
        if (ray[axis] == 0) return kNever;
        return ((ray[axis] > 0 ? most_m_ : least_m_)[axis] - eye.at[axis]) / ray[axis];
      };
      const double to_floor = ray.z() < 0 ? -eye.at.z() / ray.z() : kNever;
      const double x_wall = to_wall(0), y_wall = to_wall(1);
      const double far = std::min({to_floor, x_wall, y_wall});
      const Vector3d at = eye.at + far * ray;
      scenery.far.at<float>(row, column) = float(far);
      auto& light = scenery.light.at<cv::Vec3f>(row, column);
      if (far == to_floor) {
        // Longer than wide: the mean of both.
        const double pixel_m = far / eye.px_per_rad * std::sqrt(far / eye.at.z());
        light = At<3, false>(floor_.levels, floor_.px_per_m,
                             {at.x() - least_m_.x(), most_m_.y() - at.y()}, pixel_m);
      } else {
        const double long_m = double(wall_.levels[0].cols) / wall_.px_per_m;
        const double along_m = std::fmod(std::abs(far == x_wall ? at.y() : at.x()) + 1.3, long_m);
        light = At<3, false>(wall_.levels, wall_.px_per_m, {along_m, kWallHighM - at.z()},
                             far / eye.px_per_rad);
      }
    }
  }
  return scenery;
}

// Around the pixels of these points; the whole picture where one of them is behind the camera.
cv::Rect2d HallPainter::BoxOf(const std::vector<Vector3d>& points, const Eye& eye) const {
  const cv::Rect2d all(0, 0, kWidth, kHeight);
  Vector2d least(1e9, 1e9), most(-1e9, -1e9);
  for (const Vector3d& point : points) {
    const Vector3d seen = eye.turn.transpose() * (point - eye.at);
    Vector2d at(-seen.y(), -seen.z());
    if (eye.spec->model == world::CameraModel::kFisheye) {
      const double out = at.norm();
      if (out < 1e-9) return all;
      at *= std::atan2(out, seen.x()) / out;
    } else {
      if (seen.x() < 0.05) return all;
      at /= seen.x();
    }
    at = at * eye.px_per_rad + Vector2d(kWidth / 2.0, kHeight / 2.0);
    least = least.cwiseMin(at);
    most = most.cwiseMax(at);
  }
  constexpr double kRim = 3;
  return cv::Rect2d(least.x() - kRim, least.y() - kRim, most.x() - least.x() + 2 * kRim,
                    most.y() - least.y() + 2 * kRim) &
         all;
}

void HallPainter::Draw(const Panel& panel, const Eye& eye, Scenery& scenery) const {
  constexpr double kFarthestM = 12;
  const Vector3d to = panel.middle - eye.at;
  if (to.norm() > kFarthestM) return;
  Vector3d right = panel.right;
  if (panel.turns) {
    right = Vector3d(to.y(), -to.x(), 0).normalized() * panel.right.norm();
  }
  const Vector3d normal = right.cross(panel.up).normalized();
  std::vector<Vector3d> grid;
  for (const double x : {-1.0, -0.5, 0.0, 0.5, 1.0}) {
    for (const double y : {-1.0, 0.0, 1.0}) grid.push_back(panel.middle + x * right + y * panel.up);
  }
  const double ahead = (eye.turn.transpose() * to).x();
  if (ahead < -panel.right.norm() - panel.up.norm()) return;  // behind the camera
  const cv::Rect box = BoxOf(grid, eye);
  const double wide_m = 2 * right.norm(), high_m = 2 * panel.up.norm();
  for (int row = box.y; row < box.br().y; ++row) {
    for (int column = box.x; column < box.br().x; ++column) {
      const auto& seen = scenery.rays.at<cv::Vec3f>(row, column);
      const Vector3d ray(seen[0], seen[1], seen[2]);
      const double facing = normal.dot(ray);
      if (std::abs(facing) < 1e-6) continue;
      const double far = normal.dot(to) / facing;
      if (far < 0.02 || far > scenery.far.at<float>(row, column) + 0.01) continue;
      const Vector3d at = far * ray - to;
      const Vector2d place(at.dot(right) / right.norm() + wide_m / 2,
                           high_m / 2 - at.dot(panel.up) / panel.up.norm());
      const double pixel_m = far / eye.px_per_rad;
      if (place.x() < -pixel_m || place.y() < -pixel_m || place.x() > wide_m + pixel_m ||
          place.y() > high_m + pixel_m) {
        continue;
      }
      cv::Vec4f color = At<4, true>(panel.face.levels, panel.face.px_per_m, place, pixel_m);
      constexpr float kBack = 0.15F;
      if (facing > 0 && !panel.turns) {
        for (int i = 0; i < 3; ++i) color[i] = kBack * color[3];
      }
      auto& light = scenery.light.at<cv::Vec3f>(row, column);
      light = light * (1 - color[3]) + cv::Vec3f(color[0], color[1], color[2]);
      if (color[3] > 0.5F) scenery.far.at<float>(row, column) = float(far);
    }
  }
}

// A ball whose middle shines brightest, as a glass with a lamp in it.
void HallPainter::AddLamp(const world::Ball& ball, const Eye& eye, Scenery& scenery,
                          cv::Mat& lamps) const {
  const Vector3d to = ball.center_m - eye.at;
  const double radius_rad = std::asin(std::min(1.0, ball.radius_m / to.norm()));
  const Vector3d direction = to.normalized();
  for (int row = 0; row < kHeight; ++row) {
    for (int column = 0; column < kWidth; ++column) {
      const auto& seen = scenery.rays.at<cv::Vec3f>(row, column);
      const Vector3d ray(seen[0], seen[1], seen[2]);
      const double angle = std::acos(std::clamp(ray.dot(direction), -1.0, 1.0));
      if (angle > 1.3 * radius_rad || ray.squaredNorm() < 0.5) continue;
      if (scenery.far.at<float>(row, column) < to.norm()) continue;
      const double share = angle / radius_rad;
      const double cover = std::clamp((radius_rad - angle) * eye.px_per_rad + 0.5, 0.0, 1.0);
      const double shines = std::max(2 * std::exp(-2.2 * share * share), 0.35);
      auto& light = lamps.at<cv::Vec3f>(row, column);
      for (int i = 0; i < 3; ++i) {
        light[i] = float(cover * shines * vision::things::kLampYellow[i]);
      }
      scenery.light.at<cv::Vec3f>(row, column) *= float(1 - cover);
    }
  }
}

cv::Mat HallPainter::Exposed(const cv::Mat& light, const cv::Mat& lamps, std::uint64_t seed) const {
  // The exposure follows the light down to a fifth of daylight; below it the picture is darker.
  constexpr double kAutomatic = 0.2;
  const double gain =
      1.6 * std::min(1.0, light_.share / kAutomatic) * std::sqrt(std::max(1.0, light_.share));
  cv::Mat seen;
  cv::multiply(light, vision::floors::ColorOfLight(light_.kelvin) * gain, seen);
  if (!lamps.empty()) seen += lamps;
  cv::GaussianBlur(seen, seen, {3, 3}, 0.7);
  cv::min(seen, 1, seen);
  cv::max(seen, 0, seen);
  cv::pow(seen, 1 / 2.2, seen);
  cv::RNG random(seed + 1);
  const cv::Rect at(random.uniform(0, noise_.cols - kWidth),
                    random.uniform(0, noise_.rows - kHeight), kWidth, kHeight);
  seen += noise_(at);
  cv::Mat bgr;
  seen.convertTo(bgr, CV_8UC3, 255);
  return bgr;
}

cv::Mat HallPainter::Taken(std::size_t camera, const world::View& view) const {
  const Eye eye = EyeOf(camera, view);
  Scenery scenery = Empty(camera, eye);
  std::vector<const Panel*> panels;
  for (const Panel& panel : panels_) panels.push_back(&panel);
  std::ranges::stable_sort(panels, std::greater<>{},
                           [&](const Panel* panel) { return (panel->middle - eye.at).norm(); });
  for (const Panel* panel : panels) Draw(*panel, eye, scenery);
  cv::Mat lamps;
  for (std::size_t i = 0; i < balls_.size(); ++i) {
    if (std::ranges::find(view.hidden_balls, i) != view.hidden_balls.end()) continue;
    if (lamps.empty()) lamps = cv::Mat::zeros(kHeight, kWidth, CV_32FC3);
    AddLamp(balls_[i], eye, scenery, lamps);
  }
  return Exposed(scenery.light, lamps, view.seed);
}

}  // namespace musher::race::testing
