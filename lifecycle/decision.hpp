#pragma once
// Inside of the coordinator: one event's decision. Not for users of the library.

#include <string>
#include <utility>
#include <vector>

#include "musher/lifecycle/coordinator.hpp"

namespace musher {

// How long an actuator has to answer the query for the outcome of a command, and how often it is
// queried: an actuator answers this from its loop, whatever its callback does, so no answer for
// 3 × 300 ms means that the connection is lost.
inline constexpr Duration kQueryTimeout = Milliseconds(300);
inline constexpr int kQueryAttempts = 3;
// The period at which the controller retries to take control of an actuator that has published its
// status but has not answered.
inline constexpr Duration kTakeControlPeriod = Milliseconds(500);
// The retry period where the actuator has not yet received the heartbeat of this controller.
inline constexpr Duration kIntroductionPeriod = Milliseconds(20);
// How long an actuator with a higher epoch is left alone: a controller that leads with that epoch
// sends at least two heartbeats in this time.
inline constexpr Duration kRivalGrace = Milliseconds(1200);
// The same with credentials: participants authenticate each other first.
inline constexpr Duration kSecuredRivalGrace = Milliseconds(4000);
// How long a hung process is kept for its backtrace, and how long a process may take to exit.
inline constexpr Duration kBacktraceTime = Milliseconds(5000);
inline constexpr Duration kEndTime = Milliseconds(2000);
// A process that is torn down exits by itself; the time it gets for that.
inline constexpr Duration kExitGrace = Milliseconds(1000);
// Two clocks that are 100 ppm apart differ by 6 ms after this.
inline constexpr Duration kClockGoodFor = std::chrono::seconds(60);

// The fault of an actuator that was torn down alone, whether its process has exited or still runs
// other actuators.
inline constexpr const char* kTornDownAlone = "is torn down; only a new start brings it back";

// How one command ended.
struct CommandResult {
  ActuatorOutcome outcome = ActuatorOutcome::kDone;
  std::int32_t code = kCodeOk;
  std::string message;
  bool ran = false;         // the callback ran, or may have run
  std::uint64_t cause = 0;  // the record that says why; 0: the switch it was part of
};

class Decision {
 public:
  Decision(const MachineConfig& config, Machine& machine, Time now)
      : config_(config), machine_(machine), now_(now) {}

  void On(const event::Begin& begin);
  void On(const event::StatusSeen& seen);
  void On(const event::Replied& replied);
  void On(const event::Vanished& vanished);
  void On(const event::ProcessStarted& started);
  void On(const event::ProcessNotStarted& failed);
  void On(const event::ProcessesFound& found);
  void On(const event::ProcessEnded& ended);
  void On(const event::HealthChanged& changed);
  void On(const event::BacktraceTaken& taken);
  void On(const event::RestartRequested& requested);
  void On(const event::RivalSeen& rival);
  void On(const event::EmergencyStopSeen& seen);
  void On(const event::ReleaseRequested& requested);
  void On(const event::SetStateRequested& requested);
  void On(const event::SetUpAwaited& awaited);
  void On(const event::BatterySeen& seen);
  void On(const event::MotionSeen& seen);
  void On(const event::InputSilent& silent);
  void On(const event::ClockReceived& received);
  void On(const event::PolicyRequested& requested);
  void On(const event::SaveEnded& ended);
  void On(const event::TimePassed&) {}

  // Handles deadlines, then does what has become possible. Ends every step.
  void Settle();

  // A fenced controller only answers requests, with a refusal.
  void Decline(const Event& event);

  std::vector<Action> Take() && { return std::move(actions_); }

 private:
  // arriving.cpp
  void FoundTornDown(std::size_t i, const ActuatorReport& report);
  void SetUpFailed(std::size_t i, const ActuatorReport& report);
  void TakeControl(std::size_t i);
  void RaiseEpoch(std::uint64_t epoch, std::size_t because_of);
  void Attach(std::size_t i);

