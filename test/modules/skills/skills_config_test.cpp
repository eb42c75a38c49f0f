// The configs of musher-skills and musher-plan-dispatcher.

#include "musher/modules/skills/config/skills_config.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "musher/modules/skills/plan/dispatcher_config.hpp"
#include "musher/test/support/diagnostics.hpp"
#include "musher/test/support/paths.hpp"

namespace musher::skills::skills_config_test {

using musher::testing::Lines;
using ::testing::ElementsAre;
using ::testing::EndsWith;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Pair;
using ::testing::SizeIs;

TEST(SkillsConfig, NeedsOnlyTheRobotAndItsKind) {
  const auto reading = ReadSkillsText("robot = \"dog_1\"\nkind = \"dog\"\n", "/a/dog.toml");
  ASSERT_TRUE(reading.config) << Lines(reading.diagnostics).front();
  EXPECT_EQ(reading.config->names.velocity, "dog_1/cmd_vel");
  EXPECT_EQ(reading.config->names.planner, "dog_1/compute_path_to_pose");
  EXPECT_EQ(reading.config->names.line, "");
  EXPECT_THAT(reading.config->photo_folder, HasSubstr("/musher/photos"));
  EXPECT_THAT(reading.config->photo_folder, EndsWith("/dog_1"));
  EXPECT_EQ(reading.config->skill_config, "");
  EXPECT_FALSE(reading.config->hand);
  EXPECT_EQ(reading.config->ceiling_m, std::nullopt);
  EXPECT_EQ(reading.config->names.battery, "dog_1/battery");
  EXPECT_EQ(reading.config->names.goal_pose, "dog_1/goal_pose");
  EXPECT_EQ(reading.config->names.detections, "dog_1/detections");
  EXPECT_EQ(reading.config->low_battery_percent, 0);
}

TEST(SkillsConfig, LandsAFlyerBeforeItsBatteryIsEmpty) {
  const std::string flyer = "robot = \"f\"\nkind = \"cf2x\"\nflies = true\n";
  const auto usual = ReadSkillsText(flyer, "/a/f.toml");
  ASSERT_TRUE(usual.config);
  EXPECT_EQ(usual.config->low_battery_percent, 10);
  const auto given = ReadSkillsText(flyer + "[battery]\nlow_percent = 25\n", "/a/f.toml");
  ASSERT_TRUE(given.config);
  EXPECT_EQ(given.config->low_battery_percent, 25);
}

TEST(SkillsConfig, ReadsEachKey) {
  const auto reading = ReadSkillsText(R"(
robot = "dog_1"
kind = "dog"
radius_m = 0.3
hand = true
ceiling_m = 2.2
self_check_ms = 100
tf_stale_ms = 300
speed_m_s = 3
yaw_rad_s = 6.5
photo_folder = "/b/photos"
skill_config = "../skills.toml"
[topics]
odometry = "/odom"
tf = "/localisation/tf"
scan = ""
line = "line"
detections = ""
[line]
width_m = 2
[cameras]
front = "dog_1/camera/image"
[gate]
margin_m = 0.15
[gate.down]
topic = "/range"
margin_m = 0.4
[detector.qr]
topic = "/qr_detector/sighting"
width_m = 0.2
fov_deg = 90
camera_z_m = 0.3
camera_yaw_deg = -90
)",
                                      "/a/b/dog.toml");
  ASSERT_TRUE(reading.config) << Lines(reading.diagnostics).front();
  EXPECT_EQ(reading.config->names.odometry, "/odom");
  EXPECT_EQ(reading.config->names.tf, "/localisation/tf");
  EXPECT_EQ(reading.config->tf_stale, Milliseconds(300));
  EXPECT_EQ(reading.config->speed_m_s, 3);
  EXPECT_EQ(reading.config->yaw_rad_s, 6.5);
  EXPECT_THAT(reading.config->gate.scanners, IsEmpty());
  EXPECT_EQ(reading.config->gate.margin_m, 0.15);
  EXPECT_EQ(reading.config->gate.down.topic, "/range");
  EXPECT_EQ(reading.config->gate.down.margin_m, 0.4);
  EXPECT_EQ(reading.config->gate.radius_m, reading.config->radius_m);
  EXPECT_EQ(reading.config->ceiling_m, 2.2);
  EXPECT_EQ(reading.config->names.detections, "");
  EXPECT_EQ(reading.config->line.width_m, 2);
  EXPECT_EQ(reading.config->skill_config, "/a/skills.toml");
  EXPECT_THAT(reading.config->cameras, ElementsAre(Pair("front", "dog_1/camera/image")));
  ASSERT_THAT(reading.config->detectors, SizeIs(1));
  const DetectorView& qr = reading.config->detectors[0];
  EXPECT_EQ(qr.name, "qr");
  EXPECT_EQ(qr.topic, "/qr_detector/sighting");
  EXPECT_EQ(qr.width_m, 0.2);
  EXPECT_NEAR(qr.fov_rad, M_PI / 2, 1e-9);
  EXPECT_EQ(qr.camera.at.z_m, 0.3);
  EXPECT_NEAR(qr.camera.yaw_rad, -M_PI / 2, 1e-9);
}

