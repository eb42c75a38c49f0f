#include "musher/test/campaign/faults/callback.hpp"

namespace musher::campaign::callback {

SwitchPromise PromiseForSwitch(const std::string& before, const std::string& target) {
  if (target == "SelfCheck") return {"done-degraded", before};
  if (RankOf(target) > RankOf(before)) return {"undone", before};
  return {"done-degraded", target};
}

void LeaveStateOf(Trial& trial, const std::string& target) {
  if (trial.state() != target) return;
  trial.MoveTo(target == "Active" ? "DeActive" : "Active");
}

}  // namespace musher::campaign::callback
