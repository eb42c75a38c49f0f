#include "musher/modules/device/input_key.hpp"

#include <fcntl.h>
#include <linux/input.h>
#include <sys/ioctl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <climits>
#include <cstring>
#include <utility>

namespace musher::device {
namespace {

using Keys = std::array<unsigned char, KEY_MAX / CHAR_BIT + 1>;

bool Has(const Keys& keys, std::uint16_t code) {
  return ((keys.at(code / CHAR_BIT) >> (code % CHAR_BIT)) & 1U) != 0;
}

// Why that key cannot be read from the file; "": it can. A pipe may have the events of a device.
std::string FaultOf(int fd, std::uint16_t code) {
  struct stat status {};
  if (fstat(fd, &status) < 0) return std::strerror(errno);
  if (S_ISFIFO(status.st_mode)) return "";
  Keys keys{};
  const bool is_device =
      S_ISCHR(status.st_mode) && ioctl(fd, EVIOCGBIT(EV_KEY, sizeof(keys)), keys.data()) >= 0;
  if (!is_device) return "it is no input device";
  return Has(keys, code) ? "" : "it has no key " + std::to_string(code);
}

}  // namespace

InputKey::InputKey(transport::EventLoop& loop, std::string device, std::uint16_t code, OnKey on_key,
                   Log log)
    : loop_(loop),
      device_(std::move(device)),
      code_(code),
      on_key_(std::move(on_key)),
      log_(std::move(log)) {
  Open();
}

void InputKey::Open() {
  fd_ = UniqueFd(open(device_.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC));
  if (!fd_.valid()) return Lose(std::strerror(errno));
  if (const std::string fault = FaultOf(fd_.get(), code_); !fault.empty()) return Lose(fault);
  readable_ = loop_.WhenReadable(fd_.get(), [this] { Read(); });
  if (!fault_.empty()) log_("power key: " + device_ + " is available");
  fault_.clear();
  Ask();
}

void InputKey::Read() {
  constexpr std::size_t kAtOnce = 64;
  std::array<input_event, kAtOnce> events{};
  const ssize_t size = read(fd_.get(), events.data(), sizeof(events));
  if (size < 0 && (errno == EAGAIN || errno == EINTR)) return;
  if (size <= 0) return Lose(size == 0 ? "it was closed" : std::strerror(errno));
  constexpr std::int32_t kRepeated = 2;  // by the kernel, while the key is held
  const std::size_t count = static_cast<std::size_t>(size) / sizeof(input_event);
  for (std::size_t i = 0; i < count; ++i) {
    const input_event& event = events.at(i);
    if (event.type == EV_SYN && event.code == SYN_DROPPED) return Ask();
    if (event.type != EV_KEY || event.code != code_ || event.value == kRepeated) continue;
    on_key_(event.value != 0);
  }
}

void InputKey::Ask() {
  Keys pressed{};
  if (ioctl(fd_.get(), EVIOCGKEY(sizeof(pressed)), pressed.data()) < 0) return;  // a pipe
  on_key_(Has(pressed, code_));
}

void InputKey::Lose(const std::string& why) {
  if (std::exchange(fault_, why) != why) {
    log_("power key: " + device_ + ": " + why + "; it is opened again every second");
  }
  on_key_(false);
  reopen_ = loop_.At(loop_.Now() + kReopen, [this] { Open(); });
  readable_.reset();  // last: this may run in its callback
  fd_ = UniqueFd();
}

}  // namespace musher::device
