#include "musher/test/modules/vision/thing_pictures.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <opencv2/imgproc.hpp>

namespace musher::vision::things {
namespace {

constexpr int kWidth = 640, kHeight = 480;
constexpr double kEyeM = 0.35, kPitch = 8 * M_PI / 180;
constexpr double kWallM = 4.5, kRoomWideM = 14, kRoomHighM = 3.2, kNearM = 0.38;

struct Seen {
  cv::Point2d at;
  double depth_m = 0;
};

Seen SeenAt(const cv::Point3d& at) {
  const double up = at.z - kEyeM;
  const double depth = at.x * std::cos(kPitch) - up * std::sin(kPitch);
  const double over = at.x * std::sin(kPitch) + up * std::cos(kPitch);
  return {{kWidth / 2.0 - kFocalPx * at.y / depth, kHeight / 2.0 - kFocalPx * over / depth}, depth};
}

std::array<cv::Point3d, 4> CornersOf(const Place& place) {
  const double yaw = place.yaw_deg * M_PI / 180;
  std::array<cv::Point3d, 4> corners;
  constexpr std::array<std::array<double, 2>, 4> kSides{{{1, 1}, {-1, 1}, {-1, -1}, {1, -1}}};
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const double aside = kSides.at(i)[0] * place.width_m / 2;
    corners.at(i) = {place.ahead_m + aside * std::sin(yaw), place.left_m + aside * std::cos(yaw),
                     place.up_m + kSides.at(i)[1] * place.height_m / 2};
  }
  return corners;
}

cv::Mat Three(const cv::Mat& one) {
  cv::Mat three;
  cv::merge(std::vector<cv::Mat>{one, one, one}, three);
  return three;
}

// Soft blotches of about that many pixels, from -1 to 1.
cv::Mat Blotches(cv::RNG& random, const cv::Size& size, double wide_px, double high_px) {
  cv::Mat coarse(std::max(2, int(size.height / high_px)), std::max(2, int(size.width / wide_px)),
                 CV_32F);
  random.fill(coarse, cv::RNG::UNIFORM, -1, 1);
  cv::Mat fine;
  cv::resize(coarse, fine, size, 0, 0, cv::INTER_CUBIC);
  return fine;
}

void Multiply(cv::Mat& albedo, const cv::Mat& by) {
  cv::multiply(albedo, Three(by), albedo);
}

constexpr double kWallPxPerM = 160, kFloorPxPerM = 60;

cv::Mat Bricks(cv::RNG& random, const cv::Size& size) {
  cv::Mat wall(size, CV_32FC3, cv::Scalar(0.36, 0.4, 0.42));
  constexpr double kLongM = 0.222, kHighM = 0.077, kMortarM = 0.012;
  const double cool = random.uniform(0.75, 1.25);
  for (int row = 0; row * kHighM * kWallPxPerM < size.height; ++row) {
    for (int i = -1; i * kLongM * kWallPxPerM < size.width; ++i) {
      const double left = (i + (row % 2) * 0.5) * kLongM, top = row * kHighM;
      const double tint = random.uniform(0.6, 1.2);
      cv::rectangle(wall, cv::Point(int(left * kWallPxPerM), int(top * kWallPxPerM)),
                    cv::Point(int((left + kLongM - kMortarM) * kWallPxPerM),
                              int((top + kHighM - kMortarM) * kWallPxPerM)),
                    cv::Scalar(0.08 * cool, 0.12, 0.33) * tint, cv::FILLED);
    }
  }
  Multiply(wall, 1 + 0.12 * Blotches(random, size, 6, 6));
  return wall;
}

cv::Mat Wood(cv::RNG& random, const cv::Size& size, double px_per_m) {
  cv::Mat wood(size, CV_32FC3, cv::Scalar(0.1, 0.2, 0.34));
  const int plank = int(0.14 * px_per_m);
  for (int left = 0; left < size.width; left += plank) {
    const cv::Rect inside = cv::Rect(left, 0, plank, size.height) & cv::Rect(cv::Point(0, 0), size);
    wood(inside) *= 1 + random.uniform(-0.15, 0.15);
    cv::line(wood, {left, 0}, {left, size.height}, {0.03, 0.06, 0.1}, 1);
  }
  Multiply(wood, 1 + 0.14 * Blotches(random, size, 3, 60));
  return wood;
}

cv::Mat Plaster(cv::RNG& random, const cv::Size& size, double grey) {
  cv::Mat plaster(
      size, CV_32FC3,
      cv::Scalar(grey * random.uniform(0.9, 1.0), grey, grey * random.uniform(1.0, 1.08)));
  Multiply(plaster, 1 + 0.08 * Blotches(random, size, 90, 90));
  Multiply(plaster, 1 + 0.05 * Blotches(random, size, 3, 3));
  return plaster;
}

// Few of each kind: they take longer than the rest of a picture.
const cv::Mat& WallOf(Wall wall, std::uint64_t seed) {
  constexpr std::uint64_t kOfAKind = 4;
  static std::map<std::pair<Wall, std::uint64_t>, cv::Mat> known;
  cv::Mat& albedo = known[{wall, seed % kOfAKind}];
  if (!albedo.empty()) return albedo;
  cv::RNG random(seed % kOfAKind + 11);
  const cv::Size size(int(kRoomWideM * kWallPxPerM), int(kRoomHighM * kWallPxPerM));
  albedo = wall == Wall::kBricks ? Bricks(random, size)
           : wall == Wall::kWood ? Wood(random, size, kWallPxPerM)
                                 : Plaster(random, size, random.uniform(0.25, 0.55));
  constexpr double kAsSeen = 0.6;  // about as fine as the camera sees it
  cv::resize(albedo, albedo, {}, kAsSeen, kAsSeen, cv::INTER_AREA);
  return albedo;
}

const cv::Mat& FloorOf(std::uint64_t seed) {
  constexpr std::uint64_t kOfAKind = 4;
  static std::map<std::uint64_t, cv::Mat> known;
  cv::Mat& albedo = known[seed % kOfAKind];
  if (!albedo.empty()) return albedo;
  cv::RNG random(seed % kOfAKind + 31);
  const cv::Size size(int(kRoomWideM * kFloorPxPerM), int((kWallM - kNearM) * kFloorPxPerM));
  albedo = seed % 2 == 0 ? Plaster(random, size, 0.2) : Wood(random, size, kFloorPxPerM);
  return albedo;
}

// From the pixels of a face that is so large, without its rim.
cv::Mat HomographyOf(const cv::Size& face, float rim_px,
                     const std::array<cv::Point3d, 4>& corners) {
  const float least = rim_px - 0.5F;
  const float right = float(face.width) + least, bottom = float(face.height) + least;
  const std::vector<cv::Point2f> from{
      {least, least}, {right, least}, {right, bottom}, {least, bottom}};
  std::vector<cv::Point2f> to;
  for (const cv::Point3d& corner : corners) {
    to.emplace_back(SeenAt(corner).at - cv::Point2d(0.5, 0.5));
  }
  return cv::getPerspectiveTransform(from, to);
}

// Fills the picture.
void WarpAll(const cv::Mat& albedo, const std::array<cv::Point3d, 4>& corners, cv::Mat& light) {
  cv::warpPerspective(albedo, light, HomographyOf(albedo.size(), 0, corners), light.size(),
                      cv::INTER_LINEAR, cv::BORDER_REPLICATE);
}

constexpr int kRimPx = 2;  // around a face, so that its edges are smooth

// How much of each pixel of the picture the face hides.
cv::Mat HiddenBy(const Face& face, const std::array<cv::Point3d, 4>& corners) {
  cv::Mat cover, hidden;
  cv::copyMakeBorder(face.cover, cover, kRimPx, kRimPx, kRimPx, kRimPx, cv::BORDER_CONSTANT);
  cv::warpPerspective(cover, hidden, HomographyOf(face.cover.size(), kRimPx, corners),
                      {kWidth, kHeight}, cv::INTER_LINEAR);
  return hidden;
}

// Over what is there already.
void Warp(const Face& face, const std::array<cv::Point3d, 4>& corners, cv::Mat& light) {
  cv::Mat colors;
  cv::multiply(face.albedo, Three(face.cover), colors);
  cv::copyMakeBorder(colors, colors, kRimPx, kRimPx, kRimPx, kRimPx, cv::BORDER_CONSTANT);
  const cv::Mat homography = HomographyOf(face.cover.size(), kRimPx, corners);
  cv::Mat seen;
  cv::warpPerspective(colors, seen, homography, light.size(), cv::INTER_LINEAR);
  cv::multiply(light, Three(1 - HiddenBy(face, corners)), light);
  light += seen;
}

// A black body's blue, green and red beside those of 6500 K (linear, of the sRGB primaries).
cv::Scalar ColorOf(double kelvin) {
  if (kelvin < 5000) return {0.33, 0.66, 1.43};
  if (kelvin > 7500) return {1.13, 1.02, 0.9};
  return {1, 1, 1};
}

std::vector<cv::Point> PixelsOf(const Face& face, const Corners& corners, int shift) {
  std::vector<cv::Point> pixels;
  for (const cv::Point2d& corner : corners) {
    pixels.emplace_back(cvRound(corner.x * face.cover.cols * (1 << shift)),
                        cvRound(corner.y * face.cover.rows * (1 << shift)));
  }
  return pixels;
}

void Blend(Face& face, const cv::Mat& mask, const cv::Scalar& albedo) {
  cv::Mat share;
  mask.convertTo(share, CV_32F, 1 / 255.0);
  cv::Mat color(face.albedo.size(), CV_32FC3, albedo), rest;
  cv::multiply(color, Three(share), color);
  cv::multiply(face.albedo, Three(1 - share), rest);
  face.albedo = color + rest;
  face.cover = cv::max(face.cover, share);
}

// A ball whose middle shines brightest, as a glass with a lamp in it, and its glow. `hidden`: how
// much of each pixel is behind something.
void AddLamp(const Lamp& lamp, const cv::Mat& hidden, cv::Mat& light) {
  const Seen seen = SeenAt({lamp.ahead_m, lamp.left_m, lamp.up_m});
  const double radius = kFocalPx * lamp.radius_m / seen.depth_m;
  cv::Mat ball(light.size(), CV_32FC3, cv::Scalar());
  cv::Mat cover(light.size(), CV_32F, cv::Scalar());
  const int reach = int(radius) + 2;
  const cv::Rect around =
      cv::Rect(int(seen.at.x) - reach, int(seen.at.y) - reach, 2 * reach + 1, 2 * reach + 1) &
      cv::Rect(0, 0, kWidth, kHeight);
  for (int y = around.y; y < around.br().y; ++y) {
    for (int x = around.x; x < around.br().x; ++x) {
      const double from = std::hypot(x + 0.5 - seen.at.x, y + 0.5 - seen.at.y);
      const double share = from / radius;
      cover.at<float>(y, x) = float(std::clamp(radius - from + 0.5, 0.0, 1.0));
      const double shines = lamp.brightness * std::exp(-2.2 * share * share);
      for (int i = 0; i < 3; ++i) {
        ball.at<cv::Vec3f>(y, x)[i] = float(lamp.color[i] * std::max(shines, 0.35));
      }
    }
  }
  cv::multiply(cover, 1 - hidden, cover);
  cv::multiply(ball, Three(cover), ball);
  cv::multiply(light, Three(1 - cover), light);
  light += ball;
  cv::Mat glow;
  cv::GaussianBlur(ball, glow, {}, std::max(1.0, radius * 0.8), 0, cv::BORDER_CONSTANT);
  light += 0.06 * glow;
}

}  // namespace

