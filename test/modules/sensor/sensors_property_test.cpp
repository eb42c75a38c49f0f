// Whatever operations and robot states come, in whatever order: a sensor is subscribed to exactly
// while it is started and awake.

#include <gmock/gmock.h>
#include <rapidcheck/gtest.h>

#include <array>
#include <tuple>

#include "musher/test/modules/sensor/sensors_fixture.hpp"

namespace musher::sensor::sensors_property_test {

using Operation = msg::SensorOperation;

// The fixture without a test of its own.
class SensorsAtHand : public SensorsOnANetwork {
 public:
  SensorsAtHand() {
    Drive();
    ticker_.reset();  // no readings: only the subscriptions are checked
    Start();
  }
  void TestBody() override {}

  Sensors& sensors() { return *sensors_; }
  // By SensorKind.
  std::array<bool, 4> TakeReceived() {
    Run(Milliseconds(500));
    const bool one_tof = tofs_[0]->MatchedReaders() > 0;
    for (const auto& tof : tofs_) RC_ASSERT((tof->MatchedReaders() > 0) == one_tof);
    return {scan_->MatchedReaders() > 0, one_tof, range_->MatchedReaders() > 0,
            fix_->MatchedReaders() > 0};
  }
};

RC_GTEST_PROP(SensorsProperty, AreSubscribedToExactlyWhileTheyAreStartedAndAwake, ()) {
  constexpr std::array states = {kActive, kLowPower, kOta, kProtected, kError};
  SensorsAtHand robot;
  std::array<Phase, 4> phases;
  phases.fill(Phase::kStarted);
  bool low = false;
  const auto steps = *rc::gen::container<std::vector<std::tuple<int, int, int>>>(
      40, rc::gen::tuple(rc::gen::inRange(0, 3), rc::gen::inRange(0, 5), rc::gen::inRange(1, 5)));
  for (const auto& [what, which, operation] : steps) {
    if (what == 0) {
      const State state = states.at(static_cast<std::size_t>(which));
      RC_ASSERT(robot.sensors().Enter(state).ok());
      low = state == "LowPower" || state == "OTA";
    } else {
      std::array<Phase, 4> next = phases;
      bool obeyed = true;
      for (const SensorKind kind : kSensorKinds) {
        if (which != Operation::kAll && KindOfId(static_cast<std::uint16_t>(which)) != kind)
          continue;
        Phase& phase = next.at(static_cast<std::size_t>(kind));
        const auto done = Operate(kind, phase, static_cast<std::uint8_t>(operation));
        obeyed = obeyed && done.ok();
        if (done) phase = done.value();
      }
      const Result<> done = robot.sensors().Operate(
          {static_cast<std::uint16_t>(which), static_cast<std::uint8_t>(operation)});
      RC_ASSERT(done.ok() == obeyed);
      if (obeyed) phases = next;
    }
    const std::array<bool, 4> received = robot.TakeReceived();
    for (const SensorKind kind : kSensorKinds) {
      const auto index = static_cast<std::size_t>(kind);
      const bool awake = !low || kind == SensorKind::kGps;
      RC_ASSERT(received.at(index) == (awake && phases.at(index) == Phase::kStarted));
    }
  }
}

}  // namespace musher::sensor::sensors_property_test
