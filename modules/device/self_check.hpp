#pragma once
// The self-check's verdict over the devices. Plain values, no IO.
//
// CyberDog's manager adds the codes of failing devices up and then looks at the lowest eight bits,
// so that some failures together count as none. Here one code is given and all are named.

#include <array>
#include <string>
#include <string_view>
#include <vector>

#include "musher/lifecycle/code.hpp"
#include "musher/lifecycle/result.hpp"

namespace musher::device {

// In the order of the check.
inline constexpr std::array<std::string_view, 4> kDevices = {"bms", "touch", "led", "uwb"};

struct DeviceFinding {
  std::string device;
  Result<> result;
};

// Well, degraded with reasons, or failed. It fails when a critical device does, with that one's
// code; else it is degraded with the code of the first device that failed. Both name every failing
// device with its code.
struct SelfCheckVerdict {
  Result<> result;
  Error degraded{kCodeOk, ""};  // code 0: it is not

  bool well() const { return result.ok() && degraded.code == kCodeOk; }
};
SelfCheckVerdict EvaluateSelfCheck(const std::vector<DeviceFinding>& findings,
                                   const std::vector<std::string>& critical);

}  // namespace musher::device
