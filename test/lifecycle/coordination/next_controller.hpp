#pragma once
// A machine of three actuators in Active, of which a person leads "b" alone, and the controller
// that comes after the first one.

#include <gtest/gtest.h>

#include <utility>

#include "musher/test/lifecycle/coordination/policy.hpp"
#include "musher/test/lifecycle/coordination/switching.hpp"

namespace musher::testing {

class NextController : public Rules {
 protected:
  static void CrashController(Harness& t) {
    t.ClearLog();
    t.RestartController(false, true);
    t.Rest();
  }
  // Its supervisor ends the controller by a signal, and starts it again: `systemctl restart`, an
  // update of the package, a reboot of the host.
  static void TakeDown(Harness& t, AfterTearDown after) {
    t.Feed(event::SetStateRequested{771, State(kTearDown), {}, after, {}});
    t.Rest();
    ASSERT_TRUE(t.stopped());
  }
  Harness& Held(const State& in = State(kLowPower), MachineConfig config = Ours(3)) {
    Harness& t = In("Active", std::move(config));
    EXPECT_TRUE(t.Set(in, "b").done());
    t.Rest();
    t.ClearLog();
    return t;
  }
  Harness& TornDown(MachineConfig config = Ours(3)) {
    Harness& t = In("Active", std::move(config));
    EXPECT_TRUE(t.Set("TearDown", "b").done());
    t.Rest();
    t.ClearLog();
    return t;
  }
};

}  // namespace musher::testing
