#pragma once
// Decides which of a robot's two versions is started. Pure: takes the state and the slots, returns
// the slot to start and the state to save.
//
//           install, rollback           up                     self-check passed
//   confirmed ───────────▶ trial boot ──────▶ trial boot, started ─────────▶ confirmed (the new)
//       ▲                      │                       │
//       └──────────────────────┴───────────────────────┘ verification failed; trial boot failed;
//                                                        started before and not finished
//
// The state is one small file that is replaced atomically: before a change the robot starts one
// version, after it the other.

#include <functional>
#include <optional>
#include <string>
#include <string_view>

#include "musher/base/result.hpp"
#include "musher/ota/version.hpp"

namespace musher::ota {

enum class Slot { kA, kB };
std::string_view SlotName(Slot slot);  // "a", "b"
std::optional<Slot> SlotOf(std::string_view name);
constexpr Slot Other(Slot slot) {
  return slot == Slot::kA ? Slot::kB : Slot::kA;
}

// How the last trial boot ended.
struct TrialBootEnd {
  Slot slot = Slot::kA;
  std::string version;
  bool kept = false;
  std::string reason;  // why not

  friend bool operator==(const TrialBootEnd&, const TrialBootEnd&) = default;
};

struct SlotState {
  Slot confirmed = Slot::kA;   // the version known to work
  bool on_trial_boot = false;  // the other one is to be tried …
  bool started = false;        // … and its one start has been used
  bool other_good = false;     // the other one was confirmed once, and is as it was then
  std::optional<TrialBootEnd> last;
  std::string installing{};  // the version that is being written into the other one; empty: none
  // A start takes down what runs from the slot that is not due, and has not finished that.
  bool taking_down = false;

  friend bool operator==(const SlotState&, const SlotState&) = default;
};

std::string FormatState(const SlotState& state);
// nullopt: not whole.
std::optional<SlotState> ParseState(std::string_view text);

// The version in a slot, or why it must not be started.
using SlotContent = Result<Version>;
// Reads a whole slot; called only if needed.
using LookIntoSlot = std::function<SlotContent(Slot)>;

struct Boot {
  Slot start = Slot::kA;
  bool on_trial_boot = false;  // it has to prove itself; only to be started once `next` is on disk
  Version version;
  SlotState next;
  std::string reason;  // why it is not what one would expect; empty: it is
  // The machine runs from this slot, and another one is due: it is to be taken down, then started
  // from the one that is due.
  bool takes_down = false;
};

// `state`: nullopt if it is lost or damaged; then `link`, the target of ROOT/current, is used.
// `running`: the slot whose actuators run, nullopt: none. They may stand: no process of theirs is
// to end without TearDown. A pending trial boot waits until the machine was taken down; a rollback,
// or another change of the slot, takes it down first. If that has not been finished before, the
// slot that is due is started. Fails with Fault::kNoVersion if neither slot can be started.
Result<Boot> DecideBoot(const std::optional<SlotState>& state, std::optional<Slot> link,
                        const LookIntoSlot& look, std::optional<Slot> running = std::nullopt);

// The state after the trial boot: the new version is kept, or why it is not.
SlotState AfterTrialBoot(const SlotState& state, const std::string& version,
                         const Result<>& outcome);

}  // namespace musher::ota
