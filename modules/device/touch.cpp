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

bool DoubleTap::Take(std::int32_t touch_state, Time now) {
  if (touch_state != msg::TouchStatus::kDoubleTouch) return false;
  if (last_ && now - *last_ < kPause) return false;
  last_ = now;
  return true;
}

}  // namespace musher::device
