#pragma once
// Publishes the measurements of a simulated body's sensors, each at its rate of world time and
// only while it has a subscriber.
//
//   world/scan   world/ultrasonic   world/gps   world/gps/satellites   world/uwb
//   world/tof/left_head, right_head, left_rear, right_rear
//
// Threads: the loop's.

#include <array>
#include <memory>
#include <string>

#include "musher/modules/world/sensors/sensing.hpp"
#include "musher/transport/node.hpp"

namespace musher::world {

class WorldSensors {
 public:
  // The sensors of the scene. Fails when an endpoint cannot be made.
  static Result<std::unique_ptr<WorldSensors>> Make(transport::Node& node, const Scene& scene,
                                                    const std::string& name_space);

  // After each step of the world.
  void OnStep(const World& world);

 private:
  void PublishTag(const World& world);

  template <msg::Message M>
  using PublisherPtr = std::unique_ptr<transport::Publisher<M>>;

  PublisherPtr<msg::LaserScan> scan_;  // null: there is none
  PublisherPtr<msg::Range> ultrasonic_;
  std::array<PublisherPtr<msg::SingleTofPayload>, kTofNames.size()> tofs_;
  PublisherPtr<msg::NavSatFix> gps_;
  PublisherPtr<msg::UInt8> satellites_;
  PublisherPtr<msg::UwbRaw> uwb_;
};

}  // namespace musher::world
