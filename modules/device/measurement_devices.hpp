#pragma once
// Sensors on I2C buses, such as a thermometer or a current meter: each value of their registers is
// published as std_msgs/Float32, latched, on measurement/NAME, in the unit of its file. A device
// without a reading that counts has no publisher, so that its last values are not taken for present
// ones.
//
// Threads: the loop's.

#include <memory>
#include <string>
#include <vector>

#include "musher/modules/device/dependencies.hpp"
#include "musher/modules/device/i2c_registers.hpp"

namespace musher::device {

struct MeasurementConfig {
  I2cProtocol registers;
  Duration silence = Milliseconds(5000);  // timeout without a reading

  friend bool operator==(const MeasurementConfig&, const MeasurementConfig&) = default;
};

class MeasurementDevices {
 public:
  MeasurementDevices(const Dependencies& dependencies,
                     const std::vector<MeasurementConfig>& measurements);
  ~MeasurementDevices();

  // Fails with 1009 while a device has no reading that counts, or cannot be published.
  Result<> Check() const;

 private:
  class Measurement;

  std::vector<std::unique_ptr<Measurement>> measurements_;
};

}  // namespace musher::device
