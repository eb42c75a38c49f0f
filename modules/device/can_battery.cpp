#include "musher/modules/device/can_battery.hpp"

#include <algorithm>
#include <utility>

namespace musher::device {
namespace {

using msg::BatteryState;

constexpr const char* kCharge = "batt_soc";
constexpr const char* kMotorsOff = "power_motor_shutdown";
constexpr const char* kPowerUp = "cmd_normal_mode";
constexpr const char* kPowerDown = "cmd_turn_off_motor";

double ValueOf(const CanRecord::Values& values, std::string_view name) {
  const auto found = values.find(name);
  return found == values.end() ? kNotMeasured : found->second;
}

bool IsSet(const CanRecord::Values& values, std::string_view name) {
  return ValueOf(values, name) > 0;
}

}  // namespace

const CanNames& BatteryCanNames() {
  static const CanNames names = {
      {kCharge, "batt_volt", "batt_curr", "batt_temp", "batt_health", "batt_loop_number",
       "power_wired_charging", "power_finished_charging", kMotorsOff, "power_expower_supply"},
      kCharge,
      {kPowerUp, kPowerDown},
      "",
      0};
  return names;
}

BatteryReading FromRecord(const CanRecord::Values& values) {
  constexpr double kMilli = 1e-3;
  BatteryReading reading;
  reading.percent = ValueOf(values, kCharge);
  reading.voltage_v = kMilli * ValueOf(values, "batt_volt");
  reading.current_a = kMilli * ValueOf(values, "batt_curr");
  reading.temperature_c = ValueOf(values, "batt_temp");
  reading.health_percent = ValueOf(values, "batt_health");
  if (const double cycles = ValueOf(values, "batt_loop_number"); cycles >= 0) {
    reading.cycles = static_cast<int>(std::min(cycles, 30'000.0));
  }
  const bool full = IsSet(values, "power_finished_charging");
  const bool charging = IsSet(values, "power_wired_charging");
  reading.external_power = full || charging || IsSet(values, "power_expower_supply");
  reading.status = full                     ? BatteryState::kStatusFull
                   : charging               ? BatteryState::kStatusCharging
                   : reading.external_power ? BatteryState::kStatusNotCharging
                                            : BatteryState::kStatusDischarging;
  return reading;
}

CanBattery::CanBattery(transport::EventLoop& loop, const CanBus::Open& open,
                       const CanProtocol& protocol, Duration silence, Events events)
    : loop_(loop), events_(std::move(events)), reports_motors_(protocol.HasField(kMotorsOff)) {
  CanLink::Events link;
  link.on_record = [this](const CanRecord::Values& values) { OnRecord(values); };
  link.on_refused = [this](const Error& error) {
    events_.on_refused(error.message + " (" +
                       std::to_string(BmsCode(static_cast<KeyCode>(error.code))) + ")");
  };
  link.on_fault = [this](const std::string& why) { OnFault(why); };
  link.on_working = [] {};
  link_ = std::make_unique<CanLink>(loop, open, protocol, silence, std::move(link));
}

void CanBattery::PowerMotors(bool up, Done done) {
  const auto refuse = [&done](KeyCode key, const std::string& why) {
    done(Error{BmsCode(key), why});
  };
  if (waiting_ && up) return refuse(KeyCode::kTargetBusy, "another command of the motors waits");
  if (waiting_) {
    if (waiting_->undo) BeginUndo();
    End(Error{BmsCode(KeyCode::kFailed), "the motors are powered down instead"});
  }
  if (const Result<> sent = link_->Send(up ? kPowerUp : kPowerDown); !sent) {
    return refuse(static_cast<KeyCode>(sent.error().code), sent.error().message);
  }
  undo_until_.reset();
  if (!reports_motors_) return done(Ok());
  waiting_ = Request{up, up && !powered_, std::move(done)};
  const Time due = loop_.Now() + kConfirmTime;
  confirm_ = loop_.At(due, [this, due] { OnConfirmTime(due); });
}

void CanBattery::OnRecord(const CanRecord::Values& values) {
  if (reports_motors_) {
    powered_ = !IsSet(values, kMotorsOff);
    events_.on_motors(powered_);
    if (waiting_ && waiting_->up == powered_) End(Ok());
    if (undo_until_) Undo();
  }
  events_.on_reading(FromRecord(values));
}

void CanBattery::OnFault(const std::string& why) {
  if (waiting_) {
    if (waiting_->undo) BeginUndo();
    End(Error{BmsCode(KeyCode::kNetError), why});
  }
  events_.on_fault(why);
}

// A process that was suspended runs its timers first: the report may be queued.
void CanBattery::OnConfirmTime(Time due) {
  const Time now = loop_.Now();
  if (now > due + CanLink::kLate) {
    const Time again = now + CanLink::kLate;
    confirm_ = loop_.At(again, [this, again] { OnConfirmTime(again); });
    return;
  }
  const bool up = waiting_->up;
  const bool undo = waiting_->undo;
  End(Error{BmsCode(KeyCode::kTimeout),
            std::string("the battery has not reported the motors powered ") + (up ? "up" : "down") +
                " within " + std::to_string(ToMilliseconds(kConfirmTime)) + " ms"});
  if (undo) {
    BeginUndo();
    Undo();
  }
}

void CanBattery::End(const Result<>& result) {
  confirm_.reset();
  std::exchange(waiting_, std::nullopt)->done(result);
}

void CanBattery::BeginUndo() {
  undo_until_ = loop_.Now() + kUndoTime;
  events_.log("powering the motors up was not confirmed: they are powered down again");
}

// Long afterwards others may have powered them up, and the robot may stand.
void CanBattery::Undo() {
  if (powered_ && loop_.Now() > *undo_until_) {
    undo_until_.reset();
    events_.log("the motors are powered up, perhaps by the command that was not confirmed");
  } else if (link_->Send(kPowerDown)) {
    undo_until_.reset();
  }
}

}  // namespace musher::device
