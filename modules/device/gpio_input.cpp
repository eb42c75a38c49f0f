#include "musher/modules/device/gpio_input.hpp"

#include <utility>

namespace musher::device {

GpioInput::GpioInput(transport::EventLoop& loop, const GpioLine::Open& open, GpioSpec spec,
                     Events events)
    : loop_(loop), open_(open), spec_(std::move(spec)), events_(std::move(events)) {
  Open();
}

void GpioInput::Open() {
  line_.reset();  // a lost one
  GpioLine::Events events;
  events.on_level = [this](bool active) { Report(active); };
  events.on_gap = [this] { Miss(); };
  events.on_lost = [this](const std::string& why) { Lose(why); };
  auto opened = open_(loop_, spec_, GpioLine::Direction::kInput, std::move(events));
  if (!opened) return Lose(opened.error().message);
  line_ = std::move(opened).value();
  Look();
}

void GpioInput::Look() {
  const auto active = line_->IsActive();
  if (!active) return Lose(active.error().message);
  next_ = loop_.At(loop_.Now() + kLook, [this] { Look(); });
  if (!fault_.empty()) events_.log(spec_.line + " works");
  fault_.clear();
  if (level_ && *level_ != active.value()) Miss();
  Report(active.value());
}

void GpioInput::Report(bool active) {
  known_ = true;
  if (std::exchange(level_, active) != active) events_.on_level(active);
}

void GpioInput::Miss() {
  level_.reset();
  events_.on_gap();
}

// The line is kept until it is opened again: this may run in its callback.
void GpioInput::Lose(const std::string& why) {
  next_ = loop_.At(loop_.Now() + kReopen, [this] { Open(); });
  if (std::exchange(fault_, why) != why) {
    events_.log((why.find(spec_.line) != std::string::npos ? "" : spec_.line + ": ") + why +
                "; it is opened again every second");
  }
  if (!std::exchange(known_, false)) return;
  Miss();
  events_.on_lost();
}

}  // namespace musher::device
