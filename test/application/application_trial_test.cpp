// An application in thousands of unlucky lives: it ticks in Active only, and never in an emergency.

#include "musher/simulation/actuator_trial.hpp"
#include "musher/test/application/show.hpp"

namespace musher {
namespace {

using testing::Show;
using testing::Stage;

TEST(AnApplication, TicksInActiveOnlyAndNeverInAnEmergencyWhateverBefallsIt) {
  const Stage stage;
  simulation::ActuatorTrial<Show> trial;
  trial.config_file = stage.path();
  trial.always = [](const Show& show, const ActuatorReport& report) {
    // After the release of a stop it rests in Active too, until it is sent there anew.
    EXPECT_FALSE(show.ticking() && (report.state != kActive || report.emergency_stop != 0))
        << report.state;
  };
  trial.after_emergency_stop = [](const Show& show, const ActuatorReport&) {
    EXPECT_FALSE(show.ticking());
  };
  trial.Run();
}

}  // namespace
}  // namespace musher
