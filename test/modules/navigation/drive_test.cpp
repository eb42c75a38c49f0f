// The whole chain: a body is driven over a map by planner, trajectory and follower.

#include "musher/test/modules/navigation/drive.hpp"

#include <gtest/gtest.h>

#include "musher/test/modules/navigation/maps.hpp"

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
               0.5);
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

}  // namespace musher::navigation::testing::drive_test
