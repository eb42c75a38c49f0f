#pragma once
// The self-check's verdict over the sensors. Plain values, no IO.
//
// CyberDog's manager adds the codes of failing sensors up and then looks at the lowest eight bits,
// so that some failures together count as none. Here one code is given and all are named.

#include <vector>

#include "musher/lifecycle/code.hpp"
#include "musher/lifecycle/result.hpp"
#include "musher/modules/sensor/sensor_kind.hpp"

namespace musher::sensor {

struct SensorFinding {
  SensorKind kind = SensorKind::kLidar;
  Result<> result;
};

// Well, degraded with reasons, or failed. `findings` in the order of the check: the first critical
// sensor that failed fails it, with its code and its sentence alone. Else it is degraded with the
// code of the first one that failed, and all of them in the message.
struct SelfCheckVerdict {
  Result<> result;
  Error degraded{kCodeOk, ""};  // code 0: it is not

  bool well() const { return result.ok() && degraded.code == kCodeOk; }
};
SelfCheckVerdict EvaluateSelfCheck(const std::vector<SensorFinding>& findings,
                                   const std::vector<SensorKind>& critical);

}  // namespace musher::sensor