  // commands.cpp
  void Accept(std::size_t i, const ActuatorReport& report);
  void Drifted(std::size_t i);
  bool IsImpostor(std::size_t i, const ActuatorReport& report);
  void TakeUpOthers();
  CommandResult DoneUnlessContradicted(std::size_t i, const std::string& message) const;
  void Issue(std::size_t i, std::uint64_t number, const State& target, Duration budget,
             bool apart = false);
  CommandResult Tolerate(std::size_t i, const PendingCommand& command, const CommandResult& end);
  void EndCommand(std::size_t i, const CommandResult& given);
  Leg* LegUnderWay(std::size_t i);
  void QueryOrLose(std::size_t i);
  CommandResult EvaluateReport(std::size_t i, const PendingCommand& command) const;
  void Lose(std::size_t i, const std::string& how, std::uint64_t cause = 0,
            std::int32_t code = kCodeNetError);
  void LoseConnection(std::size_t i, const std::string& how, std::uint64_t cause = 0);
  void AssumeTornDown(std::size_t i);
  void EvaluateFoundBusy(std::size_t i);
  void CheckCommands();

  // waiting.cpp
  bool JoinWaiting(const event::SetStateRequested& requested, std::optional<std::size_t> only,
                   std::uint64_t request_record);
  void Await(const Plan& plan, RequestId request, std::uint64_t request_record);
  bool BeginWaiting();
  void EndWaiting(const Error& why, std::uint64_t cause);

  // switching.cpp, switch_end.cpp
  bool JoinOrRefuse(const event::SetStateRequested& requested, std::optional<std::size_t> only,
                    std::uint64_t request_record);
  void Refuse(const State& target, std::optional<std::size_t> only,
              const std::vector<RequestId>& requests, const State& state, const Error& why,
              std::uint64_t cause);
  void Supersede(std::uint64_t by, const State& target, std::uint64_t cause);
  std::uint64_t Begin(const Plan& plan, Purpose purpose, std::vector<RequestId> requests,
                      std::uint64_t cause);
  void AddLeg(Switch& s, const PlanStep& step);
  bool AdvanceSwitch();
  Duration TearDownShare(const Leg& leg) const;
  bool StartLegs(std::vector<Leg>& legs);
  const Leg* FindBlocker(const Leg& leg, const std::vector<Leg>& legs) const;
  std::optional<CommandResult> FindUnfit(const Leg& leg) const;
  void SkipLeg(Leg& leg, const Leg* blocker);
  bool Failed(const Switch& s) const;
  const Leg* WorstLeg(const Switch& s) const;
  void BeginRollback(Switch& s);
  State WayBack(const Leg& leg) const;
  void EndLeg(Leg& leg, const CommandResult& end);
  void EndSwitch();
  void Apply(const Switch& s, bool undone);
  void DriveTheRest(const Switch& s);
  void SettleBack(const Switch& s);
  bool IsAway(std::size_t i, const State& target) const;
  std::string LeftSince(const Switch& s, std::size_t i) const;
  std::optional<Error> WhyAway(const Switch& s, std::size_t i) const;
  std::optional<std::size_t> FirstAway(const Switch& s) const;
  static const Leg* FirstPartial(const Switch& s);
  std::string FirstTrouble() const;
  SwitchResult Conclude(const Switch& s, bool undone) const;
  std::vector<ActuatorResult> Results(const Switch& s) const;
  void CorrectIfAway(const Switch& s, std::size_t i, ActuatorResult& result) const;
  void Answer(const std::vector<RequestId>& requests, const SwitchResult& result);

  // starting.cpp, adopting.cpp
  void StartStage(int stage, std::uint64_t cause);
  bool StartProcesses();
  bool NeedsMet(std::size_t i, std::string& blocker) const;
  std::uint64_t CauseOfBlocker(std::size_t i) const;
  bool AnotherIsPresent(std::size_t i, std::int32_t pid) const;
  bool StageSetUp(int stage) const;
  bool StageSettled(int stage) const;
  bool AdvanceStart();
  void EndFirstStage();
  void WaitForManager(std::size_t present, const std::vector<std::string>& missing,
                      std::uint64_t cause);
  bool FailOnCriticalFault();
  void AnswerSetUpRequests();
  void AdoptFrom(const State& lowest, std::uint64_t cause);
  void AfterStartUpCheck(std::uint64_t checked);
  void Activate(std::uint64_t cause);
  void FailStartUp(const std::string& why, std::uint64_t cause);
  void BecomeRunning(const std::string& message, std::uint64_t cause);
  void CheckSetUpDeadlines();
  std::string NotSetUp(std::size_t i) const;
  bool WasDisconnected(std::size_t i) const;
  std::optional<State> LowestFound() const;
  bool AgreesWith(std::size_t i, const State& state) const;
  bool FoundSwitching() const;
  std::string Elsewhere() const;

