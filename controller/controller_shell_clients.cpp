// What clients see of the controller: there only while it leads.

#include <algorithm>
#include <utility>

#include "musher/controller/controller_shell.hpp"
#include "musher/controller/wire.hpp"
#include "musher/transport/lifecycle_wire.hpp"

namespace musher {
namespace {

constexpr Duration kPublishPeriod = Milliseconds(20);

}  // namespace

Result<> ControllerShell::OpenToClients() {
  transport::Node& node = *world_.node;
  auto status = transport::MakePublisher<msg::MachineStatus>(
      node, transport::MachineStatusTopic(config_.name_space), transport::kLatchedQos);
  if (!status) return status.error();
  status_ = std::move(status).value();
  auto capabilities = CapabilityBoard::Make(node, config_, machine_);
  if (!capabilities) return capabilities.error();
  capabilities_ = std::move(capabilities).value();
  if (hooks_.open_services) {
    if (const auto opened = hooks_.open_services(); !opened) return opened;
  }
  auto info = transport::MakePublisher<msg::MachineInfo>(
      node, std::string(transport::kMachinesTopic), transport::kLatchedQos);
  if (!info) return info.error();
  info_ = std::move(info).value();
  return info_->Publish({config_.name, config_.name_space, world_.host, world_.pid});
}

// What still waits for an answer gets `why` first.
void ControllerShell::CloseToClients(const Error& why) {
  for (auto& [request, done] : std::exchange(waiting_for_answer_, {})) done(why);
  for (auto& [request, done] : std::exchange(waiting_for_result_, {})) {
    if (done) done(Refusal(why));
  }
  publish_later_ = nullptr;
  status_ = nullptr;
  info_ = nullptr;
  capabilities_ = nullptr;
  if (hooks_.close_services) hooks_.close_services();
}

// The status is latched for people and dashboards: what changes within a moment is told as one.
void ControllerShell::PublishSoon() {
  if (publish_later_ || !status_) return;
  const Time now = world_.node->loop().Now();
  publish_later_ = world_.node->loop().At(std::max(now, published_at_ + kPublishPeriod), [this] {
    publish_later_ = nullptr;
    Publish();
  });
}

void ControllerShell::Publish() {
  if (!status_) return;
  msg::MachineStatus status = Status();
  if (status == published_) return;
  static_cast<void>(
      status_->Publish(status));  // a latch that fails is told again at the next change
  published_ = std::move(status);
  published_at_ = world_.node->loop().Now();
}

msg::Capabilities ControllerShell::Capabilities() const {
  return capabilities_ ? capabilities_->Now() : msg::Capabilities{};
}

SwitchResult ControllerShell::Refusal(const Error& why) const {
  SwitchResult result;
  result.outcome = SwitchOutcome::kRefused;
  result.code = why.code;
  result.reason = why.message;
  result.state = machine_.state;
  return result;
}

msg::MachineStatus ControllerShell::Status() const {
  msg::MachineStatus status = ToMessage(config_, machine_);
  status.pid = world_.pid;
  status.host = world_.host;
  return status;
}

}  // namespace musher