Face Blank(const Place& place, const cv::Scalar& albedo, double cover) {
  constexpr double kFiner = 1.5;
  const double px_per_m = kFiner * kFocalPx / place.ahead_m;
  const cv::Size size(std::clamp(int(place.width_m * px_per_m), 8, 1600),
                      std::clamp(int(place.height_m * px_per_m), 8, 1600));
  return {cv::Mat(size, CV_32FC3, albedo), cv::Mat(size, CV_32F, cv::Scalar(cover))};
}

void Fill(Face& face, const Corners& corners, const cv::Scalar& albedo) {
  constexpr int kShift = 4;
  cv::Mat mask(face.cover.size(), CV_8U, cv::Scalar());
  cv::fillPoly(mask, std::vector{PixelsOf(face, corners, kShift)}, 255, cv::LINE_AA, kShift);
  Blend(face, mask, albedo);
}

void FillEllipse(Face& face, const cv::Rect2d& box, const cv::Scalar& albedo) {
  cv::Mat mask(face.cover.size(), CV_8U, cv::Scalar());
  const cv::Point2d middle = (box.tl() + box.br()) / 2;
  cv::ellipse(mask, cv::Point(int(middle.x * mask.cols), int(middle.y * mask.rows)),
              cv::Size(int(box.width / 2 * mask.cols), int(box.height / 2 * mask.rows)), 0, 0, 360,
              255, cv::FILLED, cv::LINE_AA);
  Blend(face, mask, albedo);
}

