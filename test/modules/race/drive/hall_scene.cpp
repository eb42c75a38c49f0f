#include "musher/test/modules/race/drive/hall_scene.hpp"

#include <unistd.h>
#include <algorithm>
#include <filesystem>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <stdexcept>
#include <vector>

namespace musher::race::testing {
namespace {

using Eigen::Vector2d;
using Points = std::vector<Vector2d>;

constexpr double kGapM = 0.1;          // between lines that meet at a corner
constexpr double kBayALengthM = 0.52;  // from the line at its end to the cross lane's
constexpr double kBayPlaceM = 0.44;    // of the robot's middle from that line
constexpr double kCrossMoreM = 0.02;   // the cross lane A is wider than others, on either side

// Of the scene as it is.
constexpr double kSEndX = 4.1513, kS2Y = 0.743;

Points Arc(const Vector2d& center, double radius, double from_deg, double to_deg) {
  constexpr double kStepDeg = 3;
  const int steps = static_cast<int>(std::ceil(std::abs(to_deg - from_deg) / kStepDeg));
  Points points;
  for (int i = 0; i <= steps; ++i) {
    const double angle = (from_deg + (to_deg - from_deg) * i / steps) * M_PI / 180;
    points.emplace_back(center + radius * Vector2d(std::cos(angle), std::sin(angle)));
  }
  return points;
}

class Layout {
 public:
  Layout(const Hall& hall, const SCurve& s, world::Scene& scene)
      : hall_(hall), s_(s), scene_(scene), half_(hall.half_m()) {
    const double arc = s.arc_deg * M_PI / 180;
    bay_a_far_ = hall.bay_a_aside_m + half_;
    s_begin_ = bay_a_far_ + 0.03;
    s_end_ = s_begin_ + 2 * s.radius_m * std::sin(arc);
    s2_y_ = -hall.s1_m + 2 * s.radius_m * (1 - std::cos(arc));
    aside_ = s_end_ - kSEndX;
    far_ = aside_ + hall.lane_length_m - Hall{}.lane_length_m;
  }

  void Run() {
    scene_.lines.clear();
    LayStart();
    LayBaysA();
    LayS();
    LayLane(1);
    LayLane(-1);
    Line({{13.38 + far_, s2_y_ - hall_.bay_b_aside_m + half_ + kGapM},
          {13.38 + far_, s2_y_ + hall_.bay_b_aside_m - half_ - kGapM}});
    MoveZones();
    MoveThings();
    const double south = hall_.cross_m - Hall{}.cross_m, north = s2_y_ - kS2Y;
    scene_.least_m.y() -= std::max({south, -north, 0.0});
    scene_.most_m += Vector2d(std::max(0.0, far_), std::max(0.0, north));
  }

 private:
  void Line(Points points) {
    world::Line line;
    line.points_m = std::move(points);
    line.width_m = hall_.line_m;
    line.watched = true;
    scene_.lines.push_back(std::move(line));
  }

  void LayStart() {
    const double north = -hall_.s1_m + half_;  // of the S lane
    Line({{-1.54, half_}, {half_ - kGapM, half_}});
    Line({{-1.54, -half_}, {-half_ - kGapM, -half_}});
    Line({{-1.64, -half_ + kGapM}, {-1.64, half_ - kGapM}});
    Line({{half_, half_ - kGapM}, {half_, north + kGapM}});
  }

  // Lane Q, the cross lane, and its bays to the west and to the east.
  void LayBaysA() {
    const double end = -hall_.s1_m - half_;
    const double north = -hall_.cross_m + half_ + kCrossMoreM;
    const double south = -hall_.cross_m - half_ - kCrossMoreM;
    Line({{-half_, -half_ - kGapM}, {-half_, north + kGapM}});
    Line({{half_, end - kGapM}, {half_, north + kGapM}});
    for (const double side : {-1, 1}) {
      Line({{side * half_, south - kGapM}, {side * half_, -hall_.cross_m - 1.08}});
    }
    const double near = hall_.bay_a_aside_m - half_, far = bay_a_far_;
    for (const double side : {-1, 1}) {
      const double at_end = side < 0 ? end - kGapM : end - kGapM - 0.03;
      Line({{side * (half_ + kGapM), north}, {side * (near - kGapM), north}});
      Line({{side * (far - kGapM), south}, {side * (half_ + kGapM), south}});
      Line({{side * near, north + kGapM}, {side * near, at_end}});
      Line({{side * far, south + kGapM}, {side * far, at_end}});
    }
    Line({{-far + kGapM, end}, {-near - kGapM, end}});
  }

  void LayS() {
    const Vector2d first(s_begin_, -hall_.s1_m + s_.radius_m);
    const Vector2d second(s_end_, s2_y_ - s_.radius_m);
    for (const double side : {1, -1}) {
      const double aside = side * half_;
      Line({{half_ + kGapM, -hall_.s1_m + aside}, {s_begin_, -hall_.s1_m + aside}});
      Line(Arc(first, s_.radius_m - aside, -90, -90 + s_.arc_deg));
      Line(Arc(second, s_.radius_m + aside, 90 + s_.arc_deg, 90));
      Line({{s_end_, s2_y_ + aside}, {4.43 + aside_, s2_y_ + aside}});
    }
  }

