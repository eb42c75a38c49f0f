#include "musher/modules/device/host_lights.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <sstream>
#include <system_error>
#include <utility>

#include "musher/base/files.hpp"
#include "musher/base/unique_fd.hpp"

namespace musher::device {
namespace {

namespace fs = std::filesystem;

constexpr double kFull = 255;  // of a colour of the arbiter

Error CannotWrite(const fs::path& file, int why) {
  std::string what = file.string() + ": " + std::strerror(why);
  if (why == EACCES || why == EPERM) what += "; a udev rule can give it to the robot's account";
  return {MakeCode(cyberdog::module_code::kLed, KeyCode::kDeviceError), what};
}

// A file of the kernel takes the whole value in one write.
Result<> WriteValue(const fs::path& file, const std::string& value) {
  const UniqueFd fd(open(file.c_str(), O_WRONLY | O_CLOEXEC | O_TRUNC));
  if (!fd.valid()) return CannotWrite(file, errno);
  if (write(fd.get(), value.data(), value.size()) < 0) return CannotWrite(file, errno);
  return Ok();
}

int Highest(const fs::path& folder) {
  std::istringstream text(ReadFile(folder / "max_brightness"));
  int highest = 0;
  return text >> highest && highest > 0 ? highest : static_cast<int>(kFull);
}

std::string Scaled(std::uint8_t value, int highest) {
  return std::to_string(static_cast<int>(std::ceil(value / kFull * highest)));
}

// The share of each of its colours, in the order of its own; empty: it has a single one.
std::string Intensities(const fs::path& folder, const Look& look, int highest) {
  std::istringstream colors(ReadFile(folder / "multi_index"));
  std::string text;
  for (std::string color; colors >> color;) {
    const std::uint8_t value = color == "red"     ? look.r
                               : color == "green" ? look.g
                               : color == "blue"  ? look.b
                                                  : std::uint8_t{0};
    text += (text.empty() ? "" : " ") + Scaled(value, highest);
  }
  return text;
}

}  // namespace

Result<> ShowOnLed(const std::string& folder, const Look& look) {
  const fs::path led(folder);
  const std::uint8_t brightest = std::max({look.r, look.g, look.b});
  const int highest = Highest(led);
  std::string brightness = Scaled(brightest, highest);
  // What the kernel shows on it otherwise, such as the traffic of a disk, or the blinking so far.
  std::error_code ignored;  // it may not be permitted to look; then writing says why
  if (fs::exists(led / "trigger", ignored)) {
    if (Result<> done = WriteValue(led / "trigger", "none"); !done) return done;
  }
  if (const std::string colors = Intensities(led, look, highest);
      !colors.empty() && brightest > 0) {
    if (Result<> done = WriteValue(led / "multi_intensity", colors); !done) return done;
    brightness = std::to_string(highest);
  }
  if (Result<> done = WriteValue(led / "brightness", brightness); !done) return done;
  if (brightest == 0 || look.half_period == Duration()) return Ok();
  // A kernel that cannot blink shows it steadily; these two files it makes itself, perhaps for root
  // only, and blinks at 1 Hz without them.
  if (!WriteValue(led / "trigger", "timer")) return Ok();
  const std::string half_ms = std::to_string(ToMilliseconds(look.half_period));
  static_cast<void>(WriteValue(led / "delay_on", half_ms));
  static_cast<void>(WriteValue(led / "delay_off", half_ms));
  return Ok();
}

HostLights::HostLights(transport::EventLoop& loop, const std::string& folder, const LedNames& names,
                       std::function<void(const std::string&)> log)
    : loop_(loop), log_(std::move(log)) {
  for (std::size_t i = 0; i < lamps_.size(); ++i) {
    if (!names.at(i).empty()) lamps_.at(i).folder = fs::path(folder) / names.at(i);
  }
}

void HostLights::Show(const Lights& lights) {
  for (std::size_t i = 0; i < lamps_.size(); ++i) {
    const Look look = LookOf(kLedTargets.at(i), lights.at(i).light);
    Lamp& lamp = lamps_.at(i);
    if (lamp.folder.empty() || lamp.wanted == look) continue;
    lamp.wanted = look;
    lamp.shown = false;
  }
  ShowAll();
}

void HostLights::ShowAll() {
  retry_.reset();
  for (Lamp& lamp : lamps_) {
    if (!lamp.wanted || lamp.shown) continue;
    const Result<> shown = ShowOnLed(lamp.folder, *lamp.wanted);
    lamp.shown = shown.ok();
    const std::string fault = shown ? "" : shown.error().message;
    if (std::exchange(lamp.fault, fault) != fault) {
      log_("led: " + (fault.empty() ? lamp.folder + " works" : fault));
    }
    if (!shown && !retry_) retry_ = loop_.At(loop_.Now() + kRetry, [this] { ShowAll(); });
  }
}

std::string HostLights::FaultOf(std::uint8_t target) const {
  return lamps_.at(target - kLedTargets.front()).fault;
}

}  // namespace musher::device
