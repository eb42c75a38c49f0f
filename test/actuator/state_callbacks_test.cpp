// One callback for all the states that have none of their own, and what the others keep.

#include <gmock/gmock.h>

#include <fstream>
#include <stdexcept>

#include "musher/actuator/callback_harness.hpp"
#include "musher/actuator/machine_actuator.hpp"
#include "musher/controller/machine_controller.hpp"
#include "musher/lifecycle/config/config_toml.hpp"
#include "musher/test/actuator/robot_file.hpp"
#include "musher/test/support/temp_folder.hpp"

namespace musher::state_callbacks_test {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using testing::RobotFile;

constexpr const char* kRobot = R"(
  [controller]
  actuators = ["arm", "leg"]
  states = ["SetUp", "SelfCheck", "Active", "Waving", "LowPower", "TearDown"]
  default_time = 5000
  default_state = "Uninitialized"
  [[state]]
  name = "Waving"
  rank = 5
  [actuator.arm]
  states = ["SetUp", "SelfCheck", "Active", "Waving"]
  times = [20000, 20000, 20000, 20000]
  [actuator.leg]
  states = ["SetUp", "SelfCheck", "Active", "LowPower", "TearDown"]
  times = [20000, 20000, 20000, 20000, 20000]
)";

class Arm : public MachineActuator {
 public:
  Arm() : MachineActuator("arm") {
    RegisterStateCallback([this](const State& state) { return Enter(state); });
  }

  std::vector<State> entered;
  State fails_in;
  State throws_in;

 private:
  Result<> Enter(const State& state) {
    entered.push_back(state);
    if (state == throws_in) throw std::runtime_error("cable loose");
    if (state == fails_in) return Error{3012, "no motor"};
    return Ok();
  }
};

// Fails where Start() would.
Result<> FitToRobot(MachineActuator& actuator) {
  const ConfigReading reading = ReadConfigText(kRobot, "robot.toml");
  EXPECT_TRUE(reading.config) << FormatDiagnostic(reading.diagnostics.at(0));
  return CallbackHarness(actuator).Adopt(*reading.config);
}

TEST(TheCallbackOfAllOtherStates, IsGivenTheStateAlsoOneOfTheRobotsOwn) {
  ActuatorRunner<Arm> arm;
  ASSERT_TRUE(FitToRobot(arm));
  CallbackHarness callbacks(arm);
  EXPECT_TRUE(callbacks.Run("SetUp"));
  EXPECT_TRUE(callbacks.Run("Waving"));
  EXPECT_THAT(arm.entered, ElementsAre("SetUp", "Waving"));
}

TEST(TheCallbackOfAllOtherStates, LeavesAStateToItsOwnCallbackWhicheverWasRegisteredFirst) {
  ActuatorRunner<Arm> arm;
  int active = 0;
  arm.RegisterStateCallback("Active", [&] {
    ++active;
    return kCodeOk;
  });
  ASSERT_TRUE(FitToRobot(arm));
  CallbackHarness callbacks(arm);
  EXPECT_TRUE(callbacks.Run("Active"));
  EXPECT_TRUE(callbacks.Run("SelfCheck"));
  EXPECT_EQ(active, 1);
  EXPECT_THAT(arm.entered, ElementsAre("SelfCheck"));

  MachineActuator other("arm");
  int rest = 0;
  other.RegisterStateCallback("Active", [&] {
    ++active;
    return kCodeOk;
  });
  other.RegisterStateCallback([&](const State&) {
    ++rest;
    return kCodeOk;
  });
  EXPECT_TRUE(CallbackHarness(other).Run("Active"));
  EXPECT_EQ(active, 2);
  EXPECT_EQ(rest, 0);
}

TEST(TheCallbackOfAllOtherStates, FailsWithItsErrorItsCodeOrWhatItThrows) {
  ActuatorRunner<Arm> arm;
  arm.fails_in = "Active";
  arm.throws_in = "Waving";
  CallbackHarness callbacks(arm);
  EXPECT_EQ(callbacks.Run("Active").error(), (Error{3012, "no motor"}));
  const Result<> thrown = callbacks.Run("Waving");
  ASSERT_FALSE(thrown);
  EXPECT_EQ(thrown.error().code, kCodeFailed);
  EXPECT_THAT(thrown.error().message, HasSubstr("cable loose"));

  MachineActuator plain("arm");
  plain.RegisterStateCallback([](const State& state) { return state == "Active" ? 3012 : 0; });
  EXPECT_EQ(CallbackHarness(plain).Run("Active").error().code, 3012);
  EXPECT_TRUE(CallbackHarness(plain).Run("SetUp"));
}

