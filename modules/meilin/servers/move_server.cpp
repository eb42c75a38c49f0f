#include "musher/modules/meilin/servers/move_server.hpp"

#include <cmath>
#include <numbers>
#include <utility>

#include "musher/messages/stamp.hpp"
#include "musher/messages/std_msgs/basic.hpp"

namespace musher::meilin::servers {
namespace {

constexpr double kDegreesPerRadian = 180 / std::numbers::pi;

double YawOf(const msg::Quaternion& q) {
  return std::atan2(2 * (q.w * q.z + q.x * q.y), 1 - 2 * (q.y * q.y + q.z * q.z));
}

}  // namespace

MoveServer::MoveServer(const Dependencies& dependencies, MoveConfig config)
    : OneGoalServer(dependencies, true), config_(std::move(config)), core_(config_.settings) {}

MoveServer::~MoveServer() {
  Interrupt("ROS shutdown during goal execution");
}

Result<std::unique_ptr<Server>> MoveServer::Make(const Dependencies& dependencies,
                                                 const MoveConfig& config) {
  std::unique_ptr<MoveServer> server(new MoveServer(dependencies, config));
  if (const Result<> opened = server->Open(); !opened) return opened.error();
  return std::unique_ptr<Server>(std::move(server));
}

Result<> MoveServer::Open() {
  command_ = endpoints().Advertise<msg::Float32MultiArray>(config_.command);
  endpoints().Subscribe<msg::PoseStamped>(config_.pose,
                                          [this](const msg::PoseStamped& pose) { OnPose(pose); });
  endpoints().Subscribe<msg::Int32>(
      config_.climb_state, [this](const msg::Int32& state) { core_.OnClimbing(state.data != 0); },
      transport::kDefaultQos);
  Serve(config_.action);
  if (endpoints().opened()) StandStill();
  return endpoints().opened();
}

void MoveServer::OnPose(const msg::PoseStamped& pose) {
  const std::string& frame = pose.header.frame_id;
  if (!frame.empty() && frame != config_.frame) {
    return Warn("frame", "a pose is ignored: its frame is '" + frame + "', expected '" +
                             config_.frame + "'");
  }
  const msg::Quaternion& q = pose.pose.orientation;
  if (q.x == 0 && q.y == 0 && q.z == 0 && q.w == 0) {
    return Warn("orientation", "a pose is ignored: its orientation is (0, 0, 0, 0)");
  }
  const Duration stamp = msg::FromStamp(pose.header.stamp);
  const Duration last = std::exchange(pose_stamp_, stamp);
  if (stamp == last && stamp != Duration{}) return;  // published again: not where the body is now
  core_.OnPose({pose.pose.position.x, pose.pose.position.y, YawOf(q)}, Now(), stamp);
}

void MoveServer::OnPermit(bool /*permitted*/) {
  if (!busy()) StandStill();
}

void MoveServer::StandStill() {
  core_.Stop(Now());
  Send({});
  Arm();
}

std::string MoveServer::WhyMalformed(const msg::MoveToPose::Goal& goal) const {
  if (std::isfinite(goal.x) && std::isfinite(goal.y) && std::isfinite(goal.yaw_deg)) return "";
  return "x, y or yaw_deg is not a finite number";
}

std::string MoveServer::Begin(const msg::MoveToPose::Goal& goal) {
  core_.Begin({goal.x, goal.y, goal.yaw_deg / kDegreesPerRadian}, Now());
  return "";
}

msg::MoveToPose::Result MoveServer::StopWork() {
  core_.Stop(Now());
  Send({});
  return {};
}

bool MoveServer::Tick() {
  if (!busy() && command_->MatchedReaders() == 0) core_.Stop(Now());
  const MoveToPose::Step step = core_.Update(Now());
  if (step.command) Send(*step.command);
  const bool braking = core_.phase() == MovePhase::kBrake;
  if (!step.end && !braking && !step.idle) Report();
  if (step.end) Conclude({step.end->success, step.end->message});
  return step.idle;
}

void MoveServer::Report() {
  const MoveFeedback& now = core_.feedback();
  msg::MoveToPose::Feedback feedback;
  feedback.phase = MovePhaseName(core_.phase());
  feedback.current_x = now.current.x_m;
  feedback.current_y = now.current.y_m;
  feedback.current_yaw_deg = now.current.yaw_rad * kDegreesPerRadian;
  feedback.target_x = now.target.x_m;
  feedback.target_y = now.target.y_m;
  feedback.target_yaw_deg = now.target.yaw_rad * kDegreesPerRadian;
  feedback.yaw_error_deg = now.yaw_error_rad * kDegreesPerRadian;
  feedback.distance_error = now.distance_m;
  feedback.cmd_vx = now.command.x_m_s;
  feedback.cmd_vy = now.command.y_m_s;
  feedback.cmd_wz = now.command.yaw_rad_s;
  Feedback(feedback);
}

void MoveServer::Send(const BodyVelocity& velocity) {
  msg::Float32MultiArray message;
  message.data = {static_cast<float>(velocity.x_m_s), static_cast<float>(velocity.y_m_s),
                  static_cast<float>(velocity.yaw_rad_s)};
  static_cast<void>(command_->Publish(message));  // the next one comes soon
}

std::string MoveServer::Missing() const {
  const std::string blind = core_.Blind(Now());
  if (!blind.empty()) return blind + " on " + config_.pose;
  return command_->MatchedReaders() > 0 ? "" : "no subscriber of " + config_.command;
}

}  // namespace musher::meilin::servers
