#pragma once
// The self-check's verdict over the devices. Plain values, no IO.
//
// CyberDog's manager adds the codes of failing devices up and then looks at the lowest eight bits,
// so that some failures together count as none. Here one code is given and all are named.

#include <array>
#include <string>
#include <string_view>
#include <vector>

#include "musher/lifecycle/result.hpp"

namespace musher::device {

// In the order of the check.
inline constexpr std::array<std::string_view, 4> kDevices = {"bms", "touch", "led", "uwb"};

struct DeviceFinding {
  std::string device;
  Result<> result;
};

// Fails with the code of the first critical device that failed, else of the first one that did;
// the message names every failing device with its code.
Result<> JudgeSelfCheck(const std::vector<DeviceFinding>& findings,
                        const std::vector<std::string>& critical);

}  // namespace musher::device
