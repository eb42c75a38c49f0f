// Texts of injected events, for timelines: the form of the kind (injection.cpp) with its names
// filled in.

#include "musher/base/check.hpp"
#include "musher/simulation/hosts.hpp"
#include "musher/simulation/injection.hpp"

namespace musher::simulation {
namespace {

std::string InMilliseconds(Duration duration) {
  return std::to_string(ToMilliseconds(duration)) + " ms";
}

std::string Describe(PermitFault fault, const std::string& actuator) {
  switch (fault) {
    case PermitFault::kConsoleEnds:
      return "the console gives no permits to move";
    case PermitFault::kLost:
      return "permits to move are lost";
    case PermitFault::kLate:
      return "permits to move are late";
    case PermitFault::kCut:
      break;
  }
  return "the link from the console to " + actuator + " is cut";
}

std::string DescribeClock(const Injection& injection) {
  const std::string lasts = " for " + InMilliseconds(injection.lasts);
  switch (ClockFaultOf(injection)) {
    case ClockFault::kRate:
      return "/clock runs at " + std::to_string(ClockRateOf(injection)) + " thousandths" + lasts;
    case ClockFault::kPause:
      return "/clock pauses" + lasts;
    case ClockFault::kBack:
    case ClockFault::kForward:
      return "/clock jumps by " + InMilliseconds(ClockJumpOf(injection));
    case ClockFault::kRestart:
      break;
  }
  return "/clock begins again";
}

// What stands for a name in braces of an injection's form.
std::string ValueOf(std::string_view name, const MachineConfig& config,
                    const Injection& injection) {
  const auto one_of = [&](unsigned n, const char* first, const char* others) {
    return injection.random % n == 0 ? first : others;
  };
  std::string actuator = config.actuators[injection.actuator].name;
  std::string ms = InMilliseconds(injection.lasts);
  if (name == "actuator") return actuator;
  if (name == "host") return std::string(HostName(injection.host));
  if (name == "other") return std::string(HostName(injection.other_host));
  if (name == "state") return injection.state;
  if (name == "lasts") return " for " + ms;
  if (name == "ms") return ms;
  if (name == "released") {
    return injection.lasts == Duration::zero() ? "" : ", released after " + ms;
  }
  if (name == "battery") return std::to_string(BatteryOf(injection));
  if (name == "charging") return ChargesIn(injection) ? ", charging" : "";
  if (name == "moves") return one_of(4, "moves", "lies still");
  if (name == "seconds") return std::to_string(injection.random % 8);
  if (name == "enters") return one_of(2, "enters", "leaves");
  if (name == "on") return one_of(3, "off", "on");
  if (name == "of_one") return injection.random % 8 == 0 ? " of " + actuator : "";
  if (name == "permit_fault") return Describe(PermitFaultOf(injection), actuator);
  if (name == "clock_fault") return DescribeClock(injection);
  MUSHER_CHECK(false, std::string(name), "stands for nothing in the text of an injection");
}

}  // namespace

std::string Describe(const MachineConfig& config, const Injection& injection) {
  std::string text;
  std::string_view form = FormOf(injection.kind);
  for (auto begin = form.find('{'); begin != form.npos; begin = form.find('{')) {
    const auto end = form.find('}', begin);
    text += form.substr(0, begin);
    text += ValueOf(form.substr(begin + 1, end - begin - 1), config, injection);
    form.remove_prefix(end + 1);
  }
  return text + std::string(form);
}

}  // namespace musher::simulation
