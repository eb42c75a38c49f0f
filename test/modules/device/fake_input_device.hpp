#pragma once
// Input devices of Linux for tests: a pipe with events as the kernel has them, and a device of
// uinput where this kernel has it.

#include <fcntl.h>
#include <gtest/gtest.h>
#include <linux/uinput.h>
#include <sys/ioctl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cstdint>
#include <cstring>
#include <filesystem>
#include <string>
#include <vector>

#include "musher/base/unique_fd.hpp"
#include "musher/test/support/temp_folder.hpp"

namespace musher::device {

inline input_event InputEvent(std::uint16_t type, std::uint16_t code, std::int32_t value) {
  input_event event{};
  event.type = type;
  event.code = code;
  event.value = value;
  return event;
}

inline void WriteEvents(const UniqueFd& to, const std::vector<input_event>& events) {
  const std::size_t size = events.size() * sizeof(input_event);
  ASSERT_EQ(write(to.get(), events.data(), size), static_cast<ssize_t>(size));
}

class FakeInputDevice {
 public:
  const std::string& file() const { return file_; }

  // The file is there from now on; before, there is none.
  void Plug() {
    std::filesystem::remove(file_);
    ASSERT_EQ(mkfifo(file_.c_str(), 0600), 0);
    writer_ = UniqueFd(open(file_.c_str(), O_RDWR | O_NONBLOCK | O_CLOEXEC));
    ASSERT_TRUE(writer_.valid());
  }
  // A reader of the file finds its end.
  void Unplug() { writer_ = UniqueFd(); }
  void Send(const std::vector<input_event>& events) { WriteEvents(writer_, events); }

 private:
  const TempFolder folder_;
  const std::string file_ = folder_ / "event0";
  UniqueFd writer_;
};

// Makes `uinput`, an open /dev/uinput, a device with one key.
inline void MakeDeviceWithKey(const UniqueFd& uinput, const std::string& name, std::uint16_t key) {
  ASSERT_EQ(ioctl(uinput.get(), UI_SET_EVBIT, EV_KEY), 0);
  ASSERT_EQ(ioctl(uinput.get(), UI_SET_KEYBIT, key), 0);
  uinput_setup setup{};
  std::strncpy(setup.name, name.c_str(), sizeof(setup.name) - 1);
  ASSERT_EQ(ioctl(uinput.get(), UI_DEV_SETUP, &setup), 0);
  ASSERT_EQ(ioctl(uinput.get(), UI_DEV_CREATE), 0);
}

// The file of that device; "": there is none, as without udev and devtmpfs.
inline std::string EventFileOf(const UniqueFd& uinput) {
  char name[64] = {};
  if (ioctl(uinput.get(), UI_GET_SYSNAME(sizeof(name)), name) < 0) return "";
  for (const auto& entry :
       std::filesystem::directory_iterator("/sys/devices/virtual/input/" + std::string(name))) {
    const std::string file = "/dev/input/" + entry.path().filename().string();
    if (std::filesystem::exists(file)) return file;
  }
  return "";
}

}  // namespace musher::device
