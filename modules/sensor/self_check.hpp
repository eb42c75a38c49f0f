#pragma once
// The outcome of the self-check from the results of all sensors. Plain values, no IO.
//
// CyberDog's manager adds up the codes of failing sensors and then looks at the lowest eight bits,
// so that some failures together count as none. Here the outcome has one code and names all of
// them.

#include <vector>

#include "musher/base/code.hpp"
#include "musher/base/result.hpp"
#include "musher/modules/sensor/sensor_kind.hpp"

namespace musher::sensor {

struct SensorResult {
  SensorKind kind = SensorKind::kLidar;
  Result<> result;
};

// Ok, degraded with reasons, or failed. `findings` in the order of the check: the first critical
// sensor that failed fails it, with its code and message alone. Else it is degraded with the code
// of the first one that failed, and all of them in the message.
struct SelfCheckVerdict {
  Result<> result;
  Error degraded{kCodeOk, ""};  // code 0: not degraded

  bool well() const { return result.ok() && degraded.code == kCodeOk; }
};
SelfCheckVerdict EvaluateSelfCheck(const std::vector<SensorResult>& checked,
                                   const std::vector<SensorKind>& critical);

}  // namespace musher::sensor
