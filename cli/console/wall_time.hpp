#pragma once
// Wall-clock times as text.

#include <cstdint>
#include <string>
#include <string_view>

#include "musher/base/result.hpp"

namespace musher::cli {

// Nanoseconds since 1970.
std::int64_t WallNow();
// When this host was booted, by today's wall clock.
std::int64_t BootWallNs();

std::string UtcText(std::int64_t wall_ns);    // "2026-03-01T12:00:05.250Z"
std::string LocalText(std::int64_t wall_ns);  // "2026-03-01 13:00:05.250", in the local zone
std::string LocalTime(std::int64_t wall_ns);  // "13:00:05.250"

// Parses the time of `--since`: how long ago ("90s", "10m", "2h", "1d") or a point in time
// ("2026-03-01", "2026-03-01T12:00", with seconds, with "Z" or "+01:00", else local).
Result<std::int64_t> ParseSince(std::string_view text, std::int64_t now_wall_ns);

// What is wrong with such a time; "" if nothing is.
std::string TimeError(const std::string& text);

}  // namespace musher::cli
