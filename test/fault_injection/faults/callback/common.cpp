#include "musher/test/fault_injection/faults/callback.hpp"

namespace musher::fault_injection::callback {

SwitchExpectation ExpectationForSwitch(const std::string& before, const std::string& target) {
  if (target == "SelfCheck") return {"done-degraded", before};
  if (RankOf(target) > RankOf(before)) return {"undone", before};
  return {"done-degraded", target};
}

void LeaveStateOf(FaultRun& run, const std::string& target) {
  if (run.state() != target) return;
  run.MoveTo(target == "Active" ? "DeActive" : "Active");
}

}  // namespace musher::fault_injection::callback
