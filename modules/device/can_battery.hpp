#pragma once
// A battery on a CAN bus, which also switches the power of the motors. Its file of frames names the
// values as the message BmsStatus does, in the same units, and CyberDog's two commands.
//
// The motors' power is what the battery reports, not what was commanded. A command to power them up
// that it has not confirmed in time is undone where they had no power: it may still wait in a queue
// of the bus, and would be carried out long after its caller was refused.
//
// Threads: the loop's.

#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "musher/modules/device/battery.hpp"
#include "musher/modules/device/can_link.hpp"
#include "musher/modules/device/can_protocol_toml.hpp"

namespace musher::device {

// The names that its file may have.
const CanNames& BatteryCanNames();

// Of a record; values that it lacks are kNotMeasured.
BatteryReading FromRecord(const CanRecord::Values& values);

class CanBattery {
 public:
  static constexpr Duration kConfirmTime = Milliseconds(2000);
  static constexpr Duration kUndoTime = std::chrono::seconds(10);

  struct Events {
    std::function<void(const BatteryReading&)> on_reading;
    std::function<void(bool powered)> on_motors;  // as reported
    std::function<void(const std::string& why)> on_refused;
    std::function<void(const std::string& why)> on_fault;
    std::function<void(const std::string&)> log;
  };
  using Done = std::function<void(const Result<>&)>;

  CanBattery(transport::EventLoop& loop, const CanBus::Open& open, const CanProtocol& protocol,
             Duration silence, Events events);

  // Calls `done` once the battery has reported it, or at once where its file has no such report.
  // Fails with NetError while the bus does not work, Timeout after kConfirmTime, TargetBusy when
  // another request is waiting (powering down ends that one instead).
  void PowerMotors(bool up, Done done);

 private:
  struct Request {
    bool up = false;
    bool undo = false;  // if it is not confirmed
    Done done;
  };

  void OnRecord(const CanRecord::Values& values);
  void OnFault(const std::string& why);
  void OnConfirmTime(Time due);
  void End(const Result<>& result);
  void BeginUndo();
  void Undo();

  transport::EventLoop& loop_;
  const Events events_;
  const bool reports_motors_;
  std::optional<Request> waiting_;
  bool powered_ = false;  // as reported last
  // Powering up was not confirmed: they are powered down once that can be sent.
  std::optional<Time> undo_until_;
  transport::LoopHandlePtr confirm_;
  std::unique_ptr<CanLink> link_;  // last: its callbacks use the rest
};

}  // namespace musher::device
