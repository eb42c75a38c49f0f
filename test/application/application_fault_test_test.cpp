// An application under thousands of injected faults: its machine runs in Active only, and never
// during an emergency stop. The test has no clock: it checks whether the machine is to be ticked;
// no tick comes.

#include "musher/simulation/actuator_fault_test.hpp"
#include "musher/test/application/show.hpp"

namespace musher::application_fault_test_test {

using testing::Harness;
using testing::Show;

TEST(AnApplication, RunsInActiveOnlyAndNeverInAnEmergencyUnderInjectedFaults) {
  const Harness harness;
  simulation::ActuatorFaultTest<Show> test;
  test.config_file = harness.path();
  int went_on = 0;
  test.always = [&went_on](const Show& show, const ActuatorReport& report) {
    if (show.ticking()) ++went_on;
    // After the release of a stop it is paused in Active too, until Active is set again.
    EXPECT_FALSE(show.ticking() && (report.state != kActive || report.emergency_stop != 0))
        << report.state;
  };
  test.after_emergency_stop = [](const Show& show, const ActuatorReport&) {
    EXPECT_FALSE(show.ticking());
  };
  test.Run();
  EXPECT_GT(went_on, 100) << "or nothing has been tried";
}

}  // namespace musher::application_fault_test_test
