#pragma once
// The tables of the sensors on the body: [lidar], [ultrasonic], [tof], [gps] and [uwb].

#include "musher/base/toml/rows.hpp"
#include "musher/modules/world/scene/sensor_specs.hpp"

namespace musher::world {

config_toml::Rows SensorRows(SensorSpecs& sensors);

// Those of [lidar], also of a robot's.
config_toml::Rows LidarRows(LidarSpec& lidar);

// Those of a robot's [range_down].
config_toml::Rows RangeDownRows(RangeDownSpec& range);

}  // namespace musher::world
