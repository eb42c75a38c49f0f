// What the judge must not say.

#include <gtest/gtest.h>

#include "musher/simulation/trial.hpp"

namespace musher::testing::judge_test {

using simulation::Incident;
using simulation::IncidentKind;

Incident At(Duration at, IncidentKind kind, const State& state = {}) {
  Incident incident;
  incident.at = at;
  incident.kind = kind;
  incident.actuator = 1;
  incident.state = state;
  incident.lasts = Milliseconds(100);
  return incident;
}

// A second controller begins at the very instant at which the first one's patience ends: whose turn
// comes first is no fault of the other's.
TEST(Judge, LetsAControllerHaveItsTurnAtTheInstantOfItsDeadline) {
  const auto config = simulation::ConfigAround("arm", {"SetUp", "SelfCheck", "Active", "LowPower"});
  ASSERT_TRUE(config) << config.error().message;
  simulation::StoryOptions options = simulation::UsualOptions(config.value());
  options.provided = false;
  const auto ending = TellStory(config.value(), 1,
                                {At(Milliseconds(2000), IncidentKind::kHang),
                                 At(Milliseconds(2000), IncidentKind::kSet, "LowPower"),
                                 At(Milliseconds(5000), IncidentKind::kTakeover),
                                 At(Milliseconds(5000), IncidentKind::kSet, "LowPower")},
                                options);
  EXPECT_FALSE(ending.violation) << ending.violation->what;
}

}  // namespace musher::testing::judge_test
