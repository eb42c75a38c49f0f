// The files of musher-planner and musher-controller: their defaults, and messages about errors.

#include <gmock/gmock.h>

#include "musher/modules/navigation/controller_server/controller_config.hpp"
#include "musher/modules/navigation/planner_server/planner_config.hpp"
#include "musher/test/support/diagnostics.hpp"
#include "musher/test/support/paths.hpp"

namespace musher::navigation::server_config_test {

using ::testing::IsEmpty;

template <class Reading>
std::string ErrorIn(const Reading& reading) {
  return musher::testing::FirstError(reading);
}

std::string PlannerError(const std::string& text) {
  return ErrorIn(ReadPlannerText(text, "planner.toml"));
}

std::string ControllerError(const std::string& text) {
  return ErrorIn(ReadControllerText(text, "controller.toml"));
}

TEST(PlannerFile, ThatIsShippedHasTheDefaults) {
  const auto reading = ReadPlannerFile(SourceDir() + "/config/navigation/planner.toml");
  EXPECT_THAT(reading.diagnostics, IsEmpty());
  ASSERT_TRUE(reading.config);
  const PlannerConfig& file = *reading.config;
  const PlannerConfig defaults;
  EXPECT_EQ(file.frame, defaults.frame);
  EXPECT_EQ(file.map, defaults.map);
  EXPECT_EQ(file.cloud, defaults.cloud);
  EXPECT_EQ(file.keep_out, defaults.keep_out);
  EXPECT_EQ(file.tf.topic, defaults.tf.topic);
  EXPECT_EQ(file.tf.stale, defaults.tf.stale);
  EXPECT_EQ(file.limit, defaults.limit);
  EXPECT_EQ(file.stale, defaults.stale);
  EXPECT_EQ(file.self_check_time, defaults.self_check_time);
  EXPECT_EQ(file.blocked_from, defaults.blocked_from);
  EXPECT_EQ(file.unknown_is_free, defaults.unknown_is_free);
  EXPECT_EQ(file.cloud_resolution_m, defaults.cloud_resolution_m);
  EXPECT_EQ(file.cloud_margin_m, defaults.cloud_margin_m);
  EXPECT_EQ(file.ceiling_m, 2.4) << "of the rooms";
  ASSERT_EQ(file.robots.size(), 4U);
  const auto same = ReadPlannerText("[[robot]]\nname = \"jetbot_0\"\n", "short.toml");
  ASSERT_TRUE(same.config);
  const PlannerRobot &full = file.robots[0], &brief = same.config->robots[0];
  EXPECT_EQ(full.radius_m, brief.radius_m);
  EXPECT_EQ(full.margin_m, brief.margin_m);
  EXPECT_EQ(full.comfort_m, brief.comfort_m);
  EXPECT_EQ(full.flies, brief.flies);
  EXPECT_EQ(full.odometry, brief.odometry);
  ASSERT_EQ(full.scanners.size(), 1U);
  ASSERT_EQ(brief.scanners.size(), 1U);
  EXPECT_EQ(full.scanners[0].topic, brief.scanners[0].topic);
  EXPECT_EQ(full.action, brief.action);
  EXPECT_EQ(full.path, brief.path);
  EXPECT_TRUE(file.robots[2].flies);
  EXPECT_EQ(file.robots[2].action, "cf2x_0/compute_path_to_pose");
}

TEST(ControllerFile, ThatIsShippedHasTheDefaults) {
  const auto reading = ReadControllerFile(SourceDir() + "/config/navigation/controller.toml");
  EXPECT_THAT(reading.diagnostics, IsEmpty());
  ASSERT_TRUE(reading.config);
  const ControllerConfig& file = *reading.config;
  const ControllerConfig defaults;
  EXPECT_EQ(file.frame, defaults.frame);
  EXPECT_EQ(file.map, defaults.map);
  EXPECT_EQ(file.cloud, defaults.cloud);
  EXPECT_EQ(file.cloud_resolution_m, defaults.cloud_resolution_m);
  EXPECT_EQ(file.keep_out, defaults.keep_out);
  EXPECT_EQ(file.speed_mask, defaults.speed_mask);
  EXPECT_EQ(file.tf.topic, defaults.tf.topic);
  EXPECT_EQ(file.tf.stale, defaults.tf.stale);
  EXPECT_EQ(file.memory.side_m, defaults.memory.side_m);
  EXPECT_EQ(file.memory.decay, defaults.memory.decay);
  EXPECT_EQ(file.odometry_stale, defaults.odometry_stale);
  EXPECT_EQ(file.scan_stale, defaults.scan_stale);
  EXPECT_EQ(file.obstacle_time, defaults.obstacle_time);
  EXPECT_EQ(file.late, defaults.late);
  EXPECT_EQ(file.self_check_time, defaults.self_check_time);
  ASSERT_EQ(file.robots.size(), 4U);
  const auto same = ReadControllerText("[[robot]]\nname = \"jetbot_0\"\n", "short.toml");
  ASSERT_TRUE(same.config);
  const ControllerRobot &full = file.robots[0], &brief = same.config->robots[0];
  EXPECT_EQ(full.radius_m, brief.radius_m);
  EXPECT_EQ(full.margin_m, brief.margin_m);
  EXPECT_EQ(full.differential, brief.differential);
  EXPECT_EQ(full.limits.speed_m_s, brief.limits.speed_m_s);
  EXPECT_EQ(full.limits.acceleration_m_s2, brief.limits.acceleration_m_s2);
  EXPECT_EQ(full.limits.yaw_rad_s, brief.limits.yaw_rad_s);
  EXPECT_EQ(full.limits.yaw_rad_s2, brief.limits.yaw_rad_s2);
  EXPECT_EQ(full.lag_s, brief.lag_s);
  EXPECT_EQ(full.arrive_m, brief.arrive_m);
  EXPECT_EQ(full.arrive_rad, brief.arrive_rad);
  EXPECT_EQ(full.join_m, brief.join_m);
  EXPECT_EQ(full.odometry, brief.odometry);
  ASSERT_EQ(full.scanners.size(), 1U);
  ASSERT_EQ(brief.scanners.size(), 1U);
  EXPECT_EQ(full.scanners[0].topic, brief.scanners[0].topic);
  EXPECT_EQ(full.action, brief.action);
  EXPECT_EQ(full.trajectory, brief.trajectory);
  EXPECT_EQ(full.command, brief.command);
  EXPECT_FALSE(file.robots[2].differential) << "a flyer";
}

TEST(PlannerFile, ReportsErrorsAtTheirPlace) {
  EXPECT_EQ(PlannerError("ceiling_m = 3.0\n"),
            "planner.toml:1:1: error: the key \"robot\" is missing; expected a table [[robot]] "
            "for each robot");
  EXPECT_EQ(PlannerError("[[robot]]\nname = \"a\"\n[[robot]]\nname = \"a\"\n"),
            "planner.toml:4:8: error: robot.name: another table has the robot \"a\"");
  EXPECT_EQ(PlannerError("[[robot]]\nname = \"a\"\nradius = 1\n"),
            "planner.toml:3:1: error: robot: unknown key \"radius\"; did you mean \"radius_m\"?");
  EXPECT_EQ(PlannerError("frame = \"\"\n[[robot]]\nname = \"a\"\n"),
            "planner.toml:1:9: error: frame: expected the frame of the map, as in \"map\"");
  EXPECT_EQ(PlannerError("[[robot]]\nname = \"a\"\nscan = \"a b\"\n"),
            "planner.toml:3:8: error: robot.scan: expected the name of a topic, as in "
            "\"jetbot_0/odom\", or \"\" for none, found \"a b\"");
}

TEST(ControllerFile, ReportsErrorsAtTheirPlace) {
  EXPECT_EQ(ControllerError("[[robot]]\nname = \"a\"\nkind = \"flyer\"\ndrive = "
                            "\"differential\"\n"),
            "controller.toml:4:9: error: robot.drive: a flyer is \"omni\"");
  EXPECT_EQ(ControllerError("[[robot]]\nname = \"0a\"\n"),
            "controller.toml:2:8: error: robot.name: expected a name of letters, digits and '_' "
            "that begins with no digit, at most 64 long");
}

TEST(ControllerFile, HasTheGateItsZonesAndTheScannersOfEachRobot) {
  const auto reading = ReadControllerText(R"(
[[robot]]
name = "a"
lag_s = 0.3
[robot.gate]
margin_m = 0.1
brake_m_s2 = 1.5
reaction_ms = 300
approach_ms = 2000
unknown_m_s = 0.1
[[robot.gate.zone]]
name = "ahead"
kind = "stop"
corners = [[0.8, 0.4], [0.8, -0.4], [0, 0]]
least_points = 2
[[robot.scanner]]
topic = "a/front"
x_m = 0.2
yaw_deg = 90
most_m = 5
[[robot.scanner]]
topic = "a/rear"
[[robot]]
name = "b"
kind = "flyer"
)",
                                          "controller.toml");
  ASSERT_TRUE(reading.config) << reading.diagnostics.front().message;
  const ControllerRobot& a = reading.config->robots[0];
  EXPECT_EQ(a.gate.margin_m, 0.1);
  EXPECT_EQ(a.gate.brake_m_s2, 1.5);
  EXPECT_EQ(a.gate.reaction_s, 0.3);
  EXPECT_EQ(a.gate.approach_s, 2);
  EXPECT_EQ(a.gate.unknown_m_s, 0.1);
  ASSERT_EQ(a.gate.zones.size(), 1U);
  EXPECT_TRUE(a.gate.zones[0].stops);
  EXPECT_EQ(a.gate.zones[0].least_points, 2);
  EXPECT_EQ(a.gate.zones[0].corners[1], (Point{0.8, -0.4, 0}));
  ASSERT_EQ(a.scanners.size(), 2U);
  EXPECT_EQ(a.scanners[0].topic, "a/front");
  EXPECT_EQ(a.scanners[0].on_body.at.x_m, 0.2);
  EXPECT_NEAR(a.scanners[0].on_body.yaw_rad, M_PI / 2, 1e-9);
  EXPECT_EQ(a.scanners[0].most_m, 5);
  EXPECT_EQ(a.scanners[1].topic, "a/rear");
  EXPECT_EQ(reading.config->robots[1].gate.blind_m_s, 0) << "a drive of a flyer is no hold";
}

