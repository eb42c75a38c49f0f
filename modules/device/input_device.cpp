#include "musher/modules/device/input_device.hpp"

#include <fcntl.h>
#include <linux/input.h>
#include <sys/ioctl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <climits>
#include <cstring>
#include <ctime>
#include <filesystem>
#include <utility>

#include "musher/base/files.hpp"

namespace musher::device {
namespace {

using Keys = std::array<unsigned char, KEY_MAX / CHAR_BIT + 1>;

bool Has(const Keys& keys, std::uint16_t code) {
  return ((keys.at(code / CHAR_BIT) >> (code % CHAR_BIT)) & 1U) != 0;
}

UniqueFd OpenFile(const std::string& file) {
  return UniqueFd(open(file.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC));
}

// Why these keys cannot be read from the file; "": they can. A pipe may have the events of a
// device.
std::string FaultOf(int fd, const std::vector<std::uint16_t>& codes) {
  struct stat status {};
  if (fstat(fd, &status) < 0) return std::strerror(errno);
  if (S_ISFIFO(status.st_mode)) return "";
  Keys keys{};
  const bool is_device =
      S_ISCHR(status.st_mode) && ioctl(fd, EVIOCGBIT(EV_KEY, sizeof(keys)), keys.data()) >= 0;
  if (!is_device) return "it is no input device";
  for (const std::uint16_t code : codes) {
    if (!Has(keys, code)) return "it has no key " + std::to_string(code);
  }
  return "";
}

// The device of that name, the one with these keys if several have it; not valid: none. Its name is
// read without opening it: each opened device takes milliseconds to close.
UniqueFd OpenByName(const std::string& name, const std::vector<std::uint16_t>& codes) {
  UniqueFd found;
  int why_not = ENODEV;
  for (const std::filesystem::path& entry : EntriesOf("/sys/class/input")) {
    const std::string device = entry.filename();
    if (!device.starts_with("event") || ReadFile(entry / "device/name") != name + "\n") continue;
    UniqueFd fd = OpenFile("/dev/input/" + device);
    if (!fd.valid()) {
      why_not = errno;  // as without permission
      continue;
    }
    found = std::move(fd);
    if (FaultOf(found.get(), codes).empty()) return found;
  }
  errno = why_not;
  return found;
}

}  // namespace

InputDevice::InputDevice(transport::EventLoop& loop, InputSource source,
                         std::vector<std::uint16_t> codes, Events events)
    : loop_(loop),
      source_(std::move(source)),
      codes_(std::move(codes)),
      events_(std::move(events)) {
  Open();
}

void InputDevice::Open() {
  fd_ = source_.file.empty() ? OpenByName(source_.name, codes_) : OpenFile(source_.file);
  if (!fd_.valid()) return Lose(std::strerror(errno));
  if (const std::string fault = FaultOf(fd_.get(), codes_); !fault.empty()) return Lose(fault);
  const int clock = CLOCK_MONOTONIC;
  ioctl(fd_.get(), EVIOCSCLOCKID, &clock);  // a pipe has none
  readable_ = loop_.WhenReadable(fd_.get(), [this] { Read(); });
  if (!fault_.empty()) events_.log(name() + " is available");
  fault_.clear();
  events_.on_open();
  Ask();
}

void InputDevice::Read() {
  constexpr std::size_t kAtOnce = 64;
  std::array<input_event, kAtOnce> events{};
  const ssize_t size = read(fd_.get(), events.data(), sizeof(events));
  if (size < 0 && (errno == EAGAIN || errno == EINTR)) return;
  if (size <= 0) return Lose(size == 0 ? "it was closed" : std::strerror(errno));
  constexpr std::int32_t kRepeated = 2;  // by the kernel, while the key is held
  const Duration now = loop_.Now().time_since_epoch();
  const std::size_t count = static_cast<std::size_t>(size) / sizeof(input_event);
  for (std::size_t i = 0; i < count; ++i) {
    const input_event& event = events.at(i);
    // After a hang two touches that are read at once may have been seconds apart. 0: of a pipe.
    const Duration at = std::chrono::seconds(event.input_event_sec) +
                        std::chrono::microseconds(event.input_event_usec);
    const bool late = at > Duration() && now - at > kLate;
    if (late || (event.type == EV_SYN && event.code == SYN_DROPPED)) {
      events_.on_gap();
      return Ask();
    }
    const bool is_key =
        event.type == EV_KEY && std::ranges::find(codes_, event.code) != codes_.end();
    if (is_key && event.value != kRepeated) events_.on_key(event.code, event.value != 0);
  }
}

void InputDevice::Ask() {
  Keys pressed{};
  ioctl(fd_.get(), EVIOCGKEY(sizeof(pressed)), pressed.data());  // a pipe leaves them released
  for (const std::uint16_t code : codes_) events_.on_key(code, Has(pressed, code));
}

void InputDevice::Lose(const std::string& why) {
  if (std::exchange(fault_, why) != why) {
    events_.log(name() + ": " + why + "; it is opened again every second");
  }
  events_.on_gap();
  for (const std::uint16_t code : codes_) events_.on_key(code, false);
  reopen_ = loop_.At(loop_.Now() + kReopen, [this] { Open(); });
  readable_.reset();  // last: this may run in its callback
  fd_ = UniqueFd();
}

}  // namespace musher::device
