#pragma once
// The end: TearDown in reverse order, then SIGTERM, then SIGKILL. TearDown may use 70 % of the
// budget; at 90 % the remaining processes are killed; at 100 % the machine is stopped
// unconditionally.
//
// Before the first TearDown the intent goes to disk, so that a controller which a supervisor starts
// after a crash finishes the TearDown instead of bringing the machine up. A disk that does not
// answer delays it for a moment only.
//
// An actuator that may run, and has not announced itself to this controller since its start, is
// waited for, at most kLongestDiscovery and three tenths of the budget: a signal would end it
// without its TearDown, and one that this controller did not start would not be torn down at all.
// So is one whose connection alone was lost, while its process runs.
//
// An actuator that does not list TearDown is ended by the signals alone. Where the controller did
// not start its process either, nothing ends it: it is listed as degraded.
//
// An actuator that was lost without a known exit may still run in its last state, also when only an
// earlier controller of this host has received its status: it is listed as degraded, and the
// outcome is done-degraded. So is one of another host that has not answered the last search for
// processes within the budget, and one that the controller of another machine has taken on its
// host: it is that one's to end.
//
// An actuator whose process has exited without its TearDown is listed as degraded, too, where it
// has that state: a motor that the process had switched on may be on.
//
// The intent that is not on disk at the end is named by the answer: nothing else says to a person
// that a supervisor would start the machine again.

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "musher/lifecycle/policy/policy_memory.hpp"
#include "musher/lifecycle/policy/power.hpp"
#include "musher/lifecycle/switch/plan.hpp"
#include "musher/lifecycle/switch/switches.hpp"

namespace musher {

// How long TearDown waits for actuators that ran before this controller started. They are
// discovered within a second.
inline constexpr Duration kLongestDiscovery = std::chrono::seconds(3);

class TearDown : StepPart {
 public:
  TearDown(StepContext& step, Saver& saver, PolicyMemory& memory, Power& power, Commands& commands,
           Switches& switches)
      : StepPart(step),
        saver_(saver),
        memory_(memory),
        power_(power),
        commands_(commands),
        switches_(switches) {}

  void Begin(const Plan& plan, std::vector<RequestId> requests, RecordId cause,
             AfterTearDown after = AfterTearDown::kStaysDown, const Requester& by = {});
  // Another request for the TearDown under way. Of several, the one counts that keeps the machine
  // down.
  void Join(const event::SetStateRequested& requested);
  // Begins the switch to TearDown, once it need not wait for actuators any more. Returns whether it
  // has.
  bool BeginWaiting();
  // Whether the first TearDown still waits for the intent to be on disk.
  bool WaitsForIntent();
  // The switch to TearDown has ended.
  void OnTornDown(SwitchResult result);
  void On(const event::ProcessesFound& found);
  // Escalates, and stops the machine when all processes have exited or the budget is used up.
  void Advance();
  // The result of TearDown now. `code`: of processes that still run and are left behind;
  // `successor`: the controller that has taken over, if any.
  SwitchResult Conclude(std::int32_t code, const std::optional<std::string>& successor);

 private:
  bool IsDisconnected(ActuatorIndex i) const;
  bool MayAnnounceItself(ActuatorIndex i) const;
  std::optional<ActuatorIndex> FirstSilent() const;
  void EndWithout(ActuatorIndex i);
  bool RunsAnother(ActuatorIndex i, std::int32_t pid) const;
  void BeginSwitch(const Plan& plan);
  void ListSurvivors();
  std::optional<RecordText> WhyMayRun(ActuatorIndex i) const;
  std::optional<RecordText> WhyMayBeOn(ActuatorIndex i) const;
  bool ProcessesLeft() const;
  bool HasSearched();
  void Search();
  void NameSilentHosts();
  bool IsOutOfReach(ActuatorIndex i) const;
  SwitchResult WithUnlisted(SwitchResult result) const;
  std::optional<Error> LeftBehind(ActuatorIndex i) const;
  void ForgetElsewhere(ActuatorIndex i);
  void SignalProcesses(bool kill);
  void EndUnfinished();
  void NameUnsavedIntent(SwitchResult& result) const;

  Saver& saver_;
  PolicyMemory& memory_;
  Power& power_;
  Commands& commands_;
  Switches& switches_;
};

}  // namespace musher
