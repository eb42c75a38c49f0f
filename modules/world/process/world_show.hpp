#pragma once
// A humanoid and its guests on the network; the scene names all topics.
//
//   /wedding/motion/pose            std_msgs/String, subscribed: the pose to take
//   /wedding/motion/look_at         geometry_msgs/PointStamped, subscribed: the gaze, 0 to 1
//   /wedding/motion/joint_states    sensor_msgs/JointState, every step: the joints' angles
//   /wedding/motion/joint_commands  the same, the angles that the motion adapter commands
//   /wedding/perception/gesture     std_msgs/String, 10 Hz while a guest makes one, then "none"
//
// Threads: the loop's.

#include <functional>
#include <memory>
#include <string>

#include "musher/messages/geometry_msgs/point_stamped.hpp"
#include "musher/messages/sensor_msgs/joint_state.hpp"
#include "musher/messages/std_msgs/string.hpp"
#include "musher/modules/world/simulation/world.hpp"
#include "musher/transport/node.hpp"

namespace musher::world {

class WorldShow {
 public:
  // The humanoid and guests of the scene. Fails when an endpoint cannot be made. `world` outlives
  // it.
  static Result<std::unique_ptr<WorldShow>> Make(transport::Node& node, World& world,
                                                 const std::string& name_space,
                                                 std::function<void(const std::string&)> log);

  // After each step of the world.
  void OnStep();

 private:
  template <msg::Message M>
  using PublisherPtr = std::unique_ptr<transport::Publisher<M>>;

  WorldShow(World& world, std::function<void(const std::string&)> log)
      : world_(world), log_(std::move(log)) {}
  Result<> Connect(transport::Node& node, const std::string& name_space);
  Result<> ConnectHumanoid(transport::Node& node, const std::string& name_space);
  void PublishGesture();
  void Log(const std::optional<std::string>& line) const;

  World& world_;
  const std::function<void(const std::string&)> log_;
  Gesture gesture_ = Gesture::kNone;  // the last one published
  PublisherPtr<msg::JointState> joint_states_;
  PublisherPtr<msg::JointState> joint_commands_;
  PublisherPtr<msg::String> gestures_;
  std::unique_ptr<transport::Subscription> poses_;  // last: their callbacks use the rest
  std::unique_ptr<transport::Subscription> looks_;
};

}  // namespace musher::world
