#pragma once
// The outcome of the self-check from the results of all devices. Plain values, no IO.
//
// CyberDog's manager adds up the codes of failing devices and then looks at the lowest eight bits,
// so that some failures together count as none. Here the outcome has one code and names all of
// them.

#include <array>
#include <string>
#include <string_view>
#include <vector>

#include "musher/base/code.hpp"
#include "musher/base/result.hpp"

namespace musher::device {

// In the order of the check.
inline constexpr std::array<std::string_view, 6> kDevices = {"bms", "touch",   "led",
                                                             "uwb", "contact", "measurement"};

struct DeviceResult {
  std::string device;
  Result<> result;
};

// Ok, degraded with reasons, or failed. It fails when a critical device fails, with the code of
// that device; else it is degraded with the code of the first device that failed. Both name every
// failing device with its code.
struct SelfCheckVerdict {
  Result<> result;
  Error degraded{kCodeOk, ""};  // code 0: not degraded

  bool well() const { return result.ok() && degraded.code == kCodeOk; }
};
SelfCheckVerdict EvaluateSelfCheck(const std::vector<DeviceResult>& checked,
                                   const std::vector<std::string>& critical);

}  // namespace musher::device
