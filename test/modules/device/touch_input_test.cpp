// A touch pad that is an input device of Linux: events as the kernel has them, by a pipe, in
// virtual time, and by a device of uinput where this kernel has it.

#include <gmock/gmock.h>

#include <array>
#include <cstring>
#include <filesystem>
#include <string>
#include <vector>

#include "musher/modules/device/input_device.hpp"
#include "musher/test/modules/device/devices_fixture.hpp"
#include "musher/test/modules/device/fake_input_device.hpp"
#include "musher/test/modules/world/socket_node.hpp"
#include "musher/transport/linux_event_loop.hpp"

namespace musher::device::touch_input_test {

using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

class TouchInput : public DevicesOnANetwork {
 protected:
  TouchInput() {
    robot_ = std::make_unique<transport::SocketNode>(std::move(robot_));
    config_.led.source = LedSource::kNone;
    config_.battery.source = BatterySource::kNone;
    config_.touch.source = KeySource::kInput;
    config_.touch.input.file = device_.file();
    device_.Plug();
  }
  void Send(std::uint16_t type, std::uint16_t code, std::int32_t value) {
    ASSERT_NO_FATAL_FAILURE(device_.Send({InputEvent(type, code, value)}));
    Run(Milliseconds(10));
  }
  void Tap() {
    Send(EV_KEY, BTN_TOUCH, 1);
    Run(Milliseconds(80));
    Send(EV_KEY, BTN_TOUCH, 0);
  }
  // The touches since the last call.
  std::vector<std::int32_t> Touches() {
    Run(Milliseconds(1000));
    std::vector<std::int32_t> states;
    for (const msg::TouchStatus& touch : received_) states.push_back(touch.touch_state);
    received_.clear();
    return states;
  }

  FakeInputDevice device_;
  std::vector<msg::TouchStatus> received_;
  std::unique_ptr<transport::Subscription> touches_ =
      Listen<msg::TouchStatus>("dog1/touch_status", received_);
};

TEST_F(TouchInput, KnowsTapsAndHoldsByWhenItIsTouched) {
  Start();
  Tap();
  EXPECT_THAT(Touches(), ElementsAre(msg::TouchStatus::kSingle));
  Tap();
  Run(Milliseconds(100));
  Tap();
  EXPECT_THAT(Touches(), ElementsAre(msg::TouchStatus::kDoubleTouch));
  Send(EV_KEY, BTN_TOUCH, 1);
  EXPECT_THAT(Touches(), ElementsAre(msg::TouchStatus::kHold));
  Send(EV_KEY, BTN_TOUCH, 0);
  EXPECT_THAT(Touches(), IsEmpty());
}

TEST_F(TouchInput, HasKeysForTheTouchesOfAPadThatKnowsThem) {
  config_.touch.codes = {0, KEY_F1, KEY_F2, KEY_F3};
  Start();
  for (const std::uint16_t key : std::array<std::uint16_t, 4>{KEY_F2, KEY_F3, KEY_F1, BTN_TOUCH}) {
    Send(EV_KEY, key, 1);
    Send(EV_KEY, key, 2);
    Send(EV_KEY, key, 0);
  }
  EXPECT_THAT(Touches(), ElementsAre(msg::TouchStatus::kDoubleTouch, msg::TouchStatus::kHold,
                                     msg::TouchStatus::kSingle));
}

TEST_F(TouchInput, LeavesNoHalfDoubleTapWhenItsDeviceIsLostOrItsEventsAreDropped) {
  Start();
  Tap();
  device_.Unplug();
  Run(Milliseconds(20));
  EXPECT_THAT(Failures(), ElementsAre(1509));
  device_.Plug();
  EXPECT_THAT(Touches(), IsEmpty());
  Run(Milliseconds(200));
  EXPECT_THAT(Failures(), IsEmpty()) << "it is available again";
  EXPECT_THAT(log_, Contains(HasSubstr("touch: " + config_.touch.input.file + ": it was closed")));
  Tap();
  Send(EV_SYN, SYN_DROPPED, 0);
  Tap();
  EXPECT_THAT(Touches(), ElementsAre(msg::TouchStatus::kSingle));
}

// The process hung: it reads at once what the pad had seconds apart, and it woke the robot.
TEST_F(TouchInput, MakesNoDoubleTapOfTwoTapsThatItReadsLate) {
  Start();
  Run(std::chrono::seconds(10));
  const auto ago = [&](Duration time, std::int32_t pressed) {
    const Duration at = robot_->loop().Now().time_since_epoch() - time;
    input_event event = InputEvent(EV_KEY, BTN_TOUCH, pressed);
    event.input_event_sec = std::chrono::duration_cast<std::chrono::seconds>(at).count();
    event.input_event_usec =
        std::chrono::duration_cast<std::chrono::microseconds>(at % std::chrono::seconds(1)).count();
    ASSERT_NO_FATAL_FAILURE(device_.Send({event}));
  };
  ago(Milliseconds(3000), 1);
  ago(Milliseconds(2900), 0);
  ago(Milliseconds(1000), 1);
  ago(Milliseconds(900), 0);
  EXPECT_THAT(Touches(), IsEmpty());
}

TEST(TouchInputDevice, IsFoundByItsName) {
  const UniqueFd uinput(open("/dev/uinput", O_WRONLY | O_NONBLOCK | O_CLOEXEC));
  if (!uinput.valid()) GTEST_SKIP() << "/dev/uinput: " << std::strerror(errno);
  const std::string name = "musher touch pad " + std::to_string(getpid());
  ASSERT_NO_FATAL_FAILURE(MakeDeviceWithKey(uinput, name, BTN_TOUCH));
  if (!std::filesystem::exists("/dev/input")) GTEST_SKIP() << "no udev makes /dev/input";
  transport::LinuxEventLoop loop;
  std::vector<bool> keys;
  InputDevice::Events events{[&](std::uint16_t, bool pressed) { keys.push_back(pressed); }, [] {},
                             [](const std::string&) {}};
  const InputDevice device(loop, {"", name}, {BTN_TOUCH}, events);
  EXPECT_EQ(device.fault(), "");
  ASSERT_NO_FATAL_FAILURE(
      WriteEvents(uinput, {InputEvent(EV_KEY, BTN_TOUCH, 1), InputEvent(EV_SYN, SYN_REPORT, 0)}));
  EXPECT_TRUE(loop.RunUntil([&] { return !keys.empty() && keys.back(); },
                            loop.Now() + std::chrono::seconds(120)));
}

}  // namespace musher::device::touch_input_test
