#pragma once
// The order of an upgrade's steps, and what follows a failed step. Pure: takes the outcome of a
// step and returns the next step.
//
//   check ─▶ enter OTA ─▶ prepare ─▶ copy ─▶ check written ─▶ mark ─▶ start again ─▶ trial boot
//     │          └───────────┴─────────┴────────────┴───────────┘         │               │
//     ▼                         leave OTA                                 ▼               ▼
//    end, machine unchanged                                       end: kept, or rolled back
//
// Without a running machine the steps that need one are skipped: the next start is the trial boot.

#include <deque>
#include <optional>
#include <string_view>

#include "musher/base/result.hpp"

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
  std::deque<Step> left;            // the first is next
  bool in_ota = false;              // the machine was switched to OTA, or that was tried
  std::optional<Error> failure;     // the first failure
  std::optional<Error> afterwards;  // failure of leaving OTA; does not hide the first

  friend bool operator==(const Flow&, const Flow&) = default;
};

Flow InstallFlow(bool machine_runs);
Flow RollbackFlow(bool machine_runs);

// Call when the first of the steps left has ended.
void Advance(Flow& flow, const Result<>& outcome);

}  // namespace musher::ota
