#include "musher/modules/meilin/nodes/action_nodes.hpp"

#include <utility>

namespace musher::meilin {

using tree::Status;

GoalNode::GoalNode(tree::Setup& setup, Robot& robot, std::string label, double limit_s,
                   const std::string& server)
    : label_(std::move(label)),
      timeout_s_(setup.Input<double>("timeout_sec", limit_s, "s; 0: no limit")),
      server_(setup.OptionalInput<std::string>("server_name", "of the action: " + server)),
      own_server_(server),
      robot_(robot),
      board_(setup.board()) {}

Status GoalNode::OnStart(const tree::Tick& tick) {
  Begun begun = Begin();
  board_.active_action.Set(label_);
  board_.SetState(kActionRunning);
  watch_.Begin(std::move(begun.goal), {label_, begun.client, server()}, limit_s(), tick.now);
  return Look(tick.now);
}

Status GoalNode::Look(Time now) {
  const Status status = watch_.Look(now);
  if (status == Status::kFailure) {
    board_.Fail(watch_.failure());
    Report(watch_.failure(), watch_.goal()->final_state());
    return Status::kFailure;
  }
  if (status == Status::kRunning && !IsEnough()) return Status::kRunning;
  board_.SetState(kActionSuccess);
  Report(watch_.goal()->message(), watch_.goal()->final_state());
  watch_.Release();
  return Status::kSuccess;
}

PoseNode::PoseNode(tree::Setup& setup, Robot& robot, const char* label)
    : GoalNode(setup, robot, label, 30, kMoveServer),
      x_m_(setup.Input<double>("target_x", "m, in the frame map")),
      y_m_(setup.Input<double>("target_y", "m, in the frame map")),
      yaw_rad_(setup.Input<double>("target_yaw", "rad")),
      max_speed_(setup.Input<double>("max_speed", 0.5, "m/s; not sent")),
      error_(setup.Output<std::string>("error_msg", "the failure, or \"\"")) {}

GoalNode::Begun PoseNode::Begin() {
  return {robot().MoveToPose(server(), {x_m_.Get(), y_m_.Get(), yaw_rad_.Get()}),
          MoveClientName(server())};
}

void PoseNode::Report(const std::string& message, int) {
  error_.Set(watch().succeeded() ? "" : message);
}

MoveToPose::MoveToPose(tree::Setup& setup, Robot& robot)
    : PoseNode(setup, robot, "MoveToPose"),
      frame_id_(setup.OptionalInput<std::string>("frame_id", "of the target: map")) {
  const std::string* frame = frame_id_.entry() == nullptr ? frame_id_.Find() : nullptr;
  if (frame != nullptr && *frame != "map") {
    setup.Report("frame_id", Severity::kError,
                 "port 'frame_id': the server knows the frame map only; found '" + *frame + "'");
  }
}

SuspensionControl::SuspensionControl(tree::Setup& setup, Robot& robot)
    : GoalNode(setup, robot, "SuspensionControl", 30, kSuspensionServer),
      mode_(setup.Input<std::uint8_t>("mode", std::uint8_t{0}, "0 auto, 1 up, 2 down, 3 direct")),
      direction_(setup.Input<std::uint8_t>("direction", std::uint8_t{0},
                                           "0 forward, 1 left, 2 right, 3 backward")),
      height_mm_(setup.Input<double>("height", 0.0, "of the step, or of the wheels; mm")),
      message_(setup.Output<std::string>("message", "of the server, or the failure")),
      final_state_(setup.Output<int>("final_state", "of the sequence")) {}

GoalNode::Begun SuspensionControl::Begin() {
  return {robot().ControlSuspension(server(),
                                    {mode_.Get(), direction_.Get(), height_mm_.Get(), limit_s()}),
          "SuspensionControl"};
}

void SuspensionControl::Report(const std::string& message, int final_state) {
  message_.Set(message);
  final_state_.Set(final_state);
}

ArmAction::ArmAction(tree::Setup& setup, Robot& robot)
    : GoalNode(setup, robot, "ArmAction", 30, kArmServer),
      command_(setup.Input<std::uint8_t>("command",
                                         "0 idle, 1 grasp, 2 store to body, 3 store on "
                                         "arm, 4 get body, 5 place mid, 6 place high")),
      wait_result_(setup.Input<bool>("wait_result", true, "false: done when it is accepted")),
      message_(setup.Output<std::string>("message", "of the server, or the failure")) {}

GoalNode::Begun ArmAction::Begin() {
  return {robot().MoveArm(server(), {command_.Get(), wait_result_.Get(), limit_s()}), "ArmAction"};
}

void ArmAction::Report(const std::string& message, int) {
  message_.Set(message);
}

SpearAction::SpearAction(tree::Setup& setup, Robot& robot)
    : GoalNode(setup, robot, "SpearAction", 5, kSpearServer),
      command_(setup.Input<std::uint8_t>(
          "command", "0 idle, 1 prepare, 2 grasp, 3 dock extend, 4 dock release")),
      message_(setup.Output<std::string>("message", "of the server, or the failure")) {}

GoalNode::Begun SpearAction::Begin() {
  if (command_.Get() == kSpearDock) {
    board().dock_trues.Set(static_cast<int>(robot().partner_ready().trues));
  }
  return {robot().MoveSpear(server(), {command_.Get(), limit_s()}), "SpearAction"};
}

void SpearAction::Report(const std::string& message, int) {
  message_.Set(message);
}

}  // namespace musher::meilin
