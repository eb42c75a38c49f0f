#include "musher/modules/device/battery_device.hpp"

#include <cmath>
#include <string>
#include <utility>

namespace musher::device {
namespace {

using msg::BmsCmd;

std::string Percent(const BatteryReading& reading) {
  return std::to_string(std::lround(reading.percent)) + " %";
}

}  // namespace

BatteryDevice::BatteryDevice(const Dependencies& around, const BatteryConfig& config,
                             OnStatus on_status)
    : around_(around), config_(config), on_status_(std::move(on_status)) {}

Result<std::unique_ptr<BatteryDevice>> BatteryDevice::Make(const Dependencies& around,
                                                           const BatteryConfig& config,
                                                           OnStatus on_status) {
  std::unique_ptr<BatteryDevice> device(new BatteryDevice(around, config, std::move(on_status)));
  if (Result<> connected = device->Connect(); !connected) return connected.error();
  return device;
}

Result<> BatteryDevice::Connect() {
  auto status = transport::MakePublisher<msg::BmsStatus>(around_.node, around_.Name("bms_status"));
  if (!status) return status.error();
  status_ = std::move(status).value();
  auto power = transport::MakePublisher<msg::Bool>(around_.node, around_.Name("world/motor_power"),
                                                   transport::kLatchedQos);
  if (!power) return power.error();
  motor_power_ = std::move(power).value();
  auto commands = transport::MakeServer<Command>(
      around_.node, around_.Name("bms_cmd"), [this](const Command::Request& request, auto reply) {
        const Result<> done = Execute(request);
        if (!done) around_.log("bms_cmd refused: " + done.error().message);
        reply({done.ok(), done ? kCodeOk : done.error().code});
      });
  if (!commands) return commands.error();
  commands_ = std::move(commands).value();
  if (config_.source == BatterySource::kWorld) {
    transport::SubscriptionEvents events;
    events.on_match_changed = [this] {
      // A world that is gone takes its clock along: no silence would ever be over.
      if (told_ && readings_->MatchedWriters() == 0) Lose("nobody publishes world/battery");
    };
    auto readings = transport::MakeSubscription<msg::BatteryState>(
        around_.node, around_.Name("world/battery"),
        [this](const msg::BatteryState& state, const auto&) { OnReading(FromMessage(state)); },
        transport::kDefaultQos, std::move(events));
    if (!readings) return readings.error();
    readings_ = std::move(readings).value();
  } else if (config_.source == BatterySource::kHost) {
    poll_ = around_.clock.Every(config_.period, [this] { ReadHost(); });
    ReadHost();
  }
  return Ok();
}

void BatteryDevice::ReadHost() {
  const auto reading = ReadHostBattery(config_.folder, config_.name);
  reading ? OnReading(reading.value()) : Refuse(reading.error().message);
}

// One line when readings begin to be refused, not one for each.
void BatteryDevice::Refuse(const std::string& reason) {
  const std::string complaint = "its readings are refused: " + reason;
  if (complaint_ == complaint) return;
  complaint_ = complaint;
  around_.log("battery: refused: " + reason);
}

void BatteryDevice::OnReading(const BatteryReading& reading) {
  if (const Result<> fine = Judge(reading); !fine) return Refuse(fine.error().message);
  Hear();
  const bool held_before = filter_.held().has_value();
  const std::optional<BatteryReading> counts = filter_.Take(reading);
  if (filter_.held() && !held_before) {
    around_.log("battery: a jump to " + Percent(reading) + " waits for the next reading");
  }
  if (!counts) return;
  told_ = counts;
  if (!complaint_.empty()) around_.log("battery: well, at " + Percent(*counts));
  complaint_.clear();
  PublishWhenDue();
}

void BatteryDevice::Hear() {
  silence_ = around_.clock.At(around_.clock.Now() + config_.silence, [this] {
    Lose("silent for " + std::to_string(ToMilliseconds(config_.silence)) + " ms");
  });
}

void BatteryDevice::Lose(const std::string& why) {
  told_.reset();
  due_.reset();
  silence_.reset();
  complaint_ = why;
  around_.log("battery: " + complaint_);
}

void BatteryDevice::PublishWhenDue() {
  const Time now = around_.clock.Now();
  if (!published_ || now - *published_ >= kLeastPause) {
    due_.reset();
    Publish();
  } else if (!due_) {
    due_ = around_.clock.At(*published_ + kLeastPause, [this] {
      due_.reset();
      Publish();
    });
  }
}

void BatteryDevice::Publish() {
  if (!told_) return;
  published_ = around_.clock.Now();
  msg::BmsStatus status = ToBmsStatus(*told_, motors_powered_);
  status.header = {around_.stamp(), "battery_id"};
  static_cast<void>(status_->Publish(status));  // the next one comes soon
  on_status_(status);
}

void BatteryDevice::OnTimeJumped() {
  published_.reset();
  if (due_) PublishWhenDue();
}

Result<> BatteryDevice::Check() const {
  if (config_.source == BatterySource::kNone) return Ok();
  const auto failed = [](const std::string& why) {
    return Error{BmsCode(KeyCode::kSelfCheckFailed), why};
  };
  if (readings_ && readings_->MatchedWriters() == 0)
    return failed("nobody publishes world/battery");
  if (!complaint_.empty()) return failed(complaint_);
  return Ok();
}

Result<> BatteryDevice::Execute(const Command::Request& request) {
  const std::uint8_t motors = request.electric_machine_command;
  const std::uint8_t charging = request.wireless_charging_command;
  const auto refuse = [](KeyCode key, const std::string& why) { return Error{BmsCode(key), why}; };
  if (motors != 0 && motors != BmsCmd::kMotorsUp && motors != BmsCmd::kMotorsDown) {
    return refuse(KeyCode::kParametersInvalid,
                  "there is no motor command " + std::to_string(motors) + "; 1 is up, 2 is down");
  }
  if (charging != 0 && charging != BmsCmd::kWirelessChargingOn &&
      charging != BmsCmd::kWirelessChargingOff) {
    return refuse(
        KeyCode::kParametersInvalid,
        "there is no charging command " + std::to_string(charging) + "; 3 is on, 4 is off");
  }
  if (motors == 0 && charging == 0) return refuse(KeyCode::kParametersInvalid, "it asks nothing");
  if (charging != 0) return refuse(KeyCode::kUnSupport, "this battery has no wireless charging");
  if (motors == BmsCmd::kMotorsUp) {
    if (Result<> may = around_.may_power_motors(); !may) return may;
  }
  if (Result<> sent = motor_power_->Publish({motors == BmsCmd::kMotorsUp}); !sent) return sent;
  motors_powered_ = motors == BmsCmd::kMotorsUp;
  around_.log(std::string("motors powered ") + (motors_powered_ ? "up" : "down"));
  return Ok();
}

}  // namespace musher::device
