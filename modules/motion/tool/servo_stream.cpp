#include "musher/modules/motion/tool/servo_stream.hpp"

#include <utility>

#include "musher/modules/motion/motion_code.hpp"

namespace musher::motion::tool {

Result<std::unique_ptr<ServoStream>> ServoStream::Open(program::ToolLink& link, std::int32_t id,
                                                       std::int32_t source) {
  std::unique_ptr<ServoStream> stream(new ServoStream(id, source));
  auto commands = transport::MakeDirectedPublisher<msg::MotionServoCmd>(
      link.node(), link.Name("motion_servo_cmd"),
      transport::PublisherOf<msg::MotionServoResponse>(link.Name("motion_servo_response")),
      transport::kSystemDefaultQos);
  if (!commands) return commands.error();
  stream->commands_ = std::move(commands).value();
  auto responses = transport::MakeSubscription<msg::MotionServoResponse>(
      link.node(), link.Name("motion_servo_response"),
      [raw = stream.get()](const msg::MotionServoResponse& response, const transport::SampleInfo&) {
        raw->OnResponse(response);
      });
  if (!responses) return responses.error();
  stream->responses_ = std::move(responses).value();
  return stream;
}

void ServoStream::OnResponse(const msg::MotionServoResponse& response) {
  ended_ = ending_;
  if (!sent_) return;  // for another client, or outdated
  if (response.code == kCodeOk) {
    moving_ = response.motion_id == id_ && response.status == 0;
    return;
  }
  const std::string meaning = MotionCodeText(response.code);
  refusal_ = Error{response.code, meaning.empty() ? "refused" : meaning};
}

void ServoStream::Send(const SpeedLimit& speed) {
  msg::MotionServoCmd command;
  command.motion_id = id_;
  command.cmd_type = sent_ ? msg::MotionServoCmd::kData : msg::MotionServoCmd::kStart;
  command.cmd_source = source_;
  command.vel_des.assign(speed.begin(), speed.end());
  sent_ = true;
  static_cast<void>(commands_->Publish(command));  // the next one follows
}

void ServoStream::End() {
  if (!std::exchange(sent_, false)) return;
  ending_ = true;
  msg::MotionServoCmd command;
  command.motion_id = id_;
  command.cmd_type = msg::MotionServoCmd::kEnd;
  command.cmd_source = source_;
  static_cast<void>(commands_->Publish(command));  // if it is lost, the watchdog stops the body
}

}  // namespace musher::motion::tool
