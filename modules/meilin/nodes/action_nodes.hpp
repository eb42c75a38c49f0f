#pragma once
// The leaves that send one goal to one server:
//
//   Align              target_x target_y target_yaw max_speed timeout_sec server_name level
//                      -> error_msg
//   MoveToPose         the same, and frame_id, which must be "map"
//   SuspensionControl  mode direction height timeout_sec server_name -> message final_state
//   ArmAction          command wait_result timeout_sec server_name -> message
//   SpearAction        command timeout_sec server_name -> message
//
// Each is RUNNING until its goal has ended, and cancels it when it is halted or its time is over.
// ArmAction with wait_result="false" has succeeded when the server accepts the goal, which goes on.
// A drive is refused where its straight way from the live pose crosses another height than that on
// which the robot stands, unless level="false": a climb runs beside it. A halt of a climb that
// SuspensionControl has begun (mode 1 or 2) is a failure, as in Move.
// A failure sets last_error and ACTION_FAILED. max_speed is not sent: the action has no field for
// it. Positions: m in the frame map, rad; heights: mm; limits: s of the tree's clock.
//
// Threads: one at a time, like the tree.

#include <cstdint>
#include <string>

#include "musher/behavior/tree/node.hpp"
#include "musher/behavior/tree/setup.hpp"
#include "musher/modules/meilin/nodes/goal_watch.hpp"
#include "musher/modules/meilin/nodes/mission_board.hpp"

namespace musher::meilin {

class GoalNode : public tree::StatefulAction {
 protected:
  GoalNode(tree::Setup& setup, Robot& robot, std::string label, double limit_s,
           const std::string& server);

  struct Begun {
    GoalPtr goal;
    std::string client;
  };
  // Throws tree::PortError where an entry is missing.
  virtual Begun Begin() = 0;
  // Why it does not begin; empty: it does.
  virtual std::string WhyNot(Time /*now*/) { return ""; }
  virtual void WhenHalted() {}
  // Whether it has succeeded before its goal has ended.
  virtual bool IsEnough() const { return false; }
  virtual void Report(const std::string& message, int final_state) = 0;

  Robot& robot() { return robot_; }
  std::string server() const { return server_.Or(own_server_); }
  double limit_s() const { return timeout_s_.Get(); }
  const GoalWatch& watch() const { return watch_; }
  MissionBoard& board() { return board_; }

 private:
  tree::Status OnStart(const tree::Tick& tick) final;
  tree::Status OnRunning(const tree::Tick& tick) final { return Look(tick.now); }
  void OnHalted(const tree::Tick&) final {
    WhenHalted();
    watch_.Cancel();
  }
  tree::Status Look(Time now);

  const std::string label_;
  tree::InPort<double> timeout_s_;
  tree::InPort<std::string> server_;
  const std::string own_server_;
  Robot& robot_;
  MissionBoard board_;
  GoalWatch watch_;
};

// Align and MoveToPose.
class PoseNode : public GoalNode {
 protected:
  PoseNode(tree::Setup& setup, Robot& robot, const Settings& settings, const char* label);

 private:
  Begun Begin() override;
  std::string WhyNot(Time now) override;
  void Report(const std::string& message, int final_state) override;

  tree::InPort<double> x_m_;
  tree::InPort<double> y_m_;
  tree::InPort<double> yaw_rad_;
  tree::InPort<double> max_speed_;
  tree::InPort<bool> level_;
  tree::OutPort<std::string> error_;
  const Settings& settings_;
};

class Align final : public PoseNode {
 public:
  Align(tree::Setup& setup, Robot& robot, const Settings& settings)
      : PoseNode(setup, robot, settings, "Align") {}
};

class MoveToPose final : public PoseNode {
 public:
  MoveToPose(tree::Setup& setup, Robot& robot, const Settings& settings);

 private:
  tree::InPort<std::string> frame_id_;
};

class SuspensionControl final : public GoalNode {
 public:
  SuspensionControl(tree::Setup& setup, Robot& robot);

 private:
  Begun Begin() override;
  void WhenHalted() override;
  void Report(const std::string& message, int final_state) override;

  tree::InPort<std::uint8_t> mode_;
  tree::InPort<std::uint8_t> direction_;
  tree::InPort<double> height_mm_;
  tree::OutPort<std::string> message_;
  tree::OutPort<int> final_state_;
  bool climbs_ = false;  // the present goal
};

class ArmAction final : public GoalNode {
 public:
  ArmAction(tree::Setup& setup, Robot& robot);

 private:
  Begun Begin() override;
  bool IsEnough() const override { return !wait_result_.Get() && watch().accepted(); }
  void Report(const std::string& message, int final_state) override;

  tree::InPort<std::uint8_t> command_;
  tree::InPort<bool> wait_result_;
  tree::OutPort<std::string> message_;
};

class SpearAction final : public GoalNode {
 public:
  SpearAction(tree::Setup& setup, Robot& robot);

 private:
  // With the first kSpearDock of a match the messages of a ready partner are counted from here on:
  // one that is ready stays so while the dock is tried again.
  Begun Begin() override;
  void Report(const std::string& message, int final_state) override;

  tree::InPort<std::uint8_t> command_;
  tree::OutPort<std::string> message_;
};

}  // namespace musher::meilin