  // joining.cpp
  bool DriveLateOnes();
  bool Fits(std::size_t i) const;
  bool MayFollow(std::size_t i) const;
  void ReportUnchecked(std::size_t i);
  bool MayJoin(std::size_t i, std::string& blocker) const;
  std::string WaitsForSuspended(std::size_t i) const;
  void Join(std::size_t i);
  void EndTornDown(std::size_t i, const CommandResult& end);
  void EndJoin(std::size_t i, const PendingCommand& command, const CommandResult& end);
  void FallBack(std::size_t i);
  bool BeginFallback();

  // recovery.cpp
  bool Coming(std::size_t i) const;
  bool MayRestart(std::size_t i) const;
  std::int32_t ProcessOf(std::size_t i) const;
  void Recovered(std::size_t i, const std::string& how);
  void Hang(std::size_t i, bool silent, const std::string& how);
  void Terminate(std::size_t i, std::int32_t pid, Duration grace);
  void Kill(std::size_t i);
  void AssumeExited(std::size_t i);
  bool IsFinal(std::size_t i, const event::ProcessEnded& ended) const;
  std::string WhyFinal(const event::ProcessEnded& ended) const;
  void Recover(std::size_t i, const event::ProcessEnded& ended = {});
  void GiveUp(std::size_t i, const std::string& why);
  void EvaluateArrival(std::size_t i);
  void CheckRestarts();
  void ForgetEnd(std::size_t i);
  void CancelRestart(std::size_t i);
  void StartAgain(std::size_t i);
  bool RunsElsewhere(std::size_t i) const;
  void EndForRestart(std::size_t i);
  void AnswerRestarts(std::size_t i);

  // binding.cpp
  bool IsUp(std::size_t i) const;
  bool IsBoundTo(std::size_t i, std::size_t other, std::vector<bool>& seen) const;
  bool Suffices(std::size_t needed, std::size_t i) const;
  const std::string* MissingFor(std::size_t bound, std::size_t i, std::vector<bool>& seen) const;
  bool SuspendAndResume();
  void Suspend(std::size_t i, const std::string& missing);
  State PlaceOf(std::size_t i) const;

  // authority.cpp
  void HoldTo(const ActuatorReport& report, std::size_t i);
  void BeginStops(const StoredStops& stops);
  void Engage(const EmergencyStop& stop);
  bool Add(const EmergencyStop& stop);
  void Release(std::uint64_t id);
  bool IsReleased(std::uint64_t id) const;
  StoredStops Stops() const;

  // saving.cpp
  void Save(Stored what);
  std::vector<RemoteActuator> RemoteActuators() const;
  bool IsElsewhere(std::size_t i) const;
  void NoteHosts();

  // policy_rules.cpp
  void BeginPolicy(const StoredPolicy& stored);
  bool AdvancePolicy();
  void EvaluateLevel(const std::string& seen);
  void CountStillness();
  bool EndsKeep(const Switch& s) const;
  void EndKeep(const std::string& why);
  bool BatteryRulesWait() const;
  bool ApplyBatteryRule();
  bool TakeDown(BatteryLevel level);
  bool BringBack();
  bool LowPowerWhenStill();
  bool BeginByPolicy(const Plan& plan, const std::string& why, std::uint64_t cause);
  void BackOff();
  void NoteEndOfSwitch(const Switch& s, bool undone);
  void NoteSuperseded(const Switch& s);
  void ResumeLowering();
  void Lower(std::optional<Lowering> lowering);
  void LowerAtMostTo(const State& most);
  State UpTo(const State& wanted) const;
  Time policy_now() const { return PolicyNow(config_, machine_.policy, now_); }
  std::uint64_t RecordPolicy(std::int32_t code, const std::string& message,
                             std::uint64_t cause = 0);