TEST(SkillsConfig, ReportsWhatADetectorLacks) {
  const auto reading = ReadSkillsText(R"(robot = "dog_1"
kind = "dog"
[detector]
qr = 3
[detector.arrow]
topic = "no topic"
fov = 60
)",
                                      "dog.toml");
  EXPECT_FALSE(reading.config);
  EXPECT_THAT(
      Lines(reading.diagnostics),
      ElementsAre(
          "dog.toml:4:6: error: detector.qr: expected a table, found an integer",
          HasSubstr("dog.toml:5:1: error: detector.arrow: the key \"width_m\" is missing"),
          HasSubstr("dog.toml:5:1: error: detector.arrow: the key \"fov_deg\" is missing"),
          HasSubstr("dog.toml:6:9: error: detector.arrow.topic: expected the name of a topic"),
          HasSubstr("dog.toml:7:1: error: detector.arrow: unknown key \"fov\"")));
}

TEST(SkillsConfig, ReportsAllErrorsWithTheirPlaces) {
  const auto reading = ReadSkillsText(R"(robot = "1dog"
radius_m = 50
hnd = true
[topics]
odometry = ""
[cameras]
front = 3
)",
                                      "dog.toml");
  EXPECT_FALSE(reading.config);
  EXPECT_THAT(
      Lines(reading.diagnostics),
      ElementsAre(
          "dog.toml:1:1: error: the key \"kind\" is missing; expected the kind of robot, as in "
          "\"jetbot\"",
          "dog.toml:1:9: error: robot: expected a name of letters, digits and '_' that begins "
          "with no digit, at most 64 long, found \"1dog\"",
          "dog.toml:2:12: error: radius_m: expected a number from 0.01 to 10, found 50",
          "dog.toml:3:1: error: unknown key \"hnd\"; did you mean \"hand\"?",
          "dog.toml:5:12: error: topics.odometry: expected the name of a topic, service or "
          "action, as in \"jetbot_0/odom\", found \"\"",
          "dog.toml:7:9: error: cameras.front: expected a string, found an integer"));
}

TEST(DispatcherConfig, MayBeEmptyAndReportsAllErrors) {
  const auto empty = ReadDispatcherText("", "plan.toml");
  ASSERT_TRUE(empty.config);
  EXPECT_EQ(empty.config->rules.server_wait, std::chrono::seconds(3));
  EXPECT_THAT(
      Lines(ReadDispatcherText("server_wait_ms = 0\nrobot_action = \"/a\"\n", "plan.toml")
                .diagnostics),
      ElementsAre("plan.toml:1:18: error: server_wait_ms: expected an integer from 1 to 3600000 "
                  "(milliseconds), found 0",
                  "plan.toml:2:16: error: robot_action: expected the name of an action relative to "
                  "the namespace, as in \"skill_execution\", found \"/a\""));
}

TEST(DispatcherConfig, OfTheExampleIsValid) {
  for (const std::string robot : {"jetbot_0", "jetbot_1", "h1_0", "cf2x_0"}) {
    const auto reading = ReadSkillsFile(SourceDir() + "/config/skills/" + robot + ".toml");
    EXPECT_THAT(Lines(reading.diagnostics), IsEmpty());
    ASSERT_TRUE(reading.config);
    EXPECT_EQ(reading.config->robot, robot);
    // Of config/scenes/rooms.toml and config/navigation/planner.toml: 2.4 m.
    EXPECT_TRUE(!reading.config->flies || reading.config->ceiling_m.value_or(10) < 2.4);
  }
  EXPECT_TRUE(ReadDispatcherFile(SourceDir() + "/config/skills/plan_dispatcher.toml").config);
}

}  // namespace musher::skills::skills_config_test
