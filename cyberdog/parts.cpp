#include "musher/cyberdog/parts.hpp"

#include <algorithm>
#include <array>
#include <string>

namespace musher::cyberdog {
namespace {

constexpr std::array<Part, 4> kDevices = {
    {{"bms", 1409}, {"led", 1109}, {"touch", 1509}, {"uwb", 1609}}};
constexpr std::array<Part, 4> kSensors = {
    {{"lidar", 2109}, {"tof", 2209}, {"ultrasonic", 2309, false}, {"gps", 2409, false}}};

bool IsDecimal(char c) {
  return c >= '0' && c <= '9';
}

// Whether `message` contains `code` as a separate number.
bool Names(const std::string& message, std::int32_t code) {
  const std::string number = std::to_string(code);
  for (std::size_t at = message.find(number); at != std::string::npos;
       at = message.find(number, at + 1)) {
    const std::size_t end = at + number.size();
    const bool alone = (at == 0 || !IsDecimal(message[at - 1])) &&
                       (end == message.size() || !IsDecimal(message[end]));
    if (alone) return true;
  }
  return false;
}

// The parts with keys of their own whose codes add up to `code`: with more parts a sum would be
// ambiguous.
unsigned Summands(std::span<const Part> parts, std::int32_t code) {
  const unsigned subsets = 1U << parts.size();
  for (unsigned subset = 1; subset < subsets; ++subset) {
    std::int32_t sum = 0;
    bool known = true;
    for (std::size_t i = 0; i < parts.size(); ++i) {
      if ((subset >> i & 1U) == 0) continue;
      sum += parts[i].code;
      known = known && parts[i].own_key;
    }
    if (known && sum == code) return subset;
  }
  return 0;
}

}  // namespace

std::span<const Part> PartsOf(std::string_view actuator) {
  if (actuator == "device_manager") return kDevices;
  if (actuator == "sensor_manager") return kSensors;
  return {};
}

std::vector<std::int32_t> FailedCodes(std::span<const Part> parts, const Error& fault) {
  const unsigned summands = Summands(parts, fault.code);
  const bool of_part = std::any_of(parts.begin(), parts.end(),
                                   [&](const Part& part) { return part.code == fault.code; });
  // A number in another message may be anything, for example a pid.
  if (summands == 0 && !of_part) return {fault.code};
  std::vector<std::int32_t> codes;
  for (std::size_t i = 0; i < parts.size(); ++i) {
    const bool failed = (summands >> i & 1U) != 0 || parts[i].code == fault.code ||
                        Names(fault.message, parts[i].code);
    if (failed) codes.push_back(parts[i].code);
  }
  return codes;
}

}  // namespace musher::cyberdog
