#include "musher/modules/sensor/sensor_config.hpp"
#include "musher/test/support/diagnostics.hpp"
#include "musher/test/support/paths.hpp"

#include <gmock/gmock.h>

#include <string>
#include <vector>

namespace musher::sensor::sensor_config_test {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

std::vector<std::string> Said(const std::string& text) {
  return musher::testing::Lines(ReadManagerText(text, "/robot/sensors.toml").diagnostics);
}

TEST(SensorManagerConfig, OfTheRepositoryIsGood) {
  const Parsed<ManagerConfig> reading =
      ReadManagerFile(SourceDir() + "/config/sensor/sensor_manager.toml");
  EXPECT_THAT(reading.diagnostics, IsEmpty());
  ASSERT_TRUE(reading.config);
  EXPECT_THAT(reading.config->skip, ElementsAre(SensorKind::kGps, SensorKind::kUltrasonic));
  EXPECT_EQ(reading.config->Of(SensorKind::kTof).sources.size(), 4U);
}

TEST(SensorManagerConfig, HasTheValuesOfTheFile) {
  const Parsed<ManagerConfig> reading = ReadManagerText(R"(
self_check_ms = 700
start_ms = 100
stamp_tolerance_ms = 0
ros_distro = "galactic"
skip = ["gps"]
critical = ["tof", "lidar"]
[lidar]
source = "driver/scan"
rate_hz = 4.0
[tof]
left_head = "a"
right_head = "b"
left_rear = "c/d"
right_rear = "_e2"
silence_ms = 250
[gps]
source = "driver/gps"
satellites = "driver/satellites"
)",
                                                        "/robot/sensors.toml");
  EXPECT_THAT(reading.diagnostics, IsEmpty());
  ASSERT_TRUE(reading.config);
  ManagerConfig expected;
  expected.self_check_time = Milliseconds(700);
  expected.start_time = Milliseconds(100);
  expected.stamp_tolerance = Duration::zero();
  expected.ros_distro = RosDistro::kGalactic;
  expected.skip = {SensorKind::kGps};
  expected.critical = {SensorKind::kTof, SensorKind::kLidar};
  expected.Of(SensorKind::kLidar) = {{"driver/scan"}, Milliseconds(250), Milliseconds(1000), ""};
  expected.Of(SensorKind::kTof) = {
      {"a", "b", "c/d", "_e2"}, Duration::zero(), Milliseconds(250), ""};
  expected.Of(SensorKind::kGps).sources = {"driver/gps"};
  expected.Of(SensorKind::kGps).satellites = "driver/satellites";
  EXPECT_EQ(*reading.config, expected);
}

TEST(SensorManagerConfig, MayHaveNoSensors) {
  const Parsed<ManagerConfig> reading = ReadManagerText("", "s.toml");
  ASSERT_TRUE(reading.config);
  EXPECT_EQ(*reading.config, ManagerConfig());
}

TEST(SensorManagerConfig, ReportsAllErrorsAtOnce) {
  EXPECT_THAT(
      Said("skip = [\"lida\", \"gps\"]\n"
           "critical = [\"gps\"]\nself_check_ms = 0\n[lidar]\nsource = \"/scan\"\nrate_hz = nan\n"
           "[ultrasonic]\nsource = \"scan\"\n[tof]\nleft_head = \"a\"\nright_head = \"a\"\n"
           "left_rear = \"b//c\"\n[gps]\nsilence_ms = -1\nrate = 3\n"),
      ElementsAre(
          HasSubstr("/robot/sensors.toml:1:9: error: skip: expected one of lidar, tof, ultrasonic "
                    "and gps, found \"lida\"; did you mean \"lidar\"?"),
          HasSubstr(":2:13: error: critical: a sensor that is skipped cannot be critical"),
          HasSubstr(":3:17: error: self_check_ms: expected an integer from 1"),
          HasSubstr(":5:10: error: lidar.source: expected the name of a topic relative to the "
                    "namespace, as in \"world/scan\", found \"/scan\""),
          HasSubstr(":6:11: error: lidar.rate_hz: expected a number from 0.01 to 1000"),
          HasSubstr(":8:10: error: ultrasonic.source: this is a topic that the module publishes"),
          HasSubstr(":9:1: error: tof: the key \"right_rear\" is missing"),
          HasSubstr(":11:14: error: tof.right_head: another sensor has this topic already"),
          HasSubstr(":12:13: error: tof.left_rear: expected the name of a topic relative to the"),
          HasSubstr(":13:1: error: gps: the key \"source\" is missing"),
          HasSubstr(":14:14: error: gps.silence_ms: expected"),
          HasSubstr(":15:1: error: gps: unknown key \"rate\"; expected one of source")));
}

TEST(SensorManagerConfig, ThatCannotBeReadReportsWhy) {
  const Parsed<ManagerConfig> missing = ReadManagerFile("/nowhere/sensors.toml");
  EXPECT_FALSE(missing.config);
  ASSERT_EQ(missing.diagnostics.size(), 1U);
  EXPECT_THAT(FormatDiagnostic(missing.diagnostics[0]), HasSubstr("/nowhere/sensors.toml: error:"));
}

}  // namespace musher::sensor::sensor_config_test
