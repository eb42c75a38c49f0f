#include "musher/modules/world/process/pacer.hpp"

#include <algorithm>
#include <cstdio>
#include <utility>

namespace musher::world {
namespace {

constexpr Duration kMostLag = Milliseconds(20);  // up to which it catches up
constexpr Duration kMeasuring = std::chrono::seconds(5);
constexpr double kHeld = 0.97;  // share of the requested factor that counts as reached

}  // namespace

Pacer::Pacer(Duration step, double factor, Time now)
    : step_(step), factor_(factor), due_(now + Period()), measured_since_(now) {}

Time Pacer::Next(Time now) {
  ++steps_;
  due_ = std::max(due_ + Period(), now - kMostLag);
  Measure(now);
  return due_;
}

void Pacer::SetFactor(double factor, Time now) {
  factor_ = factor;
  due_ = now + Period();
  MeasureFrom(now);
}

void Pacer::SetPaused(bool paused, Time now) {
  paused_ = paused;
  due_ = now + Period();
  MeasureFrom(now);
}

std::optional<std::string> Pacer::TakeLogLine() {
  return std::exchange(log_line_, std::nullopt);
}

Duration Pacer::Period() const {
  return Duration(static_cast<std::int64_t>(static_cast<double>(step_.count()) / factor_));
}

void Pacer::Measure(Time now) {
  const Duration real = now - measured_since_;
  if (real < kMeasuring) return;
  reached_ = static_cast<double>((step_ * steps_).count()) / static_cast<double>(real.count());
  const bool slow = *reached_ < factor_ * kHeld;
  if (slow != slow_) {
    char text[96];
    std::snprintf(text, sizeof(text), "world time runs %.2f times as fast as real time%s%.2f",
                  *reached_, slow ? " instead of " : " again, as wanted: ", factor_);
    log_line_ = text;
  }
  slow_ = slow;
  measured_since_ = now;
  steps_ = 0;
}

void Pacer::MeasureFrom(Time now) {
  measured_since_ = now;
  steps_ = 0;
  reached_.reset();
}

}  // namespace musher::world
