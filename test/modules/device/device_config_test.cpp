#include "musher/modules/device/device_config.hpp"
#include "musher/test/support/diagnostics.hpp"
#include "musher/test/support/paths.hpp"

#include <gmock/gmock.h>

#include <fstream>
#include <iterator>
#include <string>

namespace musher::device::device_config_test {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

Parsed<DeviceConfig> Read(const std::string& text) {
  return ReadDeviceText(text, "/robot/device.toml");
}

TEST(DeviceConfig, HasTheValuesOfTheFile) {
  const Parsed<DeviceConfig> reading = Read(R"(
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
source = "input"
device = "/dev/input/event3"
key_code = 142
hold_ms = 5000
)");
  ASSERT_TRUE(reading.config);
  EXPECT_THAT(reading.diagnostics, IsEmpty());
  DeviceConfig expected;
  expected.self_check_time = Milliseconds(700);
  expected.skip = {"uwb"};
  expected.critical = {"bms", "touch"};
  expected.battery.source = BatterySource::kHost;
  expected.battery.folder = "/robot/supplies";
  expected.battery.name = "BAT1";
  expected.battery.period = Milliseconds(500);
  expected.battery.silence = Milliseconds(2000);
  expected.touch.source = KeySource::kWorld;
  expected.led.source = LedSource::kWorld;
  expected.uwb = true;
  expected.power_key = {KeySource::kInput, "/dev/input/event3", 142, Milliseconds(5000), {}};
  EXPECT_EQ(*reading.config, expected);
}

TEST(DeviceConfig, NeedsNoMoreThanTheBatterysSource) {
  const Parsed<DeviceConfig> reading =
      Read("[battery]\nsource = \"none\"\n[led]\nsource = \"none\"\n");
  ASSERT_TRUE(reading.config);
  EXPECT_EQ(*reading.config, DeviceConfig());
}

TEST(DeviceConfig, ReportsWhatIsWrongAndWhere) {
  const std::string host = "[battery]\nsource = \"host\"\n";
  musher::testing::ExpectDiagnostics(
      Read,
      {{"all errors at once",
        "skipp = []\n\nskip = [\"bmss\", \"led\"]\n"
        "critical = [\"led\"]\nself_check_ms = 0\n[battery]\nsource = \"wrld\"\nperiod_ms = 1\n"
        "[touch]\n[led]\nsource = 3\n",
        {"/robot/device.toml:1:1: error: unknown key \"skipp\"; did you mean \"skip\"?",
         ":3:9: error: skip: expected one of bms, touch, led, uwb, contact and measurement, found "
         "\"bmss\"; did you mean \"bms\"?",
         ":4:13: error: critical: a device that is skipped cannot be critical",
         ":5:17: error: self_check_ms: expected an integer from 1",
         ":7:10: error: battery.source: expected one of world, host, can, i2c and none, found "
         "\"wrld\"; did you mean \"world\"?",
         ":8:13: error: battery.period_ms: expected an integer from 100",
         ":9:1: error: touch: the key \"source\" is missing",
         ":11:10: error: led.source: expected"}},
       {"no battery", "", {"the key \"battery\" is missing"}},
       {"no source of the battery", "[battery]\n", {"battery: the key \"source\" is missing"}},
       {"silence before the next period",
        host + "period_ms = 5000\n",
        {"silence_ms: expected more than period_ms"}},
       {"a key without effect",
        "[battery]\nsource = \"world\"\nname = \"BAT0\"\n",
        {":3:8: warning: battery.name: has no effect"}},
       {"an input device without a name",
        "[battery]\nsource = \"none\"\n[touch]\nsource = \"input\"\n",
        {"touch: the key \"device\" is missing"}},
       {"an input device with two names",
        "[battery]\nsource = \"none\"\n[touch]\nsource = \"input\"\ndevice = \"event0\"\n"
        "device_name = \"pad\"\n",
        {":6:15: error: touch.device_name: expected either device or device_name"}},
       {"no key of a touch pad",
        "[battery]\nsource = \"none\"\n[touch]\nsource = \"input\"\ndevice = \"event0\"\n"
        "codes = {}\n",
        {":6:9: error: touch.codes: expected the number of a key for tap"}},
       {"a battery on a CAN bus without its file",
        "[battery]\nsource = \"can\"\n",
        {"battery: the key \"frames\" is missing"}},
       {"a file of frames that is missing",
        "[battery]\nsource = \"can\"\nframes = \"nowhere.toml\"\n",
        {"/robot/nowhere.toml: error: "}},
       {"frames without effect",
        host + "frames = \"nowhere.toml\"\n",
        {":3:10: warning: battery.frames: has no effect: only a source \"can\" uses it"}},
       {"no LED",
        "[battery]\nsource = \"none\"\n[led]\nsource = \"host\"\n",
        {":4:10: error: led.source: expected a key head, tail or mini beside it"}},
       {"a path for an LED",
        "[battery]\nsource = \"none\"\n[led]\nsource = \"host\"\nhead = \"a/b\"\n",
        {":5:8: error: led.head: expected the name of an LED, found a path"}},
       {"an LED without effect",
        "[battery]\nsource = \"none\"\n[led]\nsource = \"world\"\nfolder = \"/sys\"\n"
        "tail = \"x\"\n",
        {":5:10: warning: led.folder: has no effect", ":6:8: warning: led.tail: has no effect"}},
       {"a pad on no line",
        "[battery]\nsource = \"none\"\n[touch]\nsource = \"gpio\"\n",
        {"touch: the key \"line\" is missing"}},
       {"a line with two users",
        "[battery]\nsource = \"none\"\n[touch]\nsource = \"gpio\"\nline = \"A\"\n[[contact]]\n"
        "name = \"x\"\nline = \"A\"\n",
        {":8:8: error: contact.line: the line \"A\" is used above already"}},
       {"a line without effect",
        "[battery]\nsource = \"none\"\n[touch]\nsource = \"world\"\nline = \"A\"\n",
        {":5:8: warning: touch.line: has no effect: only a source \"gpio\" uses it"}},
       {"a debounce of a minute",
        "[battery]\nsource = \"none\"\n[power_key]\nsource = \"gpio\"\nline = \"A\"\n"
        "debounce_ms = 60000\n",
        {":6:15: error: power_key.debounce_ms: expected an integer"}},
       {"two contacts of a name",
        "[battery]\nsource = \"none\"\n[[contact]]\nname = \"x\"\nline = \"A\"\n[[contact]]\n"
        "name = \"x\"\nline = \"B\"\n",
        {":7:8: error: contact.name: \"x\" is defined above already"}},
       {"lamps without a line",
        "[battery]\nsource = \"none\"\n[led]\nsource = \"gpio\"\n",
        {":4:10: error: led.source: expected a key head, tail or mini beside it"}},
       {"a battery on an I2C bus without its file",
        "[battery]\nsource = \"i2c\"\n",
        {"battery: the key \"registers\" is missing"}},
       {"a file of registers that is missing",
        "[battery]\nsource = \"none\"\n[[measurement]]\nregisters = \"nowhere.toml\"\n",
        {"/robot/nowhere.toml: error: "}},
       {"a path for a name",
        host + "name = \"../BAT0\"\n",
        {"expected the name of a supply, found a path"}},
       {"no TOML", "skip = \n", {"/robot/device.toml:1:"}}});
}

TEST(DeviceConfig, HasLinesAndRegisters) {
  const std::string folder = SourceDir() + "/config/device/";
  const Parsed<DeviceConfig> reading = ReadDeviceText(R"(
[battery]
source = "i2c"
registers = "i2c/battery.toml"
[touch]
source = "gpio"
line = "PAD"
[power_key]
source = "gpio"
line = "gpiochip0:5"
active_low = true
bias = "pull-up"
debounce_ms = 30
[led]
source = "gpio"
tail = "LAMP"
active_low = true
[[contact]]
name = "bumper"
line = "BUMPER"
bias = "pull-down"
[[measurement]]
registers = "i2c/thermometer.toml"
silence_ms = 3000
)",
                                                      folder + "device.toml");
  EXPECT_THAT(reading.diagnostics, IsEmpty());
  ASSERT_TRUE(reading.config);
  const DeviceConfig& config = *reading.config;
  EXPECT_EQ(config.battery.source, BatterySource::kI2c);
  EXPECT_EQ(config.battery.registers.address, 0x0B);
  EXPECT_EQ(config.touch.line, (GpioSpec{"PAD", false, GpioBias::kAsIs, Milliseconds(10)}));
  EXPECT_EQ(config.power_key.line,
            (GpioSpec{"gpiochip0:5", true, GpioBias::kPullUp, Milliseconds(30)}));
  EXPECT_EQ(config.led.lines.at(0).line, "");
  EXPECT_EQ(config.led.lines.at(1).line, "LAMP");
  EXPECT_TRUE(config.led.lines.at(1).active_low);
  ASSERT_EQ(config.contacts.size(), 1U);
  EXPECT_EQ(config.contacts[0].name, "bumper");
  EXPECT_EQ(config.contacts[0].line.bias, GpioBias::kPullDown);
  ASSERT_EQ(config.measurements.size(), 1U);
  EXPECT_EQ(config.measurements[0].registers.values.at(0).name, "board_temperature");
  EXPECT_EQ(config.measurements[0].silence, std::chrono::seconds(3));
}

