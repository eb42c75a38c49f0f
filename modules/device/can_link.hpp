#pragma once
// One device on a CAN bus: receives its records and sends its commands.
//
//           open ok              silence ms without a record, bus off
//   ┌──────┐ ───▶ ┌─────────┐ ──────────────────────────────────────▶ ┌─────────┐
//   │ lost │      │ working │ ◀────────────────────────────────────── │ at fault│
//   └──────┘ ◀─── └─────────┘            a record, a frame            └─────────┘
//      interface down or gone: opened again every second
//
// A device that sends nothing by itself works once its bus is open, and again once that carries
// frames. While it is at fault or lost no command is sent: one that waits in the kernel's queue
// would be carried out whenever the bus comes back.
//
// Threads: the loop's.

#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "musher/modules/device/can_protocol.hpp"

namespace musher::device {

class CanLink {
 public:
  static constexpr Duration kReopen = std::chrono::seconds(1);
  static constexpr Duration kSteady = std::chrono::seconds(1);  // without a fault: it has recovered
  static constexpr Duration kRefusedPause = std::chrono::seconds(10);  // between two reports
  static constexpr Duration kLate = Milliseconds(50);  // a timer later than this is ignored

  // All run on the loop, and in the constructor.
  struct Events {
    std::function<void(const CanRecord::Values&)> on_record;
    // A frame of the device is refused: its key code and a sentence; once in kRefusedPause.
    std::function<void(const Error&)> on_refused;
    std::function<void(const std::string& why)> on_fault;  // it begins, or is another one
    std::function<void()> on_working;                      // again, or for the first time
  };

  // Opens the bus at once. `silence`: the longest time without a record, by the steady clock; 0:
  // the device sends none by itself. The loop outlives it.
  CanLink(transport::EventLoop& loop, const CanBus::Open& open, CanProtocol protocol,
          Duration silence, Events events);

  // Why it does not work; "": it does, or nothing is known yet.
  const std::string& fault() const { return fault_; }
  bool works() const { return works_; }
  const CanProtocol& protocol() const { return protocol_; }

  // Fails with UnSupport without such a command, with NetError while it does not work.
  Result<> Send(std::string_view command, std::span<const std::uint8_t> data = {});

 private:
  void Reopen();
  void OnFrame(const CanFrame& frame);
  void OnRecord();
  void OnRecovered();
  void Recover();
  void Fail(const std::string& why);
  void Work();
  void Lose(const std::string& why);
  void ArmSilence();
  void OnSilence(Time due);
  std::string Silence() const;

  transport::EventLoop& loop_;
  const CanBus::Open open_;
  const CanProtocol protocol_;
  const Duration silence_time_;
  const Events events_;
  CanRecord record_;
  std::string fault_;
  bool works_ = false;
  bool bus_fault_ = false;      // the fault is one of the bus, and not silence
  bool filtered_ = false;       // only frames of the device are received
  std::optional<CanId> other_;  // of a frame that is not the device's
  std::optional<Time> refused_at_;
  transport::LoopHandlePtr silence_;
  transport::LoopHandlePtr reopen_;
  transport::LoopHandlePtr recover_;
  std::unique_ptr<CanBus> bus_;  // last: its callbacks use the rest
};

}  // namespace musher::device
