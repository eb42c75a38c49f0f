#pragma once
// Pictures of boards, bars, lamps and codes in rooms that the simulated world does not have. Flat
// faces are painted, and seen through a camera whose equations are written here once more: neither
// the world's renderer nor the product has a part in them.
//
// Frame: x ahead of the camera, y to the left, z up from the floor, metres; the camera is 0.35 m
// over the floor, inclined 8 degrees downwards, 80 degrees wide, 640 x 480 pixels. Colours of
// materials are albedos in linear light, blue first; the light is that of a black body, and the
// camera has no white balance. The same seed gives the same picture. Threads: one at a time.

#include <array>
#include <cstdint>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

namespace musher::vision::things {

enum class Wall { kPlaster, kBricks, kWood };
enum class Beside { kNothing, kRedShirt, kPoster, kWindow };

struct Room {
  Wall wall = Wall::kPlaster;
  Beside beside = Beside::kNothing;
  double kelvin = 6500;
  double share = 1;  // of bright daylight
  bool shadow = false;
  double blur_px = 0.7;
  cv::Mat scene{};  // CV_32FC3, linear: a photograph instead of wall and floor; empty: these
  std::uint64_t seed = 1;
};

// A flat thing before it is seen. Both have one size.
struct Face {
  cv::Mat albedo;  // CV_32FC3
  cv::Mat cover;   // CV_32F: 0 is a hole, 1 hides what is behind
};

// The middle of a face, which looks at the camera when it is not turned.
struct Place {
  double ahead_m = 2, left_m = 0, up_m = 0.35;
  double yaw_deg = 0;
  double width_m = 0.4, height_m = 0.4;
};

struct Lamp {
  double ahead_m = 2, left_m = 0, up_m = 0.4, radius_m = 0.1;
  cv::Scalar color{0.02, 0.55, 1};  // of its light: blue, green, red
  double brightness = 1;            // of its middle, in whites of daylight
};

inline constexpr double kFocalPx = 381.4;

inline const cv::Scalar kWhite(0.8, 0.82, 0.82), kBlack(0.02, 0.02, 0.02);
inline const cv::Scalar kGreen(0.08, 0.33, 0.04), kRed(0.03, 0.03, 0.5), kYellow(0.03, 0.52, 0.8);
inline const cv::Scalar kAmber(0.01, 0.3, 1), kLampYellow(0.03, 0.62, 1), kLampWhite(1, 1, 1);

// Corners are shares of a face, from its upper left corner.
using Corners = std::vector<cv::Point2d>;

// A face of one colour, as fine as the camera sees it there; `cover` 0: nothing yet.
Face Blank(const Place& place, const cv::Scalar& albedo, double cover = 1);
void Fill(Face& face, const Corners& corners, const cv::Scalar& albedo);
void FillEllipse(Face& face, const cv::Rect2d& box, const cv::Scalar& albedo);
// In its middle, as high as that share of the face.
void Write(Face& face, const std::string& text, double height, int font, const cv::Scalar& ink);
// A frame along its edges, as thick as that share of its height.
void Frame(Face& face, double thick, const cv::Scalar& albedo);

class RoomPicture {
 public:
  explicit RoomPicture(const Room& room);

  void Put(const Face& face, const Place& place);
  void PutLamp(const Lamp& lamp) { lamps_.push_back(lamp); }

  // What the camera records, CV_8UC3; each exposure has noise of its own.
  cv::Mat Taken(std::uint64_t exposure = 0) const;

  // Where the face, or the lamp, is in the picture.
  static cv::Rect2d BoxOf(const Place& place);
  static cv::Rect2d BoxOf(const Lamp& lamp);

  // How far its middle is ahead of the camera, along the camera's axis.
  static double DepthOf(const Place& place);
  static double DepthOf(const Lamp& lamp);

 private:
  struct Item {
    Face face;
    Place place;
  };
  cv::Mat Behind() const;  // the things
  void PutPerson(cv::RNG& random);
  void PutPoster(cv::RNG& random);
  void PutWindow(cv::RNG& random);
  void Expose(cv::Mat& light) const;
  cv::Mat HiddenOf(const Lamp& lamp) const;

  const Room room_;
  std::vector<Item> items_;
  std::vector<Lamp> lamps_;
};

}  // namespace musher::vision::things
