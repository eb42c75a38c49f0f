#include "musher/view/record/recorded_text.hpp"

#include <array>
#include <cstdio>

namespace musher::view {
namespace {

std::string SizeText(double bytes) {
  static constexpr std::array<const char*, 5> kUnits = {"B", "kB", "MB", "GB", "TB"};
  std::size_t unit = 0;
  while (bytes >= 999.5 && unit + 1 < kUnits.size()) {
    bytes /= 1000;
    ++unit;
  }
  char text[32];
  std::snprintf(text, sizeof text, unit > 0 && bytes < 99.5 ? "%.1f %s" : "%.0f %s", bytes,
                kUnits.at(unit));
  return text;
}

}  // namespace

std::string RecordedText(std::uint64_t bytes, double seconds, double rate) {
  char time[32];
  std::snprintf(time, sizeof time, "%.1f s", seconds);
  return SizeText(static_cast<double>(bytes)) + " in " + time + ", " + SizeText(rate) + "/s";
}

}  // namespace musher::view
