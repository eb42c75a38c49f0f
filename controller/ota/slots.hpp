#pragma once
// Which of a robot's two versions is started, and what is remembered of that. Pure: state and slots
// in, the slot to start and the state to write out.
//
//             install, rollback        up                        self-check good
//   confirmed ────────────────▶ trial boot ────▶ trial boot, started once ────────────────▶
//   confirmed (the new)
//       ▲                         │                 │
//       └─────────────────────────┴─────────────────┘ it does not verify; it failed; it was started
//                                                     before and did not come to its end
//
// The state is one small file that is replaced whole, so every change of it is one step: before it
// the robot starts the one version, after it the other.

#include <functional>
#include <optional>
#include <string>
#include <string_view>

#include "musher/controller/ota/version.hpp"
#include "musher/lifecycle/result.hpp"

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
  Slot confirmed = Slot::kA;   // what the robot trusts
  bool on_trial_boot = false;  // the other one is to be tried …
  bool started = false;        // … and its one start has been used
  bool other_good = false;     // the other one was confirmed once, and is as it was then
  std::optional<TrialBootEnd> last;

  friend bool operator==(const SlotState&, const SlotState&) = default;
};

std::string FormatState(const SlotState& state);
// nullopt: not whole.
std::optional<SlotState> ParseState(std::string_view text);

// What a slot holds: a version, or why it must not be started.
using SlotContent = Result<Version>;
// Reads a slot, all of it; asked for as few as are needed.
using LookIntoSlot = std::function<SlotContent(Slot)>;

struct Boot {
  Slot start = Slot::kA;
  bool on_trial_boot = false;  // it has to prove itself; only to be started once `next` is on disk
  Version version;
  SlotState next;
  std::string told;  // why it is not what one would expect; empty: it is
};

// `state`: nullopt when it is lost or damaged; `link` is what ROOT/current names then. Fails with
// Fault::kNoVersion when neither slot may be started.
Result<Boot> DecideBoot(const std::optional<SlotState>& state, std::optional<Slot> link,
                        const LookIntoSlot& look);

// The state after the trial boot: the new version is kept, or why it is not.
SlotState AfterTrialBoot(const SlotState& state, const std::string& version,
                         const Result<>& outcome);

}  // namespace musher::ota
