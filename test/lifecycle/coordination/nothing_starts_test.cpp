// A first stage of which no actuator comes up, for every reason and restart policy: the start fails
// once, with the reason, and the machine can be torn down or repaired by request.

#include <gmock/gmock.h>

#include <tuple>

#include "musher/test/lifecycle/coordination/switching.hpp"

namespace musher::testing::nothing_starts_test {

using ::testing::HasSubstr;

struct Reason {
  std::string name;
  std::string state;  // of the script: "exec", or SetUp
  Behaviour behaviour;
  std::string words;  // the text that the outcome has to contain
};

const std::vector<Reason>& Reasons() {
  static const std::vector<Reason> reasons = [] {
    std::vector<Reason> all(4);
    all[0] = {"CannotBeSpawned", "exec", {}, "no such program"};
    all[0].behaviour.code = kCodeFailed;
    all[0].behaviour.message = "no such program";
    all[1] = {"EndsWithAFailure", "exec", {}, "exit code 3"};
    all[1].behaviour.exit_code = 3;
    all[2] = {"FindsItsConfigWrong", "exec", {}, "exit code 2"};
    all[2].behaviour.exit_code = kUsageExitCode;
    all[3] = {"FailsItsSetUp", "SetUp", {}, "no port"};
    all[3].behaviour.code = 2001;
    all[3].behaviour.message = "no port";
    return all;
  }();
  return reasons;
}

using Combination = std::tuple<std::size_t, RestartPolicy, bool>;  // reason, restart, by hand

class NothingStarts : public ::testing::TestWithParam<Combination> {
 protected:
  const Reason& reason() const { return Reasons()[std::get<0>(GetParam())]; }
  MachineConfig Config() const {
    MachineConfig config = Ours(2);
    for (ActuatorConfig& actuator : config.actuators) {
      actuator.restart.policy = std::get<1>(GetParam());
      actuator.restart.limit = 2;
    }
    ActuatorNamed(config, "a").critical = true;
    return config;
  }
  void Start(Harness& t) const {
    for (const char* name : {"a", "b"}) t.On(name, reason().state) = reason().behaviour;
    t.Begin(std::get<2>(GetParam()));
    if (std::get<2>(GetParam())) t.Feed(event::SetUpAwaited{99});
    t.Rest();
  }
};

TEST_P(NothingStarts, EndsTheStartWithTheReasonAndLeavesNothingBehind) {
  Harness t(Config());
  Start(t);
  if (std::get<2>(GetParam())) {  // the program that drives the start gets the answer
    ASSERT_EQ(t.calls.count(99), 1U);
    EXPECT_FALSE(t.calls.at(99));
  } else {
    ASSERT_TRUE(t.start_up());
    EXPECT_FALSE(t.usable());
    EXPECT_EQ(t.machine().phase, Phase::kFailed);
    EXPECT_THAT(t.start_up()->message, HasSubstr(reason().words));
  }
  const SwitchResult down = t.Set("TearDown");
  EXPECT_TRUE(down.done()) << down.reason;
  EXPECT_TRUE(t.stopped());
}

TEST_P(NothingStarts, CanBeRepairedByHandWithoutANewController) {
  if (std::get<2>(GetParam())) GTEST_SKIP() << "the program that drives the start decides";
  Harness t(Config());
  Start(t);
  for (const char* name : {"a", "b"}) {
    t.On(name, reason().state) = {};
    t.Restart(name);
  }
  t.Rest();
  EXPECT_TRUE(t.Set("SelfCheck").done());
  EXPECT_TRUE(t.Set("Active").done());
  EXPECT_EQ(t.machine().phase, Phase::kRunning);
}

std::string NameOf(const ::testing::TestParamInfo<Combination>& info) {
  const auto [reason, restart, by_hand] = info.param;
  const char* policy = restart == RestartPolicy::kNo          ? "RestartNo"
                       : restart == RestartPolicy::kOnFailure ? "RestartOnFailure"
                                                              : "RestartAlways";
  return Reasons()[reason].name + policy + (by_hand ? "ByHand" : "");
}

INSTANTIATE_TEST_SUITE_P(ForAnyReason, NothingStarts,
                         ::testing::Combine(::testing::Range<std::size_t>(0, 4),
                                            ::testing::Values(RestartPolicy::kNo,
                                                              RestartPolicy::kOnFailure,
                                                              RestartPolicy::kAlways),
                                            ::testing::Bool()),
                         NameOf);

}  // namespace musher::testing::nothing_starts_test
