#pragma once
#include "musher/messages/std_msgs/header.hpp"

namespace musher::msg {

// sensor_msgs/msg/NavSatStatus: how a position was found, and by whose satellites (a bit each).
struct NavSatStatus {
  static constexpr std::string_view kTypeName = "sensor_msgs::msg::dds_::NavSatStatus_";

  static constexpr std::int8_t kUnknown = -2;
  static constexpr std::int8_t kNoFix = -1;
  static constexpr std::int8_t kFix = 0;
  static constexpr std::int8_t kSbasFix = 1;  // with corrections from satellites
  static constexpr std::int8_t kGbasFix = 2;  // with corrections from the ground
  static constexpr std::uint16_t kGps = 1;
  static constexpr std::uint16_t kGlonass = 2;
  static constexpr std::uint16_t kCompass = 4;
  static constexpr std::uint16_t kGalileo = 8;

  std::int8_t status = kUnknown;
  std::uint16_t service = 0;

  template <class Self>
  static auto Fields(Self& m) {
    return std::tie(m.status, m.service);
  }
  friend bool operator==(const NavSatStatus&, const NavSatStatus&) = default;
};

// sensor_msgs/msg/NavSatFix: a position on the WGS 84 ellipsoid.
struct NavSatFix {
  static constexpr std::string_view kTypeName = "sensor_msgs::msg::dds_::NavSatFix_";

  static constexpr std::uint8_t kCovarianceUnknown = 0;
  static constexpr std::uint8_t kCovarianceApproximated = 1;
  static constexpr std::uint8_t kCovarianceDiagonalKnown = 2;
  static constexpr std::uint8_t kCovarianceKnown = 3;

  Header header;
  NavSatStatus status;
  double latitude = 0;
  double longitude = 0;
  double altitude = 0;
  std::array<double, 9> position_covariance{};
  std::uint8_t position_covariance_type = kCovarianceUnknown;

  template <class Self>
  static auto Fields(Self& m) {
    return std::tie(m.header, m.status, m.latitude, m.longitude, m.altitude, m.position_covariance,
                    m.position_covariance_type);
  }
  friend bool operator==(const NavSatFix&, const NavSatFix&) = default;
};

}  // namespace musher::msg
