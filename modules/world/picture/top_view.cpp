#include "musher/modules/world/picture/top_view.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdio>

#include "musher/modules/world/paint/palette.hpp"
#include "musher/modules/world/picture/field_view.hpp"
#include "musher/modules/world/picture/fleet_view.hpp"
#include "musher/modules/world/picture/marks.hpp"
#include "musher/modules/world/sensors/sensing.hpp"

namespace musher::world {
namespace {

using Eigen::Rotation2Dd;
using Eigen::Vector2d;

constexpr double kLetters = 12;
constexpr double kTinyLetters = 11;
constexpr double kLabelLetters = 15;
constexpr double kWayWidth = 3.5;
constexpr double kOverhead = 1;  // metres

std::vector<Vector2d> Corners(const Vector2d& center, const Vector2d& half, double yaw_rad) {
  const Rotation2Dd turn(yaw_rad);
  std::vector<Vector2d> corners;
  for (const auto& [x, y] :
       {std::pair(1, 1), std::pair(-1, 1), std::pair(-1, -1), std::pair(1, -1)}) {
    corners.emplace_back(center + turn * Vector2d(x * half.x(), y * half.y()));
  }
  return corners;
}

class TopView {
 public:
  TopView(const World& world, const Pixel& corner, const Pixel& opposite, Canvas& canvas)
      : world_(world), scene_(world.scene()), canvas_(canvas) {
    const Vector2d size = scene_.most_m - scene_.least_m;
    const Vector2d room = opposite - corner - Vector2d(0, kMapAxis);
    scale_ = (room.array() / size.array()).minCoeff();
    origin_ = Pixel(corner.x(), corner.y() + size.y() * scale_);
  }

  double right() const { return At(scene_.most_m).x(); }

  void Draw() {
    Ground();
    for (const Zone& zone : scene_.zones) DrawZone(zone);
    for (const Pad& pad : scene_.pads) DrawPad(pad);
    for (const Line& line : scene_.lines) {
      canvas_.Polyline(At(line.points_m), line.color, std::max(line.width_m * scale_, 1.0));
    }
    for (const GroundLabel& label : scene_.labels) {
      canvas_.Text(label.text, At(label.middle_m), kLabelLetters, kGreyInk, Align::kCenter);
    }
    for (const Box& box : scene_.boxes) {
      if (box.bottom_m > kOverhead) {  // over a door
        canvas_.Outline(At(Corners(box.center_m, box.half_m, box.yaw_rad)), kGrid, 1);
        continue;
      }
      const std::vector<Pixel> corners = At(Corners(box.center_m, box.half_m, box.yaw_rad));
      canvas_.Fill(corners, box.color);
      canvas_.Outline(corners, EdgeOf(box.color), 1.2);
      Label(box.name, box.center_m, 2 * box.half_m.minCoeff(), InkOn(box.color));
    }
    for (const Circle& circle : scene_.circles) {
      DrawDisc(circle.center_m, circle.radius_m, circle.color);
      Label(circle.name, circle.center_m, 2 * circle.radius_m, InkOn(circle.color));
    }
    for (const Ball& ball : scene_.balls) {
      if (!ball.shown) continue;
      if (ball.center_m.z() - ball.radius_m > kOverhead)
        continue;  // it would hide the things below
      DrawDisc(ball.center_m.head<2>(), ball.radius_m, ball.color);
    }
    for (const Board& board : scene_.boards) DrawBoard(board);
    const ToPixel to_pixel = [this](const Vector2d& point_m) { return At(point_m); };
    DrawField(world_, to_pixel, scale_, canvas_);
    DrawFleetWays(world_, to_pixel, canvas_);
    if (scene_.has_body) DrawOwnBody();
    for (std::size_t i = 0; i < scene_.guests.size(); ++i) DrawGuest(i);
    DrawFleet(world_, to_pixel, scale_, canvas_);
  }

