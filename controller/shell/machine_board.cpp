#include "musher/controller/shell/machine_board.hpp"

#include <algorithm>
#include <chrono>
#include <utility>

#include "musher/controller/shell/wire.hpp"
#include "musher/wire/lifecycle_wire.hpp"

namespace musher {
namespace {

constexpr Duration kPublishPeriod = Milliseconds(20);
constexpr Duration kUnsavedPeriod = Milliseconds(500);  // a save takes less on a disk that works

}  // namespace

MachineBoard::MachineBoard(ShellContext context, const ControllerPresence& presence)
    : context_(std::move(context)),
      dependencies_(context_.dependencies),
      config_(context_.config),
      machine_(context_.machine),
      presence_(presence) {}

Result<> MachineBoard::Open() {
  transport::Node& node = *dependencies_.node;
  auto status = transport::MakePublisher<msg::MachineStatus>(
      node, transport::MachineStatusTopic(config_.name_space), transport::kLatchedQos);
  if (!status) return status.error();
  status_ = std::move(status).value();
  auto capabilities = CapabilityBoard::Make(node, config_, machine_);
  if (!capabilities) return capabilities.error();
  capabilities_ = std::move(capabilities).value();
  return Ok();
}

Result<> MachineBoard::Announce() {
  auto info = transport::MakePublisher<msg::MachineInfo>(
      *dependencies_.node, std::string(transport::kMachinesTopic), transport::kLatchedQos);
  if (!info) return info.error();
  info_ = std::move(info).value();
  return info_->Publish({config_.name, config_.name_space, dependencies_.host, dependencies_.pid,
                         presence_.machine().id, dependencies_.node->participant().value()});
}

void MachineBoard::Close() {
  publish_later_ = nullptr;
  status_ = nullptr;
  info_ = nullptr;
  capabilities_ = nullptr;
}

void MachineBoard::Refresh() {
  PublishSoon();
  PublishWhileUnsaved();
  if (capabilities_) capabilities_->Refresh();
}

// The status is latched for people and dashboards: changes within kPublishPeriod are published as
// one.
void MachineBoard::PublishSoon() {
  if (publish_later_ || !status_) return;
  const Time now = context_.loop().Now();
  publish_later_ = context_.loop().At(std::max(now, published_at_ + kPublishPeriod), [this] {
    publish_later_ = nullptr;
    PublishStatus();
  });
}

// The status shows how long a value is not on disk, so it must be republished.
void MachineBoard::PublishWhileUnsaved() {
  if (machine_.saves.unsaved.empty()) {
    unsaved_timer_ = nullptr;
  } else if (!unsaved_timer_) {
    const Time now = context_.loop().Now();
    unsaved_timer_ = context_.loop().At(now + kUnsavedPeriod, [this] {
      unsaved_timer_ = nullptr;
      PublishSoon();
      PublishWhileUnsaved();
    });
  }
}

void MachineBoard::SetOtherVendors(std::vector<std::string> others) {
  other_vendors_ = std::move(others);
  PublishSoon();
}

void MachineBoard::SetViolatedRules(std::vector<std::string> rules) {
  if (rules == violated_rules_) return;
  violated_rules_ = std::move(rules);
  PublishSoon();
}

void MachineBoard::SetNotStopped(std::vector<std::string> actuators) {
  if (actuators == not_stopped_) return;
  not_stopped_ = std::move(actuators);
  PublishSoon();
}

void MachineBoard::PublishStatus() {
  if (!status_) return;
  msg::MachineStatus status = Status();
  if (status == published_) return;
  static_cast<void>(status_->Publish(status));  // a failed publish is repeated at the next change
  published_ = std::move(status);
  published_at_ = context_.loop().Now();
}

msg::Capabilities MachineBoard::Capabilities() const {
  return capabilities_ ? capabilities_->Now() : msg::Capabilities{};
}

msg::MachineStatus MachineBoard::Status() const {
  msg::MachineStatus status = ToMessage(config_, machine_);
  status.pid = dependencies_.pid;
  status.host = dependencies_.host;
  status.machine_id = presence_.machine().id;
  status.participant = dependencies_.node->participant().value();
  status.other_vendors = other_vendors_;
  status.violated_rules = violated_rules_;
  status.not_stopped = not_stopped_;
  for (const ControllerPresence::Rival& other : presence_.OtherMachines()) {
    status.other_machines.push_back(MachineText(other.machine) + ", " + other.process);
  }
  const Time now = context_.loop().Now();
  for (const Unsaved& unsaved : machine_.saves.unsaved) {
    // The caller that engages a stop, or sets an actuator, waits until it is saved.
    const bool at_once =
        unsaved.what == Stored::kEmergencyStops || unsaved.what == Stored::kActuators;
    if (!at_once && now - unsaved.since < kUnsavedPeriod && unsaved.why.empty()) continue;
    const auto age = std::chrono::duration_cast<std::chrono::seconds>(now - unsaved.since).count();
    status.not_on_disk.push_back(std::string(StoredName(unsaved.what)) + " (" +
                                 std::to_string(age) + " s)" +
                                 (unsaved.why.empty() ? "" : ": " + unsaved.why));
  }
  return status;
}

}  // namespace musher