void Write(Face& face, const std::string& text, double height, int font, const cv::Scalar& ink) {
  const double high_px = height * face.cover.rows;
  constexpr double kThick = 0.14;  // of the height of a letter
  const int thick = std::max(1, int(kThick * high_px));
  const double scale = cv::getFontScaleFromHeight(font, int(high_px), thick);
  int below = 0;
  const cv::Size size = cv::getTextSize(text, font, scale, thick, &below);
  cv::Mat mask(face.cover.size(), CV_8U, cv::Scalar());
  cv::putText(mask, text, {(mask.cols - size.width) / 2, (mask.rows + size.height) / 2}, font,
              scale, 255, thick, cv::LINE_AA);
  Blend(face, mask, ink);
}

void Frame(Face& face, double thick, const cv::Scalar& albedo) {
  const double aside = thick * face.cover.rows / face.cover.cols;
  Fill(face, {{0, 0}, {1, 0}, {1, thick}, {0, thick}}, albedo);
  Fill(face, {{0, 1 - thick}, {1, 1 - thick}, {1, 1}, {0, 1}}, albedo);
  Fill(face, {{0, 0}, {aside, 0}, {aside, 1}, {0, 1}}, albedo);
  Fill(face, {{1 - aside, 0}, {1, 0}, {1, 1}, {1 - aside, 1}}, albedo);
}

