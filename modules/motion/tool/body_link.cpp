#include "musher/modules/motion/tool/body_link.hpp"

#include <sys/signalfd.h>
#include <unistd.h>

#include <csignal>
#include <filesystem>
#include <utility>

#include "musher/modules/motion/motion_code.hpp"
#include "musher/transport/dds/dds_node.hpp"

namespace musher::motion::tool {
namespace {

transport::UniqueFd TakeEndSignals() {
  sigset_t signals;
  sigemptyset(&signals);
  for (const int signal : {SIGTERM, SIGINT, SIGHUP}) sigaddset(&signals, signal);
  pthread_sigmask(SIG_BLOCK, &signals, nullptr);
  return transport::UniqueFd(signalfd(-1, &signals, SFD_CLOEXEC | SFD_NONBLOCK));
}

}  // namespace

BodyLink::BodyLink(GlobalOptions global) : global_(std::move(global)), signals_(TakeEndSignals()) {
  signal_watch_ = loop_.WhenReadable(signals_.get(), [this] {
    signalfd_siginfo signal{};
    if (read(signals_.get(), &signal, sizeof(signal)) == sizeof(signal)) interrupted_ = true;
  });
}

Result<std::unique_ptr<BodyLink>> BodyLink::Open(const GlobalOptions& global) {
  std::unique_ptr<BodyLink> link(new BodyLink(global));
  if (auto joined = link->Join(); !joined) return joined.error();
  return link;
}

Result<> BodyLink::Join() {
  transport::DdsOptions options;
  options.domain_id = global_.domain;
  options.impatient = true;
  if (!global_.keys.empty()) {
    options.credentials =
        transport::Credentials{std::filesystem::absolute(global_.keys), global_.identity};
  }
  auto node = transport::MakeDdsNode(loop_, options);
  if (!node) return node.error();
  node_ = std::move(node).value();
  if (!global_.clock_topic) {
    clock_ = transport::Clock::Steady(loop_);
    return Ok();
  }
  auto clock = transport::Clock::FromTopic(*node_);
  if (!clock) return clock.error();
  clock_ = std::move(clock).value();
  return Ok();
}

bool BodyLink::RunUntil(const std::function<bool()>& done, Duration timeout) {
  loop_.RunUntil([&] { return done() || interrupted_; }, loop_.Now() + timeout);
  return done();
}

bool BodyLink::AwaitClock() {
  return !global_.clock_topic || RunUntil([this] { return clock_->Now() != Time{}; }, discovery());
}

Error BodyLink::Nobody() const {
  return {kCodeNetError, "no motion manager in namespace '" + global_.name_space +
                             "'; use --namespace and --domain, or --transport lan for other hosts"};
}

Result<std::unique_ptr<ServoStream>> ServoStream::Open(BodyLink& link, std::int32_t id,
                                                       std::int32_t source) {
  std::unique_ptr<ServoStream> stream(new ServoStream(id, source));
  auto commands = transport::MakePublisher<msg::MotionServoCmd>(
      link.node(), link.Name("motion_servo_cmd"), transport::kSystemDefaultQos);
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
  if (!sent_) return;  // to somebody else, or too late to matter
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