 private:
  void DrawOwnBody() {
    Way();
    for (const Bump& bump : world_.track().bumps()) Cross(At(bump.where_m), 5);
    if (scene_.picture.scan && scene_.sensors.lidar.enabled) Scan();
    if (scene_.humanoid) Sight();
    DrawBody(scene_.start, false);
    DrawBody(world_.body().pose(), true);
  }

  Pixel At(const Vector2d& point_m) const {
    const Vector2d from_corner = (point_m - scene_.least_m) * scale_;
    return {origin_.x() + from_corner.x(), origin_.y() - from_corner.y()};
  }
  std::vector<Pixel> At(const std::vector<Vector2d>& points_m) const {
    std::vector<Pixel> pixels;
    pixels.reserve(points_m.size());
    for (const Vector2d& point : points_m) pixels.push_back(At(point));
    return pixels;
  }

  void Ground() {
    const Pixel low = At(scene_.least_m);
    const Pixel high = At(scene_.most_m);
    canvas_.FillRect({low.x(), high.y()}, {high.x(), low.y()}, kGround);
    const double every =
        MarkEvery((scene_.most_m - scene_.least_m).maxCoeff(), 16, {1, 2, 5, 10, 20, 50, 100, 200});
    for (const double x : Marks(scene_.least_m.x(), scene_.most_m.x(), every)) {
      const double px = At({x, 0}).x();
      canvas_.Line({px, low.y()}, {px, high.y()}, kGrid);
      canvas_.Text(Metres(x), {px, low.y() + 17}, kTinyLetters, kGreyInk, Align::kCenter);
    }
    for (const double y : Marks(scene_.least_m.y(), scene_.most_m.y(), every)) {
      const double py = At({0, y}).y();
      canvas_.Line({low.x(), py}, {high.x(), py}, kGrid);
      canvas_.Text(Metres(y), {low.x() - 8, py + 4}, kTinyLetters, kGreyInk, Align::kRight);
    }
    canvas_.Outline({low, {high.x(), low.y()}, high, {low.x(), high.y()}}, kGreyInk, 1.2);
    canvas_.Text("x, m", {high.x(), low.y() + 32}, kTinyLetters, kGreyInk, Align::kRight);
    canvas_.Text("y, m", {low.x() - 8, high.y() - 8}, kTinyLetters, kGreyInk, Align::kRight);
  }

  static std::string Metres(double value) {
    char text[16];
    std::snprintf(text, sizeof(text), "%s%.0f", value < 0 ? "\u2212" : "", std::abs(value));
    return text;
  }

  void Label(const std::string& name, const Vector2d& center_m, double narrow_m, const Color& ink) {
    if (name.empty() || narrow_m * scale_ < kTinyLetters + 4) return;
    canvas_.Text(name, At(center_m) + Pixel(0, 4), kTinyLetters, ink, Align::kCenter);
  }

  static Color EdgeOf(const Color& color) { return Mix(color, kInk, 0.4); }

  void DrawDisc(const Vector2d& center_m, double radius_m, const Color& color) {
    canvas_.Disc(At(center_m), radius_m * scale_, color);
    canvas_.Ring(At(center_m), radius_m * scale_, EdgeOf(color), 1.2);
  }

  // In a light colour with its name: lines and the way are drawn over it.
  void DrawZone(const Zone& zone) {
    const std::vector<Pixel> corners = At(Corners(zone.center_m, zone.half_m, zone.yaw_rad));
    canvas_.Fill(corners, kZone);
    canvas_.Outline(corners, kZoneEdge, 1);
    const auto corner = std::min_element(
        corners.begin(), corners.end(),
        [](const Pixel& a, const Pixel& b) { return a.x() + a.y() < b.x() + b.y(); });
    canvas_.Text(zone.name, *corner + Pixel(3, 10), kTinyLetters - 2, kZoneName);
  }

