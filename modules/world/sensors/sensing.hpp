#pragma once
// The measurements of the range sensors and the GPS of a simulated body, as messages. A function
// of the world alone: random numbers depend on its seed, the sensor and the time, so that a
// reading is the same for every subscriber, and the body's random generator is not used.

#include <array>
#include <optional>
#include <string_view>

#include "musher/messages/protocol/device.hpp"
#include "musher/messages/protocol/sensor.hpp"
#include "musher/messages/sensor_msgs/laser_scan.hpp"
#include "musher/messages/sensor_msgs/nav_sat_fix.hpp"
#include "musher/messages/sensor_msgs/range.hpp"
#include "musher/messages/std_msgs/basic.hpp"
#include "musher/modules/world/simulation/world.hpp"

namespace musher::world {

// By their number in SingleTofPayload.tof_position.
inline constexpr std::array<std::string_view, 4> kTofNames = {"left_head", "right_head",
                                                              "left_rear", "right_rear"};

msg::LaserScan MeasureScan(const World& world);
msg::Range MeasureUltrasonic(const World& world);
// Zones row by row, from the left above to the right below, as the sensor sees them.
msg::SingleTofPayload MeasureTof(const World& world, std::size_t position);
msg::NavSatFix MeasureFix(const World& world);
// The number of satellites of that fix; NavSatFix has no field for it.
msg::UInt8 CountSatellites(const World& world);
// Distance and angle of the tag, the latter in rad from straight ahead, left positive; nothing
// when it is too far. n_los is 1 behind an obstacle, else 0.
std::optional<msg::UwbRaw> MeasureTag(const World& world);

}  // namespace musher::world
