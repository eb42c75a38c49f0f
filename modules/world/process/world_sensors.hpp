#pragma once
// Publishes the measurements of a simulated body's sensors, each at its rate of world time and
// only while it has a subscriber.
//
//   world/scan   world/ultrasonic   world/gps   world/gps/satellites   world/uwb
//   world/tof/left_head, right_head, left_rear, right_rear
//
// Threads: the loop's.

#include <array>

#include "musher/modules/world/sensors/sensing.hpp"
#include "musher/transport/endpoints.hpp"

namespace musher::world {

class WorldSensors {
 public:
  // The sensors of the scene. `endpoints` has the error if a topic could not be opened.
  WorldSensors(transport::Endpoints& endpoints, const Scene& scene);

  // After each step of the world.
  void OnStep(const World& world);

 private:
  void PublishTag(const World& world);

  transport::Publisher<msg::LaserScan>* scan_ = nullptr;  // null: there is none
  transport::Publisher<msg::Range>* ultrasonic_ = nullptr;
  std::array<transport::Publisher<msg::SingleTofPayload>*, kTofNames.size()> tofs_{};
  transport::Publisher<msg::NavSatFix>* gps_ = nullptr;
  transport::Publisher<msg::UInt8>* satellites_ = nullptr;
  transport::Publisher<msg::UwbRaw>* uwb_ = nullptr;
};

}  // namespace musher::world
