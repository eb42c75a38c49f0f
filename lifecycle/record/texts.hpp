#pragma once
// The sentences of all records and faults of the decision code, each with its event name and its
// arguments: the only place that puts them together. The callers give the values; a reader finds a
// sentence here, and test/golden/record_texts.expected has an example of each one.
//
// A fault's sentence has no subject: its record is "<actuator> is degraded: <sentence>". Durations
// are shown in ms, durations of the policy in s. Pure; from any thread.

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "musher/base/time.hpp"
#include "musher/lifecycle/event_name.hpp"
#include "musher/lifecycle/health/health.hpp"
#include "musher/lifecycle/ids.hpp"
#include "musher/lifecycle/machine/start_progress.hpp"
#include "musher/lifecycle/machine/switch_result.hpp"
#include "musher/lifecycle/record/record_text.hpp"
#include "musher/lifecycle/state.hpp"

namespace musher::texts {

// A pid as an argument; 0 is not known.
inline std::optional<int> Known(std::int32_t pid) {
  return pid == 0 ? std::nullopt : std::optional<int>(pid);
}

// The machine and its controller: machine_texts.cpp.
RecordText ControllerStarted(Epoch epoch, std::size_t actuators);
RecordText TearDownResumed();
RecordText TearDownResumedBySupervisor();
RecordText StageStarted(int stage);
RecordText ActuatorsSetUp(std::size_t present);
RecordText WaitingForManager(const std::vector<std::string>& missing);
RecordText StartUpFailed(const State& state, const std::string& why);
RecordText UnfinishedSwitchFound(const std::string& elsewhere, const State& lowest);
RecordText MixedStatesFound(const std::string& elsewhere, const State& lowest);
RecordText MachineUsable(const State& state, const std::string& trouble);  // "": none
RecordText MachineUsableWithoutActive();
RecordText MachineAdopted(const State& state);
RecordText InvariantBroken(const std::string& broken);
RecordText StopIntentLate();
// `left`: what is left behind, if anything.
RecordText MachineStopped(Duration took, const std::optional<std::string>& left);
RecordText ControllerFenced(Epoch epoch, const std::string& why);
RecordText EpochRaised(Epoch epoch, const std::string& actuator);
RecordText SaveFailed(std::string_view what, const std::string& why);
RecordText SaveRecovered(std::string_view what);
RecordText UnlistedActuatorFound(const std::string& actuator, std::int32_t pid, const State& state,
                                 const std::string& config);
// Another machine has a controller in this namespace and domain, or an actuator of a listed name.
RecordText OtherMachineSeen(const std::string& machine, const std::string& process,
                            const std::string& name_space);
RecordText EmergencyStopEngaged(const std::string& by, const std::string& reason);
RecordText EmergencyStopReleased(const std::string& by);
RecordText StateNotWritable(const std::string& why);
RecordText ReleaseUnconfirmed(const std::vector<std::string>& actuators);
// `rule`: of the user, as its file has it; `states`: of what it names.
RecordText RuleViolated(const std::string& rule, const std::string& states);
// `what`: of a request that is neither for a switch nor to the policy, "restart of legs".
RecordText RequestRefused(const std::string& what, const std::string& why);
RecordText FallbackStarted(const State& target);
RecordText FallbackRefused(const State& target, const std::string& why);
// TearDown, and what it leaves behind.
RecordText ProcessFound(std::int32_t pid, const std::string& actuator);
RecordText ProcessSignalled(const std::string& actuator, std::int32_t pid, bool kill);
// `pid` 0: unknown. `successor`: the controller that has taken over, if any.
// `host`: that runs the process, if it is not the controller's.
RecordText ProcessLeftBehind(std::int32_t pid, const std::optional<std::string>& successor,
                             const std::string& host = {});
// `how`: of event::Vanished.
RecordText LeftToOther(std::int32_t pid, const std::string& host, const std::string& how);
RecordText HostUnreached(const std::string& host, const std::string& why);
RecordText MayStillRun(const std::optional<State>& state);  // none: not known
RecordText MayStillRunOn(const std::string& host);
RecordText KeepsRunning(const State& state);  // nothing can end it
RecordText LostWithoutTearDown(const State& state);

// A switch: switch_texts.cpp. `to`: "to Active", "of eyes to Active".
// `by`: Requester::name.
RecordText SwitchRequested(const std::string& to, const State& target, const std::string& by = "");
RecordText SwitchWaiting(const std::string& to, Duration at_most, const std::string& why);
RecordText SwitchRefused(const std::string& to, const std::string& why);
// `actuator`: "": the machine.
RecordText SwitchStarted(CommandNumber number, const std::string& actuator, const State& from,
                         const State& target, std::size_t actuators);
RecordText SwitchEnded(CommandNumber number, SwitchOutcome outcome, const std::string& reason);
RecordText RollbackStarted(CommandNumber number, CommandNumber command, std::size_t actuators);
// Why a leg was not done.
RecordText AnotherFailedFirst();
RecordText NeededOneFailed(const std::string& needed);
RecordText NoLongerAvailable();
RecordText RefusedByEmergencyStop();
RecordText RestartedUnchecked();
RecordText NoStateToGoBackTo();
RecordText NotDrivenBack();
RecordText NoAnswerWithinBudget();
RecordText BudgetUsedUp();
// Faults after a switch.
RecordText RollbackFailed(const State& target, const std::string& why);  // "": no target
RecordText StoppedWhileBusy(const State& busy_with, const State& target);
RecordText StoppedIn(const State& state, const State& target);

// A command to one actuator: command_texts.cpp.
RecordText CommandEnded(const std::string& actuator, const State& target, ActuatorOutcome outcome,
                        Duration took, const std::string& message);
RecordText CommandUnanswered(const std::string& actuator, Duration waited, const State& target,
                             bool has_query);
// The actuator's own words about a command that ended with `outcome`.
RecordText Reported(ActuatorOutcome outcome, const std::string& message);
RecordText DoneDegraded(const std::string& why);
RecordText StillBusy(const State& target, Duration time);
RecordText HadNotStarted(const State& target, Duration time);
RecordText ContradictedBy(const State& state);
RecordText CommandNotDone(const State& target, ActuatorOutcome outcome, const std::string& message);
RecordText FailedLate(const std::string& message);
RecordText FoundBusy(const State& target, Duration time);

// An actuator: actuator_texts.cpp.
// `target`: of a callback that runs; empty: none.
RecordText ActuatorPresent(const std::string& actuator, const State& state, std::int32_t pid,
                           const State& target = {});
RecordText ActuatorDrifted(const std::string& actuator, const State& state,
                           const std::optional<std::string>& failure);
RecordText ActuatorStarved(const std::string& actuator, const std::string& how);
RecordText ActuatorRecovered(const std::string& actuator, const std::string& how);
RecordText TwoNodes(const std::string& which);  // of ROS 2, with one name
RecordText DuplicateActuator(const std::string& actuator, std::int32_t pid, const std::string& host,
                             std::int32_t known_pid);
RecordText ConfigDiffers(const std::string& actuator, const std::string& hash,
                         const std::string& file, const std::string& own_hash);
RecordText Degraded(const std::string& actuator, const RecordText& fault);
// Faults.
RecordText DependencyDegraded(const std::string& needed, const std::string& why);
RecordText DependencySuspended(const std::string& needed);
RecordText NotUp(const std::string& bound_to);
RecordText SetUpFailed(std::int32_t code, const std::string& message);
RecordText SetUpTimeout(Duration within);
RecordText NodeNotDiscovered(const std::string& node, Duration within, std::int32_t pid);
RecordText NotAnnounced(const std::string& actuator, const std::vector<std::string>& command,
                        Duration within, std::int32_t pid, StartProgress progress);
RecordText NotAnnouncedBeside(const std::string& actuator, const std::string& other,
                              Duration within, std::int32_t pid);
RecordText TornDownAlone();
RecordText StartedBeside(const std::string& other);
RecordText SelfCheckMissing(const State& state);
RecordText NoState(const State& state);
RecordText HeldIn(const State& state, const State& machine);
RecordText FoundBelow(const State& state, const State& machine);
RecordText EpochOutOfRange(Epoch epoch);
RecordText ControlledByAnother(Epoch epoch);
// Faults of an actuator that is lost, or hangs.
RecordText Unhealthy(Health health, const std::string& how);  // not kWell
RecordText HungIn(const State& target, Duration time);
RecordText StillHung();
RecordText Crashed(const std::string& how);
RecordText Killed();
RecordText Replaced();
RecordText PidUnknown();
RecordText QueryUnanswered(const State& target);
// `how`: of event::Vanished. Only the loss that says no more than kOutOfReach is kConnectionLost:
// the exit of the process explains it later.
RecordText Disconnected(const std::string& how);

// A process: process_texts.cpp.
RecordText ProcessStarted(const std::string& actuator, std::int32_t pid);
// `found`: it ran there already.
RecordText ProcessStartedOn(const std::string& host, const std::string& actuator, std::int32_t pid,
                            bool found);
RecordText ProcessExited(const std::string& actuator, std::int32_t pid, const std::string& how);
RecordText ProcessExitAssumed(std::int32_t pid);
RecordText ProcessUnproven(const std::string& actuator, std::int32_t pid, const std::string& why);
RecordText BacktraceStarted(const std::string& actuator, std::int32_t pid);
RecordText BacktraceTaken(const std::string& actuator);
// `by`: the person or program; "" = not known.
RecordText RestartRequested(const std::string& actuator, const std::string& by);
RecordText RestartScheduled(const std::string& actuator, Duration delay, int restart, int limit);
// Faults.
RecordText ProcessNotStarted(const std::string& why);
RecordText Exited(std::int32_t pid, const std::string& how, bool clean, bool in_set_up);
RecordText RestartPrevented(const std::string& how, int exit_code, const std::string& actuator);
RecordText GivenUp(const std::string& actuator, int restarts,
                   const std::optional<std::string>& why);
// By an earlier controller. `lost_in`: "" = it had not been set up.
RecordText GivenUpBefore(const State& lost_in);
RecordText RestartedTooOften(int starts, Duration reset_after);

// The policy: policy_texts.cpp.
// "the battery is at 18 %, being charged": the beginning of sentences; it has no braces. Without a
// sample: that it was low.
std::string BatteryText(std::optional<int> percent, bool charging);
// `target`: of a request for a switch; "": another request.
RecordText PolicyRequested(const std::string& what, const State& target,
                           const std::string& by = {});
RecordText PolicyRefused(const std::string& what, const std::string& why);
RecordText BatterySampleInvalid(int percent);
RecordText BatteryJumped(int before, int percent);
RecordText BatteryDoubled(const std::string& topic, int publishers, int lowest, int highest);
// `was_low`: an earlier controller knew it as low.
RecordText BatterySilent(Duration limit, std::optional<int> last, bool was_low = false);
RecordText BatteryResumed();
// What a battery sample changes for the machine.
enum class BatteryLimit {
  kAsBefore,
  kLifted,
  kNoSwitchAbove,  // charging keeps it in its state
  kLimited,
  kEmpty,
};
// `charger`: was connected (true) or disconnected; none: neither. `most`: the limit.
RecordText BatteryChanged(int percent, bool charging, std::optional<bool> charger,
                          BatteryLimit limit, const State& most);
// `limit`: the message of AboveCeiling().
RecordText BatteryLimitsStart(const std::string& limit, const State& target);
RecordText BatterySwitchDown(std::optional<int> percent, bool charging, const State& target);
RecordText BatterySwitchUp(int percent, bool charging, const State& target);
RecordText LyingStill(Duration limit);
RecordText PolicySwitchRefused(const RecordText& wanted, const std::string& why);
RecordText KeepEnded(const State& state, const std::string& why);
RecordText PowerDownStarted(bool reboot);
RecordText PowerCommandGiven(bool reboot, bool in_time, const std::vector<std::string>& command);
// `command`: "reboot" or "power_off"; `how`: "failed: exit code 1".
RecordText PowerCommandFailed(const std::string& command, const std::string& how);
RecordText PowerTearDownRefused(const std::string& why);

}  // namespace musher::texts
