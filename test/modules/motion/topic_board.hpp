#pragma once
// The board behind world/body_command and world/body_state, on any transport. The body walks at
// the commanded speed.
//
// Threads: its node's loop only.

#include <Eigen/Geometry>
#include <memory>
#include <string>

#include "musher/messages/musher_msgs/body.hpp"
#include "musher/messages/protocol/motion.hpp"
#include "musher/test/modules/motion/board.hpp"
#include "musher/transport/node.hpp"

namespace musher::motion::testing {

class TopicBoard {
 public:
  explicit TopicBoard(transport::Node& node, const std::string& name_space = "");

  Board board;
  int commands = 0;  // frames that came
  int reports = 0;   // that went
  BodyCommand last;  // of them
  double speed_factor = 1;

 private:
  void OnCommand(const msg::MotionCustomCommand& command);
  void Report();
  void Walk();

  transport::Node& node_;
  Eigen::Isometry3d X_OB_ = Eigen::Isometry3d::Identity();
  Eigen::Vector3d speed_ = Eigen::Vector3d::Zero();  // x, y in m/s, yaw in rad/s
  std::unique_ptr<transport::Publisher<msg::BodyState>> states_;
  std::unique_ptr<transport::Subscription> commands_;
  transport::LoopHandlePtr timer_;
};

}  // namespace musher::motion::testing
