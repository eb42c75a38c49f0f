#pragma once
// Walking from the command line: frames of a servo motion to the motion manager.

#include <memory>
#include <optional>

#include "musher/actuator/program/command_line_tool.hpp"
#include "musher/messages/protocol/motion.hpp"
#include "musher/modules/motion/motion_command.hpp"
#include "musher/transport/directed_publisher.hpp"

namespace musher::motion::tool {

// Publishes frames of a servo motion and receives the responses. The destructor and End() stop the
// body.
class ServoStream {
 public:
  static Result<std::unique_ptr<ServoStream>> Open(program::ToolLink& link, std::int32_t id,
                                                   std::int32_t source);
  ~ServoStream() { End(); }
  ServoStream(const ServoStream&) = delete;
  ServoStream& operator=(const ServoStream&) = delete;

  void Send(const SpeedLimit& speed);
  void End();

  // The motion manager is discovered.
  bool Ready() const { return commands_->Ready(); }
  // The response to End() has been received.
  bool ended() const { return ended_; }
  // The body executes this motion now.
  bool moving() const { return moving_; }
  // Why it does not, once that is known.
  const std::optional<Error>& refusal() const { return refusal_; }

 private:
  ServoStream(std::int32_t id, std::int32_t source) : id_(id), source_(source) {}
  void OnResponse(const msg::MotionServoResponse& response);

  std::int32_t id_;
  std::int32_t source_;
  bool sent_ = false;
  bool ending_ = false;
  bool ended_ = false;
  bool moving_ = false;
  std::optional<Error> refusal_;
  std::unique_ptr<transport::DirectedPublisher<msg::MotionServoCmd>> commands_;
  std::unique_ptr<transport::Subscription> responses_;
};

}  // namespace musher::motion::tool
