#include "musher/controller/ros2/diagnostics.hpp"

#include <algorithm>
#include <utility>

#include "musher/base/joined.hpp"
#include "musher/messages/builtin_interfaces/time.hpp"
#include "musher/messages/stamp.hpp"
#include "musher/transport/lost_samples.hpp"

namespace musher {
namespace {

using Status = msg::DiagnosticStatus;

constexpr Duration kDiagnosticsPeriod = std::chrono::seconds(1);
// Changes within this time are published together.
constexpr Duration kDiagnosticsDelay = Milliseconds(100);
constexpr Duration kRecentlyLost = std::chrono::seconds(60);

const char* YesOrNo(bool yes) {
  return yes ? "yes" : "no";
}

// "Active", "Active, switching to LowPower"
std::string Describe(const std::string& state, const std::string& target) {
  return target.empty() || target == state ? state : state + ", switching to " + target;
}

Status OfMachine(const msg::MachineStatus& machine) {
  Status status;
  status.name = machine.machine + ": machine";
  status.hardware_id = machine.host;
  status.message = Describe(machine.state, machine.target);
  if (machine.phase != "running") status.message = machine.phase + ", " + status.message;
  if (!machine.degraded.empty()) {
    status.level = Status::kWarn;
    status.message += ", degraded: " + Joined(machine.degraded);
  }
  for (const std::string& rule : machine.violated_rules) {
    status.level = Status::kWarn;
    status.message += ", rule violated: " + rule;
  }
  if (machine.phase == "failed") status.level = Status::kError;
  if (machine.emergency_stop) {
    status.level = Status::kError;
    status.message += ", emergency stop by " + machine.emergency_stop_by +
                      (machine.emergency_stop_reason.empty() ? "" : ": ") +
                      machine.emergency_stop_reason;
  }
  for (const std::string& actuator : machine.not_stopped) {
    status.message += ", NOT STOPPED: " + actuator;
  }
  status.values = {{"state", machine.state},
                   {"phase", machine.phase},
                   {"epoch", std::to_string(machine.epoch)},
                   {"last switch", std::to_string(machine.switch_number)},
                   {"emergency stop", YesOrNo(machine.emergency_stop)}};
  return status;
}

std::uint8_t LevelOf(const msg::ActuatorInfo& actuator) {
  const bool away = actuator.presence == "lost";
  const bool bad = actuator.health != "well" && actuator.health != "starved";
  if (away || bad || (actuator.degraded && actuator.critical)) return Status::kError;
  if (actuator.degraded || actuator.health == "starved") return Status::kWarn;
  return actuator.presence == "present" ? Status::kOk : Status::kStale;
}

Status OfActuator(const std::string& machine, const msg::ActuatorInfo& actuator) {
  Status status;
  status.level = LevelOf(actuator);
  status.name = machine + ": " + actuator.name;
  status.hardware_id = actuator.host;
  const bool present = actuator.presence == "present";
  status.message = present ? Describe(actuator.state, actuator.target) : actuator.presence;
  if (actuator.health != "well") status.message += ", " + actuator.health;
  if (actuator.degraded) status.message += ", degraded: " + actuator.message;
  status.values = {{"state", actuator.state},
                   {"presence", actuator.presence},
                   {"health", actuator.health},
                   {"pid", std::to_string(actuator.pid)},
                   {"protocol", actuator.protocol},
                   {"restarts", std::to_string(actuator.restarts)},
                   {"code", std::to_string(actuator.code)},
                   {"critical", YesOrNo(actuator.critical)}};
  return status;
}

Status OfBattery(const std::string& machine, const msg::PolicyInfo& policy) {
  Status status;
  status.name = machine + ": battery";
  status.message = std::to_string(policy.battery) + " %" + (policy.charging ? ", charging" : "");
  if (!policy.ceiling.empty()) {
    status.level = Status::kWarn;
    status.message += ", the machine is limited to " + policy.ceiling;
  }
  if (policy.battery < 0) {
    status.level = Status::kStale;
    status.message = "no sample received yet";
  } else if (policy.battery_silent) {
    status.level = Status::kStale;
    status.message += ", no recent sample";
  }
  status.values = {{"percent", std::to_string(policy.battery)},
                   {"charging", YesOrNo(policy.charging)}};
  return status;
}

Status OfDds(const msg::MachineStatus& machine, const DdsLosses& losses) {
  Status status;
  status.level = losses.recently ? Status::kWarn : Status::kOk;
  status.name = machine.machine + ": DDS";
  status.hardware_id = machine.host;
  const std::string lost = std::to_string(losses.lost_samples);
  status.message = losses.recently ? "the controller loses samples: " + lost + " so far"
                                   : "the controller loses no samples";
  status.values = {{"lost samples", lost}};
  return status;
}

}  // namespace

msg::DiagnosticArray ToDiagnostics(const msg::MachineStatus& status, const DdsLosses& losses) {
  msg::DiagnosticArray array;
  array.status.reserve(status.actuators.size() + 3);
  array.status.push_back(OfMachine(status));
  for (const msg::ActuatorInfo& actuator : status.actuators) {
    array.status.push_back(OfActuator(status.machine, actuator));
  }
  if (status.policy.active) array.status.push_back(OfBattery(status.machine, status.policy));
  array.status.push_back(OfDds(status, losses));
  return array;
}

Result<std::unique_ptr<Diagnostics>> Diagnostics::Make(transport::Node& node,
                                                       ControllerShell& shell,
                                                       std::function<std::int64_t()> wall_ns) {
  std::unique_ptr<Diagnostics> diagnostics(new Diagnostics(node, shell, std::move(wall_ns)));
  Diagnostics* self = diagnostics.get();
  // ROS 2's topic for all robots of the domain, outside the machine's namespace.
  auto publisher = transport::MakePublisher<msg::DiagnosticArray>(
      node, "diagnostics", transport::kDefaultQos, {[self] { self->OnSubscribers(); }});
  if (!publisher) return publisher.error();
  diagnostics->publisher_ = std::move(publisher).value();
  diagnostics->OnSubscribers();
  return diagnostics;
}

void Diagnostics::OnSubscribers() {
  if (!HasSubscriber()) {
    every_second_ = nullptr;
  } else if (!every_second_) {
    PublishSoon();
    every_second_ = node_.loop().Every(kDiagnosticsPeriod, [this] { Publish(); });
  }
}

void Diagnostics::PublishSoon() {
  if (soon_ || !HasSubscriber()) return;
  const Time due = std::max(node_.loop().Now(), published_at_ + kDiagnosticsDelay);
  soon_ = node_.loop().At(due, [this] {
    soon_ = nullptr;
    Publish();
  });
}

void Diagnostics::Publish() {
  const Time now = node_.loop().Now();
  const std::uint64_t lost = transport::LostSamples();
  if (lost != std::exchange(lost_, lost)) lost_at_ = now;
  auto array = ToDiagnostics(shell_.Status(), {lost, lost_at_ && now - *lost_at_ < kRecentlyLost});
  array.header.stamp = msg::ToStamp(std::chrono::nanoseconds(wall_ns_()));
  published_at_ = now;
  static_cast<void>(publisher_->Publish(array));  // a lost array is followed by the next
}

}  // namespace musher
