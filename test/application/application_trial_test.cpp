// An application in thousands of unlucky lives: its machine goes on in Active only, and never in an
// emergency. A trial has no clock: whether it is to be ticked is judged, no tick comes.

#include "musher/simulation/actuator_trial.hpp"
#include "musher/test/application/show.hpp"

namespace musher::application_trial_test {

using testing::Show;
using testing::Stage;

TEST(AnApplication, GoesOnInActiveOnlyAndNeverInAnEmergencyWhateverBefallsIt) {
  const Stage stage;
  simulation::ActuatorTrial<Show> trial;
  trial.config_file = stage.path();
  int went_on = 0;
  trial.always = [&went_on](const Show& show, const ActuatorReport& report) {
    if (show.ticking()) ++went_on;
    // After the release of a stop it rests in Active too, until it is sent there anew.
    EXPECT_FALSE(show.ticking() && (report.state != kActive || report.emergency_stop != 0))
        << report.state;
  };
  trial.after_emergency_stop = [](const Show& show, const ActuatorReport&) {
    EXPECT_FALSE(show.ticking());
  };
  trial.Run();
  EXPECT_GT(went_on, 100) << "or nothing has been tried";
}

}  // namespace musher::application_trial_test
