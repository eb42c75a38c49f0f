// Planner and controller together, as a skill uses them: a path, and the drive along it.

#include "musher/test/modules/navigation/navigation_rig.hpp"

namespace musher::navigation::navigation_servers_test {

using ::testing::HasSubstr;
using transport::GoalEnd;

class NavigationServers : public testing::NavigationRig {};

TEST_F(NavigationServers, PlanAndDriveThroughADoor) {
  StartServers();
  const msg::Path path = PathTo(6.5, 1, 1.5);
  ASSERT_GT(path.poses.size(), 2U);
  EXPECT_EQ(path.header.frame_id, "map");
  const std::size_t drive = Follow(path);
  ASSERT_TRUE(AwaitEnd(drive)) << robot_.pose().at.x_m << " " << robot_.pose().at.y_m;
  EXPECT_EQ(drives_.ends[drive]->end, GoalEnd::kSucceeded) << log_.back();
  EXPECT_NEAR(robot_.pose().at.x_m, 6.5, 0.2);
  EXPECT_NEAR(robot_.pose().at.y_m, 1, 0.2);
  EXPECT_NEAR(robot_.pose().yaw_rad, 1.5, 0.1);
  Run(100);
  EXPECT_EQ(robot_.last_command().linear.x, 0);
  const int commands = robot_.commands();
  Run(1000);
  EXPECT_EQ(robot_.commands(), commands) << "after the end nothing is sent";
}

}  // namespace musher::navigation::navigation_servers_test
