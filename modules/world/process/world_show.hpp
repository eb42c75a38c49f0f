#pragma once
// A humanoid and its guests on the network; the scene names all topics.
//
//   wedding/motion/pose            std_msgs/String, subscribed: the pose to take
//   wedding/motion/look_at         geometry_msgs/PointStamped, subscribed: the gaze, 0 to 1
//   wedding/motion/joint_states    sensor_msgs/JointState, every step: the joints' angles
//   wedding/motion/joint_commands  the same, the angles that the motion adapter commands
//   wedding/perception/gesture     std_msgs/String, 10 Hz while a guest makes one, then "none"
//
// Threads: the loop's.

#include <functional>
#include <optional>
#include <string>

#include "musher/messages/geometry_msgs/point_stamped.hpp"
#include "musher/messages/sensor_msgs/joint_state.hpp"
#include "musher/messages/std_msgs/string.hpp"
#include "musher/modules/world/simulation/world.hpp"
#include "musher/transport/endpoints.hpp"

namespace musher::world {

class WorldShow {
 public:
  // The humanoid and guests of the scene. `endpoints` is dropped before it and has the error if a
  // topic could not be opened. `world` outlives it.
  WorldShow(transport::Endpoints& endpoints, World& world,
            std::function<void(const std::string&)> log);
  WorldShow(const WorldShow&) = delete;
  WorldShow& operator=(const WorldShow&) = delete;

  // After each step of the world.
  void OnStep();

 private:
  void OpenHumanoid(transport::Endpoints& endpoints, const HumanoidSpec& spec);
  void PublishGesture();
  void Log(const std::optional<std::string>& line) const;

  World& world_;
  const std::function<void(const std::string&)> log_;
  Gesture gesture_ = Gesture::kNone;  // the last one published
  transport::Publisher<msg::JointState>* joint_states_ = nullptr;
  transport::Publisher<msg::JointState>* joint_commands_ = nullptr;
  transport::Publisher<msg::String>* gestures_ = nullptr;  // null: there are no guests
};

}  // namespace musher::world
