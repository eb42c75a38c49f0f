// The controller as a member of a program, against real actuators over DDS.

#include "musher/controller/machine_controller.hpp"

#include <gmock/gmock.h>
#include <unistd.h>

#include <atomic>
#include <fstream>
#include <future>

#include "musher/actuator/machine_actuator.hpp"
#include "musher/base/host.hpp"
#include "musher/lifecycle/record/texts.hpp"
#include "musher/test/actuator/robot_file.hpp"
#include "musher/test/support/refusals.hpp"

namespace musher::machine_controller_test {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using testing::kAllStates;
using ::testing::Pair;
using testing::RobotFile;

constexpr auto kDeadline = std::chrono::seconds(120);

// An actuator whose callbacks fail or wait on request.
class Puppet : public MachineActuator {
 public:
  Puppet(const std::string& name, const RobotFile& file,
         std::shared_ptr<transport::NodeThread> node)
      : MachineActuator(name) {
    RegisterStateCallback([this](const State& state) -> Result<> {
      if (state == blocks_in) {
        entered.set_value();
        gate.get_future().wait();
      }
      if (state == fails_in) return Error{5001, "by the test"};
      return Ok();
    });
    started = Init(file.path(), std::move(node)).ok() && Start().ok();
  }

  bool started = false;
  std::string fails_in;
  std::string blocks_in;
  std::promise<void> entered;  // the blocking callback has begun …
  std::promise<void> gate;     // … and may end
};

class Controlling : public ::testing::Test {
 protected:
  explicit Controlling(const std::map<std::string, int>& times_ms = {})
      : file_({"arm", "leg"}, kAllStates, times_ms),
        node_(transport::NodeThread::Start().value()),
        arm_("arm", file_, node_),
        leg_("leg", file_, node_) {
    EXPECT_TRUE(arm_.started);
    EXPECT_TRUE(leg_.started);
  }

  void BringUp() {
    ASSERT_TRUE(controller_.Init(file_.path()));
    ASSERT_TRUE(controller_.AwaitSetUp());
    for (const BuiltInState state : {kSelfCheck, kActive}) {
      const SwitchResult result = controller_.Switch(state);
      ASSERT_TRUE(result.done()) << state << ": " << result.reason;
    }
  }

