#pragma once
// A device on an I2C bus in virtual time: the test writes its registers.

#include <functional>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "musher/modules/device/i2c_link.hpp"

namespace musher::device {

class FakeI2c {
 public:
  // Of the robot: `Dependencies::i2c`. Reads at once, without a thread.
  I2cDoor Door() {
    return {[this](const std::string& bus, std::uint8_t) -> Result<std::unique_ptr<I2cBus>> {
              ++opened;
              if (!fault.empty()) return ErrorOf(bus + ": " + fault);
              return std::unique_ptr<I2cBus>(std::make_unique<Device>(*this));
            },
            [this] {
              return [this](std::function<void()> work) {
                if (is_held) {
                  held_.push_back(std::move(work));
                } else {
                  work();
                }
              };
            }};
  }
  // The bus is held no longer.
  void Release() {
    is_held = false;
    for (const auto& work : std::exchange(held_, {})) work();
  }

  std::map<std::uint8_t, RegisterBytes> registers;
  std::string fault;     // of the bus and of every register; empty: none
  bool is_held = false;  // no call returns
  int opened = 0;

 private:
  static Error ErrorOf(const std::string& why) {
    return {static_cast<std::int32_t>(KeyCode::kNetError), why};
  }

  struct Device : I2cBus {
    explicit Device(FakeI2c& its_bus) : bus(its_bus) {}
    Result<RegisterBytes> Read(std::uint8_t address, std::size_t bytes) override {
      if (!bus.fault.empty()) return ErrorOf(bus.fault);
      RegisterBytes found = bus.registers[address];
      found.resize(bytes);
      return found;
    }

    FakeI2c& bus;
  };

  std::vector<std::function<void()>> held_;
};

}  // namespace musher::device
