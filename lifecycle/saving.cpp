// What has to survive the controller: handed to the disk thread, which only TearDown waits for, and
// saved once the disk thread reports it.

#include <algorithm>
#include <utility>

#include "musher/lifecycle/decision.hpp"

namespace musher {

void Decision::Save(Stored what) {
  const std::uint64_t save = ++machine_.last_save;
  auto& unsaved = machine_.unsaved;
  const auto found = std::find_if(unsaved.begin(), unsaved.end(),
                                  [what](const Unsaved& one) { return one.what == what; });
  if (found == unsaved.end()) {
    unsaved.push_back({what, save, now_, {}});
  } else {
    found->save = save;
  }
  switch (what) {
    case Stored::kEpoch:
      return Do(action::SaveEpoch{machine_.epoch, save});
    case Stored::kEmergencyStops:
      return Do(action::SaveEmergencyStops{Stops(), save});
    case Stored::kPolicy:
      return Do(action::SavePolicy{machine_.policy.stored, save});
    case Stored::kStopIntent:
      return Do(action::SaveStopIntent{machine_.phase == Phase::kStopping, save});
  }
}

void Decision::On(const event::SaveEnded& ended) {
  auto& unsaved = machine_.unsaved;
  const auto found = std::find_if(unsaved.begin(), unsaved.end(), [&](const Unsaved& one) {
    return one.what == ended.what && one.save == ended.save;
  });
  if (found == unsaved.end()) return;  // a newer save of the same counts
  const std::string what(StoredName(ended.what));
  const bool failed_before = !found->why.empty();
  if (ended.ok) {
    unsaved.erase(found);
    if (failed_before) RecordMachine(kCodeOk, "the " + what + " is on disk now");
  } else {
    found->why = ended.why.empty() ? "failed" : ended.why;
    if (!failed_before) {
      RecordMachine(kCodeFailed, "the " + what + " is not on disk: " + found->why);
    }
  }
  if (ended.what == Stored::kStopIntent && machine_.stopping) machine_.stopping->intent_by.reset();
}

}  // namespace musher
