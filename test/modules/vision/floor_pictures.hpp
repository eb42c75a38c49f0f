#pragma once
// Pictures of lanes on floors that the simulated world does not have: a floor is painted from
// above, and seen through a camera whose equations are written here once more, so that neither the
// world's renderer nor the product's ground has a part in them.
//
// Frame: of the robot's stand, x ahead, y to the left, metres; the floor is 5 m by 5 m around it.
// The colours of materials are albedos, and the light is that of a black body.

#include <array>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <string>
#include <vector>

namespace musher::vision::floors {

enum class Material { kGrey, kConcrete, kOak, kBeech, kBlueMat, kWet, kParquet };

inline const std::vector<std::pair<Material, std::string>>& Materials() {
  static const std::vector<std::pair<Material, std::string>> all = {
      {Material::kGrey, "grey"},        {Material::kConcrete, "concrete, tiles"},
      {Material::kOak, "oak"},          {Material::kBeech, "beech"},
      {Material::kBlueMat, "blue mat"}, {Material::kWet, "wet spots"},
      {Material::kParquet, "parquet"}};
  return all;
}

// A tape from one place to another.
struct Tape {
  cv::Point2d from_m, to_m;
  double width_m = 0.05;
};

struct Light {
  double kelvin = 6500;
  double share = 1;    // of bright daylight
  bool pools = false;  // of warm lamps above, on the floor
};

struct Floor {
  Material material = Material::kGrey;
  Light light;
  std::vector<Tape> tapes;
  std::uint64_t seed = 1;
  cv::Mat photograph{};  // CV_32FC3, linear: repeated, instead of the material; empty: that
  double wide_m = 1;     // of it
};

struct Camera {
  bool fisheye = false;
  double x_m = 0, y_m = 0, height_m = 0.35;
  double yaw_deg = 0, pitch_deg = 0, hfov_deg = 80;
};

inline constexpr Camera kFront{false, 0.27, 0, 0.35, 0, 8, 80};
inline constexpr Camera kLeft{true, 0.22, 0.06, 0.34, 90, 20, 180};
inline constexpr Camera kRight{true, 0.22, -0.06, 0.34, -90, 20, 180};

// The floor without its tapes, CV_32FC3, linear light, blue first, 200 pixels a metre.
cv::Mat UnmarkedFloor(const Floor& floor);

// A black body's blue, green and red beside those of 6500 K (linear, of the sRGB primaries).
cv::Scalar ColorOfLight(double kelvin);

// The pictures of one floor, painted once.
class FloorPicture {
 public:
  explicit FloorPicture(const Floor& floor);
  // 640 x 480, CV_8UC3, what a camera with automatic exposure and without white balance records.
  cv::Mat SeenBy(const Camera& camera) const;

 private:
  const Floor floor_;
  cv::Mat
      above_;  // CV_32FC3, linear light, blue first; row 0 is far ahead, column 0 far to the left
};

}  // namespace musher::vision::floors
