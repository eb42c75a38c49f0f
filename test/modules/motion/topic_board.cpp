#include "musher/test/modules/motion/topic_board.hpp"
#include "musher/messages/stamp.hpp"

#include <algorithm>
#include <chrono>

namespace musher::motion::testing {

TopicBoard::TopicBoard(transport::Node& node, const std::string& name_space) : node_(node) {
  states_ = transport::MakePublisher<msg::BodyState>(
                node, transport::ResolveName(name_space, "world/body_state"))
                .value();
  commands_ = transport::MakeSubscription<msg::MotionCustomCommand>(
                  node, transport::ResolveName(name_space, "world/body_command"),
                  [this](const msg::MotionCustomCommand& command, const transport::SampleInfo&) {
                    OnCommand(command);
                  })
                  .value();
  timer_ = node.loop().Every(Board::kReport, [this] { Report(); });
}

void TopicBoard::OnCommand(const msg::MotionCustomCommand& command) {
  ++commands;
  last = {};
  last.mode = command.mode;
  last.gait = command.gait_id;
  last.contact = command.contact;
  last.life_count = command.life_count;
  last.value = command.value;
  last.duration_ms = command.duration;
  std::copy_n(command.vel_des.begin(), std::min<std::size_t>(3, command.vel_des.size()),
              last.vel.begin());
  board.Take(last, node_.loop().Now());
}

void TopicBoard::Walk() {
  constexpr double kSeconds = ToSeconds(Board::kReport);
  const bool walks = board.report.mode == 11 && board.report.mode == last.mode;
  speed_.setZero();
  if (walks) speed_ << last.vel[0], last.vel[1], last.vel[2];
  speed_ *= speed_factor;
  X_OB_.translate(Eigen::Vector3d(speed_.x(), speed_.y(), 0) * kSeconds);
  X_OB_.rotate(Eigen::AngleAxisd(speed_.z() * kSeconds, Eigen::Vector3d::UnitZ()));
}

void TopicBoard::Report() {
  if (board.silent) return;
  board.report = board.Report(node_.loop().Now());
  Walk();
  const BodyReport& report = board.report;
  msg::BodyState state;
  state.header.stamp = msg::ToStamp(node_.loop().Now().time_since_epoch());
  state.mode = report.mode;
  state.gait_id = report.gait;
  state.contact = report.contact;
  state.order_process_bar = report.bar;
  state.switch_status = report.switch_status;
  state.motor_error = report.motor_error;
  state.motor_temperature = report.motor_temperature;
  state.life_count = report.life_count;
  const Eigen::Quaterniond turn(X_OB_.rotation());
  state.pose = {{X_OB_.translation().x(), X_OB_.translation().y(), 0},
                {turn.x(), turn.y(), turn.z(), turn.w()}};
  state.twist = {{speed_.x(), speed_.y(), 0}, {0, 0, speed_.z()}};
  static_cast<void>(states_->Publish(state));
  ++reports;
}

}  // namespace musher::motion::testing