RoomPicture::RoomPicture(const Room& room) : room_(room) {
  cv::RNG random(room.seed * 7919 + 5);
  if (room.beside == Beside::kRedShirt) PutPerson(random);
  if (room.beside == Beside::kPoster) PutPoster(random);
  if (room.beside == Beside::kWindow) PutWindow(random);
}

// Of a child or of a man, in a red shirt, behind or beside the thing.
void RoomPicture::PutPerson(cv::RNG& random) {
  const double tall = random.uniform(1.1, 1.8), ahead = random.uniform(1.2, 3.5);
  const double side = random.uniform(0.0, 1.0) < 0.5 ? 1 : -1;
  const Place place{ahead, side * random.uniform(0.35, 0.6) * ahead, tall / 2, 0, 0.36 * tall,
                    tall};
  Face face = Blank(place, {}, 0);
  const cv::Scalar trousers(random.uniform(0.03, 0.2), 0.05, 0.04);
  Fill(face, {{0.27, 0.5}, {0.73, 0.5}, {0.7, 1}, {0.54, 1}, {0.5, 0.6}, {0.46, 1}, {0.3, 1}},
       trousers);
  Fill(face, {{0.25, 0.18}, {0.75, 0.18}, {0.74, 0.53}, {0.26, 0.53}}, kRed);
  Fill(face, {{0.25, 0.18}, {0.27, 0.26}, {0.12, 0.46}, {0.02, 0.43}}, kRed);
  Fill(face, {{0.75, 0.18}, {0.73, 0.26}, {0.88, 0.46}, {0.98, 0.43}}, kRed);
  FillEllipse(face, {0.36, 0.0, 0.28, 0.16}, {0.2, 0.3, 0.5});
  Put(face, place);
}

