// A touch pad that is an input device of Linux: events as the kernel has them, by a pipe, in
// virtual time, and by a device of uinput where this kernel has it.

#include <fcntl.h>
#include <gmock/gmock.h>
#include <linux/uinput.h>
#include <sys/ioctl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cstring>
#include <filesystem>
#include <string>
#include <vector>

#include "musher/modules/device/input_device.hpp"
#include "musher/test/modules/device/devices_fixture.hpp"
#include "musher/test/modules/world/socket_node.hpp"
#include "musher/test/support/temp_folder.hpp"
#include "musher/transport/linux_event_loop.hpp"

namespace musher::device::touch_input_test {

using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

input_event Event(std::uint16_t type, std::uint16_t code, std::int32_t value) {
  input_event event{};
  event.type = type;
  event.code = code;
  event.value = value;
  return event;
}

class TouchInput : public DevicesOnANetwork {
 protected:
  TouchInput() {
    robot_ = std::make_unique<transport::SocketNode>(std::move(robot_));
    config_.led.source = LedSource::kNone;
    config_.battery.source = BatterySource::kNone;
    config_.touch.source = KeySource::kInput;
    config_.touch.input.file = folder_ / "event0";
    Plug();
  }
  void Plug() {
    std::filesystem::remove(config_.touch.input.file);
    ASSERT_EQ(mkfifo(config_.touch.input.file.c_str(), 0600), 0);
    writer_ = UniqueFd(open(config_.touch.input.file.c_str(), O_RDWR | O_NONBLOCK | O_CLOEXEC));
    ASSERT_TRUE(writer_.valid());
  }
  void Send(std::uint16_t type, std::uint16_t code, std::int32_t value) {
    const input_event event = Event(type, code, value);
    ASSERT_EQ(write(writer_.get(), &event, sizeof(event)), static_cast<ssize_t>(sizeof(event)));
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

  const TempFolder folder_;
  UniqueFd writer_;
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
  writer_ = UniqueFd();
  Run(Milliseconds(20));
  EXPECT_THAT(Failures(), ElementsAre(1509));
  Plug();
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
    input_event event = Event(EV_KEY, BTN_TOUCH, pressed);
    event.input_event_sec = std::chrono::duration_cast<std::chrono::seconds>(at).count();
    event.input_event_usec =
        std::chrono::duration_cast<std::chrono::microseconds>(at % std::chrono::seconds(1)).count();
    ASSERT_EQ(write(writer_.get(), &event, sizeof(event)), static_cast<ssize_t>(sizeof(event)));
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
  ASSERT_EQ(ioctl(uinput.get(), UI_SET_EVBIT, EV_KEY), 0);
  ASSERT_EQ(ioctl(uinput.get(), UI_SET_KEYBIT, BTN_TOUCH), 0);
  uinput_setup setup{};
  const std::string name = "musher touch pad " + std::to_string(getpid());
  std::strncpy(setup.name, name.c_str(), sizeof(setup.name) - 1);
  ASSERT_EQ(ioctl(uinput.get(), UI_DEV_SETUP, &setup), 0);
  ASSERT_EQ(ioctl(uinput.get(), UI_DEV_CREATE), 0);
  if (!std::filesystem::exists("/dev/input")) GTEST_SKIP() << "no udev makes /dev/input";
  transport::LinuxEventLoop loop;
  std::vector<bool> keys;
  InputDevice::Events events{[&](std::uint16_t, bool pressed) { keys.push_back(pressed); }, [] {},
                             [](const std::string&) {}};
  const InputDevice device(loop, {"", name}, {BTN_TOUCH}, events);
  EXPECT_EQ(device.fault(), "");
  const input_event press[] = {Event(EV_KEY, BTN_TOUCH, 1), Event(EV_SYN, SYN_REPORT, 0)};
  ASSERT_EQ(write(uinput.get(), press, sizeof(press)), static_cast<ssize_t>(sizeof(press)));
  EXPECT_TRUE(loop.RunUntil([&] { return !keys.empty() && keys.back(); },
                            loop.Now() + std::chrono::seconds(30)));
}

}  // namespace musher::device::touch_input_test
