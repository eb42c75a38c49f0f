// LEDs of this computer: folders as the kernel has them under /sys/class/leds.

#include "musher/modules/device/host_lights.hpp"

#include <fstream>

#include "musher/base/files.hpp"
#include "musher/test/modules/device/devices_fixture.hpp"
#include "musher/test/support/temp_folder.hpp"

namespace musher::device::host_lights_test {

using msg::LedExecute;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

Light Colored(std::uint8_t effect) {
  return {LedExecute::kUserColor, effect, 255, 128, 0};
}

TEST(LedLook, IsTheColourAndHowItBlinks) {
  const std::uint8_t head = LedExecute::kHead;
  EXPECT_EQ(LookOf(head, Colored(LedExecute::kRgbOn)), (Look{255, 128, 0, Duration()}));
  EXPECT_EQ(LookOf(head, Colored(LedExecute::kBlinkFast)), (Look{255, 128, 0, Milliseconds(125)}));
  EXPECT_EQ(LookOf(head, Colored(LedExecute::kTrailingRace)), (Look{255, 128, 0, Duration()}));
  const Light red{LedExecute::kPredefined, LedExecute::kRedOn + 1, 0, 0, 0};
  EXPECT_EQ(LookOf(head, red), (Look{255, 50, 50, Milliseconds(500)}));
  EXPECT_EQ(LookOf(head, {LedExecute::kPredefined, LedExecute::kRgbOff, 9, 9, 9}), Look());
  EXPECT_EQ(LookOf(LedExecute::kMini, Colored(LedExecute::kCircularBreath)),
            (Look{255, 128, 0, Milliseconds(1000)}));
  EXPECT_EQ(LookOf(LedExecute::kMini, {LedExecute::kPredefined, LedExecute::kMiniOff, 9, 9, 9}),
            Look());
}

TEST(LedLook, HasTheNumbersOfTheBoards) {
  const Light yellow{LedExecute::kPredefined, LedExecute::kYellowOneByOneFast, 0, 0, 0};
  EXPECT_THAT(BoardBytes(LedExecute::kTail, yellow),
              ElementsAre(LedExecute::kOneByOneFast, 255, 150, 0));
  const Light blue{LedExecute::kPredefined, LedExecute::kRedOn + 7, 0, 0, 0};
  EXPECT_THAT(BoardBytes(LedExecute::kTail, blue), ElementsAre(LedExecute::kRgbOn, 44, 252, 255));
  EXPECT_THAT(BoardBytes(LedExecute::kMini, Colored(0x35)), ElementsAre(0x23, 255, 128, 0));
  const Light off{LedExecute::kPredefined, LedExecute::kMiniOff, 9, 9, 9};
  EXPECT_THAT(BoardBytes(LedExecute::kMini, off), ElementsAre(0, 0, 0, 0));
}

class HostLightsTest : public DevicesOnANetwork {
 protected:
  HostLightsTest() {
    config_.battery.source = BatterySource::kNone;
    config_.touch.source = KeySource::kNone;
    config_.led.source = LedSource::kHost;
    config_.led.folder = folder_.path();
    config_.led.names = {"rgb:head", "", ""};
  }
  void Make(const std::string& led, const std::string& colors) {
    std::filesystem::create_directories(folder_ / led);
    Put(led + "/max_brightness", "100\n");
    Put(led + "/brightness", "7\n");
    Put(led + "/trigger", "[none] timer disk-activity\n");
    Put(led + "/delay_on", "");
    Put(led + "/delay_off", "");
    if (!colors.empty()) {
      Put(led + "/multi_index", colors + "\n");
      Put(led + "/multi_intensity", "1 1 1\n");
    }
  }
  void Put(const std::string& file, const std::string& text) {
    std::ofstream(folder_ / file) << text;
  }
  // A file of the head's LED.
  std::string Has(const std::string& file) const {
    return ReadFile(folder_ / ("rgb:head/" + file));
  }
  std::int32_t Show(std::uint8_t effect, std::uint8_t r, std::uint8_t g, std::uint8_t b) {
    return Call<LedExecute>("dog1/led_execute", {true, "vp", LedExecute::kHead,
                                                 LedExecute::kUserColor, effect, r, g, b})
        .code;
  }

  const TempFolder folder_;
};

TEST_F(HostLightsTest, OfSeveralColoursGetTheShareOfEach) {
  Make("rgb:head", "green red blue");
  Start();
  EXPECT_EQ(Show(LedExecute::kRgbOn, 255, 51, 0), 0);
  EXPECT_EQ(Has("multi_intensity"), "20 100 0");
  EXPECT_EQ(Has("brightness"), "100");
  EXPECT_EQ(Has("trigger"), "none");
  EXPECT_THAT(Failures(), IsEmpty());
}

TEST_F(HostLightsTest, OfASingleColourAreAsBrightAsTheBrightestOne) {
  Make("rgb:head", "");
  Start();
  EXPECT_EQ(Show(LedExecute::kRgbOn, 0, 128, 3), 0);
  EXPECT_EQ(Has("brightness"), "51");
  EXPECT_EQ(Show(LedExecute::kRgbOn, 0, 0, 0), 0);
  EXPECT_EQ(Has("brightness"), "0");
}

TEST_F(HostLightsTest, BlinkByTheKernel) {
  Make("rgb:head", "red green blue");
  Start();
  EXPECT_EQ(Show(LedExecute::kBlink, 255, 0, 0), 0);
  EXPECT_EQ(Has("trigger"), "timer");
  EXPECT_EQ(Has("delay_on"), "500");
  EXPECT_EQ(Has("delay_off"), "500");
}

TEST_F(HostLightsTest, AreShownOnceTheyArePluggedIn) {
  Start();
  EXPECT_THAT(Failures(), ElementsAre(1109));
  EXPECT_EQ(Show(LedExecute::kRgbOn, 255, 255, 255), 1107) << "kept";
  Run(Milliseconds(5000));
  EXPECT_THAT(log_, ElementsAre(HasSubstr("led: "), HasSubstr("kept until the light works: ")));
  Make("rgb:head", "");
  Run(Milliseconds(1100));
  EXPECT_EQ(Has("brightness"), "100");
  EXPECT_THAT(Failures(), IsEmpty());
}

TEST_F(HostLightsTest, WithoutALedAreCheckedOnly) {
  Make("rgb:head", "");
  Start();
  const auto tail = Call<LedExecute>(
      "dog1/led_execute",
      {true, "vp", LedExecute::kTail, LedExecute::kUserColor, LedExecute::kRgbOn, 1, 2, 3});
  EXPECT_EQ(tail.code, 0);
}

}  // namespace musher::device::host_lights_test
