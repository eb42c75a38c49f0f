// The plan dispatcher under injected faults: a robot executes a step of a plan in Active only; in
// all other states and during an emergency stop its goal is cancelled.

#include <algorithm>
#include <vector>

#include "musher/modules/skills/plan/dispatcher_actuator.hpp"
#include "musher/test/modules/module_fault_test.hpp"

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
  // What a process had begun that was killed.
  void EndAll() {
    for (auto& goal : std::exchange(running_, {})) goal.Succeed({true, "completed"});
  }

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
  testing::ModuleFaultTest<DispatcherActuator, RobotAndClient> test;
  test.make = [] {
    return std::make_unique<DispatcherActuator>("plan_dispatcher", DispatcherConfig{});
  };
  int executed = 0;
  test.always = [&](const DispatcherActuator&, const ActuatorReport& report) {
    if (report.state == kSetUp) test.peers->EndAll();
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