  // L1 and B1, or R1 and B2.
  void LayLane(double side) {
    const auto y = [&](double from_s2) { return s2_y_ + side * from_s2; };
    const double lane = hall_.lane_aside_m, bay = hall_.bay_b_aside_m, west = 4.13 + aside_;
    Line({{west, y(half_ + kGapM)}, {west, y(lane + half_ - kGapM)}});
    Line({{4.23 + aside_, y(lane + half_)}, {11.9 + far_, y(lane + half_)}});
    Line({{12.0 + far_, y(bay + half_ + 0.017)}, {13.28 + far_, y(bay + half_ + 0.017)}});
    Line({{6.13 + aside_, y(lane - half_)}, {12.28 + far_, y(lane - half_)}});
    Line({{13.48 + far_, y(bay + half_)}, {14.43 + far_, y(bay + half_)}});
    Line({{13.48 + far_, y(bay - half_)}, {14.43 + far_, y(bay - half_)}});
    Line({{14.53 + far_, y(bay - half_ + kGapM)}, {14.53 + far_, y(bay + half_ - kGapM)}});
  }

  void MoveZone(const std::string& name, const Vector2d& center) {
    for (world::Zone& zone : scene_.zones) {
      if (zone.name != name) continue;
      zone.center_m = center;
      zone.half_m.y() = hall_.lane_m / 2;
      const bool square = name == "QR_A" || name == "A1" || name == "A2";
      if (square) zone.half_m.x() = hall_.lane_m / 2;
      return;
    }
    throw std::runtime_error("the scene has no zone " + name);
  }

  void MoveZones() {
    const double place_y = -hall_.cross_m + hall_.bay_a_in_m;
    MoveZone("START", {-0.78, 0});
    MoveZone("QR_A", {0, 0});
    MoveZone("A1", {-hall_.bay_a_aside_m, place_y});
    MoveZone("A2", {hall_.bay_a_aside_m, place_y});
    // The body lies in it completely: also in a narrow lane.
    for (world::Zone& zone : scene_.zones) {
      if (zone.name == "A1" || zone.name == "A2") zone.half_m.y() = 0.415;
    }
    MoveZone("S1", {1.1, -hall_.s1_m});
    MoveZone("S2", {5.03 + aside_, s2_y_});
    MoveZone("L1", {8.93 + aside_, s2_y_ + hall_.lane_aside_m});
    MoveZone("R1", {8.93 + aside_, s2_y_ - hall_.lane_aside_m});
    MoveZone("QR_B", {12.83 + far_, s2_y_});
    MoveZone("B1", {13.815 + far_, s2_y_ + hall_.bay_b_aside_m});
    MoveZone("B2", {13.815 + far_, s2_y_ - hall_.bay_b_aside_m});
  }

  void MoveThings() {
    const double south = -(hall_.cross_m - Hall{}.cross_m), north = s2_y_ - kS2Y;
    const double lanes = hall_.lane_aside_m - Hall{}.lane_aside_m;
    // What stands at L1 or R1, over its own lane.
    const auto at_lane = [&](Vector2d& center) {
      center += Vector2d(aside_, north + (center.y() > kS2Y ? lanes : -lanes));
    };
    for (world::Board& board : scene_.boards) {
      if (board.name == "board A") board.center_m.y() += south;
      if (board.name == "board B") board.center_m += Vector2d(far_, north);
      if (board.name == "arrow") board.center_m += Vector2d(aside_, north);
      if (board.name == "yellow marker") at_lane(board.center_m);
    }
    for (world::Box& box : scene_.boxes) at_lane(box.center_m);
    for (world::Circle& circle : scene_.circles) at_lane(circle.center_m);
  }

