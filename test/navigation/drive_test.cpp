// The whole chain: a body is driven over a map by planner, trajectory and follower.

#include "musher/test/navigation/drive.hpp"

#include <gmock/gmock.h>

#include "musher/test/navigation/maps.hpp"

namespace musher::navigation::testing::drive_test {

using End = DriveResult::End;

CellMap TwoRooms() {
  return Drawn({"####################",  //
                "#        #         #",  //
                "#        #         #",  //
                "#        #         #",  //
                "#                  #",  //
                "#                  #",  //
                "#                  #",  //
                "#        #         #",  //
                "#        #         #",  //
                "####################"},
               0.5, 5);
}

TEST(Drive, ArrivesInTheOtherRoomWithoutTouchingAWall) {
  const DriveResult result = Drive(TwoRooms(), {{1.5, 1.2, 0}, 0}, {{8.5, 4, 0}, 1.5}, {});
  ASSERT_EQ(result.end, End::kArrived) << result.reason;
  EXPECT_NEAR(result.pose.at.x_m, 8.5, 0.2);
  EXPECT_NEAR(result.pose.at.y_m, 4, 0.2);
  EXPECT_NEAR(result.pose.yaw_rad, 1.5, 0.1);
  EXPECT_GT(result.least_room_m, 0.05);
  EXPECT_LT(result.tracking_most_m, 0.05);
  EXPECT_GT(result.highest_m_s, 1) << "it does not creep";
  EXPECT_LE(result.highest_m_s, 1.5);
}

TEST(Drive, GoesAroundAnObstacleThatTheMapDoesNotHave) {
  DriveOptions options;
  options.movers = {{{5.0, 2.2, 0}, {5.0, 2.2, 0}, 0.25, 0}};
  const DriveResult result = Drive(TwoRooms(), {{1.5, 2.2, 0}, 0}, {{8.5, 2.2, 0}, 0}, options);
  EXPECT_EQ(result.end, End::kFailed) << "it fills the door";
  EXPECT_THAT(result.reason, ::testing::HasSubstr("in the way for 30 s"));
  options.movers = {{{3.0, 2.2, 0}, {3.0, 2.2, 0}, 0.25, 0}};
  const DriveResult around = Drive(TwoRooms(), {{1.5, 2.2, 0}, 0}, {{8.5, 2.2, 0}, 0}, options);
  ASSERT_EQ(around.end, End::kArrived) << around.reason;
  EXPECT_EQ(around.replans, 1);
  EXPECT_EQ(around.hits_of_body, 0);
  EXPECT_GT(around.least_room_m, 0);
}

TEST(Drive, LetsAMoverPass) {
  DriveOptions options;
  options.movers = {{{7, 0.8, 0}, {7, 4.2, 0}, 0.25, 0.3, 1.0}};
  const DriveResult result = Drive(TwoRooms(), {{1.5, 2.2, 0}, 0}, {{8.5, 2.2, 0}, 0}, options);
  ASSERT_EQ(result.end, End::kArrived) << result.reason;
  EXPECT_EQ(result.hits_of_body, 0);
}

TEST(Drive, StandsBeforeAMoverThatDoesNotStandTouchesIt) {
  int touched = 0;
  for (const double from_m : {5.0, 6.0, 7.0, 8.0, 9.0}) {
    for (const double speed_m_s : {0.4, 0.5, 0.6}) {
      DriveOptions options;
      options.movers = {{{from_m, 2.2, 0}, {1, 2.2, 0}, 0.25, speed_m_s}};
      options.movers[0].yields = false;
      const DriveResult result = Drive(TwoRooms(), {{1.5, 2.2, 0}, 0}, {{8.5, 2.2, 0}, 0}, options);
      EXPECT_EQ(result.hits_of_body, 0) << from_m << " m, " << speed_m_s << " m/s";
      touched += result.hits_of_movers;
    }
  }
  EXPECT_GT(touched, 0);
}

TEST(Drive, StaysOnItsWayWhenTheBodyIsPushed) {
  DriveOptions options;
  options.disturb = [](double at_s, Pose& pose) {
    if (std::abs(at_s - 3) < 0.008) pose.at.y_m += 0.12;
  };
  const DriveResult result = Drive(TwoRooms(), {{1.5, 2.2, 0}, 0}, {{8.5, 2.2, 0}, 0}, options);
  ASSERT_EQ(result.end, End::kArrived) << result.reason;
  EXPECT_GT(result.tracking_most_m, 0.1);
  EXPECT_LT(result.tracking_rms_m, 0.05);
}

TEST(Drive, SaysWhyItDoesNotStart) {
  const DriveResult result = Drive(TwoRooms(), {{1.5, 2.2, 0}, 0}, {{4.7, 1, 0}, 0}, {});
  EXPECT_EQ(result.end, End::kRefused);
  EXPECT_EQ(result.reason, "goal (4.70, 1.00) is in an obstacle");
}

}  // namespace musher::navigation::testing::drive_test
