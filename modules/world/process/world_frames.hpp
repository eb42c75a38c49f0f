#pragma once
// What RViz needs of the robots of a world, at 20 Hz of world time where nothing else is said:
//
//   R/robot_description  std_msgs/String, latched: the URDF of each robot R
//   robot_description    of the body
//   joint_states         sensor_msgs/JointState, of a humanoid, while subscribed
//   /tf                  tf2_msgs/TFMessage, whatever the namespace, while subscribed: of each
//                        robot R/odom → R/base_link by its odometry, of the body odom → base_link
//                        and its joints, and map → odom if the scene is localised
//   /tf_static           latched: map → R/odom, for its odometry is exact without a fault, and
//                        what is fixed on them
//
// The frames of the body have no prefix and /tf is one for all namespaces, so a DDS domain has one
// world with a body at most.
//
// Threads: the loop's.

#include <vector>

#include "musher/messages/sensor_msgs/joint_state.hpp"
#include "musher/messages/std_msgs/string.hpp"
#include "musher/messages/tf2_msgs/tf_message.hpp"
#include "musher/modules/world/process/robot_model.hpp"
#include "musher/modules/world/process/world_robots.hpp"
#include "musher/transport/endpoints.hpp"

namespace musher::world {

class WorldFrames {
 public:
  // `endpoints` is dropped before it and has the error if a topic could not be opened. `world` and
  // `robots` outlive it.
  WorldFrames(transport::Endpoints& endpoints, const World& world, WorldRobots& robots);
  WorldFrames(const WorldFrames&) = delete;
  WorldFrames& operator=(const WorldFrames&) = delete;

  // After each step of the world.
  void OnStep();

 private:
  void Describe(transport::Endpoints& endpoints, const std::string& topic, const RobotModel& model,
                msg::TfMessage& fixed);
  msg::TfMessage Moving() const;

  const World& world_;
  WorldRobots& robots_;
  std::vector<ModelJoint> joints_;                      // of a humanoid, those that turn
  transport::Publisher<msg::TfMessage>* tf_ = nullptr;  // null: the world has no robot
  transport::Publisher<msg::JointState>* joint_states_ = nullptr;
};

}  // namespace musher::world
