// The plan dispatcher under injected faults: a robot executes a step of a plan in Active only; in
// all other states, during an emergency stop and after a kill of the process its goal is cancelled.

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <vector>

#include "musher/modules/skills/plan/dispatcher_actuator.hpp"
#include "musher/test/modules/module_fault_test.hpp"
#include "musher/test/support/temp_folder.hpp"

namespace musher::skills::dispatcher_fault_test {

// A robot whose skills never end by themselves, and a client that sends plans at all times.
class RobotAndClient {
 public:
  explicit RobotAndClient(transport::Node& desk)
      : client_(transport::MakeActionClient<msg::PlanExecution>(desk, "plan_execution").value()),
        endpoints_(desk, ""),
        ticker_(desk.loop().Every(Milliseconds(200), [this] { Send(); })) {
    transport::ActionHandlers<msg::SkillExecution> handlers;
    handlers.start = [this](transport::ServerGoal<msg::SkillExecution> goal) {
      goal.Execute();
      running_.push_back(goal);
    };
    handlers.cancel = [this](transport::ServerGoal<msg::SkillExecution> goal) {
      std::erase_if(running_, [&](const auto& each) { return each.id() == goal.id(); });
      goal.Canceled({false, "cancelled"});
    };
    endpoints_.ServeAction<msg::SkillExecution>("a/skill_execution", std::move(handlers));
  }

  std::size_t running() const { return running_.size(); }

 private:
  void Send() {
    msg::SkillInfo skill;
    skill.skill = "wait";
    msg::SkillPlan plan;
    plan.steps = {{1, {{"a", {skill}}}}};
    client_->SendGoal({plan}, Milliseconds(500), {});
  }

  std::vector<transport::ServerGoal<msg::SkillExecution>> running_;
  std::unique_ptr<transport::ActionClient<msg::PlanExecution>> client_;
  transport::Endpoints endpoints_;
  transport::LoopHandlePtr ticker_;
};

TEST(ThePlanDispatcher, ExecutesPlansInActiveOnlyAndNeverInAnEmergencyUnderInjectedFaults) {
  const TempFolder states;  // of the machine; a scenario begins without a file
  setenv("XDG_STATE_HOME", states.path().c_str(), 1);
  testing::ModuleFaultTest<DispatcherActuator, RobotAndClient> test;
  test.before_scenario = [&states, begin = test.before_scenario] {
    std::filesystem::remove_all(states / "musher");
    begin();
  };
  test.make = [] {
    return std::make_unique<DispatcherActuator>("plan_dispatcher", DispatcherConfig{});
  };
  int executed = 0;
  test.always = [&](const DispatcherActuator&, const ActuatorReport& report) {
    test.Pass(Milliseconds(600));
    const bool executes = test.peers->running() > 0;
    if (executes) ++executed;
    EXPECT_TRUE(!executes || (report.state == kActive && report.emergency_stop == 0))
        << "a plan is executed in " << report.state;
  };
  test.after_emergency_stop = [&](const DispatcherActuator&, const ActuatorReport& report) {
    if (report.state == kUninitialized) return;
    test.Pass(Milliseconds(600));
    EXPECT_EQ(test.peers->running(), 0U) << "during a stop";
  };
  test.Run();
  EXPECT_GT(executed, 50) << "or nothing has been tried";
}

}  // namespace musher::skills::dispatcher_fault_test
