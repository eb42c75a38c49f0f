#pragma once
// Reads the tables of the sensors on the body: [lidar], [ultrasonic], [tof] and [gps].

#include "musher/base/toml/table_reader.hpp"
#include "musher/modules/world/scene/sensor_specs.hpp"

namespace musher::world {

void ReadSensors(config_toml::TableReader& root, config_toml::Findings& findings,
                 SensorSpecs& sensors);

// [lidar], and that of a robot.
void ReadLidar(config_toml::TableReader& reader, LidarSpec& lidar);

}  // namespace musher::world
