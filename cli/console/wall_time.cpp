#include "musher/cli/console/wall_time.hpp"

#include <fmt/format.h>

#include <charconv>
#include <chrono>
#include <ctime>
#include <optional>

#include "musher/base/date_text.hpp"

namespace musher::cli {
namespace {

constexpr std::int64_t kSecond = 1'000'000'000;
constexpr std::int64_t kLongestAgo = 100LL * 365 * 86400;  // seconds; keeps the arithmetic in range

std::string Format(std::int64_t wall_ns, bool local, const char* pattern) {
  const std::chrono::sys_seconds seconds = WholeSeconds(wall_ns);
  const std::int64_t rest_ns = (wall_ns % kSecond + kSecond) % kSecond;  // also before 1970
  return fmt::format("{}.{:03}",
                     local ? FormatLocal(seconds, pattern) : FormatUtc(seconds, pattern),
                     rest_ns / 1'000'000);
}

std::optional<std::int64_t> SecondsAgo(std::string_view text) {
  std::int64_t count = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), count);
  const std::string_view unit = text.substr(end - text.data());
  const std::int64_t scale = unit == "s"   ? 1
                             : unit == "m" ? 60
                             : unit == "h" ? 3600
                             : unit == "d" ? 86400
                                           : 0;
  if (error != std::errc() || scale == 0 || count < 0 || count > kLongestAgo / scale) {
    return std::nullopt;
  }
  return count * scale;
}

// From whole seconds and nanoseconds; nullopt if the time does not fit (before 1678, after 2261).
std::optional<std::int64_t> Nanoseconds(std::int64_t seconds, std::int64_t fraction) {
  constexpr std::int64_t kFarthest = INT64_MAX / kSecond - 1;
  if (seconds < -kFarthest || seconds > kFarthest) return std::nullopt;
  return seconds * kSecond + fraction;
}

// Nanoseconds since 1970 of a date with or without a time, without trailing text.
std::optional<std::int64_t> PointInTime(const std::string& text) {
  std::tm parts{};
  parts.tm_isdst = -1;
  const char* rest = nullptr;
  for (const char* pattern :
       {"%Y-%m-%dT%H:%M:%S", "%Y-%m-%d %H:%M:%S", "%Y-%m-%dT%H:%M", "%Y-%m-%d %H:%M", "%Y-%m-%d"}) {
    rest = strptime(text.c_str(), pattern, &parts);
    if (rest != nullptr) break;
    parts = {};
    parts.tm_isdst = -1;
  }
  if (rest == nullptr) return std::nullopt;
  std::int64_t fraction = 0;
  if (*rest == '.') {
    std::int64_t weight = kSecond / 10;
    for (++rest; *rest >= '0' && *rest <= '9'; ++rest, weight /= 10) {
      fraction += (*rest - '0') * weight;
    }
  }
  std::tm corrected = parts;
  const std::int64_t as_utc = timegm(&corrected);
  // By the calendar alone: mktime() also moves a time that the zone skips.
  if (corrected.tm_mday != parts.tm_mday) return std::nullopt;
  if (*rest == '\0') return Nanoseconds(std::mktime(&parts), fraction);
  std::tm zone{};
  const char* end = strptime(rest, "%z", &zone);  // takes "Z", "+01:00" and "+0100"
  if (end == nullptr || *end != '\0') return std::nullopt;
  return Nanoseconds(as_utc - zone.tm_gmtoff, fraction);
}

}  // namespace

std::int64_t WallNow() {
  const auto now = std::chrono::system_clock::now().time_since_epoch();
  return std::chrono::duration_cast<std::chrono::nanoseconds>(now).count();
}

std::int64_t BootWallNs() {
  timespec since_boot{};
  clock_gettime(CLOCK_BOOTTIME, &since_boot);
  return WallNow() - since_boot.tv_sec * 1'000'000'000 - since_boot.tv_nsec;
}

std::string UtcText(std::int64_t wall_ns) {
  return Format(wall_ns, false, "%Y-%m-%dT%H:%M:%S") + "Z";
}

std::string LocalText(std::int64_t wall_ns) {
  return Format(wall_ns, true, "%Y-%m-%d %H:%M:%S");
}

std::string LocalTime(std::int64_t wall_ns) {
  return Format(wall_ns, true, "%H:%M:%S");
}

Result<std::int64_t> ParseSince(std::string_view text, std::int64_t now_wall_ns) {
  if (const auto ago = SecondsAgo(text)) return now_wall_ns - *ago * kSecond;
  if (const auto point = PointInTime(std::string(text))) return *point;
  return Error{kCodeParametersInvalid,
               "invalid time '" + std::string(text) +
                   "'; expected how long ago (90s, 10m, 2h, 1d) or a date such as "
                   "2026-03-01T12:00 or 2026-03-01T12:00:00Z"};
}

std::string TimeError(const std::string& text) {
  const auto time = ParseSince(text, 0);
  return time ? "" : time.error().message;
}

}  // namespace musher::cli
