#pragma once
// Reads the tables of the sensors on the body: [lidar], [ultrasonic], [tof] and [gps].

#include "musher/base/toml/table_reader.hpp"
#include "musher/modules/world/scene/sensor_specs.hpp"

namespace musher::world {

void ReadSensors(config_toml::TableReader& root, config_toml::Findings& findings,
                 SensorSpecs& sensors);

}  // namespace musher::world
