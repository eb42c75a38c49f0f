// The plan dispatcher with its controller, over DDS in one process.

#include "musher/modules/skills/plan/dispatcher_actuator.hpp"

#include <future>

#include "musher/test/application/show.hpp"

namespace musher::skills::dispatcher_actuator_test {

using testing::Harness;
using ::testing::HasSubstr;

// Has the name that the harness has a config for.
class TestDispatcher : public DispatcherActuator {
 public:
  TestDispatcher() : DispatcherActuator("show", DispatcherConfig{}) {}
};

class ADispatcherActuator : public ::testing::Test {
 protected:
  using Client = transport::ActionClient<msg::PlanExecution>;

  ADispatcherActuator() {
    harness_.node().RunOnLoop([this] {
      client_ =
          transport::MakeActionClient<msg::PlanExecution>(harness_.node().node(), "plan_execution")
              .value();
    });
  }
  ~ADispatcherActuator() override {
    harness_.node().RunOnLoop([this] { client_.reset(); });
  }
  // The message of the result of a plan with one robot, which has no server.
  std::string ReasonOf() {
    msg::SkillInfo skill;
    skill.skill = "wait";
    msg::PlanExecution::Goal goal;
    goal.plan.steps = {{1, {{"cf2x_9", {skill}}}}};
    std::promise<std::string> reason;
    transport::GoalEvents<msg::PlanExecution> events;
    events.on_end = [&](const auto& outcome) { reason.set_value(outcome.result.message); };
    harness_.node().RunOnLoop([&] { client_->SendGoal(goal, std::chrono::seconds(20), events); });
    return reason.get_future().get();
  }

  Harness harness_{"steady"};
  std::unique_ptr<Client> client_;
  ActuatorRunner<TestDispatcher> dispatcher_;
};

TEST_F(ADispatcherActuator, ExecutesPlansInActiveOnly) {
  ASSERT_TRUE(dispatcher_.Init(harness_.path()).ok());
  ASSERT_TRUE(dispatcher_.Start().ok());
  ASSERT_TRUE(harness_.controller().Init(harness_.path()).ok());
  ASSERT_TRUE(harness_.controller().AwaitSetUp().ok());
  EXPECT_THAT(ReasonOf(), HasSubstr("no plans are executed: it is not in Active"));
  ASSERT_TRUE(harness_.controller().Switch("SelfCheck").done());
  ASSERT_TRUE(harness_.controller().Switch("Active").done());
  EXPECT_EQ(ReasonOf(), "Execution failed in timestep 1. no action server within 3.0 s: cf2x_9");
  ASSERT_TRUE(harness_.controller().Switch("LowPower").done());
  EXPECT_EQ(ReasonOf(), "no plans are executed: it is in LowPower");
}

}  // namespace musher::skills::dispatcher_actuator_test