TEST(ControllerFile, HasTheSensorThatLooksDown) {
  const auto reading = ReadControllerText(R"(
[[robot]]
name = "a"
kind = "flyer"
[robot.gate.down]
topic = "a/range_down"
z_m = -0.05
foot_m = 0.1
cone_deg = 90
most_m = 3
ground_m = -0.5
stale_ms = 300
person_m_s = 2.0
person_m = 1.8
low_m_s = 0.2
[[robot]]
name = "b"
kind = "flyer"
)",
                                          "controller.toml");
  ASSERT_TRUE(reading.config) << reading.diagnostics.front().message;
  const DownRules& down = reading.config->robots[0].gate.down;
  EXPECT_EQ(down.topic, "a/range_down");
  EXPECT_EQ(down.on_body.z_m, -0.05);
  EXPECT_EQ(down.foot_m, 0.1);
  EXPECT_NEAR(*down.cone_rad, M_PI / 2, 1e-9);
  EXPECT_EQ(down.most_m, 3);
  EXPECT_EQ(down.least_m, std::nullopt);
  EXPECT_EQ(down.ground_m, -0.5);
  EXPECT_EQ(down.stale, Milliseconds(300));
  EXPECT_EQ(down.person_m_s, 2);
  EXPECT_EQ(down.person_m, 1.8);
  EXPECT_EQ(down.low_m_s, 0.2);
  EXPECT_EQ(reading.config->robots[1].gate.down.topic, "");
  EXPECT_EQ(
      ControllerError("[[robot]]\nname = \"a\"\n[robot.gate.down]\nz_m = 0.1\n"),
      "controller.toml:3:1: error: robot.gate.down: the key \"topic\" is missing; expected the "
      "topic of its ranges, as in \"cf2x_0/range_down\"");
}

