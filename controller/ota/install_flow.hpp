#pragma once
// The order of an upgrade, and what follows when a step fails. Pure: steps and their ends go in,
// the next step comes out.
//
//   check ─▶ enter OTA ─▶ prepare ─▶ copy ─▶ check written ─▶ mark trial boot ─▶ start again ─▶
//   trial boot
//     │          └─────────────┴─────────┴──────────┴──────────────┘             │           │
//     ▼                         leave OTA                                        ▼           ▼
//    end, the machine as it was                                          end: kept, or gone back
//
// Without a machine that runs, the steps that need one fall out: the next start is the trial boot.

#include <deque>
#include <optional>
#include <string_view>

#include "musher/lifecycle/result.hpp"

namespace musher::ota {

enum class Step {
  kCheck,
  kEnterOta,
  kPrepare,
  kCopy,
  kCheckWritten,
  kMarkTrialBoot,
  kStartAgain,
  kTrialBoot,
  kLeaveOta,
};
std::string_view StepName(Step step);  // "check", "enter OTA", …

struct Flow {
  std::deque<Step> left;            // the first is to be done now
  bool in_ota = false;              // we have taken the machine there, or tried to
  std::optional<Error> failure;     // the first
  std::optional<Error> afterwards;  // that of leaving OTA, which does not hide the first

  friend bool operator==(const Flow&, const Flow&) = default;
};

Flow InstallFlow(bool machine_runs);
Flow RollbackFlow(bool machine_runs);

// The first of the steps left has ended.
void Advance(Flow& flow, const Result<>& outcome);

}  // namespace musher::ota