void RoomPicture::PutPoster(cv::RNG& random) {
  const double side = random.uniform(0.0, 1.0) < 0.5 ? 1 : -1;
  const Place place{
      kWallM - 0.05, side * random.uniform(1.0, 2.2), random.uniform(0.9, 1.3), 0, 0.7, 1.0};
  Face face = Blank(place, {random.uniform(0.1, 0.7), random.uniform(0.1, 0.7), 0.6});
  FillEllipse(face, {0.2, 0.1, 0.6, 0.42}, random.uniform(0.0, 1.0) < 0.5 ? kYellow : kRed);
  Fill(face, {{0.1, 0.6}, {0.9, 0.6}, {0.9, 0.75}, {0.1, 0.75}}, kRed);
  Fill(face, {{0.1, 0.8}, {0.9, 0.8}, {0.9, 0.84}, {0.1, 0.84}}, kBlack);
  Fill(face, {{0.1, 0.88}, {0.7, 0.88}, {0.7, 0.92}, {0.1, 0.92}}, kGreen);
  Put(face, place);
}

void RoomPicture::PutWindow(cv::RNG& random) {
  const Place place{kWallM - 0.05, random.uniform(-2.0, 2.0), 1.4, 0, 1.6, 1.3};
  Face face = Blank(place, cv::Scalar(2.6, 2.3, 2.1) * random.uniform(0.7, 1.3));
  Frame(face, 0.05, kWhite);
  Fill(face, {{0.48, 0}, {0.52, 0}, {0.52, 1}, {0.48, 1}}, kWhite);
  Fill(face, {{0, 0.35}, {1, 0.35}, {1, 0.4}, {0, 0.4}}, kWhite);
  Put(face, place);
}

void RoomPicture::Put(const Face& face, const Place& place) {
  items_.push_back({face, place});
  std::stable_sort(items_.begin(), items_.end(), [](const Item& one, const Item& other) {
    return one.place.ahead_m > other.place.ahead_m;
  });
}

// The middle of a photograph, as large as the picture, or the wall and the floor.
cv::Mat RoomPicture::Behind() const {
  if (!room_.scene.empty()) {
    const double scale =
        std::max(double(kWidth) / room_.scene.cols, double(kHeight) / room_.scene.rows);
    cv::Mat large;
    cv::resize(room_.scene, large, {}, scale, scale, scale < 1 ? cv::INTER_AREA : cv::INTER_CUBIC);
    cv::Mat light(kHeight, kWidth, CV_32FC3);
    cv::getRectSubPix(large, {kWidth, kHeight},
                      {float(large.cols - 1) / 2, float(large.rows - 1) / 2}, light);
    return cv::max(light, 0);
  }
  cv::Mat light(kHeight, kWidth, CV_32FC3, cv::Scalar(0.3, 0.3, 0.3));
  const double half = kRoomWideM / 2;
  WarpAll(WallOf(room_.wall, room_.seed),
          {cv::Point3d(kWallM, half, kRoomHighM),
           {kWallM, -half, kRoomHighM},
           {kWallM, -half, 0},
           {kWallM, half, 0}},
          light);
  const int foot = int(SeenAt({kWallM, 0, 0}).at.y);
  cv::Mat floor = light.clone();
  WarpAll(FloorOf(room_.seed),
          {cv::Point3d(kWallM, half, 0), {kWallM, -half, 0}, {kNearM, -half, 0}, {kNearM, half, 0}},
          floor);
  floor.rowRange(foot, kHeight).copyTo(light.rowRange(foot, kHeight));
  return light;
}

