#include "musher/ota/install_flow.hpp"

#include "musher/base/check.hpp"

namespace musher::ota {

std::string_view StepName(Step step) {
  switch (step) {
    case Step::kCheck:
      return "check";
    case Step::kEnterOta:
      return "enter OTA";
    case Step::kPrepare:
      return "prepare";
    case Step::kCopy:
      return "copy";
    case Step::kCheckWritten:
      return "check what was written";
    case Step::kMarkTrialBoot:
      return "mark for the trial boot";
    case Step::kStartAgain:
      return "start again";
    case Step::kTrialBoot:
      return "trial boot";
    case Step::kLeaveOta:
      break;
  }
  return "leave OTA";
}

Flow InstallFlow(bool machine_runs) {
  Flow flow;
  if (machine_runs) {
    flow.left = {Step::kCheck,        Step::kEnterOta,      Step::kPrepare,    Step::kCopy,
                 Step::kCheckWritten, Step::kMarkTrialBoot, Step::kStartAgain, Step::kTrialBoot};
  } else {
    flow.left = {Step::kCheck, Step::kPrepare, Step::kCopy, Step::kCheckWritten,
                 Step::kMarkTrialBoot};
  }
  return flow;
}

Flow RollbackFlow(bool machine_runs) {
  Flow flow;
  flow.left = {Step::kMarkTrialBoot};
  if (machine_runs) {
    flow.left = {Step::kEnterOta, Step::kMarkTrialBoot, Step::kStartAgain, Step::kTrialBoot};
  }
  return flow;
}

void Advance(Flow& flow, const Result<>& outcome) {
  MUSHER_CHECK(!flow.left.empty());
  const Step step = flow.left.front();
  flow.left.pop_front();
  // A failed switch may also have moved some actuators.
  if (step == Step::kEnterOta) flow.in_ota = true;
  if (step == Step::kStartAgain && outcome) flow.in_ota = false;
  if (outcome) return;
  if (step == Step::kLeaveOta) {
    flow.afterwards = outcome.error();
    return;
  }
  flow.failure = outcome.error();
  flow.left.clear();
  // Once marked, the next start of the machine is the trial boot; until then the machine stays in
  // OTA.
  if (flow.in_ota && step != Step::kStartAgain) flow.left.push_back(Step::kLeaveOta);
}

}  // namespace musher::ota
