#pragma once
// A robot behind ROS 2 topics and actions, as the nodes use it (../robot.hpp).
//
//   no topics ── Open() ──→ open ── its endpoints are dropped ──→ no topics
//
// Without topics each goal is unavailable and there is no pose: a tree may be declared and tested
// under injected faults. A goal waits kServerTime (real time) for a server and its reply. While an
// earlier goal of this robot at the same server is being cancelled, the next one waits for its end.
//
// Units and frames: those of robot.hpp. Poses in another frame than map, that are not finite, or
// that are published again with the same stamp, are ignored. Threads: the loop's.

#include <array>
#include <functional>
#include <memory>
#include <string>

#include "musher/modules/meilin/robot.hpp"
#include "musher/transport/endpoints.hpp"

namespace musher::meilin {

class RosRobot final : public Robot {
 public:
  static constexpr Duration kServerTime = std::chrono::seconds(3);

  struct Topics {
    std::string pose = "transformed/pose";
    std::string chassis = "r0x0201";
    // Of the heights in its messages: front-left, front-right, rear-left, rear-right.
    std::array<std::size_t, Wheels::kCount> wheel_order = {0, 1, 2, 3};
  };
  explicit RosRobot(Topics topics) : topics_(std::move(topics)) {}

  // Opens its topics, for as long as these endpoints exist. `warn`: what nodes want to be logged.
  void Open(transport::Endpoints& endpoints, std::function<void(const std::string&)> warn);
  // Before each tick: goals that wait are sent, cancellations that were lost are repeated.
  void Update();
  // Cancels every goal, also those that a process before this one has left behind.
  void CancelAll();
  // Goals that have not ended.
  std::size_t open_goals() const;
  // What cannot be reached: "no server of arm_action". Empty: nothing is missing.
  std::string Missing() const;

  GoalPtr MoveToPose(const std::string& server, const MoveGoal& goal) override;
  GoalPtr ControlSuspension(const std::string& server, const SuspensionGoal& goal) override;
  GoalPtr MoveArm(const std::string& server, const ArmGoal& goal) override;
  GoalPtr MoveSpear(const std::string& server, const SpearGoal& goal) override;
  std::optional<PoseFix> pose() const override { return pose_; }
  std::optional<Wheels> wheels() const override { return wheels_; }
  int suspension_state() const override { return suspension_state_; }
  const Signal& partner_ready() const override { return partner_ready_; }
  const Signal& arm_idle() const override { return arm_idle_; }
  void Warn(const std::string& text) override;

 private:
  struct Wire;

  void Subscribe(transport::Endpoints& endpoints);

  const Topics topics_;
  std::function<void(const std::string&)> warn_;
  std::weak_ptr<Wire> wire_;
  std::optional<PoseFix> pose_;
  Duration pose_stamp_{};  // of the last message
  std::optional<Wheels> wheels_;
  int suspension_state_ = 0;
  Signal partner_ready_;
  Signal arm_idle_;
};

}  // namespace musher::meilin
