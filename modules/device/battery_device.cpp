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

BatteryDevice::BatteryDevice(const Dependencies& dependencies, const BatteryConfig& config,
                             OnStatus on_status)
    : dependencies_(dependencies),
      config_(config),
      on_status_(std::move(on_status)),
      endpoints_(dependencies.node, dependencies.name_space) {}

Result<std::unique_ptr<BatteryDevice>> BatteryDevice::Make(const Dependencies& dependencies,
                                                           const BatteryConfig& config,
                                                           OnStatus on_status) {
  std::unique_ptr<BatteryDevice> device(
      new BatteryDevice(dependencies, config, std::move(on_status)));
  if (Result<> connected = device->Connect(); !connected) return connected.error();
  return device;
}

Result<> BatteryDevice::Connect() {
  status_ = endpoints_.Advertise<msg::BmsStatus>("bms_status");
  motor_power_ = endpoints_.Advertise<msg::Bool>("world/motor_power", transport::kLatchedQos);
  endpoints_.Serve<Command>("bms_cmd", [this](const Command::Request& request, auto reply) {
    Execute(request, [this, reply](const Result<>& done) {
      if (!done) dependencies_.log("bms_cmd refused: " + done.error().message);
      reply({done.ok(), done ? kCodeOk : done.error().code});
    });
  });
  if (config_.source == BatterySource::kWorld) {
    transport::SubscriptionEvents events;
    events.on_match_changed = [this] {
      // A world that exits takes its clock with it: the silence timer would never fire.
      if (valid_ && readings_->MatchedWriters() == 0) Lose("no publisher of world/battery");
    };
    readings_ = endpoints_.Subscribe<msg::BatteryState>(
        "world/battery", [this](const msg::BatteryState& state) { OnReading(FromMessage(state)); },
        transport::kDefaultQos, std::move(events));
  }
  if (endpoints_.opened() && config_.source == BatterySource::kHost) {
    poll_ = dependencies_.clock.Every(config_.period, [this] { ReadHost(); });
    ReadHost();
  }
  if (endpoints_.opened() && config_.source == BatterySource::kCan) OpenCan();
  if (endpoints_.opened() && config_.source == BatterySource::kI2c) OpenI2c();
  return endpoints_.opened();
}

void BatteryDevice::OpenCan() {
  CanBattery::Events events;
  events.on_reading = [this](const BatteryReading& reading) { OnReading(reading); };
  events.on_motors = [this](bool powered) { motors_powered_ = powered; };
  events.on_refused = [this](const std::string& why) { Refuse(why); };
  events.on_fault = [this](const std::string& why) { Lose(why); };
  events.log = [this](const std::string& line) { dependencies_.log("battery: " + line); };
  can_ = std::make_unique<CanBattery>(dependencies_.node.loop(), dependencies_.open_can,
                                      config_.frames, config_.silence, std::move(events));
}

void BatteryDevice::OpenI2c() {
  I2cLink::Events events;
  events.on_record = [this](const I2cRecord::Values& values) { OnReading(FromRecord(values)); };
  events.on_refused = [this](const Error& error) {
    const std::int32_t code = BmsCode(static_cast<KeyCode>(error.code));
    Refuse(error.message + " (" + std::to_string(code) + ")");
  };
  events.on_fault = [this](const std::string& why) { Lose(why); };
  i2c_ = std::make_unique<I2cLink>(dependencies_.node.loop(), dependencies_.i2c, config_.registers,
                                   config_.silence, std::move(events));
}

void BatteryDevice::ReadHost() {
  const auto reading = ReadHostBattery(config_.folder, config_.name);
  reading ? OnReading(reading.value()) : Refuse(reading.error().message);
}

// One line when readings begin to be refused, not one for each.
void BatteryDevice::Refuse(const std::string& reason) {
  const std::string fault = "its readings are refused: " + reason;
  if (fault_ == fault) return;
  fault_ = fault;
  dependencies_.log("battery: refused: " + reason);
}

