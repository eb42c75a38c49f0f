#include "musher/modules/device/device_config.hpp"
#include "musher/test/support/diagnostics.hpp"
#include "musher/test/support/paths.hpp"

#include <gmock/gmock.h>

#include <fstream>
#include <iterator>
#include <string>
#include <vector>

namespace musher::device::device_config_test {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

DeviceReading Read(const std::string& text) {
  return ReadDeviceText(text, "/robot/device.toml");
}

std::vector<std::string> Said(const std::string& text) {
  return musher::testing::Lines(Read(text).diagnostics);
}

TEST(DeviceConfig, HasTheValuesOfTheFile) {
  const DeviceReading reading = Read(R"(
self_check_ms = 700
skip = ["uwb"]
critical = ["bms", "touch"]
[battery]
source = "host"
folder = "supplies"
name = "BAT1"
period_ms = 500
silence_ms = 2000
[touch]
source = "world"
[led]
source = "world"
[uwb]
source = "world"
[power_key]
source = "world"
hold_ms = 5000
)");
  ASSERT_TRUE(reading.config);
  EXPECT_THAT(reading.diagnostics, IsEmpty());
  DeviceConfig expected;
  expected.self_check_time = Milliseconds(700);
  expected.skip = {"uwb"};
  expected.critical = {"bms", "touch"};
  expected.battery = {BatterySource::kHost, "/robot/supplies", "BAT1", Milliseconds(500),
                      Milliseconds(2000)};
  expected.touch = true;
  expected.led = true;
  expected.uwb = true;
  expected.power_key = {true, Milliseconds(5000)};
  EXPECT_EQ(*reading.config, expected);
}

TEST(DeviceConfig, NeedsNoMoreThanTheBatterysSource) {
  const DeviceReading reading = Read("[battery]\nsource = \"none\"\n[led]\nsource = \"none\"\n");
  ASSERT_TRUE(reading.config);
  EXPECT_EQ(*reading.config, DeviceConfig());
}

TEST(DeviceConfig, ReportsAllErrorsAtOnce) {
  EXPECT_THAT(
      Said("skipp = []\n\nskip = [\"bmss\", \"led\"]\n"
           "critical = [\"led\"]\nself_check_ms = 0\n[battery]\nsource = \"wrld\"\nperiod_ms = 1\n"
           "[touch]\n[led]\nsource = 3\n"),
      ElementsAre(
          HasSubstr("/robot/device.toml:1:1: error: unknown key \"skipp\"; did you mean \"skip\"?"),
          HasSubstr(
              ":3:9: error: skip: expected one of bms, touch, led and uwb, found \"bmss\"; did you "
              "mean \"bms\"?"),
          HasSubstr(":4:13: error: critical: a device that is skipped cannot be critical"),
          HasSubstr(":5:17: error: self_check_ms: expected an integer from 1"),
          HasSubstr(":7:10: error: battery.source: expected one of world, host and none, found "
                    "\"wrld\"; did you mean \"world\"?"),
          HasSubstr(":8:13: error: battery.period_ms: expected an integer from 100"),
          HasSubstr(":9:1: error: touch: the key \"source\" is missing"),
          HasSubstr(":11:10: error: led.source: expected")));
}

TEST(DeviceConfig, NeedsASourceOfTheBattery) {
  EXPECT_THAT(Said(""), ElementsAre(HasSubstr("the key \"battery\" is missing")));
  EXPECT_THAT(Said("[battery]\n"),
              ElementsAre(HasSubstr("battery: the key \"source\" is missing")));
}

TEST(DeviceConfig, NeedsAPeriodShorterThanTheSilenceTimeout) {
  EXPECT_THAT(Said("[battery]\nsource = \"host\"\nperiod_ms = 5000\n"),
              ElementsAre(HasSubstr("silence_ms: expected more than period_ms")));
}

TEST(DeviceConfig, WarnsOfKeysWithoutEffect) {
  EXPECT_THAT(Said("[battery]\nsource = \"world\"\nname = \"BAT0\"\n"),
              ElementsAre(HasSubstr(":3:8: warning: battery.name: has no effect")));
  EXPECT_TRUE(Read("[battery]\nsource = \"world\"\nname = \"BAT0\"\n").config);
}

TEST(DeviceConfig, TakesANameNotAPath) {
  EXPECT_THAT(Said("[battery]\nsource = \"host\"\nname = \"../BAT0\"\n"),
              ElementsAre(HasSubstr("expected the name of a supply, found a path")));
}

TEST(DeviceConfig, OfTheDemoIsGoodAndNamesEveryKey) {
  const std::string file = SourceDir() + "/config/device/device_manager.toml";
  const DeviceReading reading = ReadDeviceFile(file);
  ASSERT_TRUE(reading.config);
  EXPECT_THAT(reading.diagnostics, IsEmpty());
  EXPECT_THAT(reading.config->critical, ElementsAre("bms", "touch"));
  std::ifstream stream(file);
  const std::string text(std::istreambuf_iterator<char>(stream), {});
  for (const char* key : {"self_check_ms", "skip", "critical", "source", "silence_ms", "folder",
                          "name", "period_ms"}) {
    EXPECT_THAT(text, HasSubstr(std::string(key) + " = ")) << key;
  }
}

TEST(DeviceConfig, ReportsWhyAFileCannotBeRead) {
  const DeviceReading missing = ReadDeviceFile("/nowhere/at/all.toml");
  ASSERT_EQ(missing.diagnostics.size(), 1U);
  EXPECT_THAT(missing.diagnostics.front().message, HasSubstr("No such file"));
  EXPECT_THAT(Said("skip = \n"), ElementsAre(HasSubstr("/robot/device.toml:1:")));
}

}  // namespace musher::device::device_config_test