  // A stroke, with a short one in the direction it faces.
  void DrawBoard(const Board& board) {
    const Rotation2Dd turn(board.yaw_rad);
    const Vector2d along = turn * Vector2d(0, board.width_m / 2);
    canvas_.Line(At(board.center_m - along), At(board.center_m + along), kBoard, 2.5);
    const Vector2d front = turn * Vector2d(1, 0) * (5 / scale_);
    canvas_.Line(At(board.center_m), At(board.center_m + front), kBoard, 1.5);
  }

  void DrawPad(const Pad& pad) {
    const auto half = Vector2d::Constant(pad.size_m / 2);
    const std::vector<Pixel> corners = At(Corners(pad.center_m, half, 0));
    canvas_.Fill(corners, kPad);
    canvas_.Outline(corners, kPadEdge, 1.5);
    const double unit = pad.size_m * scale_ / 4;
    const Pixel center = At(pad.center_m);
    std::vector<Pixel> bolt;
    for (const auto& [x, y] : {std::pair(0.2, -1.2), std::pair(-0.7, 0.2), std::pair(-0.1, 0.2),
                               std::pair(-0.2, 1.2), std::pair(0.7, -0.2), std::pair(0.1, -0.2)}) {
      bolt.emplace_back(center + Pixel(x, y) * unit);
    }
    canvas_.Fill(bolt, kPadEdge);
  }

  // In pieces of one colour. Without a line where the body was carried.
  void Way() {
    const std::vector<Sample>& samples = world_.track().samples();
    const bool by_time = scene_.picture.way == Picture::Way::kTime;
    std::vector<Pixel> piece = {At(samples.front().pose.position_m)};
    for (std::size_t i = 1; i < samples.size(); ++i) {
      const Sample& last = samples[i - 1];
      const Sample& sample = samples[i];
      const double seconds = ToSeconds(sample.at - last.at);
      const bool carried =
          (sample.pose.position_m - last.pose.position_m).norm() > 0.3 + 2 * seconds;
      if (!carried) piece.push_back(At(sample.pose.position_m));
      if (carried || i + 1 == samples.size() || sample.machine_state != last.machine_state ||
          std::abs(sample.battery_percent - battery_) > 2 || by_time) {
        if (piece.size() > 1) {
          const Color color =
              by_time ? ColorOfTime(ShareOf(last, samples)) : ColorOfWay(world_.track(), last);
          canvas_.Polyline(piece, color, kWayWidth);
        }
        piece = {At(sample.pose.position_m)};
        battery_ = sample.battery_percent;
      }
    }
  }

  static double ShareOf(const Sample& sample, const std::vector<Sample>& samples) {
    const double end = ToSeconds(samples.back().at);
    return end > 0 ? ToSeconds(sample.at) / end : 0;
  }

  void Cross(const Pixel& at, double half) {
    canvas_.Line(at - Pixel(half, half), at + Pixel(half, half), kBumpRed, 2);
    canvas_.Line(at + Pixel(-half, half), at + Pixel(half, -half), kBumpRed, 2);
  }

  void Scan() {
    constexpr double kDot = 1.6;
    const msg::LaserScan scan = MeasureScan(world_);
    const Pose2& pose = world_.body().pose();
    const Mount& mount = scene_.sensors.lidar.mount;
    const Vector2d eye = pose.position_m + Rotation2Dd(pose.yaw_rad) * mount.position_m.head<2>();
    double angle = pose.yaw_rad + mount.yaw_rad + scan.angle_min;
    for (const float range : scan.ranges) {
      const Vector2d hit = eye + range * Vector2d(std::cos(angle), std::sin(angle));
      if (std::isfinite(range)) canvas_.Disc(At(hit), kDot, kScanRed);
      angle += scan.angle_increment;
    }
  }

