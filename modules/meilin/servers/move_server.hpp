#pragma once
// move_to_pose on the network: the pose in, velocities out, an action
// action_of_motion_interfaces/MoveToPose. A newer goal ends the present one. Without a goal it
// sends zero velocities for a while from its start on, and at each Permit(): a process before this
// one may have left the body driving. They count from when the velocity has a subscriber.
//
// Threads: the loop's. Runs on any transport.

#include <memory>
#include <string>

#include "musher/messages/action_of_motion_interfaces/move_to_pose.hpp"
#include "musher/messages/geometry_msgs/geometry.hpp"
#include "musher/messages/std_msgs/multi_array.hpp"
#include "musher/modules/meilin/servers/move_to_pose.hpp"
#include "musher/modules/meilin/servers/one_goal.hpp"

namespace musher::meilin::servers {

struct MoveConfig {
  MoveSettings settings;
  std::string action = "move_to_pose";
  std::string pose = "transformed/pose";
  std::string command = "t0x0101_pid";
  std::string climb_state = "current_state";
  std::string frame = "map";
};

class MoveServer final : public OneGoalServer<msg::MoveToPose> {
 public:
  static Result<std::unique_ptr<Server>> Make(const Dependencies& dependencies,
                                              const MoveConfig& config);
  ~MoveServer() override;

  std::string Missing() const override;

 protected:
  std::string WhyMalformed(const msg::MoveToPose::Goal& goal) const override;
  std::string Begin(const msg::MoveToPose::Goal& goal) override;
  msg::MoveToPose::Result StopWork() override;
  std::string CancelText() const override { return core_.CancelText(); }
  bool Tick() override;
  Duration Period() const override { return core_.UpdatePeriod(); }
  void Forget() override { core_.ForgetPose(); }
  void OnPermit(bool permitted) override;

 private:
  MoveServer(const Dependencies& dependencies, MoveConfig config);
  Result<> Open();
  void OnPose(const msg::PoseStamped& pose);
  void StandStill();
  void Send(const BodyVelocity& velocity);
  void Report();

  const MoveConfig config_;
  MoveToPose core_;
  Duration pose_stamp_{};  // of the last message
  transport::Publisher<msg::Float32MultiArray>* command_ = nullptr;
};

}  // namespace musher::meilin::servers
