#include "musher/modules/device/gpio_chip.hpp"

#include <fcntl.h>
#include <linux/gpio.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <cstring>
#include <filesystem>
#include <utility>
#include <vector>

#include "musher/base/files.hpp"

namespace musher::device {
namespace {

constexpr std::string_view kChipPrefix = "gpiochip";
constexpr std::string_view kDeviceFolder = "/dev/";
constexpr std::size_t kEventsAtOnce = 16;

Error GpioError(const std::string& what) {
  return {static_cast<std::int32_t>(KeyCode::kDeviceError), what};
}

bool IsNumber(std::string_view text) {
  return !text.empty() && std::ranges::all_of(text, [](char c) { return c >= '0' && c <= '9'; });
}

// A chip, and the name of the line for messages: "gpiochip0:5 'BUMPER'".
struct FoundLine {
  UniqueFd chip;
  std::uint32_t number = 0;
  std::string name;
};

std::string LineName(const std::string& chip, std::uint32_t number, const std::string& line) {
  return chip + ":" + std::to_string(number) + (line.empty() ? "" : " '" + line + "'");
}

UniqueFd OpenChip(const std::string& chip) {
  return UniqueFd(open((std::string(kDeviceFolder) + chip).c_str(), O_RDWR | O_CLOEXEC));
}

Error CannotOpen(const std::string& chip, int why) {
  std::string text = std::string(kDeviceFolder) + chip + ": " + std::strerror(why);
  if (why == EACCES || why == EPERM) {
    text += "; add the account of the robot to the group of that file: ls -l " +
            std::string(kDeviceFolder) + chip;
  }
  return GpioError(text);
}

Result<gpiochip_info> InfoOf(const UniqueFd& chip, const std::string& name) {
  gpiochip_info info{};
  if (ioctl(chip.get(), GPIO_GET_CHIPINFO_IOCTL, &info) == 0) return info;
  return GpioError(std::string(kDeviceFolder) + name + " is no GPIO chip: " + std::strerror(errno));
}

Result<gpio_v2_line_info> LineOf(const UniqueFd& chip, std::uint32_t number) {
  gpio_v2_line_info info{};
  info.offset = number;
  if (ioctl(chip.get(), GPIO_V2_GET_LINEINFO_IOCTL, &info) == 0) return info;
  const bool is_old = errno == ENOTTY || errno == EINVAL;
  return GpioError(is_old
                       ? "this kernel has no GPIO lines of version 2: it takes Linux 5.10 or later"
                       : std::strerror(errno));
}

std::string TextOf(const char (&text)[GPIO_MAX_NAME_SIZE]) {
  return {text, strnlen(text, sizeof text)};
}

Result<FoundLine> AtPlace(const GpioPlace& place) {
  FoundLine found{OpenChip(place.chip), place.number, ""};
  if (!found.chip.valid()) return CannotOpen(place.chip, errno);
  const auto chip = InfoOf(found.chip, place.chip);
  if (!chip) return chip.error();
  if (place.number >= chip.value().lines) {
    return GpioError(place.chip + " has " + std::to_string(chip.value().lines) +
                     " lines, from 0 on: " + std::to_string(place.number) + " is none of them");
  }
  const auto line = LineOf(found.chip, place.number);
  if (!line) return line.error();
  found.name = LineName(place.chip, place.number, TextOf(line.value().name));
  return found;
}

std::vector<std::string> Chips() {
  std::vector<std::string> chips;
  for (const std::filesystem::path& entry : EntriesOf(std::string(kDeviceFolder))) {
    const std::string name = entry.filename();
    if (name.starts_with(kChipPrefix) && IsNumber(name.substr(kChipPrefix.size())))
      chips.push_back(name);
  }
  std::ranges::sort(chips);
  return chips;
}

Result<FoundLine> OfName(const std::string& wanted) {
  std::optional<FoundLine> found;
  std::optional<Error> closed;  // a chip that may have it
  const std::vector<std::string> chips = Chips();
  for (const std::string& name : chips) {
    UniqueFd chip = OpenChip(name);
    if (!chip.valid()) {
      closed = CannotOpen(name, errno);
      continue;
    }
    const auto info = InfoOf(chip, name);
    if (!info) continue;
    for (std::uint32_t i = 0; i < info.value().lines; ++i) {
      const auto line = LineOf(chip, i);
      if (!line) return line.error();
      if (TextOf(line.value().name) != wanted) continue;
      if (found) {
        return GpioError("two GPIO lines are named '" + wanted + "': " + found->name + " and " +
                         LineName(name, i, "") + "; write the chip and the number");
      }
      found = FoundLine{UniqueFd(dup(chip.get())), i, LineName(name, i, wanted)};
    }
  }
  if (found) return std::move(*found);
  if (closed) return *closed;
  return GpioError(chips.empty() ? "this computer has no GPIO chip (/dev/gpiochip0)"
                                 : "no GPIO line is named '" + wanted + "'; `gpioinfo` lists them");
}

std::uint64_t FlagsOf(const GpioSpec& spec, GpioLine::Direction direction) {
  const std::uint64_t low = spec.active_low ? GPIO_V2_LINE_FLAG_ACTIVE_LOW : 0;
  if (direction == GpioLine::Direction::kOutput) return low | GPIO_V2_LINE_FLAG_OUTPUT;
  const std::uint64_t input = low | GPIO_V2_LINE_FLAG_INPUT | GPIO_V2_LINE_FLAG_EDGE_RISING |
                              GPIO_V2_LINE_FLAG_EDGE_FALLING;
  switch (spec.bias) {
    case GpioBias::kPullUp:
      return input | GPIO_V2_LINE_FLAG_BIAS_PULL_UP;
    case GpioBias::kPullDown:
      return input | GPIO_V2_LINE_FLAG_BIAS_PULL_DOWN;
    case GpioBias::kNone:
      return input | GPIO_V2_LINE_FLAG_BIAS_DISABLED;
    case GpioBias::kAsIs:
      break;
  }
  return input;
}

void AddAttribute(gpio_v2_line_config& config, const gpio_v2_line_attribute& attribute) {
  gpio_v2_line_config_attribute& slot = config.attrs[config.num_attrs++];
  slot.attr = attribute;
  slot.mask = 1;  // of the only line
}

gpio_v2_line_request RequestOf(const GpioSpec& spec, GpioLine::Direction direction,
                               std::uint32_t number) {
  gpio_v2_line_request request{};
  request.offsets[0] = number;
  request.num_lines = 1;
  std::strncpy(request.consumer, "musher-device-manager", sizeof request.consumer - 1);
  request.config.flags = FlagsOf(spec, direction);
  gpio_v2_line_attribute attribute{};
  if (direction == GpioLine::Direction::kOutput) {
    attribute.id = GPIO_V2_LINE_ATTR_ID_OUTPUT_VALUES;
    attribute.values = 0;  // inactive
    AddAttribute(request.config, attribute);
  } else if (spec.debounce > Duration()) {
    attribute.id = GPIO_V2_LINE_ATTR_ID_DEBOUNCE;
    attribute.debounce_period_us = static_cast<std::uint32_t>(ToMilliseconds(spec.debounce) * 1000);
    AddAttribute(request.config, attribute);
  }
  return request;
}

// Why the kernel does not give a line.
Error RefusedLine(const FoundLine& line, int why) {
  if (why == EBUSY) {
    const auto info = LineOf(line.chip, line.number);
    const std::string user = info ? TextOf(info.value().consumer) : "";
    return GpioError(line.name + " is in use by " +
                     (user.empty() ? "a driver or another program" : "'" + user + "'"));
  }
  std::string text = line.name + ": " + std::strerror(why);
  if (why == ENXIO) text += "; its chip reports no changes (it has no interrupts)";
  if (why == EINVAL || why == EOPNOTSUPP || why == ENOTSUP) {
    text += "; its chip may not have that bias or direction";
  }
  return GpioError(text);
}

}  // namespace

std::optional<GpioPlace> ReadGpioPlace(std::string_view text) {
  const std::size_t colon = text.find(':');
  if (!text.starts_with(kChipPrefix) || colon == std::string_view::npos) return std::nullopt;
  const std::string_view number = text.substr(colon + 1);
  GpioPlace place{std::string(text.substr(0, colon)), 0};
  if (!IsNumber(text.substr(kChipPrefix.size(), colon - kChipPrefix.size()))) return std::nullopt;
  const char* const end = number.data() + number.size();
  const auto [rest, fault] = std::from_chars(number.data(), end, place.number);
  if (number.empty() || fault != std::errc() || rest != end) return std::nullopt;
  return place;
}

Result<std::unique_ptr<GpioLine>> OpenGpioLine(transport::EventLoop& loop, const GpioSpec& spec,
                                               GpioLine::Direction direction,
                                               GpioLine::Events events) {
  const auto place = ReadGpioPlace(spec.line);
  const auto found = place ? AtPlace(*place) : OfName(spec.line);
  if (!found) return found.error();
  gpio_v2_line_request request = RequestOf(spec, direction, found.value().number);
  if (ioctl(found.value().chip.get(), GPIO_V2_GET_LINE_IOCTL, &request) != 0) {
    return RefusedLine(found.value(), errno);
  }
  UniqueFd fd(request.fd);
  // Without it a read at the wrong moment would wait.
  if (fcntl(fd.get(), F_SETFL, O_NONBLOCK) != 0) return RefusedLine(found.value(), errno);
  return std::unique_ptr<GpioLine>(std::make_unique<GpioFile>(
      loop, found.value().name, std::move(fd), direction, std::move(events)));
}

GpioFile::GpioFile(transport::EventLoop& loop, std::string name, UniqueFd fd, Direction direction,
                   Events events)
    : loop_(loop),
      name_(std::move(name)),
      direction_(direction),
      events_(std::move(events)),
      fd_(std::move(fd)) {
  if (direction_ == Direction::kOutput) return;
  readable_ = loop_.WhenReadable(fd_.get(), [this] { Read(); });
}

GpioFile::~GpioFile() {
  if (direction_ == Direction::kOutput) static_cast<void>(Set(false));  // or the chip is gone
}

Result<bool> GpioFile::IsActive() {
  gpio_v2_line_values values{0, 1};
  if (ioctl(fd_.get(), GPIO_V2_LINE_GET_VALUES_IOCTL, &values) == 0) return values.bits != 0;
  return GpioError(name_ + ": " + std::strerror(errno));
}

Result<> GpioFile::Set(bool active) {
  gpio_v2_line_values values{active ? 1U : 0U, 1};
  if (ioctl(fd_.get(), GPIO_V2_LINE_SET_VALUES_IOCTL, &values) == 0) return Ok();
  return GpioError(name_ + ": " + std::strerror(errno));
}

void GpioFile::Read() {
  std::array<gpio_v2_line_event, kEventsAtOnce> changes{};
  const ssize_t size = read(fd_.get(), changes.data(), sizeof changes);
  if (size < 0 && (errno == EAGAIN || errno == EINTR)) return;
  if (size <= 0) {
    readable_.reset();
    return events_.on_lost(name_ + ": " + (size == 0 ? "it was closed" : std::strerror(errno)));
  }
  const Duration now = loop_.Now().time_since_epoch();
  const auto count = static_cast<std::size_t>(size) / sizeof(gpio_v2_line_event);
  bool gap = false;
  for (std::size_t i = 0; i < count; ++i) {
    const gpio_v2_line_event& change = changes.at(i);
    const bool follows = !number_ || change.line_seqno == *number_ + 1;
    number_ = change.line_seqno;
    // 0: of a test.
    const Duration at = std::chrono::nanoseconds(change.timestamp_ns);
    if (!follows || (at > Duration() && now - at > kLate)) gap = true;
  }
  if (gap) {
    events_.on_gap();
    const bool last = changes.at(count - 1).id == GPIO_V2_LINE_EVENT_RISING_EDGE;
    const auto present = IsActive();  // further changes may wait
    return events_.on_level(present ? present.value() : last);
  }
  for (std::size_t i = 0; i < count; ++i) {
    events_.on_level(changes.at(i).id == GPIO_V2_LINE_EVENT_RISING_EDGE);
  }
}

}  // namespace musher::device