TEST(TheCallbackOfAllOtherStates, IsOne) {
  ActuatorRunner<Arm> arm;
  arm.RegisterStateCallback([](const State&) { return kCodeOk; });
  EXPECT_THAT(FitToRobot(arm).error().message,
              HasSubstr("two callbacks for the states without one of their own"));
}

TEST(TheCallbackOfAllOtherStates, DoesNotExcuseACallbackForAStateThatIsNotListed) {
  ActuatorRunner<Arm> arm;
  arm.RegisterStateCallback("Wavin", [] { return kCodeOk; });
  EXPECT_THAT(FitToRobot(arm).error().message, HasSubstr("state 'Wavin'"));
}

TEST(TheCallbackOfAllOtherStates, IsRunOnARobotButNotForAStateThatIsNotListed) {
  const TempFolder folder;
  setenv("ROS_DOMAIN_ID", std::to_string(transport::TestDomain()).c_str(), 1);
  const std::string file = folder / "robot.toml";
  std::string text = kRobot;
  const std::string controller = "[controller]";
  text.insert(text.find(controller) + controller.size(),
              "\nnamespace = \"" + RobotFile::name_space() + "\"\nstate_dir = \"" +
                  std::string(folder / "state") + "\"\n");
  std::ofstream(file) << text;
  const auto node = transport::NodeThread::Start();
  ASSERT_TRUE(node);
  ActuatorRunner<Arm> arm;
  ActuatorRunner<MachineActuator> leg("leg");
  leg.RegisterStateCallback([](const State&) { return kCodeOk; });
  ASSERT_TRUE(arm.Init(file, node.value()));
  ASSERT_TRUE(leg.Init(file, node.value()));
  ASSERT_TRUE(arm.Start());
  ASSERT_TRUE(leg.Start());
  MachineController machine;
  ASSERT_TRUE(machine.Init(file).ok());
  ASSERT_TRUE(machine.AwaitSetUp().ok());
  ASSERT_TRUE(machine.Switch("SelfCheck").done());
  ASSERT_TRUE(machine.Switch("Active").done());
  const SwitchResult down = machine.Switch("LowPower");
  EXPECT_EQ(down.outcome, SwitchOutcome::kDoneDegraded);
  EXPECT_THAT(down.degraded, ElementsAre("arm"));
  const SwitchResult alone = machine.Switch("arm", "LowPower");
  EXPECT_EQ(alone.outcome, SwitchOutcome::kRefused);
  EXPECT_EQ(alone.code, kCodeUnSupport);
  arm.Shutdown();
  EXPECT_THAT(arm.entered, ElementsAre("SetUp", "SelfCheck", "Active"));
}

TEST(ALineOfTheLog, HasTheActuatorsNameAndTheCodeOfAnError) {
  const MachineActuator arm("arm");
  ::testing::internal::CaptureStderr();
  arm.Log("waves");
  arm.Log(Error{3, "may not wave"});
  arm.Log(Error{kCodeOk, "is well again"});
  EXPECT_EQ(::testing::internal::GetCapturedStderr(),
            "arm: waves\narm: warning: may not wave (3 StateInvalid)\narm: is well again\n");
}

// Its callbacks do not fit: a program that is this actuator ends with 2 before it does anything.
TEST(ConfigurationErrors, EndRunWithTwoAndOfferTheNearestName) {
  const TempFolder folder;
  const std::string robot = folder / "robot.toml";
  std::ofstream(robot) << kRobot;
  MachineActuator misspelt("arn");
  EXPECT_EQ(misspelt.Run(robot), MachineActuator::kConfigurationError);
  EXPECT_THAT(misspelt.Init(robot).error().message,
              HasSubstr("has no actuator 'arn'; did you mean 'arm'?"));
  ActuatorRunner<MachineActuator> arm("arm");
  EXPECT_EQ(arm.Run(robot), 2);
  for (const char* state : {"SetUp", "SelfCheck", "active", "Waving"}) {
    arm.RegisterStateCallback(State(state), [] { return Result<>(Ok()); });
  }
  EXPECT_EQ(arm.Run(robot), 2);
  EXPECT_THAT(
      arm.Start().error().message,
      HasSubstr("lists state 'Active' for arm, but there is no callback for it; did you mean "
                "the callback for 'active', which the config does not list?"));
}

}  // namespace musher::state_callbacks_test
