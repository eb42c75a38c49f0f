// A key of an input device: events as the kernel has them, by a pipe, and by a device of uinput
// where this kernel has it.

#include "musher/modules/device/input_device.hpp"

#include <gmock/gmock.h>

#include <cstring>
#include <filesystem>
#include <fstream>
#include <memory>
#include <string>
#include <vector>

#include "musher/test/modules/device/fake_input_device.hpp"
#include "musher/transport/linux_event_loop.hpp"

namespace musher::device::input_device_test {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

class Key : public ::testing::Test {
 protected:
  std::unique_ptr<InputDevice> Start(const std::string& device, std::uint16_t code = KEY_POWER) {
    InputDevice::Events events{[this](std::uint16_t, bool pressed) { keys_.push_back(pressed); },
                               [] {}, [this](const std::string& line) { log_.push_back(line); }};
    return std::make_unique<InputDevice>(loop_, InputSource{device, ""},
                                         std::vector<std::uint16_t>{code}, std::move(events));
  }
  bool Await(std::size_t keys) {
    return loop_.RunUntil([&] { return keys_.size() >= keys; },
                          loop_.Now() + std::chrono::seconds(120));
  }

  FakeInputDevice device_;
  transport::LinuxEventLoop loop_;
  std::vector<bool> keys_;
  std::vector<std::string> log_;
};

TEST_F(Key, IsPressedAndReleased) {
  device_.Plug();
  const auto key = Start(device_.file());
  device_.Send({InputEvent(EV_KEY, KEY_A, 1), InputEvent(EV_KEY, KEY_POWER, 1),
                InputEvent(EV_SYN, SYN_REPORT, 0), InputEvent(EV_KEY, KEY_POWER, 2),
                InputEvent(EV_REL, KEY_POWER, 1), InputEvent(EV_KEY, KEY_POWER, 0)});
  ASSERT_TRUE(Await(3));
  EXPECT_THAT(keys_, ElementsAre(false, true, false))
      << "neither another key nor a repetition counts";
  EXPECT_THAT(log_, IsEmpty());
}

// Otherwise a key whose device is gone would switch the robot off.
TEST_F(Key, IsReleasedWhenItsDeviceIsLostAndWorksAgainOnceItIsBack) {
  device_.Plug();
  const auto key = Start(device_.file());
  device_.Send({InputEvent(EV_KEY, KEY_POWER, 1)});
  ASSERT_TRUE(Await(2));
  device_.Unplug();
  ASSERT_TRUE(Await(3));
  EXPECT_THAT(keys_, ElementsAre(false, true, false));
  EXPECT_THAT(log_, ElementsAre(HasSubstr("it was closed; it is opened again every second")));
  device_.Plug();
  ASSERT_TRUE(
      loop_.RunUntil([&] { return log_.size() == 2; }, loop_.Now() + std::chrono::seconds(120)));
  EXPECT_THAT(log_.back(), HasSubstr("is available"));
  device_.Send({InputEvent(EV_KEY, KEY_POWER, 1)});
  ASSERT_TRUE(Await(5));
  EXPECT_TRUE(keys_.back());
}

TEST_F(Key, WithoutItsDeviceIsLoggedOnce) {
  const auto key = Start(device_.file());
  ASSERT_TRUE(Await(2));
  EXPECT_THAT(keys_, ::testing::Each(false));
  EXPECT_THAT(log_, SizeIs(1));
  EXPECT_THAT(log_.front(), HasSubstr("No such file"));
}

// The event loop refuses a folder, a file and /dev/null.
TEST_F(Key, OfAFileThatIsNoInputDeviceIsLoggedOnce) {
  const TempFolder folder;
  const std::string file = folder / "file";
  std::ofstream(file) << "text";
  for (const std::string& device : {folder.path(), file, std::string("/dev/null")}) {
    SCOPED_TRACE(device);
    keys_.clear();
    log_.clear();
    const auto key = Start(device);
    ASSERT_TRUE(Await(2)) << "it is opened again";
    EXPECT_THAT(keys_, ::testing::Each(false));
    EXPECT_THAT(log_, ElementsAre(HasSubstr("it is no input device")));
  }
}

TEST_F(Key, OfADeviceOfTheKernelIsKnownWhenItIsPressedAlready) {
  const UniqueFd uinput(open("/dev/uinput", O_WRONLY | O_NONBLOCK | O_CLOEXEC));
  if (!uinput.valid()) GTEST_SKIP() << "/dev/uinput: " << std::strerror(errno);
  ASSERT_NO_FATAL_FAILURE(MakeDeviceWithKey(uinput, "musher test key", KEY_POWER));
  const std::string device = EventFileOf(uinput);
  if (device.empty()) GTEST_SKIP() << "no udev makes a file of it";
  ASSERT_NO_FATAL_FAILURE(
      WriteEvents(uinput, {InputEvent(EV_KEY, KEY_POWER, 1), InputEvent(EV_SYN, SYN_REPORT, 0)}));
  const auto key = Start(device);
  EXPECT_THAT(keys_, ElementsAre(true));
  EXPECT_THAT(Start(device, KEY_A)->fault(), HasSubstr("it has no key 30"));
  keys_.clear();
  ioctl(uinput.get(), UI_DEV_DESTROY);
  ASSERT_TRUE(Await(1));
  EXPECT_FALSE(keys_.back());
}

}  // namespace musher::device::input_device_test
