// An application in thousands of unlucky lives: its machine goes on in Active only, and never in an
// emergency. A trial has no clock: whether it is to be ticked is judged, no tick comes.

#include "musher/simulation/actuator_fault_test.hpp"
#include "musher/test/application/show.hpp"

namespace musher::application_fault_test_test {

using testing::Harness;
using testing::Show;

TEST(AnApplication, GoesOnInActiveOnlyAndNeverInAnEmergencyWhateverBefallsIt) {
  const Harness harness;
  simulation::ActuatorFaultTest<Show> test;
  test.config_file = harness.path();
  int went_on = 0;
  test.always = [&went_on](const Show& show, const ActuatorReport& report) {
    if (show.ticking()) ++went_on;
    // After the release of a stop it rests in Active too, until it is sent there anew.
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
