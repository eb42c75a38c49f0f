// The match's planner under injected faults: a plan, which moves the robot, is sent and handed out
// in Active only and never during an emergency stop.

#include "musher/messages/r2_interfaces/get_action_seq.hpp"
#include "musher/modules/meilin/plan/planner_actuator.hpp"
#include "musher/test/modules/module_fault_test.hpp"
#include "musher/transport/service.hpp"

namespace musher::meilin::planner_fault_test {

// The page with a map, which sends the best plan at all times, and the robot.
class PageAndRobot {
 public:
  explicit PageAndRobot(transport::Node& desk)
      : map_(transport::MakePublisher<msg::String>(desk, "mf_r2_data", transport::kLatchedQos)
                 .value()),
        command_(transport::MakePublisher<msg::String>(desk, "planning/command").value()),
        buffer_(transport::MakeClient<msg::GetActionSeq>(desk, "get_action_seq").value()),
        sent_(transport::MakeSubscription<msg::Float32MultiArray>(
                  desk, "mf_action_seq", [this](const auto&...) { ++plans; })
                  .value()),
        ticker_(desk.loop().Every(Milliseconds(100), [this] {
          static_cast<void>(command_->Publish({"SEND"}));
          buffer_->Call({}, Milliseconds(90), [this](const auto& reply) {
            if (reply && reply.value().has_data) ++plans;
          });
        })) {
    static_cast<void>(map_->Publish(
        {R"({"grid": [[0,0,0],[0,2,0],[0,2,1],[0,2,0],[0,3,0],[0,0,0]], "team": "blue",
             "method": 1})"}));
  }

  int plans = 0;

 private:
  std::unique_ptr<transport::Publisher<msg::String>> map_;
  std::unique_ptr<transport::Publisher<msg::String>> command_;
  std::unique_ptr<transport::Client<msg::GetActionSeq>> buffer_;
  std::unique_ptr<transport::Subscription> sent_;
  transport::LoopHandlePtr ticker_;
};

TEST(ThePlannerOfTheMatch, SendsPlansInActiveOnlyAndNeverInAnEmergencyUnderInjectedFaults) {
  testing::ModuleFaultTest<PlannerActuator, PageAndRobot> test;
  test.scenarios = 30;
  test.make = [] { return std::make_unique<PlannerActuator>("meilin_planner", PlannerConfig{}); };
  const auto plans = [&test] {
    test.Pass(Milliseconds(100));  // what is under way
    test.peers->plans = 0;
    test.Pass(Milliseconds(500));
    return test.peers->plans;
  };
  int sent = 0;
  test.always = [&](const PlannerActuator&, const ActuatorReport& report) {
    const bool sends = plans() > 0;
    if (sends) ++sent;
    EXPECT_TRUE(!sends || (report.state == kActive && report.emergency_stop == 0))
        << "a plan is sent in " << report.state;
  };
  test.after_emergency_stop = [&](const PlannerActuator&, const ActuatorReport&) {
    EXPECT_EQ(plans(), 0) << "during a stop";
  };
  test.Run();
  EXPECT_GT(sent, 20) << "or nothing has been tried";
}

}  // namespace musher::meilin::planner_fault_test
