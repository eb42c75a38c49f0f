// The match's actuator under injected faults: its tree is ticked in Active only, and never during
// an emergency stop.

#include "musher/modules/meilin/mission/meilin_actuator.hpp"
#include "musher/simulation/actuator_fault_test.hpp"
#include "musher/test/support/paths.hpp"

namespace musher::meilin::meilin_fault_test {
namespace {

// With a public ticking().
class Watched final : public MeilinActuator {
 public:
  using MeilinActuator::MeilinActuator;
  using TreeActuator::ticking;
};

MissionConfig Stage() {
  MissionConfig config;
  config.tree_file = SourceDir() + "/config/meilin/meilin_stage.xml";
  return config;
}

}  // namespace

TEST(TheMeilinActuator, TicksItsTreeInActiveOnlyAndNeverInAnEmergencyUnderInjectedFaults) {
  simulation::ActuatorFaultTest<Watched> test;
  test.make = [] { return std::make_unique<Watched>("meilin", Stage(), MatchConfig{}); };
  int ticked = 0;
  test.always = [&ticked](const Watched& meilin, const ActuatorReport& report) {
    if (meilin.ticking()) ++ticked;
    EXPECT_FALSE(meilin.ticking() && (report.state != kActive || report.emergency_stop != 0))
        << report.state;
  };
  test.after_emergency_stop = [](const Watched& meilin, const ActuatorReport&) {
    EXPECT_FALSE(meilin.ticking());
  };
  test.Run();
  EXPECT_GT(ticked, 100) << "or nothing has been tried";
}

}  // namespace musher::meilin::meilin_fault_test
