#pragma once
// Valid readings.

#include <cmath>
#include <cstdint>

#include "musher/messages/protocol/sensor.hpp"
#include "musher/messages/sensor_msgs/laser_scan.hpp"
#include "musher/messages/sensor_msgs/nav_sat_fix.hpp"

namespace musher::sensor {

inline msg::Stamp At(int seconds) {
  return {seconds, 0};
}

// 181 rays of the same distance.
inline msg::LaserScan ScanOf(float distance, int at_s = 0) {
  msg::LaserScan scan;
  scan.header = {At(at_s), "laser_frame"};
  scan.angle_min = static_cast<float>(-M_PI / 2);
  scan.angle_max = static_cast<float>(M_PI / 2);
  scan.angle_increment = static_cast<float>(M_PI / 180);
  scan.range_min = 0.1F;
  scan.range_max = 12;
  scan.ranges.assign(181, distance);
  return scan;
}

inline msg::Range RangeOf(float distance, int at_s = 0) {
  return {{At(at_s), "ultrasonic"}, msg::Range::kUltrasound, 0.5F, 0.1F, 1, distance, 0};
}

inline msg::SingleTofPayload TofOf(std::uint8_t position, int at_s = 0) {
  msg::SingleTofPayload tof;
  tof.header = {At(at_s), "tof"};
  tof.data_available = true;
  tof.tof_position = position;
  tof.data.assign(msg::SingleTofPayload::kZones, 0.4F);
  tof.intensity.assign(msg::SingleTofPayload::kZones, 0.1F);
  return tof;
}

inline msg::NavSatFix FixOf(double latitude, double longitude, int at_s = 0) {
  msg::NavSatFix fix;
  fix.header = {At(at_s), "gps"};
  fix.status = {msg::NavSatStatus::kFix, msg::NavSatStatus::kGps};
  fix.latitude = latitude;
  fix.longitude = longitude;
  return fix;
}

}  // namespace musher::sensor
