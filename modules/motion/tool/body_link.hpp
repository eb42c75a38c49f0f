#pragma once
// The way from a command to the motion manager: joins the domain, sends and hears.
//
// Threads: one; RunUntil() runs the loop. Ctrl-C ends a wait, not the program.

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "musher/messages/nav_msgs/odometry.hpp"
#include "musher/messages/protocol/motion.hpp"
#include "musher/modules/motion/tool/options.hpp"
#include "musher/transport/clock.hpp"
#include "musher/transport/host.hpp"
#include "musher/transport/linux_event_loop.hpp"
#include "musher/transport/service.hpp"

namespace musher::motion::tool {

class BodyLink {
 public:
  // How long a motion manager may take to be found: those with keys introduce themselves longer.
  Duration discovery() const { return Milliseconds(global_.keys.empty() ? 1200 : 4000); }

  static Result<std::unique_ptr<BodyLink>> Open(const GlobalOptions& global);

  // Runs the loop until `done` holds, at most `timeout` of steady time, or until Ctrl-C; says
  // whether it held.
  bool RunUntil(const std::function<bool()>& done, Duration timeout);
  bool interrupted() const { return interrupted_; }
  // Whether there was a Ctrl-C; waits again from now on.
  bool TakeInterrupt() { return std::exchange(interrupted_, false); }

  transport::Node& node() { return *node_; }
  transport::Clock& clock() { return *clock_; }
  // False when /clock is to be followed and nobody publishes it.
  bool AwaitClock();
  std::string Name(const char* name) const {
    return transport::ResolveName(global_.name_space, name);
  }
  Error Nobody() const;

 private:
  explicit BodyLink(GlobalOptions global);
  Result<> Join();

  const GlobalOptions global_;
  transport::UniqueFd signals_;  // before the node: its threads inherit the mask
  transport::LinuxEventLoop loop_;
  bool interrupted_ = false;
  transport::LoopHandlePtr signal_watch_;
  std::unique_ptr<transport::Node> node_;
  std::unique_ptr<transport::Clock> clock_;
};

// Sends frames of a servo motion and hears what becomes of them. Dropped, or after End(), the body
// has been told to stop.
class ServoStream {
 public:
  static Result<std::unique_ptr<ServoStream>> Open(BodyLink& link, std::int32_t id,
                                                   std::int32_t source);
  ~ServoStream() { End(); }
  ServoStream(const ServoStream&) = delete;
  ServoStream& operator=(const ServoStream&) = delete;

  void Send(const SpeedLimit& speed);
  void End();

  bool Ready() const { return commands_->MatchedReaders() > 0; }
  // End() has been heard.
  bool ended() const { return ended_; }
  // The body does this motion now.
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
  std::unique_ptr<transport::Publisher<msg::MotionServoCmd>> commands_;
  std::unique_ptr<transport::Subscription> responses_;
};

}  // namespace musher::motion::tool
