#include "musher/test/modules/actuator_peer.hpp"

#include <fcntl.h>

#include <csignal>
#include <fstream>
#include <iterator>
#include <utility>

#include "musher/test/modules/exec/processes.hpp"
#include "musher/test/support/domain.hpp"
#include "musher/test/support/paths.hpp"
#include "musher/wire/lifecycle_wire.hpp"

namespace musher::test {
namespace {

void Write(const std::string& file, const std::string& text) {
  std::ofstream(file) << text;
}

std::string StateConfig(const std::string& actuator, const std::vector<std::string>& states,
                        const std::string& keys = "") {
  std::string names;
  std::string times;
  for (const std::string& state : states) {
    names += "\"" + state + "\", ";
    times += "20000, ";
  }
  return "[controller]\nactuators = [\"" + actuator + "\"]\nstates = [" + names +
         "]\nstate_dir = \"state\"\ndefault_time = 20000\ndefault_state = "
         "\"Uninitialized\"\n" +
         keys + "[actuator." + actuator + "]\nstates = [" + names + "]\ntimes = [" + times + "]\n";
}

}  // namespace

ActuatorPeer::ActuatorPeer(std::string actuator, const std::vector<std::string>& states,
                           std::string program)
    : actuator_(std::move(actuator)),
      states_(states),
      program_(std::move(program)),
      reaper_(exec::Reaper::Start().value()) {
  setenv("ROS_DOMAIN_ID", std::to_string(transport::TestDomain()).c_str(), 1);
  Write(config_, StateConfig(actuator_, states_));
  node_ = transport::MakeDdsNode(loop_).value();
  status_ = transport::MakeSubscription<msg::ActuatorStatus>(
                *node_, transport::ActuatorStatusTopic(""),
                [this](const msg::ActuatorStatus& status, const transport::SampleInfo&) {
                  // One that was killed may be received still, after its successor's.
                  if (process_ && status.pid != process_->pid()) return;
                  report_ = transport::FromMessage(status);
                  report_at_ = loop_.Now();
                },
                transport::kLatchedFromManyQos)
                .value();
  heartbeats_ = transport::MakePublisher<msg::ControllerHeartbeat>(
                    *node_, transport::ControllerHeartbeatTopic(""), transport::kLatchedQos)
                    .value();
  static_cast<void>(heartbeats_->Publish({"", 1, 1, "", getpid(), 0}));
  client_ =
      transport::MakeClient<msg::ActuatorCommand>(*node_, transport::CommandService("", actuator_))
          .value();
}

void ActuatorPeer::Start(const std::string& module_file) {
  const std::string file = folder_ / (actuator_ + ".toml");
  Write(file, module_file);
  StartWith({"--actuator", actuator_, "--config", config_, file});
}

void ActuatorPeer::StartOnWorldTime(const std::string& module_file) {
  Write(config_, StateConfig(actuator_, states_, "clock = \"topic\"\n"));
  Start(module_file);
}

void ActuatorPeer::StartWith(std::vector<std::string> arguments) {
  arguments.insert(arguments.begin(), BinDir() + "/" + program_);
  const UniqueFd output(
      open((folder_ / "output").c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0600));
  process_.emplace(
      exec::Child::Start({arguments, folder_.path(), {{"MUSHER_TEST", folder_.path()}}}, reaper_,
                         output.get())
          .value());
}

bool ActuatorPeer::AwaitVisible() {
  const bool there = AwaitStatus(
      [this](const ActuatorReport& report) { return report.state == kSetUp && client_->Ready(); });
  return there && AwaitObedience();
}

// It accepts commands once it has received the announcement of this controller.
bool ActuatorPeer::AwaitObedience() {
  const Time deadline = loop_.Now() + std::chrono::seconds(120);
  while (loop_.Now() < deadline) {
    const Reply reply = Query();
    if (reply && reply.value().verdict == msg::ActuatorCommand::kVerdictDone) return true;
  }
  return false;
}

bool ActuatorPeer::AwaitStatus(const std::function<bool(const ActuatorReport&)>& holds) {
  return Until([&] { return holds(report_); });
}

msg::ActuatorCommand::Request ActuatorPeer::Request(std::uint8_t kind) const {
  msg::ActuatorCommand::Request request;
  request.kind = kind;
  request.epoch = 1;
  request.number = number_;
  request.budget_ns = Duration(std::chrono::seconds(120)).count();
  request.incarnation = report_.incarnation.value();
  request.status_stamp_ns = transport::ToNanoseconds(report_.stamp);
  request.since_status_ns = Duration(std::chrono::steady_clock::now() - report_at_).count();
  return request;
}

void ActuatorPeer::Send(const State& target) {
  ++number_;
  reply_.reset();
  auto request = Request(msg::ActuatorCommand::kKindSwitch);
  request.target = target;
  client_->Call(request, std::chrono::seconds(180), [this](const Reply& reply) { reply_ = reply; });
}

// One that a process has not received because its predecessor, which was killed, is still the only
// server that is known, is sent again.
ActuatorPeer::Reply ActuatorPeer::Query() {
  answer_.reset();
  auto request = Request(msg::ActuatorCommand::kKindQuery);
  request.stop = true;
  client_->Call(request, std::chrono::seconds(3), [this](const Reply& reply) { answer_ = reply; });
  Until([this] { return answer_.has_value(); });
  return answer_.value();
}

bool ActuatorPeer::AwaitReply() {
  return Until([this] { return reply_.has_value(); });
}

ActuatorPeer::Reply ActuatorPeer::Switch(const State& target) {
  Send(target);
  AwaitReply();
  return reply_.value();
}

int ActuatorPeer::AwaitExit() {
  if (!process_->EndedBy(exec::Soon())) return -1000;
  const ExitStatus status = process_->Reap();
  return status.killed ? -status.number : status.number;
}

std::string ActuatorPeer::Output() const {
  std::ifstream stream(folder_ / "output");
  return {std::istreambuf_iterator<char>(stream), {}};
}

bool ActuatorPeer::Until(const std::function<bool()>& holds) {
  return loop_.RunUntil(holds, exec::Soon());
}

}  // namespace musher::test