TEST(DeviceConfig, OfTheDemoIsGoodAndNamesEveryKey) {
  const std::string file = SourceDir() + "/config/device/device_manager.toml";
  const Parsed<DeviceConfig> reading = ReadDeviceFile(file);
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

TEST(DeviceConfig, OfACyberDog2HasItsFrames) {
  const Parsed<DeviceConfig> reading =
      ReadDeviceFile(SourceDir() + "/config/device/cyberdog2.toml");
  EXPECT_THAT(reading.diagnostics, IsEmpty());
  ASSERT_TRUE(reading.config);
  EXPECT_EQ(reading.config->battery.source, BatterySource::kCan);
  EXPECT_TRUE(reading.config->battery.frames.HasField("batt_soc"));
  EXPECT_TRUE(reading.config->led.frames[0]);
  EXPECT_FALSE(reading.config->led.frames[1]);
  EXPECT_EQ(reading.config->led.frames[0]->network_interface, "can1");
  EXPECT_EQ(reading.config->touch.codes, (TouchCodes{0, 301, 303, 307}));
}

TEST(DeviceConfig, ReportsWhyAFileCannotBeRead) {
  const Parsed<DeviceConfig> missing = ReadDeviceFile("/nowhere/at/all.toml");
  ASSERT_EQ(missing.diagnostics.size(), 1U);
  EXPECT_THAT(missing.diagnostics.front().message, HasSubstr("No such file"));
}

}  // namespace musher::device::device_config_test