TEST(ControllerFile, ReportsErrorsOfTheGateAtTheirPlace) {
  const std::string robot = "[[robot]]\nname = \"a\"\n";
  const std::string corners =
      "expected three corners or more around the body, as in [[0.8, 0.4], [0.8, -0.4], [0, 0]]";
  EXPECT_EQ(ControllerError(robot + "[robot.gate]\nmargin_m = -1\n"),
            "controller.toml:4:12: error: robot.gate.margin_m: expected a number from 0 to 10, "
            "found -1");
  EXPECT_EQ(ControllerError(robot + "[[robot.gate.zone]]\nname = \"z\"\ncorners = [[0, 1]]\n"),
            "controller.toml:5:11: error: robot.gate.zone.corners: " + corners);
  EXPECT_EQ(ControllerError(robot + "[[robot.gate.zone]]\nname = \"z\"\ncorners = [[0, nan]]\n"),
            "controller.toml:5:12: error: robot.gate.zone.corners: " + corners);
  EXPECT_EQ(ControllerError(robot + "[[robot.scanner]]\ntopic = \"a/scan\"\nyaw = 3\n"),
            "controller.toml:5:1: error: robot.scanner: unknown key \"yaw\"; expected one of "
            "topic, x_m, y_m, z_m, yaw_deg, upside_down, least_m and most_m");
}

TEST(ControllerFile, MayLeaveOutMapAndScan) {
  const auto reading =
      ReadControllerText("map = \"\"\n[[robot]]\nname = \"a\"\nscan = \"\"\n", "controller.toml");
  ASSERT_TRUE(reading.config);
  EXPECT_EQ(reading.config->map, "");
  EXPECT_THAT(reading.config->robots[0].scanners, IsEmpty());
}

}  // namespace musher::navigation::server_config_test