  RobotFile file_;
  std::shared_ptr<transport::NodeThread> node_;
  ActuatorRunner<Puppet> arm_;
  ActuatorRunner<Puppet> leg_;
  MachineController controller_;
};

TEST_F(Controlling, BringsActuatorsUpAndReportsTheirStates) {
  BringUp();
  EXPECT_THAT(controller_.States(), ElementsAre(Pair("arm", "Active"), Pair("leg", "Active")));
  EXPECT_EQ(controller_.GetMachineState(), "Active");
  EXPECT_EQ(arm_.CurrentState(), "Active");
}

TEST_F(Controlling, SwitchesOneActuatorOnly) {
  BringUp();
  EXPECT_TRUE(controller_.Switch("arm", "Protected").done());
  EXPECT_EQ(controller_.StateOf("arm"), "Protected");
  EXPECT_EQ(controller_.StateOf("leg"), "Active");
  EXPECT_EQ(controller_.StateOf("tail"), std::nullopt);
}

TEST_F(Controlling, ReturnsTheCodeAndMessageOfTheFailedActuatorAndUndoesTheRest) {
  BringUp();
  ASSERT_TRUE(controller_.Switch("LowPower").done());
  leg_.fails_in = "Active";
  const SwitchResult result = controller_.Switch("Active");
  EXPECT_EQ(result.outcome, SwitchOutcome::kUndone);
  EXPECT_EQ(result.code, 5001);
  EXPECT_THAT(result.reason, HasSubstr("by the test"));
  EXPECT_EQ(arm_.CurrentState(), "LowPower");
  EXPECT_FALSE(controller_.Switch("Active").done());
}

TEST_F(Controlling, IsAnsweredByAnActuatorWhoseCallbackBlocks) {
  BringUp();
  leg_.blocks_in = "LowPower";
  auto low_power = std::async(std::launch::async, [&] { return controller_.Switch("LowPower"); });
  leg_.entered.get_future().wait();
  const SwitchResult busy = controller_.Switch("Protected");
  EXPECT_EQ(busy.outcome, SwitchOutcome::kRefused);
  leg_.gate.set_value();
  EXPECT_TRUE(low_power.get().done());
}

TEST_F(Controlling, AnAsynchronousSwitchReturnsWhileACallbackBlocksAndReportsItsOutcomeLater) {
  BringUp();
  leg_.blocks_in = "LowPower";
  std::promise<SwitchResult> ended;
  std::future<SwitchResult> end = ended.get_future();
  controller_.SwitchAsync("LowPower", [&](const SwitchResult& result) { ended.set_value(result); });
  ASSERT_EQ(leg_.entered.get_future().wait_for(kDeadline), std::future_status::ready);
  EXPECT_EQ(end.wait_for(std::chrono::seconds(0)), std::future_status::timeout);
  leg_.gate.set_value();
  ASSERT_EQ(end.wait_for(kDeadline), std::future_status::ready);
  const SwitchResult result = end.get();
  EXPECT_TRUE(result.done()) << result.reason;
  EXPECT_EQ(result.state, "LowPower");
}

TEST_F(Controlling, AnAsynchronousSwitchBeginsTheNextFromItsEnd) {
  BringUp();
  std::promise<std::vector<SwitchResult>> ended;
  controller_.SwitchAsync("arm", "Protected", [&](const SwitchResult& first) {
    controller_.SwitchAsync("arm", "Active", [&, first](const SwitchResult& second) {
      ended.set_value({first, second});
    });
  });
  auto end = ended.get_future();
  ASSERT_EQ(end.wait_for(kDeadline), std::future_status::ready);
  const std::vector<SwitchResult> results = end.get();
  EXPECT_TRUE(results[0].done()) << results[0].reason;
  EXPECT_TRUE(results[1].done()) << results[1].reason;
  EXPECT_EQ(controller_.StateOf("arm"), "Active");
}

TEST_F(Controlling, ARefusalOfAnAsynchronousSwitchIsAnOutcome) {
  BringUp();
  std::promise<SwitchResult> ended;
  controller_.SwitchAsync("tail", "Active",
                          [&](const SwitchResult& result) { ended.set_value(result); });
  auto end = ended.get_future();
  ASSERT_EQ(end.wait_for(kDeadline), std::future_status::ready);
  EXPECT_EQ(end.get().outcome, SwitchOutcome::kRefused);
}

// Its callback and all that it refers to may be destroyed.
TEST_F(Controlling, AControllerThatIsDestroyedCallsNoEndAnyMore) {
  auto controller = std::make_unique<MachineController>();
  ASSERT_TRUE(controller->Init(file_.path()));
  ASSERT_TRUE(controller->AwaitSetUp());
  ASSERT_TRUE(controller->Switch("SelfCheck").done());
  leg_.blocks_in = "Active";
  std::atomic<bool> ran = false;
  controller->SwitchAsync("Active", [&](const SwitchResult&) { ran = true; });
  ASSERT_EQ(leg_.entered.get_future().wait_for(kDeadline), std::future_status::ready);
  controller.reset();
  leg_.gate.set_value();
  EXPECT_FALSE(ran);
}

TEST_F(Controlling, TearsDownAndTheActuatorsProgramsEnd) {
  BringUp();
  EXPECT_TRUE(controller_.Switch("TearDown").done());
  EXPECT_EQ(arm_.Wait(), 0);
  EXPECT_EQ(leg_.Wait(), 0);
}

TEST_F(Controlling, RefusesASecondControllerBesideALivingOne) {
  BringUp();
  MachineController second;
  const Result<> result = second.Init(file_.path());
  ASSERT_FALSE(result.ok());
  EXPECT_EQ(result.error().code, kCodeTargetBusy);
  EXPECT_THAT(result.error().message, HasSubstr(std::to_string(getpid())));
}

class ControllingInAHurry : public Controlling {
 protected:
  ControllingInAHurry() : Controlling({{"LowPower", 1000}}) {}
};

TEST_F(ControllingInAHurry, QueriesAnOverdueActuator) {
  ASSERT_NO_FATAL_FAILURE(BringUp());
  leg_.blocks_in = "LowPower";
  const SwitchResult result = controller_.Switch("LowPower");
  EXPECT_EQ(result.outcome, SwitchOutcome::kDoneDegraded);
  EXPECT_EQ(result.code, kCodeTimeout);
  EXPECT_THAT(result.reason, HasSubstr("leg: overdue"));
  EXPECT_THAT(result.degraded, ElementsAre("leg"));
  leg_.gate.set_value();
}

TEST(MachineController, IsOfNoUseBeforeInit) {
  MachineController controller;
  EXPECT_FALSE(controller.AwaitSetUp());
  EXPECT_FALSE(controller.Switch("Active").done());
  SwitchOutcome outcome = SwitchOutcome::kDone;
  controller.SwitchAsync("Active", [&](const SwitchResult& result) { outcome = result.outcome; });
  EXPECT_EQ(outcome, SwitchOutcome::kRefused);
}

TEST(MachineController, IsRefusedWhereAProcessOfAnotherUserHoldsItsName) {
  if (geteuid() != 0) GTEST_SKIP() << "only root can be another user";
  const RobotFile file({"arm"}, kAllStates);
  ASSERT_EQ(seteuid(65534), 0);
  const auto lock = NameLock::Acquire(
      NameLock::NameOf(transport::TestDomain(), RobotFile::name_space(), "musher/controller"));
  ASSERT_EQ(seteuid(0), 0);
  ASSERT_TRUE(lock);
  MachineController controller;
  const Result<> refused = controller.Init(file.path());
  ASSERT_FALSE(refused);
  EXPECT_THAT(refused.error(), testing::IsRefused(Refusal::kNameHeld));
}

TEST(MachineController, RefusesAProtocolThatItHasNoExtensionFor) {
  const RobotFile file({"legs"}, kAllStates);
  std::ofstream(file.path(), std::ios::app) << "protocol = \"cyberdog\"\n";
  MachineController controller;
  const Result<> begun = controller.Init(file.path());
  ASSERT_FALSE(begun.ok());
  EXPECT_EQ(
      begun.error().message,
      "actuator 'legs' has the protocol 'cyberdog', which the controller of this program does "
      "not have: give it the extension for that protocol, such as "
      "MachineController({cyberdog::Extension()})");
}

TEST(MachineController, WarnsOfAManagerThatNoExtensionServes) {
  const RobotFile file({"legs"}, kAllStates);
  std::ofstream(file.path(), std::ios::app) << "[policy]\nmanager = true\n";
  ::testing::internal::CaptureStderr();
  {
    MachineController controller;  // its log is complete when it has ended
    EXPECT_TRUE(controller.Init(file.path()));
  }
  const std::string log = ::testing::internal::GetCapturedStderr();
  EXPECT_THAT(log, HasSubstr("[policy] manager has no effect: give the controller the extension"));
}

TEST(MachineController, ReportsAnActuatorThatDidNotStartByItsDeadline) {
  const RobotFile file({"arm"}, kAllStates, {{"SetUp", 100}});
  MachineController controller;
  ASSERT_TRUE(controller.Init(file.path()));
  const Result<> result = controller.AwaitSetUp();
  ASSERT_FALSE(result.ok());
  EXPECT_THAT(result.error().message,
              HasSubstr("arm: " + texts::SetUpTimeout(Milliseconds(100)).message));
}

}  // namespace musher::machine_controller_test
