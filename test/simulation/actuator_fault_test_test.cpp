// Good and faulty actuators under test: the good one passes, and each fault is found.

#include <gmock/gmock.h>

#include <atomic>
#include <set>
#include <stdexcept>

#include "musher/test/simulation/motor.hpp"
#include "musher/test/support/paths.hpp"

namespace musher::testing::actuator_fault_test_test {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;

TEST(ActuatorFaultTest, PassesAGoodActuatorUnderEveryKindOfFault) {
  MotorFaultTest<GoodMotor> test;
  test.Run();
  const simulation::FaultTestCounts& met = test.counts();
  std::cout << met.scenarios << " scenarios, " << met.processes << " processes, " << met.callbacks
            << " callbacks: " << met.failed << " failed, " << met.repeated << " repeated, "
            << met.stop_requested << " requested to stop, " << met.killed << " killed, "
            << met.stops_during_callback << " of " << met.emergency_stops
            << " stops during a callback, " << met.stops_before_callback
            << " before its first instruction; " << met.torn_down << " torn down\n";
  EXPECT_GT(met.processes, met.scenarios);
  EXPECT_GT(met.failed, 0U);
  EXPECT_GT(met.repeated, 0U);
  EXPECT_GT(met.stop_requested, 0U);
  EXPECT_GT(met.killed, 0U);
  EXPECT_GT(met.stops_during_callback, 0U);
  EXPECT_GT(met.stops_before_callback, 0U);
  EXPECT_GT(met.emergency_stops, met.stops_during_callback);
  EXPECT_GT(met.torn_down, met.scenarios / 2);
}

// Records that it is off before it is.
class ForgetfulMotor : public GoodMotor {
 public:
  using GoodMotor::GoodMotor;

 protected:
  Result<> PowerOn() override {
    off_ = false;
    return GoodMotor::PowerOn();
  }
  Result<> PowerOff() override {
    if (std::exchange(off_, true)) return Ok();
    return GoodMotor::PowerOff();
  }

 private:
  bool off_ = false;
};

TEST(ActuatorFaultTest, FindsPowerThatStaysOnInLowPowerAfterACallbackHasFailed) {
  MotorFaultTest<ForgetfulMotor> test;
  test.always = [](const ForgetfulMotor& motor, const ActuatorReport& report) {
    EXPECT_FALSE(report.state == "LowPower" && motor.powered());
  };
  const FaultTestFailure failure = test.Failure();
  EXPECT_THAT(failure.what, HasSubstr("motor.powered()"));
  EXPECT_LE(failure.id.only->size(), 5U) << failure.timeline;
  EXPECT_THAT(failure.timeline, HasSubstr("callbacks of motor fail"));
}

// Assumes that the process before it has left the motor without power.
class TrustingMotor : public GoodMotor {
 public:
  using GoodMotor::GoodMotor;

 protected:
  Result<> SetUp() override { return Ok(); }
};

TEST(ActuatorFaultTest, FindsWhatAProcessLeavesBehindForTheNext) {
  const FaultTestFailure failure = MotorFaultTest<TrustingMotor>().Failure();
  EXPECT_THAT(failure.what, HasSubstr("in SetUp"));
  EXPECT_THAT(failure.timeline, HasSubstr("motor has exited"));
}

// Continues after an emergency stop that was engaged during its callback.
class StubbornMotor : public GoodMotor {
 public:
  using GoodMotor::GoodMotor;

 protected:
  Result<> PowerOn() override {
    for (int step = 0; step < 5; ++step) static_cast<void>(StopRequested());
    return motor().Power(true);
  }
};

TEST(ActuatorFaultTest, FindsACallbackThatContinuesAfterAnEmergencyStop) {
  MotorFaultTest<StubbornMotor> test;
  test.after_emergency_stop = [](const StubbornMotor& motor, const ActuatorReport&) {
    EXPECT_FALSE(motor.powered()) << "during a stop";
  };
  const FaultTestFailure failure = test.Failure();
  EXPECT_THAT(failure.what, HasSubstr("during a stop"));
  EXPECT_THAT(failure.timeline, HasSubstr("an emergency stop is engaged"));
}

// Switches on at its first instruction, without a check for an earlier stop.
class HastyMotor : public GoodMotor {
 public:
  using GoodMotor::GoodMotor;

 protected:
  Result<> PowerOn() override { return motor().Power(true); }
};

TEST(ActuatorFaultTest, FindsPowerSwitchedOnAfterAStopThatCameBeforeTheFirstInstruction) {
  MotorFaultTest<HastyMotor> test;
  test.scenarios = 3000;
  test.after_emergency_stop = [](const HastyMotor& motor, const ActuatorReport&) {
    EXPECT_FALSE(motor.powered()) << "during a stop";
  };
  EXPECT_THAT(test.Failure().what, HasSubstr("during a stop"));
}

// Fails when its callback runs twice.
class OnceOnlyMotor : public GoodMotor {
 public:
  using GoodMotor::GoodMotor;

