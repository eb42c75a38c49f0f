#include "musher/modules/device/touch.hpp"

#include "musher/messages/protocol/device.hpp"

namespace musher::device {

std::string TouchText(std::int32_t touch_state) {
  using msg::TouchStatus;
  constexpr std::int32_t kLastFigure = 0x11;
  switch (touch_state) {
    case TouchStatus::kSingle:
      return "single tap";
    case TouchStatus::kDoubleTouch:
      return "double tap";
    case TouchStatus::kHold:
      return "hold";
    case TouchStatus::kCircle:
      return "circle";
    default:
      break;
  }
  const bool figure = touch_state > TouchStatus::kCircle && touch_state <= kLastFigure;
  return figure ? "figure " + std::to_string(touch_state) : "";
}

std::optional<std::int32_t> Taps::OnTouch(bool touched, Time now) {
  if (touched == touched_at_.has_value()) return std::nullopt;
  const auto known = OnTime(now);  // before this
  if (touched) {
    touched_at_ = now;
    held_ = false;
    return known;
  }
  touched_at_.reset();
  if (held_) return known;
  if (tap_at_) {
    tap_at_.reset();
    return msg::TouchStatus::kDoubleTouch;
  }
  tap_at_ = now;
  return known;
}

std::optional<std::int32_t> Taps::OnTime(Time now) {
  const auto deadline = NextDeadline();
  if (!deadline || now < *deadline) return std::nullopt;
  tap_at_.reset();
  if (!touched_at_) return msg::TouchStatus::kSingle;
  held_ = true;
  return msg::TouchStatus::kHold;
}

std::optional<Time> Taps::NextDeadline() const {
  if (touched_at_) return held_ ? std::nullopt : std::optional(*touched_at_ + kHold);
  return tap_at_ ? std::optional(*tap_at_ + kBetween) : std::nullopt;
}

bool DoubleTap::Take(std::int32_t touch_state, Time now) {
  if (touch_state != msg::TouchStatus::kDoubleTouch) return false;
  if (last_ && now - *last_ < kPause) return false;
  last_ = now;
  return true;
}

}  // namespace musher::device
