#pragma once
// A competition field on the network: the hardware topics of its robot R2, and its partner R1.
//
//   t0x0101_pid       std_msgs/Float32MultiArray, subscribed: [vx, vy, wz] in the body's frame
//   t0x0102_action    std_msgs/Float32MultiArray, subscribed: the heights of the wheels, mm
//   t0x0103_, _0104_  std_msgs/Float32MultiArray, subscribed: a command of the arm, of the spear
//   r0x0201           std_msgs/Float32MultiArray, 100 Hz: 4 photo switches, 4 heights, mm, 4 zeros
//   sensor_distances  std_msgs/Float32MultiArray, 100 Hz: 8 distances in mm
//   r0x0203, r0x0204  std_msgs/Float32MultiArray, 100 Hz: [0] is 1 when the command is done
//   transformed/pose  geometry_msgs/PoseStamped, 50 Hz, in the frame "map"
//   r1_ready          std_msgs/Bool, 5 Hz
//   world/field       std_srvs/Trigger, served: its report as JSON
//
// Rates are of world time; two samples of 100 Hz are published in a step of the world.
//
// Threads: the loop's.

#include <functional>
#include <map>
#include <optional>
#include <string>

#include "musher/messages/geometry_msgs/geometry.hpp"
#include "musher/messages/std_msgs/basic.hpp"
#include "musher/messages/std_msgs/multi_array.hpp"
#include "musher/modules/world/simulation/world.hpp"
#include "musher/transport/endpoints.hpp"

namespace musher::world {

class WorldField {
 public:
  // Opens nothing in a scene without a field. `endpoints` is dropped before it; `world` outlives
  // it.
  WorldField(transport::Endpoints& endpoints, World& world,
             std::function<void(const std::string&)> log);
  WorldField(const WorldField&) = delete;
  WorldField& operator=(const WorldField&) = delete;

  // After each step of the world.
  void OnStep();

 private:
  using Floats = msg::Float32MultiArray;

  // Subscribes; `handle` returns the reason when it refuses the numbers. A refusal is logged once
  // until a command of this topic is accepted.
  void Listen(transport::Endpoints& endpoints, const std::string& topic, std::size_t numbers,
              std::function<std::optional<std::string>(const std::vector<float>&)> handle);
  void PublishReadings(const Field& field);

  World& world_;
  const std::function<void(const std::string&)> log_;
  std::map<std::string, std::string> refused_;  // the last refusal, by topic
  transport::Publisher<Floats>* suspension_ = nullptr;
  transport::Publisher<Floats>* distances_ = nullptr;
  transport::Publisher<Floats>* arm_ = nullptr;
  transport::Publisher<Floats>* spear_ = nullptr;
  transport::Publisher<msg::PoseStamped>* pose_ = nullptr;
  transport::Publisher<msg::Bool>* ready_ = nullptr;
  bool was_ready_ = false;
};

}  // namespace musher::world