void BatteryDevice::OnReading(const BatteryReading& reading) {
  if (const Result<> fine = Validate(reading); !fine) return Refuse(fine.error().message);
  RestartSilenceTimer();
  const bool held_before = filter_.held().has_value();
  const std::optional<BatteryReading> counts = filter_.Take(reading);
  if (filter_.held() && !held_before) {
    dependencies_.log("battery: a jump to " + Percent(reading) + " is held until the next reading");
  }
  if (!counts) return;
  valid_ = counts;
  if (!fault_.empty()) dependencies_.log("battery: ok, at " + Percent(*counts));
  fault_.clear();
  PublishWhenDue();
}

void BatteryDevice::RestartSilenceTimer() {
  const bool has_link =
      config_.source == BatterySource::kCan || config_.source == BatterySource::kI2c;
  if (has_link) return;  // which knows what is missing
  silence_ = dependencies_.clock.At(dependencies_.clock.Now() + config_.silence, [this] {
    Lose("silent for " + std::to_string(ToMilliseconds(config_.silence)) + " ms");
  });
}

void BatteryDevice::Lose(const std::string& why) {
  valid_.reset();
  due_.reset();
  silence_.reset();
  fault_ = why;
  dependencies_.log("battery: " + fault_);
}

void BatteryDevice::PublishWhenDue() {
  const Time now = dependencies_.clock.Now();
  if (!published_ || now - *published_ >= kLeastPause) {
    due_.reset();
    Publish();
  } else if (!due_) {
    due_ = dependencies_.clock.At(*published_ + kLeastPause, [this] {
      due_.reset();
      Publish();
    });
  }
}

void BatteryDevice::Publish() {
  if (!valid_) return;
  published_ = dependencies_.clock.Now();
  msg::BmsStatus status = ToBmsStatus(*valid_, motors_powered_);
  status.header = {dependencies_.stamp(), "battery_id"};
  static_cast<void>(status_->Publish(status));  // the next one follows soon
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
  if (readings_ && readings_->MatchedWriters() == 0) return failed("no publisher of world/battery");
  if (!fault_.empty()) return failed(fault_);
  return Ok();
}

void BatteryDevice::Execute(const Command::Request& request, const Done& done) {
  const std::uint8_t motors = request.electric_machine_command;
  const std::uint8_t charging = request.wireless_charging_command;
  const auto refuse = [&done](KeyCode key, const std::string& why) {
    done(Error{BmsCode(key), why});
  };
  if (motors != 0 && motors != BmsCmd::kMotorsUp && motors != BmsCmd::kMotorsDown) {
    return refuse(KeyCode::kParametersInvalid,
                  "unknown motor command " + std::to_string(motors) + "; 1 is up, 2 is down");
  }
  if (charging != 0 && charging != BmsCmd::kWirelessChargingOn &&
      charging != BmsCmd::kWirelessChargingOff) {
    return refuse(KeyCode::kParametersInvalid,
                  "unknown charging command " + std::to_string(charging) + "; 3 is on, 4 is off");
  }
  if (motors == 0 && charging == 0)
    return refuse(KeyCode::kParametersInvalid, "the command is empty");
  if (charging != 0) return refuse(KeyCode::kUnSupport, "this battery has no wireless charging");
  if (motors == BmsCmd::kMotorsUp) {
    if (const Result<> may = dependencies_.may_power_motors(); !may) return done(may);
  }
  PowerMotors(motors == BmsCmd::kMotorsUp, done);
}

void BatteryDevice::PowerMotors(bool up, const Done& done) {
  const auto ended = [this, up, done](const Result<>& result) {
    if (result) {
      motors_powered_ = up;
      dependencies_.log(std::string("motors powered ") + (up ? "up" : "down"));
    }
    done(result);
  };
  if (can_) return can_->PowerMotors(up, ended);
  const bool has_reader = motor_power_->MatchedReaders() > 0;
  // "Down" is latched for a program that subscribes later, which would read an earlier "up".
  Result<> published = has_reader || !up ? motor_power_->Publish({up}) : Ok();
  if (!has_reader) {
    published = Error{BmsCode(KeyCode::kNetError),
                      "the power of the motors is not switched: world/motor_power has no "
                      "subscriber"};
  }
  ended(published);
}

}  // namespace musher::device
