#pragma once
// Lines of the GPIO chips of Linux, by their character devices (/dev/gpiochip0) and version 2 of
// their interface, which a kernel has from 5.10 on. It is used without libgpiod: the version of
// Debian 12 uses the first interface, whose kernel does not debounce, and that of Debian 13 has
// other functions.
//
// A kernel driver or another program that has the line keeps it: it is named. A line is released
// when its program ends, however that is. An output keeps its voltage then on most chips; a program
// that ends by itself makes it inactive before.
//
// Threads: the loop's. Reading and switching a line of a chip on a bus (I2C, SPI) blocks as long as
// the bus does. On a simulated loop, which has no files, no change is received.

#include <optional>
#include <string>
#include <string_view>

#include "musher/base/unique_fd.hpp"
#include "musher/modules/device/gpio_line.hpp"

namespace musher::device {

// "gpiochip0:5": the chip and the number of the line on it.
struct GpioPlace {
  std::string chip;
  std::uint32_t number = 0;

  friend bool operator==(const GpioPlace&, const GpioPlace&) = default;
};
// nullopt: the text is the name of a line.
std::optional<GpioPlace> ReadGpioPlace(std::string_view text);

// GpioLine::Open of this computer.
Result<std::unique_ptr<GpioLine>> OpenGpioLine(transport::EventLoop& loop, const GpioSpec& spec,
                                               GpioLine::Direction direction,
                                               GpioLine::Events events);

class GpioFile : public GpioLine {
 public:
  static constexpr Duration kLate = Milliseconds(100);  // a change that has waited longer is a gap

  // `fd` is a line that the kernel has given, or of a test: a pipe with its events. `name` is for
  // messages.
  GpioFile(transport::EventLoop& loop, std::string name, UniqueFd fd, Direction direction,
           Events events);
  ~GpioFile() override;

  Result<bool> IsActive() override;
  Result<> Set(bool active) override;

 private:
  void Read();

  transport::EventLoop& loop_;
  const std::string name_;
  const Direction direction_;
  const Events events_;
  std::optional<std::uint32_t> number_;  // of the last change
  UniqueFd fd_;
  transport::LoopHandlePtr readable_;  // last: its callback uses the rest
};

}  // namespace musher::device
