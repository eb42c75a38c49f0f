// The refusals of applications: their codes and the values in their places. The tests of the base
// classes provoke them, but for the stop that is engaged between a command and its callback: no
// test can bring the two into that order.

#include "musher/application/refusal.hpp"

#include "musher/test/support/refusals.hpp"

namespace musher::testing::application_refusal_test {

TEST(ARefusalOfAnApplication, HasItsCodeAndTheValuesInTheirPlaces) {
  EXPECT_EQ(Refused<ApplicationRefusal::kRunsNoSkills>("arm", "LowPower"),
            (Error{kCodeStateInvalid, "arm runs no skills in LowPower"}));
  EXPECT_EQ(Refused<ApplicationRefusal::kWaitsForStart>("dog", "dog"),
            (Error{kCodeStateInvalid,
                   "dog stands and waits for START: musher behavior dog --send START"}));
  EXPECT_EQ(
      Refused<ApplicationRefusal::kOtherRobot>("robot_7", "robot_0"),
      (Error{kCodeParametersInvalid, "the skill is for the robot 'robot_7', and this is robot_0"}));
  EXPECT_THAT(Refused<ApplicationRefusal::kStoppedMeanwhile>(),
              IsRefused(ApplicationRefusal::kStoppedMeanwhile));
}

TEST(ARefusalOfAnApplication, HasTheCodeOfItsModule) {
  EXPECT_EQ(RefusedWith<ApplicationRefusal::kStoppedMeanwhile>(5303),
            (Error{5303, "an emergency stop was engaged meanwhile"}));
}

}  // namespace musher::testing::application_refusal_test