 protected:
  Result<> PowerOn() override {
    if (powered()) throw std::runtime_error("the motor has power already");
    return GoodMotor::PowerOn();
  }
};

TEST(ActuatorFaultTest, FindsACallbackThatCannotBeRunTwice) {
  const FaultTestFailure failure = MotorFaultTest<OnceOnlyMotor>().Failure();
  EXPECT_THAT(failure.what, HasSubstr("motor: its callback of Active was done, and fails when it "
                                      "runs again"));
  EXPECT_THAT(failure.what, HasSubstr("the motor has power already"));
}

// Does not work after a crash.
class BrokenMotor : public GoodMotor {
 public:
  using GoodMotor::GoodMotor;

 protected:
  Result<> SetUp() override {
    if (powered()) return Error{6104, "the motor is busy"};
    return GoodMotor::SetUp();
  }
};

TEST(ActuatorFaultTest, FindsAnActuatorThatDoesNotRecoverAfterACrash) {
  const FaultTestFailure failure = MotorFaultTest<BrokenMotor>().Failure();
  EXPECT_THAT(failure.what, HasSubstr("violated: "));
  EXPECT_THAT(failure.timeline, HasSubstr("the motor is busy"));
}

// Its callback of OTA never returns and never calls StopRequested().
std::atomic<bool> the_test_has_ended = false;

class DeafMotor : public GoodMotor {
 public:
  explicit DeafMotor(Motor& motor) : GoodMotor(motor) {
    RegisterStateCallback("OTA", [] {
      while (!the_test_has_ended) continue;
      return 0;
    });
  }
};

TEST(ActuatorFaultTest, GivesUpACallbackThatNeitherEndsNorCallsStopRequested) {
  MotorFaultTest<DeafMotor> test;
  test.real_time_limit = std::chrono::milliseconds(200);
  const FaultTestFailure failure = test.Failure();
  the_test_has_ended = true;
  EXPECT_THAT(failure.what, HasSubstr("motor: its callback of OTA neither ends nor calls "
                                      "StopRequested() for 200 ms of real time"));
  EXPECT_THAT(failure.timeline, HasSubstr("motor in "));
}

class WaitingMotor : public GoodMotor {
 public:
  explicit WaitingMotor(Motor& motor) : GoodMotor(motor) {
    RegisterStateCallback("OTA", [this] {
      while (!StopRequested()) continue;
      return 6108;
    });
  }
};

TEST(ActuatorFaultTest, AdvancesVirtualTimeForACallbackThatPollsUntilItIsRequestedToStop) {
  MotorFaultTest<WaitingMotor> test;
  test.scenarios = 20;
  ASSERT_TRUE(test.Find());
  EXPECT_GT(test.counts().stop_requested, 0U);
}

// Waits in OnEmergencyStop() for the running callback, which waits for the simulation.
class LockingMotor : public GoodMotor {
 public:
  using GoodMotor::GoodMotor;

  static inline std::atomic<int> stops = 0;  // under way