  const Hall& hall_;
  const SCurve& s_;
  world::Scene& scene_;
  const double half_;
  double bay_a_far_ = 0;
  double s_begin_ = 0, s_end_ = 0, s2_y_ = 0;
  double aside_ = 0;  // of everything behind the S lane, to the east
  double far_ = 0;    // and of zone B
};

constexpr double kSideM = 5, kPxPerM = 200;
constexpr int kSidePx = static_cast<int>(kSideM * kPxPerM);

// Soft blotches of about that size, from -1 to 1.
cv::Mat Blotches(cv::RNG& random, double x_m, double y_m) {
  cv::Mat coarse(std::max(2, int(kSideM / y_m)), std::max(2, int(kSideM / x_m)), CV_32F);
  random.fill(coarse, cv::RNG::UNIFORM, -1, 1);
  cv::Mat fine;
  cv::resize(coarse, fine, {kSidePx, kSidePx}, 0, 0, cv::INTER_CUBIC);
  return fine;
}

// By 1 + share.
void Shade(cv::Mat& floor, const cv::Mat& share) {
  cv::Mat three;
  cv::merge(std::vector<cv::Mat>{share, share, share}, three);
  floor = floor.mul(three + cv::Scalar::all(1));
}

// Colours as a screen shows them: blue, green, red.
cv::Mat Even(const cv::Scalar& color) {
  return {kSidePx, kSidePx, CV_32FC3, color};
}

cv::Mat Planks(cv::RNG& random) {
  constexpr double kWideM = 0.125, kLongM = 1.25;
  const cv::Scalar oak(89, 123, 156);
  cv::Mat floor = Even(oak);
  for (double y = 0; y < kSideM; y += kWideM) {
    for (double x = -random.uniform(0.0, kLongM); x < kSideM; x += kLongM) {
      const cv::Rect plank(int(x * kPxPerM), int(y * kPxPerM), int(kLongM * kPxPerM),
                           int(kWideM * kPxPerM));
      const cv::Rect inside = plank & cv::Rect(0, 0, kSidePx, kSidePx);
      if (inside.area() == 0) continue;
      floor(inside) *= 1 + random.uniform(-0.1, 0.1);
      cv::rectangle(floor, plank, oak * 0.5, 1);
    }
  }
  Shade(floor, 0.06 * Blotches(random, 0.5, 0.008));
  return floor;
}

cv::Mat Tiles(cv::RNG& random) {
  cv::Mat floor = Even({142, 144, 146});
  Shade(floor, 0.09 * Blotches(random, 0.4, 0.4));
  Shade(floor, 0.04 * Blotches(random, 0.02, 0.02));
  constexpr int kTilePx = kSidePx / 8;
  for (int at = 0; at < kSidePx; at += kTilePx) {
    cv::line(floor, {at, 0}, {at, kSidePx}, {96, 96, 96}, 2);
    cv::line(floor, {0, at}, {kSidePx, at}, {96, 96, 96}, 2);
  }
  return floor;
}

cv::Mat PaintedFloor(Flooring flooring, cv::RNG& random) {
  switch (flooring) {
    case Flooring::kOak:
      return Planks(random);
    case Flooring::kTiles:
      return Tiles(random);
    case Flooring::kBlueMat: {
      cv::Mat mat = Even({148, 84, 48});
      Shade(mat, 0.04 * Blotches(random, 0.03, 0.03));
      return mat;
    }
    case Flooring::kWetSpots: {
      cv::Mat floor = Tiles(random);
      cv::Mat shine = Blotches(random, 0.7, 0.7) - 0.35;
      cv::threshold(shine, shine, 0, 0, cv::THRESH_TOZERO);
      cv::Mat three;
      cv::merge(std::vector<cv::Mat>{shine, shine, shine}, three);
      return floor + 170 * three;
    }
    case Flooring::kGrey:
    case Flooring::kShipped:
      break;
  }
  cv::Mat grey = Even({127, 127, 127});
  Shade(grey, 0.03 * Blotches(random, 0.03, 0.03));
  return grey;
}

}  // namespace

Hall HallOf(double lane_m, double line_m) {
  Hall hall;
  hall.lane_m = lane_m;
  hall.line_m = line_m;
  const double half = hall.half_m(), cross = half + kCrossMoreM;
  hall.cross_m = hall.s1_m + half + kBayALengthM + cross;
  hall.bay_a_aside_m = 2 * half + 0.35;
  hall.bay_a_in_m = kBayALengthM - kBayPlaceM + cross;
  hall.bay_a_ahead_m = hall.bay_a_in_m + cross;
  return hall;
}

void LayOut(const Hall& hall, const SCurve& s, world::Scene& scene) {
  Layout(hall, s, scene).Run();
}

std::string NameOf(Flooring flooring) {
  constexpr const char* kNames[] = {"shipped", "grey", "oak", "tiles", "blue mat", "wet spots"};
  return kNames[static_cast<std::size_t>(flooring)];
}

void Furnish(Flooring flooring, std::uint64_t seed, world::Scene& scene) {
  if (flooring == Flooring::kShipped) return;
  cv::RNG random(seed);
  const std::filesystem::path file =
      std::filesystem::temp_directory_path() /
      ("floor-" + std::to_string(getpid()) + "-" + std::to_string(static_cast<int>(flooring)) +
       "-" + std::to_string(seed) + ".png");
  cv::Mat picture;
  PaintedFloor(flooring, random).convertTo(picture, CV_8UC3);
  if (!cv::imwrite(file, picture)) throw std::runtime_error("cannot write " + file.string());
  scene.ground.texture = world::Ground::Texture::kPicture;
  scene.ground.file = file;
  scene.ground.tile_m = kSideM;
  scene.ground.once = false;
}

void Illuminate(const HallLight& light, world::Scene& scene) {
  scene.light.temperature_k = light.temperature_k;
  scene.light.brightness *= light.share;
  const double exposure = std::clamp(1 / light.share, 0.25, 4.0);
  for (world::CameraSpec& camera : scene.cameras.cameras) {
    camera.exposure = exposure;
    camera.noise *= std::max(1.0, std::sqrt(exposure));
  }
}

}  // namespace musher::race::testing
