// Which presses of a power key count, and the key of an input device of Linux: by a pipe, in
// virtual time, and by a device of uinput where this kernel has it.

#include "musher/modules/device/power_key.hpp"

#include <gmock/gmock.h>

#include <cstring>
#include <memory>
#include <string>
#include <vector>

#include "musher/messages/std_srvs/trigger.hpp"
#include "musher/test/modules/device/devices_fixture.hpp"
#include "musher/test/modules/device/fake_input_device.hpp"
#include "musher/test/modules/world/socket_node.hpp"

namespace musher::device::power_key_test {

using ::testing::Contains;
using ::testing::Each;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;
using Effect = PowerKey::Effect;

// A key that was seen released.
PowerKey Released() {
  PowerKey key;
  EXPECT_EQ(key.OnState(false), Effect::kNone);
  return key;
}

TEST(PowerKey, CountsAPressFromItsBeginToItsEnd) {
  PowerKey key = Released();
  EXPECT_EQ(key.OnState(true), Effect::kBegins);
  EXPECT_EQ(key.OnState(true), Effect::kNone) << "the same once more";
  EXPECT_EQ(key.OnState(false), Effect::kEnds);
  EXPECT_EQ(key.OnState(false), Effect::kNone);
}

TEST(PowerKey, ThatIsPressedAtTheStartCountsOnceItWasReleased) {
  PowerKey key;
  EXPECT_EQ(key.OnState(true), Effect::kIgnored);
  EXPECT_EQ(key.OnState(true), Effect::kNone) << "it is reported once";
  EXPECT_EQ(key.OnGap(), Effect::kNone);
  EXPECT_EQ(key.OnState(true), Effect::kNone) << "missing events are no release";
  EXPECT_EQ(key.OnState(false), Effect::kNone);
  EXPECT_EQ(key.OnState(true), Effect::kBegins);
}

TEST(PowerKey, BeginsAgainAfterMissingEvents) {
  PowerKey key = Released();
  EXPECT_EQ(key.OnGap(), Effect::kNone);
  EXPECT_EQ(key.OnState(true), Effect::kBegins) << "it was pressed meanwhile";
  EXPECT_EQ(key.OnGap(), Effect::kEnds);
  EXPECT_EQ(key.OnState(true), Effect::kBegins);
}

TEST(PowerKey, WhoseDeviceIsLostWhilePressedCountsOnceItWasReleased) {
  PowerKey key = Released();
  EXPECT_EQ(key.OnState(true), Effect::kBegins);
  EXPECT_EQ(key.OnUnseen(), Effect::kEnds);
  EXPECT_EQ(key.OnState(true), Effect::kIgnored);
}

class InputPowerKey : public DevicesOnANetwork {
 protected:
  InputPowerKey() {
    robot_ = std::make_unique<transport::SocketNode>(std::move(robot_));
    config_.battery.source = BatterySource::kNone;
    config_.touch.source = KeySource::kNone;
    config_.led.source = LedSource::kNone;
    config_.power_key.source = KeySource::kInput;
    config_.power_key.device = pipe_.file();
  }
  void Press(bool pressed) {
    ASSERT_NO_FATAL_FAILURE(pipe_.Send({InputEvent(EV_KEY, KEY_POWER, pressed ? 1 : 0)}));
    Run(Milliseconds(10));
  }

  FakeInputDevice pipe_;
  int power_offs_ = 0;
  std::unique_ptr<transport::Server<msg::Trigger>> manager_ = test::Must(
      transport::MakeServer<msg::Trigger>(*desk_, "dog1/poweroff", [this](const auto&, auto reply) {
        ++power_offs_;
        reply({true, ""});
      }));
};

TEST_F(InputPowerKey, RequestsAPowerOffOnceItWasHeld) {
  pipe_.Plug();
  Start();
  Press(true);
  Run(Milliseconds(2900));
  EXPECT_EQ(power_offs_, 0);
  Run(Milliseconds(200));
  EXPECT_EQ(power_offs_, 1);
  EXPECT_THAT(log_, Each(Not(HasSubstr("at the start"))));
}

TEST_F(InputPowerKey, RequestsNoPowerOffWhenItsDeviceIsLostWhilePressed) {
  pipe_.Plug();
  Start();
  Press(true);
  Run(Milliseconds(2000));
  pipe_.Unplug();
  Run(Milliseconds(20));
  EXPECT_THAT(log_, ElementsAre(HasSubstr("it was closed"), HasSubstr("events are missing")));
  pipe_.Plug();
  Run(Milliseconds(5000));
  EXPECT_EQ(power_offs_, 0);
  Press(true);
  Run(Milliseconds(3100));
  EXPECT_EQ(power_offs_, 1) << "it works again";
}

TEST_F(InputPowerKey, CountsTheTimeAgainWhereEventsAreMissing) {
  pipe_.Plug();
  Start();
  Press(true);
  Run(Milliseconds(2000));
  ASSERT_NO_FATAL_FAILURE(pipe_.Send({InputEvent(EV_SYN, SYN_DROPPED, 0)}));
  Run(Milliseconds(5000));
  EXPECT_EQ(power_offs_, 0);
  EXPECT_THAT(log_, ElementsAre(HasSubstr("events are missing")));
}

// The kernel has its state when the module starts.
TEST_F(InputPowerKey, OfADeviceOfTheKernelPowersNothingOffThatHasJustStarted) {
  const UniqueFd uinput(open("/dev/uinput", O_WRONLY | O_NONBLOCK | O_CLOEXEC));
  if (!uinput.valid()) GTEST_SKIP() << "/dev/uinput: " << std::strerror(errno);
  ASSERT_NO_FATAL_FAILURE(MakeDeviceWithKey(uinput, "musher power key", KEY_POWER));
  config_.power_key.device = EventFileOf(uinput);
  if (config_.power_key.device.empty()) GTEST_SKIP() << "no udev makes a file of it";
  const auto press = [&](bool pressed) {
    ASSERT_NO_FATAL_FAILURE(WriteEvents(uinput, {InputEvent(EV_KEY, KEY_POWER, pressed ? 1 : 0),
                                                 InputEvent(EV_SYN, SYN_REPORT, 0)}));
    Run(Milliseconds(10));
  };
  press(true);
  Start();
  Run(Milliseconds(10'000));
  EXPECT_EQ(power_offs_, 0);
  EXPECT_THAT(log_, ElementsAre(HasSubstr("pressed at the start")));
  press(false);
  press(true);
  Run(Milliseconds(3100));
  EXPECT_EQ(power_offs_, 1);
  press(false);
  press(true);
  ioctl(uinput.get(), UI_DEV_DESTROY);
  Run(Milliseconds(5000));
  EXPECT_EQ(power_offs_, 1) << "its device is gone";
  EXPECT_THAT(log_, Contains(HasSubstr("events are missing")));
}

}  // namespace musher::device::power_key_test