 protected:
  Result<> PowerOn() override {
    const std::lock_guard lock(mutex_);
    return GoodMotor::PowerOn();
  }
  void OnEmergencyStop() override {
    ++stops;
    const std::lock_guard lock(mutex_);
    for (std::atomic<int> work = 0; work < 300'000; ++work) continue;
    GoodMotor::OnEmergencyStop();
    --stops;
  }

 private:
  std::mutex mutex_;
};

TEST(ActuatorFaultTest, FindsAnEmergencyStopThatWaitsForACallback) {
  MotorFaultTest<LockingMotor> test;
  test.real_time_limit = std::chrono::milliseconds(200);
  EXPECT_THAT(test.Failure().what, HasSubstr("its OnEmergencyStop() does not return during a "
                                             "callback of Active"));
}

// A regression: such a stop wrote to the motor of a test that had returned.
TEST(ActuatorFaultTest, EndsAnEmergencyStopThatWaitsForACallbackBeforeTheTestDoes) {
  MotorFaultTest<LockingMotor> test;
  test.real_time_limit = std::chrono::milliseconds(200);
  test.Failure();
  EXPECT_EQ(LockingMotor::stops, 0);
}

TEST(ActuatorFaultTest, IsReproducibleFromItsSeed) {
  const FaultTestFailure one = MotorFaultTest<ForgetfulMotor>().Failure();
  const FaultTestFailure two = MotorFaultTest<ForgetfulMotor>().Failure();
  EXPECT_EQ(one.id.seed, two.id.seed);
  EXPECT_EQ(one.id.only, two.id.only);
  EXPECT_EQ(one.timeline, two.timeline);
}

TEST(ActuatorFaultTest, ReportsAFailureThatIsNotReproduced) {
  MotorFaultTest<TrustingMotor> test;
  bool spoilt = false;
  test.always = [&](const TrustingMotor&, const ActuatorReport&) {
    EXPECT_TRUE(std::exchange(spoilt, true)) << "once only";
  };
  const FaultTestFailure failure = test.Failure();
  EXPECT_FALSE(failure.reproduced);
  EXPECT_THAT(failure.what, HasSubstr("once only"));
}

TEST(ActuatorFaultTest, FailsTheTestWithACommandAndTheScenario) {
  static MotorFaultTest<TrustingMotor> test;
  EXPECT_NONFATAL_FAILURE(test.Run(), "replay with: MUSHER_SEED=");
  EXPECT_NONFATAL_FAILURE(test.Run(), "--gtest_filter='ActuatorFaultTest.FailsTheTestWithACommand");
  EXPECT_NONFATAL_FAILURE(test.Run(), "motor has exited");
}

TEST(ActuatorFaultTest, ReplaysTheScenarioOfTheEnvironment) {
  const FaultTestFailure failure = MotorFaultTest<TrustingMotor>().Failure();
  const std::string command = ReplayCommand(failure.id, "A.Test");
  const auto begin = command.find("MUSHER_ONLY=") + std::string("MUSHER_ONLY=").size();
  setenv("MUSHER_SEED", std::to_string(failure.id.seed).c_str(), 1);
  setenv("MUSHER_ONLY", command.substr(begin, command.find(' ', begin) - begin).c_str(), 1);
  static MotorFaultTest<TrustingMotor> test;
  ::testing::internal::CaptureStdout();
  EXPECT_NONFATAL_FAILURE(test.Run(), "in SetUp");
  EXPECT_EQ(::testing::internal::GetCapturedStdout(), failure.timeline);
  setenv("MUSHER_ONLY", "1000", 1);
  EXPECT_NONFATAL_FAILURE(test.Run(), "injected events, and no 1000");
  setenv("MUSHER_SEED", "soon", 1);
  EXPECT_NONFATAL_FAILURE(test.Run(), "MUSHER_SEED is not a number: soon");
  unsetenv("MUSHER_SEED");
  unsetenv("MUSHER_ONLY");
}

TEST(ActuatorFaultTest, ReportsAConfigThatDoesNotFit) {
  MotorFaultTest<GoodMotor> test;
  test.config_file = SourceDir() + "/examples/first_module/robot.toml";
  EXPECT_THAT(test.Find().error().message, HasSubstr("has no actuator 'motor'"));
  test.config_file.clear();
  test.config_text = R"(
    [controller]
    actuators = ["motor"]
    states = ["SetUp", "Active"]
    default_time = 1000
    default_state = "Uninitialized"
    [actuator.motor]
    states = ["SetUp", "Active"]
    times = [1000, 1000]
  )";
  EXPECT_THAT(test.Find().error().message, HasSubstr("there is a callback for state 'LowPower'"));
}

class DancingMotor : public GoodMotor {
 public:
  explicit DancingMotor(Motor& motor) : GoodMotor(motor) {
    RegisterStateCallback("Dancing", [] { return 0; });
  }
};

class SimpleMotor : public MachineActuator {
 public:
  SimpleMotor() : MachineActuator("motor") {
    RegisterStateCallback([](const State& state) {
      entered_.insert(state);
      return 0;
    });
  }

  inline static std::set<State> entered_;
};

TEST(ActuatorFaultTest, WithoutAConfigTestsACallbackForAllStatesInTheBuiltInOnes) {
  ActuatorFaultTest<SimpleMotor> test;
  test.scenarios = 100;
  const auto found = test.Find();
  ASSERT_TRUE(found) << found.error().message;
  EXPECT_FALSE(found.value());
  EXPECT_THAT(SimpleMotor::entered_, ElementsAre("Active", "DeActive", "Error", "LowPower", "OTA",
                                                 "Protected", "SelfCheck", "SetUp", "TearDown"));
}

TEST(ActuatorFaultTest, NeedsAConfigForCustomStates) {
  EXPECT_THAT(MotorFaultTest<DancingMotor>().Find().error().message, HasSubstr("Dancing"));
}

}  // namespace musher::testing::actuator_fault_test_test
