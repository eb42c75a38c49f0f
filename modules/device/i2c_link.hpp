#pragma once
// One device on an I2C bus: reads all its registers period by period, on a thread, because a bus
// that is held blocks for seconds.
//
//             a reading that counts           silence ms without one
//   ┌───────┐ ─────────────────────▶ ┌───────┐ ─────────────────────▶ ┌────────┐
//   │ begun │                        │ works │                        │at fault│
//   └───────┘                        └───────┘ ◀───────────────────── └────────┘
//                                                a reading that counts
//
// A reading counts if every register of it was read and is believed (i2c_registers.hpp). After a
// failed one the bus is opened again.
//
// Threads: the loop's; the thread of the bus is its own.

#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "musher/modules/device/i2c_bus.hpp"
#include "musher/transport/event_loop.hpp"

namespace musher::device {

// What devices on I2C buses need of a computer.
struct I2cDoor {
  using Background = std::function<void(std::function<void()>)>;  // runs work beside the loop

  I2cBus::Open open;
  std::function<Background()> make_background;  // of one device
};
// Of Linux. A thread that a bus holds at the end of the program is left after a second.
I2cDoor I2cOfThisComputer();

class I2cLink {
 public:
  static constexpr Duration kRefusedPause = std::chrono::seconds(10);  // between two reports
  static constexpr Duration kLate = Milliseconds(50);  // a timer later than this is ignored

  // All run on the loop, none in the constructor.
  struct Events {
    std::function<void(const I2cRecord::Values&)> on_record;
    // A reading does not count: its key code and a sentence; once in kRefusedPause.
    std::function<void(const Error&)> on_refused;
    std::function<void(const std::string& why)> on_fault;  // no reading has counted for a while
  };

  // `silence`: the longest time without a reading that counts, by the steady clock. The loop
  // outlives it.
  I2cLink(transport::EventLoop& loop, const I2cDoor& door, I2cProtocol protocol, Duration silence,
          Events events);
  ~I2cLink();

  // Why it does not work; "": it does, or nothing is known yet.
  const std::string& fault() const { return fault_; }
  bool works() const { return works_; }

 private:
  using Reading = Result<std::vector<RegisterBytes>>;
  class Reader;
  struct Home;

  void Begin();
  void OnReading(const Reading& reading);
  void Refuse(const Error& error);
  void ArmSilence();
  void OnSilence(Time due);

  transport::EventLoop& loop_;
  const I2cProtocol protocol_;
  const Duration silence_time_;
  const Events events_;
  I2cRecord record_;
  std::string fault_;
  std::string refused_;  // why the last reading does not count
  std::optional<Time> reported_at_;
  std::optional<Time> begun_at_;  // of the reading under way
  bool works_ = false;
  const std::shared_ptr<Reader> reader_;
  const std::shared_ptr<Home> home_;
  const I2cDoor::Background background_;
  transport::LoopHandlePtr silence_;
  transport::LoopHandlePtr period_;  // these two are last: their callbacks use the rest
};

}  // namespace musher::device
