#include "musher/view/live/request_age.hpp"

#include <gmock/gmock.h>

#include <limits>

#include "musher/base/code.hpp"
#include "musher/lifecycle/state.hpp"

namespace musher::view::request_age_test {

using ::testing::HasSubstr;

constexpr std::int64_t kNowMs = 100'000;

std::string WhyLate(std::int64_t seen_ms) {
  const Result<> fresh = CheckAge(seen_ms, kNowMs);
  return fresh ? "" : fresh.error().message;
}

// Active, with an actuator in that state and one in `other`.
msg::MachineStatus StatusWith(std::string_view other, const std::string& presence = "present") {
  msg::MachineStatus status;
  status.state = "Active";
  status.actuators.resize(2);
  status.actuators[0].name = "motion";
  status.actuators[0].state = "Active";
  status.actuators[0].presence = "present";
  status.actuators[1].name = "audio";
  status.actuators[1].state = other;
  status.actuators[1].presence = presence;
  return status;
}

TEST(RequestAge, OfAPageThatSawTheLastSecondsIsObeyed) {
  EXPECT_EQ(WhyLate(kNowMs), "");
  EXPECT_EQ(WhyLate(kNowMs - kMostAgeMs), "");
}

TEST(RequestAge, OfARequestThatAWifiHeldUpIsSaidWithTheRefusal) {
  EXPECT_NE(WhyLate(kNowMs - kMostAgeMs - 1), "");
  const Result<> fresh = CheckAge(kNowMs - 31'400, kNowMs);
  ASSERT_FALSE(fresh.ok());
  EXPECT_EQ(fresh.error().code, kCodeStateInvalid);
  EXPECT_EQ(fresh.error().message,
            "the request is late: what its page shows is 31 s old. Nothing was done; look at the "
            "robot and press again");
}

TEST(RequestAge, OfAnotherBootIsTooOld) {
  for (const std::int64_t seen_ms :
       {kNowMs + 1, std::int64_t{-1}, std::numeric_limits<std::int64_t>::max(),
        std::numeric_limits<std::int64_t>::min()}) {
    EXPECT_THAT(WhyLate(seen_ms), HasSubstr("before this host was booted")) << seen_ms;
  }
}

TEST(RequestAge, ASwitchDownIsObeyedHoweverLate) {
  for (const char* target : {"Protected", "DeActive", "LowPower", "Error", "TearDown"}) {
    EXPECT_TRUE(OnlyLowers(StatusWith("Active"), target, "")) << target;
    EXPECT_TRUE(OnlyLowers(StatusWith("Active"), target, "audio")) << target;
  }
}

TEST(RequestAge, ASwitchThatRaisesAnActuatorThatRestsLowerIsNone) {
  EXPECT_FALSE(OnlyLowers(StatusWith("LowPower"), "Protected", ""));
  EXPECT_TRUE(OnlyLowers(StatusWith("Protected"), "Protected", ""));
  EXPECT_TRUE(OnlyLowers(StatusWith("LowPower", "lost"), "Protected", ""));
  EXPECT_FALSE(OnlyLowers(StatusWith("LowPower"), "Protected", "audio"));
  EXPECT_TRUE(OnlyLowers(StatusWith("LowPower"), "Protected", "motion"));
  EXPECT_TRUE(OnlyLowers(StatusWith("LowPower"), "TearDown", ""));
}

// The robot with one broken module is the one that a person wants down.
TEST(RequestAge, ASwitchDownIsObeyedHoweverLateBesideAnActuatorThatHasFailed) {
  for (const char* failed : {"SetUp", "Uninitialized"}) {
    EXPECT_TRUE(OnlyLowers(StatusWith(failed), "LowPower", "")) << failed;
    EXPECT_TRUE(OnlyLowers(StatusWith(failed), "DeActive", "")) << failed;
  }
  EXPECT_TRUE(OnlyLowers(StatusWith("LowPower"), "Error", ""));
}

// Out of Error it might move; an emergency stop forbids it, too.
TEST(RequestAge, ASwitchDownBesideAnActuatorInErrorIsNone) {
  for (const char* target : {"Protected", "DeActive", "LowPower"}) {
    EXPECT_FALSE(OnlyLowers(StatusWith("Error"), target, "")) << target;
  }
  EXPECT_TRUE(OnlyLowers(StatusWith("Error"), "Error", ""));
  EXPECT_TRUE(OnlyLowers(StatusWith("Error"), "TearDown", ""));
}

// The callback of Protected ran again, and could switch on what had been off.
TEST(RequestAge, ASwitchDownBesideADegradedActuatorThatRestsInTheTargetRunsItsCallbackAgain) {
  for (const bool held : {false, true}) {
    msg::MachineStatus status = StatusWith("Protected");
    EXPECT_TRUE(OnlyLowers(status, "Protected", "")) << held;
    status.actuators[1].degraded = !held;
    if (held) status.held_by_stop = {"audio"};
    EXPECT_FALSE(OnlyLowers(status, "Protected", "")) << held;
    for (const char* target : {"DeActive", "LowPower"}) {
      EXPECT_TRUE(OnlyLowers(status, target, "")) << target << held;
      status.actuators[1].state = target;
      EXPECT_TRUE(OnlyLowers(status, target, "")) << target << held;
      status.actuators[1].state = "Protected";
    }
  }
}

TEST(RequestAge, ASwitchOfAnActuatorThatGoesLowerByThenIsNone) {
  msg::MachineStatus status = StatusWith("Active");
  status.actuators[1].target = "DeActive";
  EXPECT_TRUE(OnlyLowers(status, "DeActive", "audio"));
  status.actuators[1].target = "LowPower";
  EXPECT_FALSE(OnlyLowers(status, "DeActive", "audio"));
  EXPECT_FALSE(OnlyLowers(status, "DeActive", ""));
}

TEST(RequestAge, ASwitchOfAnActuatorThatIsNotKnownIsNone) {
  EXPECT_FALSE(OnlyLowers(StatusWith("Active"), "DeActive", "lidar"));
}

TEST(RequestAge, ASwitchUpOrToAStateWithoutARankIsNone) {
  for (const char* target : {"Active", "SelfCheck", "SetUp", "Patrol", ""}) {
    EXPECT_FALSE(OnlyLowers(StatusWith("Active"), target, "")) << target;
    EXPECT_FALSE(OnlyLowers(StatusWith("Active"), target, "audio")) << target;
  }
  EXPECT_FALSE(OnlyLowers(StatusWith("Patrol"), "Protected", ""));
}

}  // namespace musher::view::request_age_test
