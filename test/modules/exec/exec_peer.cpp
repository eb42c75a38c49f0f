#include "musher/test/modules/exec/exec_peer.hpp"

#include <fcntl.h>

#include <csignal>
#include <fstream>
#include <iterator>

#include "musher/test/contract/domain.hpp"
#include "musher/test/modules/exec/processes.hpp"
#include "musher/transport/lifecycle_wire.hpp"

namespace musher::exec {
namespace {

constexpr const char* kStateConfig = R"(
[controller]
actuators = ["motion"]
states = ["SetUp", "TearDown", "SelfCheck", "Active", "LowPower"]
default_time = 20000
default_state = "Uninitialized"
[actuator.motion]
states = ["SetUp", "TearDown", "SelfCheck", "Active", "LowPower"]
times = [20000, 20000, 20000, 20000, 20000]
)";

void Write(const std::string& file, const std::string& text) {
  std::ofstream(file) << text;
}

}  // namespace

ExecPeer::ExecPeer() : keeper_(Keeper::Start().value()) {
  setenv("ROS_DOMAIN_ID", std::to_string(transport::TestDomain()).c_str(), 1);
  Write(config_, kStateConfig);
  node_ = transport::MakeDdsNode(loop_).value();
  status_ = transport::MakeSubscription<msg::ActuatorStatus>(
                *node_, transport::ActuatorStatusTopic(""),
                [this](const msg::ActuatorStatus& status, const transport::SampleInfo&) {
                  report_ = transport::FromMessage(status);
                  report_at_ = loop_.Now();
                },
                transport::kLatchedFromManyQos)
                .value();
  beats_ = transport::MakePublisher<msg::ControllerBeat>(*node_, transport::ControllerBeatTopic(""),
                                                         transport::kLatchedQos)
               .value();
  static_cast<void>(beats_->Publish({"robot", 1, 1, "", getpid(), 0}));
  client_ =
      transport::MakeClient<msg::ActuatorCommand>(*node_, transport::CommandService("", "motion"))
          .value();
}

void ExecPeer::Start(const std::string& exec_file) {
  Write(folder_ / "motion.toml", exec_file);
  StartWith({"--actuator", "motion", "--config", config_, folder_ / "motion.toml"});
}

void ExecPeer::StartWith(std::vector<std::string> arguments) {
  arguments.insert(arguments.begin(), std::string(MUSHER_BIN_DIR) + "/musher-exec");
  const transport::UniqueFd output(
      open((folder_ / "output").c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0600));
  process_.emplace(Child::Start({arguments, folder_.path(), {{"MUSHER_TEST", folder_.path()}}},
                                keeper_, output.get())
                       .value());
}

bool ExecPeer::AwaitVisible() {
  const bool there = AwaitStatus(
      [this](const ActuatorReport& report) { return report.state == kSetUp && client_->Ready(); });
  return there && AwaitObedience();
}

// It obeys once it has heard that this is a controller.
bool ExecPeer::AwaitObedience() {
  const Time deadline = loop_.Now() + std::chrono::seconds(20);
  while (loop_.Now() < deadline) {
    const Reply reply = Ask();
    if (reply && reply.value().verdict == msg::ActuatorCommand::kVerdictDone) return true;
  }
  return false;
}

bool ExecPeer::AwaitStatus(const std::function<bool(const ActuatorReport&)>& holds) {
  return Until([&] { return holds(report_); });
}

msg::ActuatorCommand::Request ExecPeer::Request(std::uint8_t kind) const {
  msg::ActuatorCommand::Request request;
  request.kind = kind;
  request.epoch = 1;
  request.number = number_;
  request.budget_ns = Duration(std::chrono::seconds(20)).count();
  request.incarnation = report_.incarnation;
  request.status_stamp_ns = transport::ToNanoseconds(report_.stamp);
  request.since_status_ns = Duration(std::chrono::steady_clock::now() - report_at_).count();
  return request;
}

void ExecPeer::Send(const State& target) {
  ++number_;
  reply_.reset();
  auto request = Request(msg::ActuatorCommand::kKindSwitch);
  request.target = target;
  client_->Call(request, std::chrono::seconds(60), [this](const Reply& reply) { reply_ = reply; });
}

ExecPeer::Reply ExecPeer::Ask() {
  answer_.reset();
  auto request = Request(msg::ActuatorCommand::kKindAsk);
  request.stop = true;
  client_->Call(request, std::chrono::seconds(20), [this](const Reply& reply) { answer_ = reply; });
  Until([this] { return answer_.has_value(); });
  return answer_.value();
}

bool ExecPeer::AwaitReply() {
  return Until([this] { return reply_.has_value(); });
}

ExecPeer::Reply ExecPeer::Switch(const State& target) {
  Send(target);
  AwaitReply();
  return reply_.value();
}

int ExecPeer::AwaitExit() {
  if (!process_->EndedBy(Soon())) return -1000;
  const ExitStatus status = process_->Reap();
  return status.killed ? -status.number : status.number;
}

std::string ExecPeer::Output() const {
  std::ifstream stream(folder_ / "output");
  return {std::istreambuf_iterator<char>(stream), {}};
}

bool ExecPeer::Until(const std::function<bool()>& holds) {
  return loop_.RunUntil(holds, Soon());
}

}  // namespace musher::exec
