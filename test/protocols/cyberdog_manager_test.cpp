// Musher actuators under CyberDog's manager.

#include <gmock/gmock.h>

#include "musher/simulation/robot.hpp"
#include "musher/test/lifecycle/coordination/harness.hpp"
#include "musher/test/protocols/cyberdog_manager.hpp"

namespace musher::testing::cyberdog_manager_test {

using simulation::Act;
using simulation::SimRobot;

class UnderACyberdogManager : public ::testing::Test {
 protected:
  UnderACyberdogManager()
      : robot_(1, MachineOf(2), [this](const std::string& actuator, const State& state) {
          const auto act = acts_.find(actuator + ":" + state);
          return act == acts_.end() ? Act{} : act->second;
        }) {
    node_ = robot_.network().MakeNode("manager");
    manager_ = std::make_unique<CyberdogManager>(*node_, "", std::vector<std::string>{"a", "b"},
                                                 Milliseconds(100));
    robot_.StartActuator("a");
    robot_.StartActuator("b");
  }

  std::vector<CyberdogManager::Result> Set(const std::string& state) {
    std::optional<std::vector<CyberdogManager::Result>> results;
    manager_->SetState(state, [&](auto r) { results = std::move(r); });
    EXPECT_TRUE(robot_.RunUntil([&] { return results.has_value(); }));
    return *results;
  }

  std::map<std::string, Act> acts_;
  SimRobot robot_;
  std::unique_ptr<transport::Node> node_;
  std::unique_ptr<CyberdogManager> manager_;
};

TEST_F(UnderACyberdogManager, ActuatorsAreVisibleOnceTheyAreSetUpAndSwitch) {
  ASSERT_TRUE(robot_.RunUntil([&] { return manager_->Ready(); }));
  for (const auto& result : Set("SelfCheck")) EXPECT_EQ(result.code, 0);
  for (const auto& result : Set("Active")) {
    EXPECT_EQ(result.code, 0);
    EXPECT_EQ(result.current_state, 4) << "Musher fills it";
  }
  EXPECT_EQ(robot_.ReportOf("b")->state, "Active");
}

TEST_F(UnderACyberdogManager, AFailureReturnsItsCodeAndAnUnknownStateAPlainEight) {
  ASSERT_TRUE(robot_.RunUntil([&] { return manager_->Ready(); }));
  acts_["a:Active"].error = {5001, "no"};
  EXPECT_EQ(Set("Active").back().code, 5001);
  EXPECT_EQ(Set("Dance").back().code, 8);
}

TEST_F(UnderACyberdogManager, ABusyActuatorRepliesThatItIsBusy) {
  ASSERT_TRUE(robot_.RunUntil([&] { return manager_->Ready(); }));
  acts_["a:Active"].takes = Milliseconds(500);
  EXPECT_EQ(Set("Active").back().code, -1) << "the manager's own timeout";
  EXPECT_EQ(Set("LowPower").back().code, kCodeTargetBusy);
}

TEST_F(UnderACyberdogManager, ActuatorsSendHeartbeatsToASubscriber) {
  ASSERT_TRUE(robot_.RunUntil([&] { return manager_->Ready(); }));
  robot_.RunFor(std::chrono::seconds(10));
  for (const char* name : {"a", "b"}) {
    EXPECT_GE(manager_->heartbeat_counts[name], 19) << name;
    EXPECT_LE(manager_->heartbeat_counts[name], 20) << name;
  }
}

TEST_F(UnderACyberdogManager, AnActuatorUnderAControllerIsDenied) {
  ASSERT_TRUE(robot_.RunUntil([&] { return manager_->Ready(); }));
  robot_.StartController();
  ASSERT_TRUE(robot_.RunUntil([&] { return robot_.machine().phase == Phase::kRunning; }));
  EXPECT_EQ(Set("LowPower").back().code, kCodePermissionDenied);
  EXPECT_EQ(robot_.ReportOf("a")->state, "Active");
}

}  // namespace musher::testing::cyberdog_manager_test
