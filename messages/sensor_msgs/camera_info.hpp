#pragma once
#include "musher/messages/std_msgs/header.hpp"

namespace musher::msg {

// sensor_msgs/msg/RegionOfInterest: the part of the full picture that is in the Image; all 0 is
// the whole.
struct RegionOfInterest {
  static constexpr std::string_view kTypeName = "sensor_msgs::msg::dds_::RegionOfInterest_";
  std::uint32_t x_offset = 0;
  std::uint32_t y_offset = 0;
  std::uint32_t height = 0;
  std::uint32_t width = 0;
  bool do_rectify = false;

  template <class Self>
  static auto Fields(Self& m) {
    return std::tie(m.x_offset, m.y_offset, m.height, m.width, m.do_rectify);
  }
  friend bool operator==(const RegionOfInterest&, const RegionOfInterest&) = default;
};

// sensor_msgs/msg/CameraInfo: how a camera sees. Lengths in pixels.
struct CameraInfo {
  static constexpr std::string_view kTypeName = "sensor_msgs::msg::dds_::CameraInfo_";

  static constexpr std::string_view kPlumbBob = "plumb_bob";       // of a pinhole camera
  static constexpr std::string_view kEquidistant = "equidistant";  // of a fisheye

  Header header;
  std::uint32_t height = 0;
  std::uint32_t width = 0;
  std::string distortion_model;
  std::vector<double> d;       // the model's parameters
  std::array<double, 9> k{};   // camera matrix: fx 0 cx, 0 fy cy, 0 0 1
  std::array<double, 9> r{};   // rectification
  std::array<double, 12> p{};  // projection
  std::uint32_t binning_x = 0;
  std::uint32_t binning_y = 0;
  RegionOfInterest roi;

  template <class Self>
  static auto Fields(Self& m) {
    return std::tie(m.header, m.height, m.width, m.distortion_model, m.d, m.k, m.r, m.p,
                    m.binning_x, m.binning_y, m.roi);
  }
  friend bool operator==(const CameraInfo&, const CameraInfo&) = default;
};

}  // namespace musher::msg
