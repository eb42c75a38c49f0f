#pragma once
// Which presses of a power key count: those that begin while the key is read. A key that is pressed
// when its device is opened is held by accident, stuck, or read with the wrong polarity; it counts
// once it was released.
//
//   unseen ──released──▶ released ──pressed──▶ held
//     │                     ▲                   │
//     │pressed              └─────released──────┘
//     ▼
//   ignored ──released──▶ released
//
// A device that is lost leads back to unseen from each of them.

namespace musher::device {

class PowerKey {
 public:
  enum class Effect {
    kNone,
    kBegins,   // a press that counts
    kEnds,     // of such a press
    kIgnored,  // a press that does not count
  };

  // The key is pressed or not, as an event says or as it was read.
  Effect OnState(bool pressed) {
    const Phase before = phase_;
    if (!pressed) {
      phase_ = Phase::kReleased;
      return before == Phase::kHeld ? Effect::kEnds : Effect::kNone;
    }
    if (before == Phase::kReleased) {
      phase_ = Phase::kHeld;
      return Effect::kBegins;
    }
    if (before == Phase::kUnseen) {
      phase_ = Phase::kIgnored;
      return Effect::kIgnored;
    }
    return Effect::kNone;
  }

  // Events are missing: a key that is still pressed may have been released and pressed again, so a
  // press begins again.
  Effect OnGap() { return phase_ == Phase::kHeld ? OnState(false) : Effect::kNone; }

  // The device is opened, or lost: the state of the key is not known.
  Effect OnUnseen() {
    const bool was_held = phase_ == Phase::kHeld;
    phase_ = Phase::kUnseen;
    return was_held ? Effect::kEnds : Effect::kNone;
  }

 private:
  enum class Phase { kUnseen, kIgnored, kReleased, kHeld };
  Phase phase_ = Phase::kUnseen;
};

}  // namespace musher::device