  // What the front camera can see of it, where it looks now.
  void Sight() {
    constexpr double kReachM = 2;
    const CameraSpec& camera = scene_.cameras.cameras[0];
    if (!camera.enabled) return;
    const Eigen::Isometry3d pose = world_.CameraPose(0);
    const Vector2d eye = pose.translation().head<2>();
    const Vector2d ahead = pose.linear().col(2).head<2>().normalized();
    const auto edge = [&](double turned) {
      return At(eye + Rotation2Dd(turned * camera.hfov_rad / 2) * ahead * kReachM);
    };
    std::vector<Pixel> fan = {At(eye)};
    for (const double turned : {-1.0, -0.5, 0.0, 0.5, 1.0}) fan.push_back(edge(turned));
    canvas_.Fill(fan, kSight);
  }

  // As wide as its shoulders, with a stroke in the direction it looks.
  void DrawGuest(std::size_t index) {
    const GuestSpec& spec = scene_.guests[index];
    const Guest& guest = world_.guests()[index];
    if (!guest.here) return;
    const std::vector<Pixel> shoulders =
        At(Corners(guest.position_m, {0.4 * kGuestRadiusM, kGuestRadiusM}, guest.yaw_rad));
    canvas_.Fill(shoulders, spec.color);
    canvas_.Outline(shoulders, EdgeOf(spec.color), 1.2);
    const Vector2d look = Rotation2Dd(guest.head_yaw_rad) * Vector2d(0.3, 0);
    canvas_.Line(At(guest.position_m), At(guest.position_m + look), kInk, 1.5);
    DrawDisc(guest.position_m, 0.45 * kGuestRadiusM, spec.color);
    std::string text = spec.name;
    if (guest.gesture != Gesture::kNone) {
      text += text.empty() ? "" : ": ";
      text += kGestureNames[static_cast<std::size_t>(guest.gesture)];
    }
    canvas_.Text(text, At(guest.position_m) + Pixel(0, kGuestRadiusM * scale_ + 12), kTinyLetters,
                 kInk, Align::kCenter);
  }

  // A trunk with its head ahead; hollow at the start, filled at the present position.
  void DrawBody(const Pose2& pose, bool now) {
    const double unit = scene_.body.radius_m;
    const Rotation2Dd turn(pose.yaw_rad);
    const auto part = [&](const Vector2d& center, const Vector2d& half) {
      return At(Corners(pose.position_m + turn * (center * unit), half * unit, pose.yaw_rad));
    };
    const bool upright = scene_.humanoid.has_value();  // its shoulders, and a foot ahead
    const std::vector<Pixel> trunk =
        upright ? part({0, 0}, {0.4, 0.9}) : part({-0.1, 0}, {0.75, 0.42});
    const std::vector<Pixel> head =
        upright ? part({0.6, 0}, {0.2, 0.3}) : part({0.85, 0}, {0.2, 0.26});
    if (now) {
      for (const auto& shape : {trunk, head}) {
        canvas_.Fill(shape, kInk);
        canvas_.Outline(shape, kPaper, 1.2);
      }
      Lights(pose);
    } else {
      canvas_.Outline(trunk, kInk, 1.5);
      canvas_.Outline(head, kInk, 1.5);
    }
  }

  void Lights(const Pose2& pose) {
    const Rotation2Dd turn(pose.yaw_rad);
    for (const auto& [target, light] : world_.track().lights()) {
      const double ahead = target == 1 ? 0.85 : target == 2 ? -0.7 : 0.2;
      const Vector2d where = pose.position_m + turn * Vector2d(ahead * scene_.body.radius_m, 0);
      canvas_.Disc(At(where), 3, {light.red, light.green, light.blue});
    }
  }

  const World& world_;
  const Scene& scene_;
  Canvas& canvas_;
  double scale_ = 1;  // pixels in a metre
  Pixel origin_;      // of the place's lower left corner
  double battery_ = -1;
};

}  // namespace

double DrawTopView(const World& world, const Pixel& corner, const Pixel& opposite, Canvas& canvas) {
  TopView view(world, corner, opposite, canvas);
  view.Draw();
  return view.right();
}

}  // namespace musher::world
