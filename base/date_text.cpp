#include "musher/base/date_text.hpp"

#include <array>
#include <ctime>
#include <limits>

namespace musher {
namespace {

using BreakDown = std::tm* (*)(const std::time_t*, std::tm*);  // gmtime_r() or localtime_r()

std::string Format(std::chrono::sys_seconds time, const char* pattern, BreakDown break_down) {
  const std::time_t seconds = time.time_since_epoch().count();
  std::tm parts{};
  constexpr int kLastYear = std::numeric_limits<int>::max() - 1900;  // glibc's %Y overflows later
  if (break_down(&seconds, &parts) == nullptr || parts.tm_year > kLastYear) {
    return "@" + std::to_string(seconds);
  }
  std::array<char, 128> text{};
  const std::size_t size = std::strftime(text.data(), text.size(), pattern, &parts);
  return {text.data(), size};
}

}  // namespace

std::chrono::sys_seconds WholeSeconds(std::int64_t wall_ns) {
  return std::chrono::floor<std::chrono::seconds>(
      std::chrono::sys_time<std::chrono::nanoseconds>(std::chrono::nanoseconds(wall_ns)));
}

std::string FormatUtc(std::chrono::sys_seconds time, const char* pattern) {
  return Format(time, pattern, gmtime_r);
}

std::string FormatLocal(std::chrono::sys_seconds time, const char* pattern) {
  return Format(time, pattern, localtime_r);
}

}  // namespace musher
