// The simulated world under injected faults: its time runs in every state, also during an emergency
// stop, from SetUp on. All other modules follow its clock.

#include "musher/modules/world/process/world_actuator.hpp"
#include "musher/test/modules/module_fault_test.hpp"
#include "musher/test/modules/world/scenes.hpp"

namespace musher::world::world_fault_test {

class Watch {
 public:
  explicit Watch(transport::Node& desk)
      : clock_(transport::MakeSubscription<msg::Clock>(
                   desk, "clock", [this](const auto&...) { ++ticks; }, transport::kClockQos)
                   .value()) {}

  int ticks = 0;

 private:
  std::unique_ptr<transport::Subscription> clock_;
};

TEST(TheWorldActuator, LetsTimeRunInEveryStateUnderInjectedFaults) {
  testing::ModuleFaultTest<WorldActuator, Watch> test;
  test.make = [] { return std::make_unique<WorldActuator>("world", EmptyYard()); };
  const auto runs = [&test] {
    test.Pass(Milliseconds(250));  // discovery
    test.peers->ticks = 0;
    test.Pass(Milliseconds(100));
    return test.peers->ticks > 0;
  };
  int in_a_stop = 0;
  test.always = [&](const WorldActuator&, const ActuatorReport& report) {
    EXPECT_TRUE(runs()) << "time stands still in " << report.state;
    if (report.emergency_stop != 0) ++in_a_stop;
  };
  test.Run();
  EXPECT_GT(in_a_stop, 20) << "or nothing has been tried";
}

}  // namespace musher::world::world_fault_test
