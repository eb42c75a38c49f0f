// The controller's topics and services for clients; they exist only while it leads.

#include <algorithm>
#include <chrono>
#include <string>
#include <utility>

#include "musher/controller/shell/controller_shell.hpp"
#include "musher/controller/shell/wire.hpp"
#include "musher/wire/lifecycle_wire.hpp"

namespace musher {
namespace {

constexpr Duration kPublishPeriod = Milliseconds(20);
constexpr Duration kUnsavedPeriod = Milliseconds(500);  // a save takes less on a disk that works

}  // namespace

Result<> ControllerShell::OpenToClients() {
  transport::Node& node = *dependencies_.node;
  auto status = transport::MakePublisher<msg::MachineStatus>(
      node, transport::MachineStatusTopic(config_.name_space), transport::kLatchedQos);
  if (!status) return status.error();
  status_ = std::move(status).value();
  auto capabilities = CapabilityBoard::Make(node, config_, machine_);
  if (!capabilities) return capabilities.error();
  capabilities_ = std::move(capabilities).value();
  if (hooks_.open_services) {
    if (auto opened = hooks_.open_services(); !opened) return opened;
  }
  auto info = transport::MakePublisher<msg::MachineInfo>(
      node, std::string(transport::kMachinesTopic), transport::kLatchedQos);
  if (!info) return info.error();
  info_ = std::move(info).value();
  return info_->Publish({config_.name, config_.name_space, dependencies_.host, dependencies_.pid,
                         machine_identity().id});
}

// Requests that still wait for an answer get `why` first.
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

// The status is latched for people and dashboards: changes within kPublishPeriod are published as
// one.
void ControllerShell::PublishSoon() {
  if (publish_later_ || !status_) return;
  const Time now = dependencies_.node->loop().Now();
  publish_later_ =
      dependencies_.node->loop().At(std::max(now, published_at_ + kPublishPeriod), [this] {
        publish_later_ = nullptr;
        PublishStatus();
      });
}

// The status shows how long a value is not on disk, so it must be republished.
void ControllerShell::PublishWhileUnsaved() {
  if (machine_.saves.unsaved.empty()) {
    unsaved_timer_ = nullptr;
  } else if (!unsaved_timer_) {
    const Time now = dependencies_.node->loop().Now();
    unsaved_timer_ = dependencies_.node->loop().At(now + kUnsavedPeriod, [this] {
      unsaved_timer_ = nullptr;
      PublishSoon();
      PublishWhileUnsaved();
    });
  }
}

void ControllerShell::PublishStatus() {
  if (!status_) return;
  msg::MachineStatus status = Status();
  if (status == published_) return;
  static_cast<void>(status_->Publish(status));  // a failed publish is repeated at the next change
  published_ = std::move(status);
  published_at_ = dependencies_.node->loop().Now();
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
  status.pid = dependencies_.pid;
  status.host = dependencies_.host;
  status.machine_id = presence_->machine().id;
  status.participant = dependencies_.node->participant().value();
  for (const ControllerPresence::Rival& other : presence_->OtherMachines()) {
    status.other_machines.push_back(MachineText(other.machine) + ", " + other.process);
  }
  const Time now = dependencies_.node->loop().Now();
  for (const Unsaved& unsaved : machine_.saves.unsaved) {
    // The caller that engages a stop waits until it is saved.
    const bool at_once = unsaved.what == Stored::kEmergencyStops;
    if (!at_once && now - unsaved.since < kUnsavedPeriod && unsaved.why.empty()) continue;
    const auto age = std::chrono::duration_cast<std::chrono::seconds>(now - unsaved.since).count();
    status.not_on_disk.push_back(std::string(StoredName(unsaved.what)) + " (" +
                                 std::to_string(age) + " s)" +
                                 (unsaved.why.empty() ? "" : ": " + unsaved.why));
  }
  return status;
}

}  // namespace musher
