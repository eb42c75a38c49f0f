#pragma once
// GPIO lines in virtual time: the test has the other end of each.

#include <algorithm>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "musher/modules/device/gpio_line.hpp"

namespace musher::device {

class FakeGpio {
 public:
  // Of the robot: `Dependencies::open_gpio`.
  GpioLine::Open Opener() {
    return [this](transport::EventLoop&, const GpioSpec& spec, GpioLine::Direction direction,
                  GpioLine::Events events) -> Result<std::unique_ptr<GpioLine>> {
      if (!fault.empty()) return ErrorOf(fault);
      auto line = std::make_unique<Line>(*this, spec, direction, std::move(events));
      if (direction == GpioLine::Direction::kOutput) active[spec.line] = false;
      lines_.push_back(line.get());
      specs[spec.line] = spec;
      return std::unique_ptr<GpioLine>(std::move(line));
    };
  }

  // A contact changes, with an event of the kernel or, as a chip without a working interrupt,
  // without one.
  void Put(const std::string& name, bool its_active, bool with_event = true) {
    active[name] = its_active;
    for (Line* const line : std::vector(lines_)) {
      if (with_event && line->spec.line == name) line->events.on_level(its_active);
    }
  }
  // Changes were dropped.
  void Drop(const std::string& name) {
    for (Line* const line : std::vector(lines_)) {
      if (line->spec.line != name) continue;
      line->events.on_gap();
      line->events.on_level(active[name]);
    }
  }
  // The chip is gone until `fault` is empty again. Outputs find out when they are switched.
  void GoAway(const std::string& why) {
    fault = why;
    for (Line* const line : std::vector(lines_)) {
      if (line->direction == GpioLine::Direction::kInput) line->events.on_lost(why);
    }
  }
  bool IsOpen(const std::string& name) const {
    return std::ranges::any_of(lines_, [&](const Line* line) { return line->spec.line == name; });
  }

  std::string fault;                      // why no line can be opened; empty: they can
  std::map<std::string, bool> active;     // by its line
  std::map<std::string, GpioSpec> specs;  // of the lines that were opened

 private:
  static Error ErrorOf(const std::string& why) {
    return {static_cast<std::int32_t>(KeyCode::kDeviceError), why};
  }

  struct Line : GpioLine {
    Line(FakeGpio& its_chip, GpioSpec its_spec, Direction its_direction, Events its_events)
        : chip(its_chip),
          spec(std::move(its_spec)),
          direction(its_direction),
          events(std::move(its_events)) {}
    ~Line() override {
      if (direction == Direction::kOutput) chip.active[spec.line] = false;
      std::erase(chip.lines_, this);
    }
    Result<bool> IsActive() override {
      if (!chip.fault.empty()) return ErrorOf(chip.fault);
      return chip.active[spec.line];
    }
    Result<> Set(bool its_active) override {
      if (!chip.fault.empty()) return ErrorOf(chip.fault);
      chip.active[spec.line] = its_active;
      return Ok();
    }

    FakeGpio& chip;
    const GpioSpec spec;
    const Direction direction;
    const Events events;
  };

  std::vector<Line*> lines_;
};

}  // namespace musher::device
