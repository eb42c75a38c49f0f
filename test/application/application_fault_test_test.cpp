// Applications under thousands of injected faults: a machine or tree runs in Active only, and never
// during an emergency stop. The test has no clock: it checks whether it is to be ticked; no tick
// comes.

#include "musher/simulation/actuator_fault_test.hpp"
#include "musher/test/application/show.hpp"
#include "musher/test/application/tree_course.hpp"

namespace musher::application_fault_test_test {

using testing::Harness;
using testing::Show;

template <class Application>
void RunsInActiveOnly() {
  const Harness harness;
  simulation::ActuatorFaultTest<Application> test;
  test.config_file = harness.path();
  int went_on = 0;
  test.always = [&went_on](const Application& show, const ActuatorReport& report) {
    if (show.ticking()) ++went_on;
    // After the release of a stop it is paused in Active too, until Active is set again.
    EXPECT_FALSE(show.ticking() && (report.state != kActive || report.emergency_stop != 0))
        << report.state;
  };
  test.after_emergency_stop = [](const Application& show, const ActuatorReport&) {
    EXPECT_FALSE(show.ticking());
  };
  test.Run();
  EXPECT_GT(went_on, 100) << "or nothing has been tried";
}

TEST(AnApplication, RunsInActiveOnlyAndNeverInAnEmergencyUnderInjectedFaults) {
  RunsInActiveOnly<Show>();
}

TEST(ATree, RunsInActiveOnlyAndNeverInAnEmergencyUnderInjectedFaults) {
  RunsInActiveOnly<testing::Course>();
}

}  // namespace musher::application_fault_test_test
