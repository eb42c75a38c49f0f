#include "musher/test/modules/vision/floor_pictures.hpp"

namespace musher::vision::floors {
namespace {

constexpr double kSideM = 5, kPxPerM = 200;
constexpr int kSidePx = static_cast<int>(kSideM * kPxPerM);
constexpr int kWidth = 640, kHeight = 480;
const cv::Scalar kTape(0.03, 0.52, 0.83);  // linear albedo of yellow tape: blue, green, red

cv::Point2d PixelOf(const cv::Point2d& at_m) {
  return {(kSideM / 2 - at_m.y) * kPxPerM, (kSideM / 2 - at_m.x) * kPxPerM};
}

// Soft blotches of about that size, from -1 to 1.
cv::Mat Blotches(cv::RNG& random, double size_x_m, double size_y_m) {
  cv::Mat coarse(std::max(2, int(kSideM / size_x_m)), std::max(2, int(kSideM / size_y_m)), CV_32F);
  random.fill(coarse, cv::RNG::UNIFORM, -1, 1);
  cv::Mat fine;
  cv::resize(coarse, fine, {kSidePx, kSidePx}, 0, 0, cv::INTER_CUBIC);
  return fine;
}

// setTo: Mat's constructor with a color copies it pixel by pixel.
cv::Mat Even(const cv::Scalar& albedo) {
  cv::Mat floor(kSidePx, kSidePx, CV_32FC3);
  floor.setTo(albedo);
  return floor;
}

void Multiply(cv::Mat& floor, const cv::Mat& by) {
  cv::Mat three;
  cv::merge(std::vector<cv::Mat>{by, by, by}, three);
  cv::multiply(floor, three, floor);
}

// Planks along x, each of its own tint, with grain and dark joints.
cv::Mat Wood(cv::RNG& random, const cv::Scalar& albedo, double contrast) {
  cv::Mat floor = Even(albedo);
  constexpr double kPlankM = 0.13, kPlankLongM = 1.1;
  for (int row = 0; row * kPlankM < kSideM; ++row) {
    const int left = int(row * kPlankM * kPxPerM), right = int((row + 1) * kPlankM * kPxPerM);
    double begin_m = -random.uniform(0.0, kPlankLongM);
    while (begin_m < kSideM) {
      const double tint = 1 + random.uniform(-contrast, contrast);
      const cv::Rect plank(left, int(begin_m * kPxPerM), right - left, int(kPlankLongM * kPxPerM));
      const cv::Rect inside = plank & cv::Rect(0, 0, kSidePx, kSidePx);
      if (inside.area() > 0) {
        floor(inside) *= tint;
        cv::rectangle(floor, plank, albedo * 0.3, 1);
      }
      begin_m += kPlankLongM;
    }
  }
  Multiply(floor, 1 + 0.12 * Blotches(random, 0.5, 0.008));
  return floor;
}

// Strips of oak, ash and walnut along x, as wide as a line.
cv::Mat Parquet(cv::RNG& random) {
  cv::Mat floor = Even({0, 0, 0});
  constexpr double kStripM = 0.07, kStripLongM = 0.45;
  const std::array<cv::Scalar, 3> woods{cv::Scalar(0.1, 0.2, 0.33), cv::Scalar(0.28, 0.4, 0.49),
                                        cv::Scalar(0.04, 0.07, 0.12)};
  for (int row = 0; row * kStripM < kSideM; ++row) {
    const int left = int(row * kStripM * kPxPerM), right = int((row + 1) * kStripM * kPxPerM);
    double begin_m = -random.uniform(0.0, kStripLongM);
    while (begin_m < kSideM) {
      const cv::Rect strip(left, int(begin_m * kPxPerM), right - left, int(kStripLongM * kPxPerM));
      const cv::Scalar& wood = woods.at(std::size_t(random.uniform(0, 3)));
      const cv::Rect inside = strip & cv::Rect(0, 0, kSidePx, kSidePx);
      if (inside.area() > 0) floor(inside).setTo(wood * random.uniform(0.9, 1.1));
      begin_m += kStripLongM;
    }
  }
  Multiply(floor, 1 + 0.1 * Blotches(random, 0.5, 0.008));
  return floor;
}

cv::Mat Concrete(cv::RNG& random) {
  cv::Mat floor = Even({0.28, 0.29, 0.3});
  Multiply(floor, 1 + 0.18 * Blotches(random, 0.4, 0.4));
  Multiply(floor, 1 + 0.08 * Blotches(random, 0.02, 0.02));
  for (double at = 0; at < kSidePx; at += 0.6 * kPxPerM) {
    cv::line(floor, cv::Point(int(at), 0), cv::Point(int(at), kSidePx), {0.12, 0.12, 0.12}, 2);
    cv::line(floor, cv::Point(0, int(at)), cv::Point(kSidePx, int(at)), {0.12, 0.12, 0.12}, 2);
  }
  return floor;
}

// Side by side, each second one mirrored, so that the edges of a photograph are no joints.
cv::Mat Repeated(const cv::Mat& photograph, double wide_m) {
  const double scale = wide_m * kPxPerM / photograph.cols;
  cv::Mat once, mirrored, row;
  cv::resize(photograph, once, {}, scale, scale, scale < 1 ? cv::INTER_AREA : cv::INTER_LINEAR);
  cv::flip(once, mirrored, 1);
  cv::hconcat(once, mirrored, row);
  cv::flip(row, mirrored, 0);
  cv::vconcat(row, mirrored, row);
  cv::Mat floor;
  cv::repeat(row, kSidePx / row.rows + 1, kSidePx / row.cols + 1, floor);
  return floor(cv::Rect(0, 0, kSidePx, kSidePx)).clone();
}

cv::Mat FloorOf(const Floor& floor, cv::RNG& random) {
  if (!floor.photograph.empty()) return Repeated(floor.photograph, floor.wide_m);
  switch (floor.material) {
    case Material::kOak:
      return Wood(random, {0.1, 0.2, 0.33}, 0.18);
    case Material::kBeech:
      return Wood(random, {0.19, 0.36, 0.52}, 0.1);
    case Material::kBlueMat:
      return Even({0.3, 0.09, 0.03});
    case Material::kConcrete:
    case Material::kWet:
      return Concrete(random);
    case Material::kParquet:
      return Parquet(random);
    case Material::kGrey:
      break;
  }
  cv::Mat grey = Even({0.21, 0.21, 0.21});
  Multiply(grey, 1 + 0.05 * Blotches(random, 0.03, 0.03));
  return grey;
}

// What mirrors the lamps: white, over everything.
void Wet(cv::Mat& floor, cv::RNG& random) {
  cv::Mat shine = Blotches(random, 0.7, 0.7) - 0.35;
  cv::threshold(shine, shine, 0, 0, cv::THRESH_TOZERO);
  cv::Mat three;
  cv::merge(std::vector<cv::Mat>{shine, shine, shine}, three);
  floor += three;
}

// Pools of the light of warm lamps, beside that of the hall.
void AddPools(cv::Mat& floor, cv::RNG& random) {
  constexpr int kLamps = 4;
  const cv::Scalar warm(0.25, 0.7, 1.4);
  cv::Mat light = Even({1, 1, 1});
  for (int i = 0; i < kLamps; ++i) {
    const cv::Point at = PixelOf({random.uniform(-0.5, 1.5), random.uniform(-1.5, 1.5)});
    const int radius_px = int(random.uniform(0.25, 0.5) * kPxPerM);
    const int reach_px = 2 * radius_px;  // of its light, with the soft edge
    const cv::Rect area(at.x - reach_px, at.y - reach_px, 2 * reach_px + 1, 2 * reach_px + 1);
    cv::Mat pool = cv::Mat::zeros(area.size(), CV_32FC3);
    cv::circle(pool, at - area.tl(), radius_px, warm * random.uniform(1.0, 3.0), cv::FILLED);
    cv::blur(pool, pool, {radius_px, radius_px});
    const cv::Rect lit = area & cv::Rect({0, 0}, floor.size());
    light(lit) += pool(lit - area.tl());
  }
  cv::multiply(floor, light, floor);
}

// From the camera through a pixel, in the body's frame; false outside of a fisheye's circle.
bool RayOf(const Camera& camera, double column, double row, cv::Vec3d& ray) {
  const double half = camera.hfov_deg / 2 * M_PI / 180;
  const double u = (column + 0.5 - kWidth / 2.0) / (kWidth / 2.0);
  const double v = (row + 0.5 - kHeight / 2.0) / (kWidth / 2.0);
  cv::Vec3d seen;  // ahead, left, up of the camera
  if (camera.fisheye) {
    const double angle = std::hypot(u, v) * half;
    if (angle > half) return false;
    const double side = angle == 0 ? 0 : std::sin(angle) / std::hypot(u, v);
    seen = {std::cos(angle), -u * side, -v * side};
  } else {
    seen = {1, -u * std::tan(half), -v * std::tan(half)};
  }
  const double pitch = camera.pitch_deg * M_PI / 180, yaw = camera.yaw_deg * M_PI / 180;
  const cv::Vec3d level(seen[0] * std::cos(pitch) + seen[2] * std::sin(pitch), seen[1],
                        seen[2] * std::cos(pitch) - seen[0] * std::sin(pitch));
  ray = {level[0] * std::cos(yaw) - level[1] * std::sin(yaw),
         level[0] * std::sin(yaw) + level[1] * std::cos(yaw), level[2]};
  return true;
}

struct Maps {
  cv::Mat x, y;
};

Maps MapsOf(const Camera& camera) {
  Maps maps{cv::Mat(kHeight, kWidth, CV_32F, cv::Scalar(-1)),
            cv::Mat(kHeight, kWidth, CV_32F, cv::Scalar(-1))};
  for (int row = 0; row < kHeight; ++row) {
    for (int column = 0; column < kWidth; ++column) {
      cv::Vec3d ray;
      if (!RayOf(camera, column, row, ray) || ray[2] > -0.02) continue;
      const double far = camera.height_m / -ray[2];
      const cv::Point2d at = PixelOf({camera.x_m + far * ray[0], camera.y_m + far * ray[1]});
      maps.x.at<float>(row, column) = float(at.x);
      maps.y.at<float>(row, column) = float(at.y);
    }
  }
  return maps;
}

// Once for each camera.
const Maps& KnownMapsOf(const Camera& camera) {
  static const std::array<Maps, 3> all{MapsOf(kFront), MapsOf(kLeft), MapsOf(kRight)};
  return all.at(!camera.fisheye ? 0 : camera.yaw_deg > 0 ? 1 : 2);
}

}  // namespace

cv::Scalar ColorOfLight(double kelvin) {
  const std::array<std::array<double, 4>, 3> known{
      {{3000, 0.33, 0.66, 1.43}, {6500, 1, 1, 1}, {8000, 1.13, 1.02, 0.9}}};
  const auto& low = kelvin <= 6500 ? known[0] : known[1];
  const auto& high = kelvin <= 6500 ? known[1] : known[2];
  const double t = std::clamp((kelvin - low[0]) / (high[0] - low[0]), 0.0, 1.0);
  return {low[1] + t * (high[1] - low[1]), low[2] + t * (high[2] - low[2]),
          low[3] + t * (high[3] - low[3])};
}

cv::Mat UnmarkedFloor(const Floor& floor) {
  cv::RNG random(floor.seed);
  cv::Mat above = FloorOf(floor, random);
  if (floor.light.pools) AddPools(above, random);
  if (floor.material == Material::kWet) Wet(above, random);
  return above;
}

FloorPicture::FloorPicture(const Floor& floor) : floor_(floor) {
  cv::RNG random(floor.seed);
  above_ = FloorOf(floor, random);
  for (const Tape& tape : floor.tapes) {
    const cv::Point2d along = (tape.to_m - tape.from_m) / cv::norm(tape.to_m - tape.from_m);
    const cv::Point2d aside = cv::Point2d(-along.y, along.x) * (tape.width_m / 2);
    std::vector<cv::Point> corners;
    for (const cv::Point2d& corner :
         {tape.from_m + aside, tape.to_m + aside, tape.to_m - aside, tape.from_m - aside}) {
      corners.push_back(PixelOf(corner));
    }
    cv::fillConvexPoly(above_, corners, kTape * random.uniform(0.85, 1.0));
  }
  if (floor.light.pools) AddPools(above_, random);
  if (floor.material == Material::kWet) Wet(above_, random);
  cv::GaussianBlur(above_, above_, {5, 5}, 1);
}

cv::Mat FloorPicture::SeenBy(const Camera& camera) const {
  const Maps& maps = KnownMapsOf(camera);
  cv::Mat seen;
  cv::remap(above_, seen, maps.x, maps.y, cv::INTER_LINEAR, cv::BORDER_CONSTANT,
            cv::Scalar(0.35, 0.35, 0.35));  // beyond: a wall
  cv::GaussianBlur(seen, seen, {3, 3}, 0.7);
  // The exposure follows the light down to a fifth of daylight; below it the picture is darker.
  constexpr double kAutomatic = 0.2;
  cv::multiply(
      seen,
      ColorOfLight(floor_.light.kelvin) * (1.6 * std::min(1.0, floor_.light.share / kAutomatic)),
      seen);
  cv::min(seen, 1, seen);
  cv::pow(seen, 1 / 2.2, seen);
  cv::Mat noise(seen.size(), CV_32FC3);
  cv::RNG random(floor_.seed + 77);
  random.fill(noise, cv::RNG::NORMAL, 0,
              0.01 + 0.012 / std::sqrt(std::max(0.05, floor_.light.share)) / 2);
  seen += noise;
  cv::Mat bgr;
  seen.convertTo(bgr, CV_8UC3, 255);
  return bgr;
}

}  // namespace musher::vision::floors
