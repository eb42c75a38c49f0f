#pragma once
// The show's numbers and their defaults.

#include "musher/base/time.hpp"

namespace musher::wedding {

struct IdleRules {
  Duration confirm{};   // how long a face has to be seen
  double sway = 0.035;  // of the gaze, to each side
  Duration sway_period = Milliseconds(2500);

  friend bool operator==(const IdleRules&, const IdleRules&) = default;
};

struct TrackingRules {
  Duration lost = Milliseconds(1500);
  double gesture_threshold = 0.7;  // a gesture needs more confidence than this
  bool greets = true;              // false: an action pack does

  friend bool operator==(const TrackingRules&, const TrackingRules&) = default;
};

struct PhotoRules {
  Duration confirm = Milliseconds(1000);
  Duration pose = Milliseconds(1500);
  Duration countdown = Milliseconds(3000);
  Duration shutter = Milliseconds(500);

  friend bool operator==(const PhotoRules&, const PhotoRules&) = default;
};

struct FarewellRules {
  Duration time = Milliseconds(2000);

  friend bool operator==(const FarewellRules&, const FarewellRules&) = default;
};

struct SafeStopRules {
  Duration clear = Milliseconds(2000);  // how long there must be no cause

  friend bool operator==(const SafeStopRules&, const SafeStopRules&) = default;
};

}  // namespace musher::wedding