cv::Mat RoomPicture::Taken(std::uint64_t exposure) const {
  cv::Mat light = Behind();
  for (const Item& item : items_) Warp(item.face, CornersOf(item.place), light);
  Expose(light);
  cv::Mat noise(light.size(), CV_32FC3);
  cv::RNG random(room_.seed * 31 + exposure * 1009 + 77);
  random.fill(noise, cv::RNG::NORMAL, 0, 0.006 + 0.006 / std::sqrt(room_.share));
  light += noise;
  cv::Mat bgr;
  light.convertTo(bgr, CV_8UC3, 255);
  return bgr;
}

// By what is nearer.
cv::Mat RoomPicture::HiddenOf(const Lamp& lamp) const {
  cv::Mat hidden(kHeight, kWidth, CV_32F, cv::Scalar());
  for (const Item& item : items_) {
    if (item.place.ahead_m >= lamp.ahead_m) continue;
    hidden = cv::max(hidden, HiddenBy(item.face, CornersOf(item.place)));
  }
  return hidden;
}

// From albedos to what a pixel holds, from 0 to 1.
void RoomPicture::Expose(cv::Mat& light) const {
  cv::RNG random(room_.seed * 131 + 3);
  const double brighter = random.uniform(-0.2, 0.2);  // from the left edge to the right one
  cv::Mat row(1, kWidth, CV_32F), level;
  for (int x = 0; x < kWidth; ++x) {
    row.at<float>(x) = float(1 + brighter * (x - kWidth / 2.0) / kWidth);
  }
  cv::repeat(row, kHeight, 1, level);
  if (room_.shadow) {
    cv::Mat dark(kHeight, kWidth, CV_32F, cv::Scalar(1));
    const double middle = random.uniform(0.3, 0.7), slope = random.uniform(-0.3, 0.3);
    const std::vector<cv::Point> corners{{int((middle + slope) * kWidth), 0},
                                         {kWidth, 0},
                                         {kWidth, kHeight},
                                         {int((middle - slope) * kWidth), kHeight}};
    cv::fillPoly(dark, std::vector{corners}, 0.4);
    cv::GaussianBlur(dark, dark, {}, 4);
    cv::multiply(level, dark, level);
  }
  Multiply(light, level);
  cv::multiply(light, ColorOf(room_.kelvin), light);
  // The exposure follows the light by half.
  light *= 1.4 * std::sqrt(room_.share);
  for (const Lamp& lamp : lamps_) AddLamp(lamp, HiddenOf(lamp), light);
  cv::GaussianBlur(light, light, {}, room_.blur_px);
  cv::min(light, 1, light);
  cv::pow(light, 1 / 2.2, light);
}

cv::Rect2d RoomPicture::BoxOf(const Place& place) {
  cv::Point2d least(1e9, 1e9), most(-1e9, -1e9);
  for (const cv::Point3d& corner : CornersOf(place)) {
    const cv::Point2d at = SeenAt(corner).at;
    least = {std::min(least.x, at.x), std::min(least.y, at.y)};
    most = {std::max(most.x, at.x), std::max(most.y, at.y)};
  }
  return {least, most};
}

cv::Rect2d RoomPicture::BoxOf(const Lamp& lamp) {
  const Seen seen = SeenAt({lamp.ahead_m, lamp.left_m, lamp.up_m});
  const double radius = kFocalPx * lamp.radius_m / seen.depth_m;
  return {seen.at.x - radius, seen.at.y - radius, 2 * radius, 2 * radius};
}

double RoomPicture::DepthOf(const Place& place) {
  return SeenAt({place.ahead_m, place.left_m, place.up_m}).depth_m;
}

double RoomPicture::DepthOf(const Lamp& lamp) {
  return SeenAt({lamp.ahead_m, lamp.left_m, lamp.up_m}).depth_m;
}

}  // namespace musher::vision::things