  // policy_requests.cpp; each returns why it refuses, or arranges the answer
  using Requested = event::PolicyRequested;
  std::optional<Error> Handle(const Requested& requested, std::uint64_t request_record);
  std::optional<Error> HandleKeep(const Requested& requested, std::uint64_t request_record);
  std::optional<Error> HandleOta(const Requested& requested, std::uint64_t request_record);
  std::optional<Error> HandleLowPowerSwitch(const Requested& requested,
                                            std::uint64_t request_record);
  std::optional<Error> HandleWakeUp(const Requested& requested, std::uint64_t request_record);
  std::optional<Error> HandlePower(const Requested& requested, std::uint64_t request_record);
  std::optional<Error> KeptOrBusy() const;
  std::optional<Error> BeginRequested(const Requested& requested, const State& target,
                                      std::uint64_t request_record);
  std::optional<Error> BeginUp(const Requested& requested, std::uint64_t request_record);
  bool InLowPower() const;

  // power.cpp
  void BeginPowerDown(bool reboot, Time tear_down_at, std::uint64_t cause);
  bool TearDownForPower();
  void CommandPower(bool in_time);
  void ForcePower();

  // stopping.cpp
  void Stop(const Plan& plan, std::vector<RequestId> requests, std::uint64_t cause,
            AfterTearDown after = AfterTearDown::kStaysDown);
  void OnTornDown(SwitchResult result);
  void AdvanceStopping();
  std::int32_t OwnProcess(std::size_t i) const;
  bool ProcessesLeft() const;
  bool HasSearched();
  void SignalProcesses(bool kill);
  void EndUnfinished();
  void JoinStop(const event::SetStateRequested& requested);
  bool WaitsForIntent();
  std::string WhyMayRun(std::size_t i) const;
  void ListSurvivors();
  SwitchResult StopResult(const Error& not_ended);

  // coordinator.cpp
  ActuatorRecord& Of(std::size_t i) { return machine_.actuators[i]; }
  const ActuatorRecord& Of(std::size_t i) const { return machine_.actuators[i]; }
  const ActuatorConfig& ConfigOf(std::size_t i) const { return config_.actuators[i]; }
  void Do(Action action) { actions_.push_back(std::move(action)); }
  // Each returns the id of its record. `cause`: the id of the record that it follows from, where
  // one is known. A decision with later effects stores the id for them in ActuatorRecord, Switch or
  // Machine.
  std::uint64_t Record(action::Record record);
  std::uint64_t RecordMachine(std::int32_t code, const std::string& message,
                              std::uint64_t cause = 0);
  std::uint64_t RecordSwitch(const Switch& s, std::int32_t code, const std::string& message,
                             std::uint64_t cause);
  std::uint64_t RecordEnd(const Switch& s, const SwitchResult& result, const std::string& message,
                          std::uint64_t cause);
  std::uint64_t RecordActuator(std::size_t i, std::int32_t code, const std::string& message,
                               std::uint64_t cause = 0);
  std::uint64_t RecordProcess(std::size_t i, std::int32_t code, const std::string& message,
                              std::uint64_t cause = 0);
  // Records the fault, once; the record becomes the cause of what follows from the fault.
  void Degrade(std::size_t i, std::int32_t code, const std::string& message,
               std::uint64_t cause = 0);
  bool Critical(std::size_t i) const { return ConfigOf(i).critical; }

  const MachineConfig& config_;
  Machine& machine_;
  Time now_;
  std::vector<Action> actions_;
};

int LastStage(const MachineConfig& config);

// TearDown before Error before the rest.
int Urgency(const State& target);
// "to Active", "of eyes to Active".
std::string Describe(const MachineConfig& config, const State& target,
                     std::optional<std::size_t> only);

// When the next command, take-control attempt or set-up deadline of one actuator is due.
std::optional<Time> NextDeadlineOf(const ActuatorRecord& record);
// When the power-off is due, or a switch of the policy is to be retried: by the steady clock.
std::optional<Time> NextPowerDeadline(const Machine& machine);

}  // namespace musher
